//! A net: nodes, springs and surface faces in their rest configuration. It is what shape functions and importers
//! return and what a builder turns into a body.
//!
//! A net describes geometry first. A spring made by a shape function has a `section` (m²): the cross-section of the bar
//! that stands for its share of the solid, so that one [`Material`](super::Material) gives every constant:
//! k = E·section/L, c = η·section/L, F_y = σ_y·section. A spring written by hand has its constants in N/m, N·s/m and N
//! and needs no material. Likewise a node has a `volume` (m³) to be multiplied by a density, or a `mass` (kg).

use super::BuildError;
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

    /// A bar of `section` m² whose constants come from a material.
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
