//! A net: nodes, springs and surface faces in their rest configuration. It is what shape functions and importers
//! return and what a builder turns into a body.
//!
//! A net describes geometry first. A spring made by a shape function has a `section` (m²): the cross-section of the bar
//! that stands for its share of the solid, so that one [`Material`](super::Material) gives every constant:
//! k = E·section/L, c = η·section/L, F_y = σ_y·section. A spring written by hand has its constants in N/m, N·s/m and N
//! and needs no material. Likewise a node has a `volume` (m³) to be multiplied by a density, or a `mass` (kg).

use super::BuildError;
use super::adjacency::Adjacency;
use crate::math::{Real, Vector};

/// A point mass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Node {
    /// Where it is at rest, in the body's own frame \[m\].
    pub position: Vector,
    /// Velocity at insertion, added to the body's \[m/s\].
    pub linvel: Vector,
    /// Mass \[kg\]; 0 means "from `volume` and the material's density".
    pub mass: Real,
    /// The share of the solid this node stands for \[m³\].
    pub volume: Real,
    /// A pinned node stays where it is put (or follows its kinematic target) whatever pulls on it.
    pub pinned: bool,
}

impl Node {
    /// A node of `mass` kg at `position`.
    pub fn new(position: Vector, mass: Real) -> Self {
        Self {
            position,
            linvel: Vector::ZERO,
            mass,
            volume: 0.0,
            pinned: false,
        }
    }

    /// A node that stands for `volume` m³ of a material.
    pub fn of_volume(position: Vector, volume: Real) -> Self {
        Self {
            volume,
            ..Self::new(position, 0.0)
        }
    }

    /// The same node, pinned.
    pub fn pinned(self) -> Self {
        Self {
            pinned: true,
            ..self
        }
    }
}

/// An axial spring between two nodes: elastic up to its yield forces, then plastic with linear hardening, until it breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Spring {
    /// The two nodes it joins.
    pub nodes: [u32; 2],
    /// Length without force \[m\]; `None` means the distance of the nodes at rest.
    pub rest_length: Option<Real>,
    /// Cross-section of the equivalent bar \[m²\]; 0 for a spring whose constants are given below.
    pub section: Real,
    /// k \[N/m\].
    pub stiffness: Real,
    /// c \[N·s/m\], on the rate of elongation.
    pub damping: Real,
    /// Tension at which it begins to flow \[N\]; infinite: never.
    pub yield_tension: Real,
    /// Compression at which it begins to flow \[N\], positive; infinite: never.
    pub yield_compression: Real,
    /// Growth of both yield forces per metre of plastic elongation \[N/m\].
    pub hardening: Real,
    /// Tension at which it breaks \[N\]; infinite: never.
    pub break_force: Real,
    /// Strain (elongation over rest length at build) at which it breaks; infinite: never.
    pub break_strain: Real,
}

impl Spring {
    /// An elastic spring with stiffness k \[N/m\], undamped, that neither yields nor breaks.
    pub fn new(a: u32, b: u32, stiffness: Real) -> Self {
        Self {
            nodes: [a, b],
            rest_length: None,
            section: 0.0,
            stiffness,
            damping: 0.0,
            yield_tension: Real::INFINITY,
            yield_compression: Real::INFINITY,
            hardening: 0.0,
            break_force: Real::INFINITY,
            break_strain: Real::INFINITY,
        }
    }

    /// A bar of `section` m² whose constants come from a material, but for damping and limits that it is given besides.
    pub fn of_section(a: u32, b: u32, section: Real) -> Self {
        Self {
            section,
            ..Self::new(a, b, 0.0)
        }
    }

    /// The same spring with damping c \[N·s/m\].
    pub fn damping(self, damping: Real) -> Self {
        Self { damping, ..self }
    }

    /// The same spring with another rest length \[m\].
    pub fn rest_length(self, rest_length: Real) -> Self {
        Self {
            rest_length: Some(rest_length),
            ..self
        }
    }

    /// The same spring, flowing at ±`force` N with linear hardening \[N/m\].
    pub fn yielding(self, force: Real, hardening: Real) -> Self {
        Self {
            yield_tension: force,
            yield_compression: force,
            hardening,
            ..self
        }
    }

