//! The boxes around all nodes and around their velocities.

use super::Kernel;
use super::vector::{LANES, Pass, Vector, numbers, run};
use crate::body::state::{Particle, State};
use crate::math::DVec3;

/// The corners of a box around all nodes \[m\], wider than the nodes stand by what rounding may add. What is not a number does
/// not count.
pub(crate) fn box_around(kernel: Kernel, state: &State<f32>) -> (DVec3, DVec3) {
    let [lo, hi] = extent(kernel, state, 0, |p| p.x);
    let low = f64::from(f32::EPSILON) * lo.abs().max(hi.abs());
    (state.origin + lo - low, state.origin + hi + low)
}

/// The least and the greatest velocities of all nodes, in each direction \[m/s\]. What is not a number does not count.
pub(crate) fn velocities_around(kernel: Kernel, state: &State<f32>) -> [DVec3; 2] {
    extent(kernel, state, 4, |p| p.v)
}

/// The least and the greatest of three numbers of all nodes, of which `first` is the place of the first in them.
fn extent(
    kernel: Kernel,
    state: &State<f32>,
    first: usize,
    of: impl Fn(&Particle<f32>) -> [f32; 3],
) -> [DVec3; 2] {
    let (groups, others) = state.particles.as_chunks();
    let found = run(kernel, Extent(groups));
    let corner = |x: &[f32]| DVec3::new(x[0].into(), x[1].into(), x[2].into());
    let [lo, hi] = found.map(|x| corner(&x[first..]));
    let others = others.iter().map(|p| corner(&of(p)));
    others.fold([lo, hi], |[lo, hi], x| [lo.min(x), hi.max(x)])
}

/// The least and the greatest of each of the eight numbers of nodes.
struct Extent<'a>(&'a [[Particle<f32>; LANES]]);

impl Pass for Extent<'_> {
    type Output = [[f32; 8]; 2];

    #[inline(always)]
    fn run<V: Vector>(self) -> Self::Output {
        // Two by turns: narrow vectors are half a row, and none waits for the one before.
        let mut least = [V::of(f64::INFINITY); 2];
        let mut greatest = [V::of(f64::NEG_INFINITY); 2];
        for group in self.0 {
            let rows = numbers(group);
            for first in (0..8 * LANES).step_by(2 * V::LANES) {
                for k in 0..2 {
                    let x = V::load_from(&rows[first + k * V::LANES..]);
                    least[k] = x.min(least[k]);
                    greatest[k] = x.max(greatest[k]);
                }
            }
        }
        let mut all = [[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]];
        for i in 0..2 * V::LANES {
            let (k, lane) = (i / V::LANES, i % V::LANES);
            all[0][i % 8] = all[0][i % 8].min(least[k].lane(lane) as f32);
            all[1][i % 8] = all[1][i % 8].max(greatest[k].lane(lane) as f32);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_around_nodes_holds_them_all() {
        for count in [1, 3, 16, 37] {
            let place = |i: usize| [(i * 7 % 11) as f32, -0.3 * (i * 5 % 13) as f32, 2.0];
            let mut s = State::<f32>::new((0..count).map(|i| (place(i), [0.0; 3], 1.0)), []);
            s.origin = DVec3::new(100.0, 0.0, 0.0);
            for node in 0..count {
                s.displace(node, [1e-9, -1e-9, 1e-8]);
            }
            let places = || (0..count).map(|i| s.position(i));
            let least = places().fold(DVec3::INFINITY, DVec3::min);
            let greatest = places().fold(DVec3::NEG_INFINITY, DVec3::max);
            for kernel in [Kernel::Auto, Kernel::Avx2, Kernel::Portable] {
                let (lo, hi) = box_around(kernel, &s);
                assert!(places().all(|x| lo.cmple(x).all() && hi.cmpge(x).all()));
                assert!((lo - least).length() < 1e-5 && (hi - greatest).length() < 1e-5);
            }
        }
    }

    #[test]
    fn velocities_lie_between_the_least_and_the_greatest() {
        for count in [1, 3, 16, 37] {
            let v = |i: usize| [(i * 7 % 11) as f32, -0.5 * (i * 5 % 13) as f32, 2.0];
            let s = State::<f32>::new((0..count).map(|i| ([9.0; 3], v(i), 1.0)), []);
            let velocities = || (0..count).map(|i| s.velocity(i));
            let least = velocities().fold(DVec3::INFINITY, DVec3::min);
            let greatest = velocities().fold(DVec3::NEG_INFINITY, DVec3::max);
            for kernel in [Kernel::Auto, Kernel::Avx2, Kernel::Portable] {
                assert_eq!(velocities_around(kernel, &s), [least, greatest]);
            }
        }
    }
}
