//! A skin that touches others in the place of the nodes: a fine surface carried by a coarse mesh.
//!
//! Contact sees points, edges and faces. Those of a skin are weighted means of nodes, and what pushes a point pushes its
//! nodes by the same weights, so that work and momentum are those of the nodes (the transpose of the interpolation, as in
//! Sifakis & Barbič 2012, §5). The skin has no state of its own: it follows the nodes.

use super::net::{Binding, Node, Skin};
use super::{Blueprint, State, Topology};
use crate::math::{DVec3, Real};

/// A skin as contact sees it.
#[derive(Clone, Debug)]
pub struct Embedded {
    /// Its points as nodes without mass, and its faces, at rest.
    pub blueprint: Blueprint,
    /// Its faces and edges.
    pub topology: Topology,
    /// Where its points are, and how fast.
    pub state: State<Real>,
    /// Which nodes carry each point.
    pub bindings: Vec<Binding>,
    /// How much farther than its nodes a point may go: the largest sum of absolute weights of any, at least 1.
    pub gain: f64,
}

impl Embedded {
    /// The skin of a body at rest, if it has one that touches others.
    pub fn of(blueprint: &Blueprint) -> Option<Box<Self>> {
        let skin = blueprint.skin.as_ref().filter(|s| s.touches)?;
        Some(Box::new(Self::new(skin)))
    }

    /// A skin at rest.
    pub fn new(skin: &Skin) -> Self {
        let blueprint = Blueprint {
            nodes: skin.vertices.iter().map(|&x| Node::new(x, 0.0)).collect(),
            faces: skin.triangles.clone(),
            ..Blueprint::default()
        };
        let still = skin.vertices.iter().map(|x| (x.to_array(), [0.0; 3], 0.0));
        let sums = skin.bindings.iter().map(|b| {
            let weights = b.weights.iter();
            weights.map(|w| f64::from(w.abs())).sum::<f64>()
        });
        Self {
            topology: Topology::of(&blueprint),
            state: State::new(still, []),
            bindings: skin.bindings.clone(),
            gain: sums.fold(1.0, f64::max),
            blueprint,
        }
    }

    /// Puts its points where the nodes of a body carry them.
    pub fn follow(&mut self, body: &State<Real>) {
        self.state.origin = body.origin;
        for (i, binding) in self.bindings.iter().enumerate() {
            let (mut x, mut v) = (DVec3::ZERO, DVec3::ZERO);
            for (node, weight) in binding.parts() {
                x += body.local(node) * weight;
                v += body.velocity(node) * weight;
            }
            self.state.set_position(i, body.origin + x);
            self.state.set_velocity(i, v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;

    #[test]
    fn points_follow_their_nodes() {
        let skin = Skin {
            vertices: vec![Vector::new(0.25, 0.0, 0.0)],
            triangles: Vec::new(),
            bindings: vec![Binding {
                nodes: [0, 1, 0, 0, 0, 0, 0, 0],
                weights: [0.75, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            }],
            touches: true,
        };
        let mut embedded = Embedded::new(&skin);
        let mut body = State::new(
            [
                ([0.0; 3], [0.0, 1.0, 0.0], 1.0),
                ([1.0, 0.0, 0.0], [0.0; 3], 1.0),
            ],
            [],
        );
        body.origin = DVec3::new(1e5, 0.0, 0.0);
        embedded.follow(&body);
        let state = &embedded.state;
        assert_eq!(state.position(0), DVec3::new(1e5 + 0.25, 0.0, 0.0));
        assert_eq!(state.velocity(0), DVec3::Y * 0.75);
        assert_eq!(embedded.gain, 1.0);
    }
}