    /// The same spring, breaking at a tension of `force` N.
    pub fn breaking(self, force: Real) -> Self {
        Self {
            break_force: force,
            ..self
        }
    }
}

/// A triangle mesh carried by the nodes: each vertex is a fixed weighted mean of nodes. It is drawn in the place of the
/// body's own faces, and may touch others in their place.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Skin {
    /// Rest position of each vertex, in the body's own frame \[m\].
    pub vertices: Vec<Vector>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Per vertex: up to eight nodes and their weights, which sum to 1 (unused places have weight 0).
    pub bindings: Vec<Binding>,
    /// Whether it touches others, in the place of the nodes.
    pub touches: bool,
}

/// Eight nodes and weights: where a skin vertex is, given its nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Binding {
    /// Node indices.
    pub nodes: [u32; 8],
    /// Weights, summing to 1.
    pub weights: [Real; 8],
}

impl Binding {
    /// The nodes that count, and their weights.
    pub fn parts(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let parts = self.nodes.iter().zip(self.weights);
        parts
            .filter(|(_, weight)| *weight != 0.0)
            .map(|(&node, weight)| (node as usize, f64::from(weight)))
    }
}

/// Nodes, springs, surface faces and an optional skin, at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Net {
    /// The point masses.
    pub nodes: Vec<Node>,
    /// The springs.
    pub springs: Vec<Spring>,
    /// Surface triangles over the nodes, counter-clockwise seen from outside; both sides count for a sheet.
    pub faces: Vec<[u32; 3]>,
    /// A finer surface for pictures, and for contact if it says so.
    pub skin: Option<Skin>,
}

impl Net {
    /// A net of explicit nodes and springs, without faces.
    pub fn new(nodes: Vec<Node>, springs: Vec<Spring>) -> Self {
        Self {
            nodes,
            springs,
            ..Self::default()
        }
    }

    /// The same net with every node satisfying `which` pinned.
    pub fn pin(mut self, which: impl Fn(Vector) -> bool) -> Self {
        for node in &mut self.nodes {
            node.pinned |= which(node.position);
        }
        self
    }

    /// The same net moved by `by` \[m\].
    pub fn translated(mut self, by: Vector) -> Self {
        for node in &mut self.nodes {
            node.position += by;
        }
        if let Some(skin) = &mut self.skin {
            for vertex in &mut skin.vertices {
                *vertex += by;
            }
        }
        self
    }

    /// The same net with its nodes numbered so that those joined by springs lie near each other in memory, and the new number
    /// of each old node. By reverse Cuthill–McKee (*Proc. 24th Nat. Conf. ACM*, 1969).
    ///
    /// Nothing but speed depends on it. Meshers number nodes as they make them, all over the body; a large body of such nodes
    /// waits for memory, and threads that share it wait for each other. Bodies by shape functions are in order. Springs and
    /// faces keep their places.
    ///
    /// # Errors
    /// What [`Net::check`] says.
    ///
    /// ```
    /// use crumple::prelude::*;
    /// use crumple::rapier3d::prelude::*;
    ///
    /// let node = |x: f32| Node::new(Vector::X * x, 0.1);
    /// // A chain whose ends are nodes 0 and 1.
    /// let nodes = vec![node(0.0), node(3.0), node(1.0), node(2.0)];
    /// let springs = [[0, 2], [2, 3], [3, 1]].map(|[a, b]| Spring::new(a, b, 1e4));
    /// let (net, new) = Net::new(nodes, springs.into()).in_order()?;
    /// assert!(net.springs.iter().all(|s| s.nodes[0].abs_diff(s.nodes[1]) == 1));
    /// assert_eq!(net.nodes[new[1] as usize].position.x, 3.0);
    /// # Ok::<(), crumple::body::BuildError>(())
    /// ```
    pub fn in_order(mut self) -> Result<(Self, Vec<u32>), BuildError> {
        self.check()?;
        let springs = self.springs.iter().map(|s| s.nodes);
        let order = Adjacency::new(self.nodes.len(), (0..).zip(springs)).cuthill_mckee();
        let mut new = vec![0; order.len()];
        for (place, &old) in (0..).zip(&order) {
            new[old as usize] = place;
        }
        let renamed = |node: &mut u32| *node = new[*node as usize];
        self.nodes = order.iter().map(|&old| self.nodes[old as usize]).collect();
        let springs = self.springs.iter_mut().flat_map(|s| &mut s.nodes);
        springs.for_each(renamed);
        self.faces.iter_mut().flatten().for_each(renamed);
        if let Some(skin) = &mut self.skin {
            let bound = skin.bindings.iter_mut().flat_map(|b| &mut b.nodes);
            bound.for_each(renamed);
        }
        Ok((self, new))
    }

