//! Tetrahedral meshes: what a solid of finite elements is made from.
//!
//! Positions are `f64`: gradients of shape functions are differences of neighbouring positions, and a mesh that comes
//! from a file far from the origin would lose its strains' last digits before the first step.

mod bind;
mod faces;
mod midpoints;
mod moduli;
mod quality;
mod springs;

#[cfg(feature = "import")]
pub(crate) use midpoints::sort_by_edge;
pub use moduli::SpringModuli;
pub use quality::{Quality, Worst};

use super::BuildError;
use crate::law::basis;
use crate::math::DVec3;

/// Below this part of the cube of its longest edge, the volume of a tet is rounding noise of `f32` positions: it is flat.
const FLAT: f64 = 1.0e-7;

/// How many bad tets an error names.
const NAMED: usize = 8;

/// Nodes of tetrahedra, all of one kind. Corners a, b, c, d turn right-handed: (b − a)×(c − a)·(d − a) > 0.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub enum Tets {
    /// Four corners: constant strain. Cheap per element, too stiff in bending and where volume is nearly kept.
    Linear(Vec<[u32; 4]>),
    /// Four corners and the middles of the edges 01, 12, 02, 03, 13, 23: linear strain, curved edges. The kind to prefer.
    Quadratic(Vec<[u32; 10]>),
}

impl Default for Tets {
    fn default() -> Self {
        Self::Linear(Vec::new())
    }
}

impl Tets {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Linear(tets) => tets.len(),
            Self::Quadratic(tets) => tets.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The nodes of each, corners first.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> + Clone {
        let (linear, quadratic) = match self {
            Self::Linear(tets) => (&tets[..], &[][..]),
            Self::Quadratic(tets) => (&[][..], &tets[..]),
        };
        let linear = linear.iter().map(|t| &t[..]);
        linear.chain(quadratic.iter().map(|t| &t[..]))
    }

    /// The four corners of each.
    pub fn corners(&self) -> impl Iterator<Item = [u32; 4]> {
        self.iter().map(|t| [t[0], t[1], t[2], t[3]])
    }
}

/// A tetrahedral mesh at rest.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct TetMesh {
    /// Positions \[m\].
    pub nodes: Vec<DVec3>,
    /// The elements.
    pub tets: Tets,
    /// Triangles of the boundary over the nodes, counter-clockwise seen from outside. A quadratic face is four of them.
    pub faces: Vec<[u32; 3]>,
}

impl TetMesh {
    /// A mesh of nodes and elements; the faces are those of a single element.
    ///
    /// # Errors
    /// Those of [`TetMesh::check`].
    pub fn new(nodes: Vec<DVec3>, tets: Tets) -> Result<Self, BuildError> {
        let mut mesh = Self {
            nodes,
            tets,
            faces: Vec::new(),
        };
        mesh.check()?;
        mesh.faces = faces::of_boundary(&mesh.tets);
        Ok(mesh)
    }

    /// Checks indices, positions and the volume of every tet; of quadratic ones at corners and integration points.
    ///
    /// # Errors
    /// [`BuildError::Empty`] without tets, [`BuildError::Value`] for a position that is not finite,
    /// [`BuildError::IndexOutOfRange`], and [`BuildError::FlatTets`] with the ids and volumes of the worst.
    pub fn check(&self) -> Result<(), BuildError> {
        if self.tets.is_empty() {
            return Err(BuildError::Empty);
        }
        let bad = |p: &DVec3| !p.as_vec3().is_finite();
        if let Some(node) = self.nodes.iter().position(bad) {
            return Err(BuildError::NodeVector {
                node: node as u32,
                what: "position",
                value: self.nodes[node].as_vec3(),
            });
        }
        let count = self.nodes.len() as u32;
        let range = |what, index: usize, nodes: &[u32]| match nodes.iter().find(|n| **n >= count) {
            Some(&node) => Err(BuildError::IndexOutOfRange {
                what,
                index: index as u32,
                node,
                count,
            }),
            None => Ok(()),
        };
        for (index, nodes) in self.tets.iter().enumerate() {
            range("tet", index, nodes)?;
        }
        for (index, nodes) in self.faces.iter().enumerate() {
            range("face", index, nodes)?;
        }
        let mut worst: Vec<(u32, f64)> = (0..self.tets.len() as u32)
            .map(|tet| (tet, self.least_volume(tet as usize)))
            .filter(|&(tet, volume)| {
                volume.is_nan() || volume <= FLAT * self.longest_edge(tet as usize).powi(3)
            })
            .collect();
        let bad = worst.len();
        if bad == 0 {
            return Ok(());
        }
        worst.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        worst.truncate(NAMED);
        Err(BuildError::FlatTets { count: bad, worst })
    }

