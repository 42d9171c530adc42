//! Elements as the force pass reads them.

use crate::body::{BuildError, TetMesh, Tets};
use crate::law::basis;
use crate::law::elastic::tensor::{Mat, det, inverse};
use crate::math::Scalar;

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
}

/// Ten nodes, four points.
#[derive(Clone, Copy, Debug)]
pub struct Quadratic;

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
}

/// One integration point of one element.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Point<S> {
    /// ∂(ξ, η, ζ)/∂X at rest \[1/m\].
    pub inverse: Mat<S>,
    /// Volume it stands for at rest \[m³\].
    pub volume: S,
}

/// One element: its nodes and its points, side by side in memory.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Element<S, const N: usize, const G: usize> {
    /// Node indices.
    pub nodes: [u32; N],
    /// Integration points.
    pub points: [Point<S>; G],
}

/// All elements of a body, of one kind.
#[derive(Clone, Debug)]
pub struct Elements<S, B, const N: usize, const G: usize> {
    pub(super) list: Vec<Element<S, N, G>>,
    pub(super) node_count: usize,
    kind: std::marker::PhantomData<B>,
}

impl<S: Scalar, B: Basis<N, G>, const N: usize, const G: usize> Elements<S, B, N, G> {
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
            points: std::array::from_fn(|g| point::<S, B, N, G>(mesh, nodes, g)),
        });
        Ok(Self {
            list: list.collect(),
            node_count: mesh.nodes.len(),
            kind: std::marker::PhantomData,
        })
    }

    /// The elements.
    pub fn list(&self) -> &[Element<S, N, G>] {
        &self.list
    }

    /// How many nodes the mesh has.
    pub fn node_count(&self) -> usize {
        self.node_count
    }

    /// Volume of each element at rest \[m³\].
    pub fn volumes(&self) -> impl Iterator<Item = f64> {
        self.list
            .iter()
            .map(|e| e.points.iter().map(|p| p.volume.f64()).sum())
    }
}

fn point<S: Scalar, B: Basis<N, G>, const N: usize, const G: usize>(
    mesh: &TetMesh,
    nodes: &[u32; N],
    g: usize,
) -> Point<S> {
    let first = mesh.nodes[nodes[0] as usize];
    let mut jacobian = [[0.0; 3]; 3];
    for (node, gradient) in nodes.iter().zip(&B::GRADIENTS[g]) {
        let x = (mesh.nodes[*node as usize] - first).to_array();
        for (row, x) in jacobian.iter_mut().zip(x) {
            for (entry, gradient) in row.iter_mut().zip(gradient) {
                *entry += x * gradient;
            }
        }
    }
    Point {
        inverse: inverse(&jacobian).map(|row| row.map(S::of)),
        volume: S::of(det(&jacobian) / 6.0 * B::SHARE),
    }
}

/// ∂x/∂(ξ, η, ζ) of values at the nodes, at a point.
#[inline(always)]
pub(super) fn jacobian<S: Scalar, B: Basis<N, G>, const N: usize, const G: usize>(
    values: &[[S; 3]; N],
    g: usize,
) -> Mat<S> {
    let mut m = [[S::ZERO; 3]; 3];
    for (value, gradient) in values.iter().zip(&B::GRADIENTS[g]) {
        for (row, &v) in m.iter_mut().zip(value) {
            for (entry, &d) in row.iter_mut().zip(gradient) {
                *entry += v * S::of(d);
            }
        }
    }
    m
}

impl<S: Scalar, const N: usize, const G: usize> Element<S, N, G> {
    /// Values at its nodes less the value at the first, which keeps the digits of `f32` positions.
    #[inline(always)]
    pub(super) fn gather<T: Scalar>(&self, value: impl Fn(usize) -> [T; 3]) -> [[T; 3]; N] {
        let first = value(self.nodes[0] as usize);
        std::array::from_fn(|a| {
            let v = value(self.nodes[a] as usize);
            [v[0] - first[0], v[1] - first[1], v[2] - first[2]]
        })
    }
}
