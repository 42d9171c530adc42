//! What a static solve asks of a body.

use crate::math::DVec3;
use crate::solve::fem::Model;

/// Something with an elastic energy over the positions of its nodes.
pub trait Structure {
    /// How many nodes it has.
    fn node_count(&self) -> usize;
    /// The elastic energy \[J\] at positions \[m\]; adds the elastic force on each node \[N\].
    fn forces(&self, positions: &[DVec3], forces: &mut [DVec3]) -> f64;
    /// Calls `add` with node a, node b and −∂(force on a)/∂(position of b) \[N/m\], row by row. Every pair that is coupled
    /// comes in both orders, the same pairs in the same order at all positions; a pair may come in several parts.
    fn stiffness(&self, positions: &[DVec3], add: &mut dyn FnMut(u32, u32, [[f64; 3]; 3]));
}

impl Structure for Model<f64> {
    fn node_count(&self) -> usize {
        Model::node_count(self)
    }

    fn forces(&self, positions: &[DVec3], forces: &mut [DVec3]) -> f64 {
        let at = |n: usize| positions[n].to_array();
        self.add_elastic(at, |n, f| forces[n] += DVec3::from_array(f));
        self.energy(at)
    }

    fn stiffness(&self, positions: &[DVec3], add: &mut dyn FnMut(u32, u32, [[f64; 3]; 3])) {
        let each = |nodes: &[u32], matrix: &[f64]| {
            let size = 3 * nodes.len();
            for (a, &na) in nodes.iter().enumerate() {
                for (b, &nb) in nodes.iter().enumerate() {
                    let entry = |i: usize, j: usize| matrix[(3 * a + i) * size + 3 * b + j];
                    let row = |i: usize| [entry(i, 0), entry(i, 1), entry(i, 2)];
                    add(na, nb, [row(0), row(1), row(2)]);
                }
            }
        };
        Model::stiffness(self, |n| positions[n].to_array(), each);
    }
}
