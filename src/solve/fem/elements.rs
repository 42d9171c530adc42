//! Elements as they are at rest.

use crate::body::{BuildError, TetMesh, Tets};
use crate::law::basis;
use crate::law::elastic::tensor::{Mat, det, inverse, matrix};
use crate::math::Number;

/// A kind of element with `N` nodes and `G` integration points.
pub trait Basis<const N: usize, const G: usize>: Copy + Send + Sync + 'static {
    /// ∂N/∂(ξ, η, ζ) of every node at every point.
    const GRADIENTS: [[[f64; 3]; N]; G];
    /// What a node has of its element's mass.
    const MASS: [f64; N];
    /// The part of the reference volume, which is 1/6, that each point stands for.
    const SHARE: f64 = 1.0 / G as f64;
    /// The elements of a mesh, if they are of this kind.
    fn nodes(tets: &Tets) -> Option<&[[u32; N]]>;
    /// Σ x ⊗ ∂N/∂(ξ, η, ζ) of values at the nodes, at every point.
    fn gradients<S: Number>(values: &[[S; 3]; N]) -> [Mat<S>; G];
    /// Σ m·∂N/∂(ξ, η, ζ) over the points, at every node: the transpose of [`Self::gradients`].
    fn collect<S: Number>(matrices: &[Mat<S>; G]) -> [[S; 3]; N];
}

/// Four nodes, one point.
#[derive(Clone, Copy, Debug)]
pub struct Linear;

impl Basis<4, 1> for Linear {
    const GRADIENTS: [[[f64; 3]; 4]; 1] = [basis::LINEAR];
    const MASS: [f64; 4] = [0.25; 4];

    fn nodes(tets: &Tets) -> Option<&[[u32; 4]]> {
        match tets {
            Tets::Linear(tets) => Some(tets),
            Tets::Quadratic(_) => None,
        }
    }

    #[inline(always)]
    fn gradients<S: Number>(x: &[[S; 3]; 4]) -> [Mat<S>; 1] {
        [matrix!(i, k => x[k + 1][i] - x[0][i])]
    }

    #[inline(always)]
    fn collect<S: Number>([m]: &[Mat<S>; 1]) -> [[S; 3]; 4] {
        let mut nodes = [[S::ZERO; 3]; 4];
        for i in 0..3 {
            nodes[0][i] = -(m[i][0] + m[i][1] + m[i][2]);
            for k in 0..3 {
                nodes[k + 1][i] = m[i][k];
            }
        }
        nodes
    }
}

/// Ten nodes, four points.
#[derive(Clone, Copy, Debug)]
pub struct Quadratic;

/// ∂/∂Lᵢ at the point near corner g is (4Lᵢ − 1)xᵢ + 4ΣLⱼxᵢⱼ, and all Lⱼ but L_g are alike. So with the three numbers 4B − 1,
/// 4B and 4(A − B) it is a sum that is the same at all points, and one node more: xᵢ_g, or x_g itself where i = g.
const CORNER: f64 = 4.0 * basis::POINTS[0][1] - 1.0;
const MIDDLE: f64 = 4.0 * basis::POINTS[0][1];
const NEAR: f64 = 4.0 * (basis::POINTS[0][0] - basis::POINTS[0][1]);

/// The node between two corners; the corner itself where they are one.
const fn between(a: usize, b: usize) -> usize {
    if a == b { a } else { 4 + basis::edge(a, b) }
}

impl Basis<10, 4> for Quadratic {
    const GRADIENTS: [[[f64; 3]; 10]; 4] = [
        basis::quadratic_gradients(basis::POINTS[0]),
        basis::quadratic_gradients(basis::POINTS[1]),
        basis::quadratic_gradients(basis::POINTS[2]),
        basis::quadratic_gradients(basis::POINTS[3]),
    ];
    /// The diagonal of the consistent mass, ∫N² = V/70 and 8V/105, scaled to the sum V: 1/36 and 4/27.
    const MASS: [f64; 10] = {
        const C: f64 = 1.0 / 36.0;
        const M: f64 = 4.0 / 27.0;
        [C, C, C, C, M, M, M, M, M, M]
    };

    fn nodes(tets: &Tets) -> Option<&[[u32; 10]]> {
        match tets {
            Tets::Linear(_) => None,
            Tets::Quadratic(tets) => Some(tets),
        }
    }

    #[inline(always)]
    fn gradients<S: Number>(x: &[[S; 3]; 10]) -> [Mat<S>; 4] {
        let (corner, middle, near) = (S::of(CORNER), S::of(MIDDLE), S::of(NEAR));
        let mut common = [[S::ZERO; 3]; 4];
        for i in 0..4 {
            let (a, b) = (between(i, (i + 1) % 4), between(i, (i + 2) % 4));
            let c = between(i, (i + 3) % 4);
            for d in 0..3 {
                common[i][d] = corner * x[i][d] + middle * (x[a][d] + x[b][d] + x[c][d]);
            }
        }
        let mut points = [[[S::ZERO; 3]; 3]; 4];
        for (g, point) in points.iter_mut().enumerate() {
            for d in 0..3 {
                let first = common[0][d] + near * x[between(0, g)][d];
                for k in 0..3 {
                    point[d][k] = common[k + 1][d] + near * x[between(k + 1, g)][d] - first;
                }
            }
        }
        points
    }

