//! Springs as a structure.

use super::Structure;
use crate::body::{Blueprint, Net, Spring, State};
use crate::law::spring;
use crate::math::{DMat3, DVec3, Real};

/// The elastic part of a body of springs: what yields, breaks or damps is not seen.
#[derive(Clone, Debug)]
pub struct SpringNet {
    nodes: usize,
    /// Nodes, stiffness \[N/m\], rest length \[m\].
    springs: Vec<([u32; 2], f64, f64)>,
}

impl SpringNet {
    /// The springs of a blueprint, at their rest lengths.
    pub fn new(blueprint: &Blueprint) -> Self {
        let each = |s: &Spring| {
            let rest = s.rest_length.unwrap_or(0.0);
            (s.nodes, f64::from(s.stiffness), f64::from(rest))
        };
        Self {
            nodes: blueprint.nodes.len(),
            springs: blueprint.springs.iter().map(each).collect(),
        }
    }

    /// The same at the rest lengths to which they have flowed, without those that broke.
    pub fn of_state(blueprint: &Blueprint, state: &State<Real>) -> Self {
        let mut net = Self::new(blueprint);
        let now = state.rest.iter().zip(&state.broken);
        for ((_, stiffness, rest), (length, broken)) in net.springs.iter_mut().zip(now) {
            *rest = (*length).into();
            if *broken {
                *stiffness = 0.0;
            }
        }
        // What pulls at nothing holds nothing.
        net.springs.retain(|(_, stiffness, _)| *stiffness > 0.0);
        net
    }

    /// The springs of a net whose sections stand for a Young's modulus \[Pa\]; those without a section keep their stiffness.
    /// Rest lengths are taken between the given positions \[m\], in `f64`, so that there is no stress there. Springs that
    /// name a node without a position are left out.
    pub fn of_sections(net: &Net, young: f64, positions: &[DVec3]) -> Self {
        let each = |s: &Spring| {
            let [a, b] = s.nodes.map(|n| positions.get(n as usize));
            let length = a?.distance(*b?);
            let section = spring::of_section(young, f64::from(s.section), length);
            Some((s.nodes, f64::from(s.stiffness) + section, length))
        };
        Self {
            nodes: positions.len(),
            springs: net.springs.iter().filter_map(each).collect(),
        }
    }
}

/// Direction and length of a spring; a spring of no length has no direction.
fn axis(positions: &[DVec3], [a, b]: [u32; 2]) -> (DVec3, f64) {
    let d = positions[b as usize] - positions[a as usize];
    let length = d.length();
    (d / length.max(f64::MIN_POSITIVE), length)
}

impl Structure for SpringNet {
    fn node_count(&self) -> usize {
        self.nodes
    }

    fn forces(&self, positions: &[DVec3], forces: &mut [DVec3]) -> f64 {
        let mut energy = 0.0;
        for &(nodes, stiffness, rest) in &self.springs {
            let (n, length) = axis(positions, nodes);
            let pull = n * spring::tension(stiffness, length - rest);
            forces[nodes[0] as usize] += pull;
            forces[nodes[1] as usize] -= pull;
            energy += spring::energy(stiffness, length - rest);
        }
        energy
    }

    fn stiffness(&self, positions: &[DVec3], add: &mut dyn FnMut(u32, u32, [[f64; 3]; 3])) {
        for &(nodes, stiffness, rest) in &self.springs {
            let (n, length) = axis(positions, nodes);
            // Along the spring k, across it tension over length.
            let across = if length > 0.0 {
                stiffness * (1.0 - rest / length)
            } else {
                0.0
            };
            let along = DMat3::from_cols(n * n.x, n * n.y, n * n.z) * (stiffness - across);
            let block = (along + DMat3::from_diagonal(DVec3::splat(across))).to_cols_array_2d();
            let other = block.map(|row| row.map(|x| -x));
            let [a, b] = nodes;
            add(a, a, block);
            add(b, b, block);
            add(a, b, other);
            add(b, a, other);
        }
    }
}