    /// Smallest and largest corner of the nodes \[m\]; both zero for an empty net.
    pub fn bounds(&self) -> (Vector, Vector) {
        let Some(first) = self.nodes.first() else {
            return (Vector::ZERO, Vector::ZERO);
        };
        self.nodes
            .iter()
            .fold((first.position, first.position), |(lo, hi), n| {
                (lo.min(n.position), hi.max(n.position))
            })
    }

    /// Distance of a spring's nodes at rest \[m\].
    pub(crate) fn length(&self, spring: &Spring) -> Real {
        let [a, b] = spring.nodes;
        self.nodes[a as usize]
            .position
            .distance(self.nodes[b as usize].position)
    }

    /// Checks every value that does not depend on a material.
    ///
    /// # Errors
    /// The first [`BuildError`] found: an empty net, a value that is not finite or negative, an index out of range, a
    /// spring from a node to itself or of zero length.
    pub fn check(&self) -> Result<(), BuildError> {
        super::error::check_net(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::shape::lattice;

    /// A lattice whose nodes are numbered all over, with a skin on its first face.
    fn without_order() -> Net {
        let mut net = lattice(Vector::ONE, 0.125).unwrap();
        let count = net.nodes.len() as u32;
        // 7 and 729 have no common factor.
        let new = |node: u32| 7 * node % count;
        let mut nodes = net.nodes.clone();
        for (old, node) in (0..).zip(&net.nodes) {
            nodes[new(old) as usize] = *node;
        }
        net.nodes = nodes;
        for spring in &mut net.springs {
            spring.nodes = spring.nodes.map(new);
        }
        for face in &mut net.faces {
            *face = face.map(new);
        }
        let [a, b, c] = net.faces[0];
        net.skin = Some(Skin {
            vertices: vec![net.nodes[c as usize].position],
            bindings: vec![Binding {
                nodes: [c, a, b, 0, 0, 0, 0, 0],
                weights: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            }],
            ..Skin::default()
        });
        net
    }

    fn spread(net: &Net) -> u32 {
        let apart = net.springs.iter().map(|s| s.nodes[0].abs_diff(s.nodes[1]));
        apart.max().unwrap()
    }

    #[test]
    fn order_brings_neighbours_together_and_changes_names_only() {
        let old = without_order();
        let (net, new) = old.clone().in_order().unwrap();
        // A layer of 9² nodes is as narrow as a lattice gets; one of Cuthill and McKee may be askew.
        assert!(
            spread(&old) > 600 && spread(&net) < 3 * 81,
            "{}",
            spread(&net)
        );
        let renamed = |node: &u32| new[*node as usize];
        for (node, name) in old.nodes.iter().zip(&new) {
            assert_eq!(net.nodes[*name as usize], *node);
        }
        for (old, spring) in old.springs.iter().zip(&net.springs) {
            assert_eq!(old.nodes.map(|n| renamed(&n)), spring.nodes);
            assert_eq!(old.section, spring.section);
        }
        for (old, face) in old.faces.iter().zip(&net.faces) {
            assert_eq!(old.map(|n| renamed(&n)), *face);
        }
        let skin = net.skin.unwrap();
        let [(node, weight)] = skin.bindings[0].parts().collect::<Vec<_>>()[..] else {
            panic!("one node")
        };
        assert_eq!((net.nodes[node].position, weight), (skin.vertices[0], 1.0));
    }

    #[test]
    fn what_is_no_net_has_no_order() {
        assert!(matches!(Net::default().in_order(), Err(BuildError::Empty)));
        let nodes = vec![Node::new(Vector::ZERO, 1.0), Node::new(Vector::X, 1.0)];
        let net = Net::new(nodes, vec![Spring::new(0, 2, 1.0)]);
        let wrong = net.in_order();
        assert!(matches!(
            wrong,
            Err(BuildError::IndexOutOfRange { node: 2, .. })
        ));
    }
}