    #[inline(always)]
    fn collect<S: Number>(m: &[Mat<S>; 4]) -> [[S; 3]; 10] {
        let (corner, middle, near) = (S::of(CORNER), S::of(MIDDLE), S::of(NEAR));
        // What each point gives to ∂/∂Lᵢ.
        let mut parts = [[[S::ZERO; 3]; 4]; 4];
        for g in 0..4 {
            parts[g] = Linear::collect(&[m[g]]);
        }
        let mut sums = [[S::ZERO; 3]; 4];
        let mut nodes = [[S::ZERO; 3]; 10];
        for i in 0..4 {
            for d in 0..3 {
                sums[i][d] = parts[0][i][d] + parts[1][i][d] + (parts[2][i][d] + parts[3][i][d]);
                nodes[i][d] = corner * sums[i][d] + near * parts[i][i][d];
            }
        }
        for (e, [a, b]) in basis::EDGES.into_iter().enumerate() {
            for d in 0..3 {
                let far = middle * (sums[a][d] + sums[b][d]);
                nodes[4 + e][d] = far + near * (parts[b][a][d] + parts[a][b][d]);
            }
        }
        nodes
    }
}

/// One integration point of one element.
#[derive(Clone, Copy, Debug)]
pub struct Point<S> {
    /// ∂(ξ, η, ζ)/∂X at rest \[1/m\].
    pub inverse: Mat<S>,
    /// Volume it stands for at rest \[m³\].
    pub volume: S,
}

/// One element.
#[derive(Clone, Copy, Debug)]
pub struct Element<const N: usize, const G: usize> {
    /// Node indices.
    pub nodes: [u32; N],
    /// Integration points.
    pub points: [Point<f64>; G],
}

/// All elements of a body, of one kind.
#[derive(Clone, Debug)]
pub struct Elements<B, const N: usize, const G: usize> {
    pub(super) list: Vec<Element<N, G>>,
    pub(super) node_count: usize,
    kind: std::marker::PhantomData<B>,
}

impl<B: Basis<N, G>, const N: usize, const G: usize> Elements<B, N, G> {
    /// The elements of a mesh.
    ///
    /// # Errors
    /// Those of [`TetMesh::check`]; [`BuildError::Value`] if the mesh is of another kind.
    pub fn new(mesh: &TetMesh) -> Result<Self, BuildError> {
        mesh.check()?;
        let tets = B::nodes(&mesh.tets).ok_or(BuildError::Value {
            what: "the number of nodes of a tet",
            value: if N == 4 { 10.0 } else { 4.0 },
            must: "that of the element",
        })?;
        let list = tets.iter().map(|nodes| Element {
            nodes: *nodes,
            points: points::<B, N, G>(mesh, nodes),
        });
        Ok(Self {
            list: list.collect(),
            node_count: mesh.nodes.len(),
            kind: std::marker::PhantomData,
        })
    }

    /// The elements.
    pub fn list(&self) -> &[Element<N, G>] {
        &self.list
    }

    /// How many nodes the mesh has.
    pub fn node_count(&self) -> usize {
        self.node_count
    }

    /// Volume of each element at rest \[m³\].
    pub fn volumes(&self) -> impl Iterator<Item = f64> {
        let volume = |e: &Element<N, G>| e.points.iter().map(|p| p.volume).sum();
        self.list.iter().map(volume)
    }
}

fn points<B: Basis<N, G>, const N: usize, const G: usize>(
    mesh: &TetMesh,
    nodes: &[u32; N],
) -> [Point<f64>; G] {
    let first = mesh.nodes[nodes[0] as usize];
    let at = |n: u32| (mesh.nodes[n as usize] - first).to_array();
    B::gradients(&nodes.map(at)).map(|jacobian| Point {
        inverse: inverse(&jacobian),
        volume: det(&jacobian) / 6.0 * B::SHARE,
    })
}

impl<const N: usize, const G: usize> Element<N, G> {
    /// Values at its nodes less the value at the first.
    pub(super) fn gather(&self, value: impl Fn(usize) -> [f64; 3]) -> [[f64; 3]; N] {
        let first = value(self.nodes[0] as usize);
        self.nodes.map(|n| {
            let v = value(n as usize);
            [v[0] - first[0], v[1] - first[1], v[2] - first[2]]
        })
    }

    /// ∇N of every node at rest at a point \[1/m\].
    pub(super) fn gradients<B: Basis<N, G>>(&self, g: usize) -> [[f64; 3]; N] {
        let inverse = &self.points[g].inverse;
        B::GRADIENTS[g].map(|d| {
            std::array::from_fn(|k| {
                d[0] * inverse[0][k] + d[1] * inverse[1][k] + d[2] * inverse[2][k]
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::elastic::tensor::from_fn;

    fn check<B: Basis<N, G>, const N: usize, const G: usize>() {
        let x: [[f64; 3]; N] =
            std::array::from_fn(|n| std::array::from_fn(|d| ((7 * n + 3 * d) as f64).sin()));
        let gradients = B::gradients(&x);
        let m: [Mat<f64>; G] =
            std::array::from_fn(|g| from_fn(|i, j| ((5 * g + 3 * i + j) as f64).cos()));
        let collected = B::collect(&m);
        for (n, found) in collected.iter().enumerate() {
            for d in 0..3 {
                let sum = |g: usize| {
                    (0..3)
                        .map(|k| m[g][d][k] * B::GRADIENTS[g][n][k])
                        .sum::<f64>()
                };
                let expected: f64 = (0..G).map(sum).sum();
                assert!((found[d] - expected).abs() < 1e-12);
            }
        }
        for (g, found) in gradients.iter().enumerate() {
            for (i, row) in found.iter().enumerate() {
                for (k, entry) in row.iter().enumerate() {
                    let sum: f64 = (0..N).map(|n| x[n][i] * B::GRADIENTS[g][n][k]).sum();
                    assert!((entry - sum).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn short_cuts_are_the_sums_they_stand_for() {
        check::<Linear, 4, 1>();
        check::<Quadratic, 10, 4>();
    }
}