    /// Where the corners of a tet are.
    pub(super) fn corners(&self, tet: &[u32]) -> [DVec3; 4] {
        std::array::from_fn(|i| self.nodes[tet[i] as usize])
    }

    fn nodes_of(&self, tet: usize) -> &[u32] {
        match &self.tets {
            Tets::Linear(tets) => &tets[tet],
            Tets::Quadratic(tets) => &tets[tet],
        }
    }

    fn longest_edge(&self, tet: usize) -> f64 {
        let p = self.corners(self.nodes_of(tet));
        let lengths = basis::EDGES.map(|[a, b]| p[a].distance(p[b]));
        lengths.into_iter().fold(0.0, f64::max)
    }

    /// The signed volume of a tet \[m³\]; of a quadratic one the least its map has anywhere it is looked at.
    fn least_volume(&self, tet: usize) -> f64 {
        let nodes = self.nodes_of(tet);
        if nodes.len() == 4 {
            return volume(self.corners(nodes));
        }
        let mut places = basis::POINTS.to_vec();
        places.extend((0..4).map(|c| std::array::from_fn(|i| if i == c { 1.0 } else { 0.0 })));
        let at = |l: &[f64; 4]| {
            let mut columns = [DVec3::ZERO; 3];
            for (node, gradient) in nodes.iter().zip(basis::quadratic_gradients(*l)) {
                for (column, g) in columns.iter_mut().zip(gradient) {
                    *column += (self.nodes[*node as usize] - self.nodes[nodes[0] as usize]) * g;
                }
            }
            columns[0].cross(columns[1]).dot(columns[2]) / 6.0
        };
        // NaN is the worst of all.
        places.iter().map(at).fold(
            f64::INFINITY,
            |m, v| if v < m || v.is_nan() { v } else { m },
        )
    }

    /// The volume of each tet by its corners \[m³\].
    pub fn corner_volumes(&self) -> impl Iterator<Item = f64> {
        self.tets.iter().map(|tet| volume(self.corners(tet)))
    }
}

/// The signed volume of a tet \[m³\].
pub(super) fn volume([a, b, c, d]: [DVec3; 4]) -> f64 {
    (b - a).cross(c - a).dot(d - a) / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Vec<DVec3> {
        vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]
    }

    #[test]
    fn bad_tets_are_refused_with_their_ids_and_volumes() {
        let mut nodes = corner();
        nodes.push(DVec3::new(0.5, 0.5, 0.0));
        let tets = vec![[0, 1, 2, 3], [1, 0, 2, 3], [0, 1, 2, 4]];
        let error = TetMesh::new(nodes, Tets::Linear(tets)).unwrap_err();
        let BuildError::FlatTets { count, worst } = &error else {
            panic!("{error}");
        };
        assert_eq!((*count, worst[0].0, worst[1].0), (2, 1, 2));
        assert!((worst[0].1 + 1.0 / 6.0).abs() < 1e-15 && worst[1].1 == 0.0);
        assert!(
            error.to_string().contains("tet 1 (-1.667e-1 m³)"),
            "{error}"
        );
    }

    #[test]
    fn bad_nodes_and_indices_are_refused() {
        let one = || Tets::Linear(vec![[0, 1, 2, 3]]);
        let mut nodes = corner();
        nodes[2].y = f64::NAN;
        let error = TetMesh::new(nodes, one()).unwrap_err();
        assert!(
            matches!(error, BuildError::NodeVector { node: 2, .. }),
            "{error}"
        );
        let error = TetMesh::new(corner(), Tets::Linear(vec![[0, 1, 2, 9]])).unwrap_err();
        assert!(
            matches!(error, BuildError::IndexOutOfRange { node: 9, .. }),
            "{error}"
        );
        assert_eq!(TetMesh::default().check(), Err(BuildError::Empty));
        assert!(TetMesh::new(corner(), Tets::Linear(vec![[0, 1, 2, 2]])).is_err());
    }

    #[test]
    fn a_curved_tet_that_folds_is_refused() {
        let mesh = TetMesh::new(corner(), Tets::Linear(vec![[0, 1, 2, 3]])).unwrap();
        let mut mesh = mesh.quadratic();
        mesh.check().unwrap();
        mesh.nodes[4] = DVec3::new(0.9, 0.0, 0.0);
        assert!(matches!(
            mesh.check(),
            Err(BuildError::FlatTets { count: 1, .. })
        ));
    }
}
