//! What a solver writes: positions, velocities, rest lengths, plastic flow, broken flags.
//!
//! The layout is the one vector kernels want: a node is 32 bytes (x, y, z, 1/m, vx, vy, vz, swing), fetched by one
//! load that crosses no line of the cache. Positions are compensated: what rounding takes from x + h·v is kept in a low-order
//! part that only the integration touches, so that a node at 1 mm/s with h = 1 µs moves although h·v is far below the spacing
//! of `f32` at x. Springs use the high part. Positions are relative to an origin that follows the body, so that a body far
//! from the world's origin is as exact as one at it.

use crate::math::{DVec3, Scalar, two_sum};

/// One node as the solver sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Particle<S> {
    /// Position relative to the body's origin, high part \[m\].
    pub x: [S; 3],
    /// 1/m \[1/kg\]; 0 for a pinned node.
    pub inv_mass: S,
    /// Velocity \[m/s\].
    pub v: [S; 3],
    /// How far it swings in the body's fastest mode, in proportion to the others \[any unit\]: what has been learned of that
    /// mode for the stable substep. 1/m before anything has been, 0 for a pinned node.
    pub swing: S,
}

/// The changing part of a body.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct State<S> {
    /// Where the particles' frame stands in the world \[m\].
    pub origin: DVec3,
    /// The nodes.
    pub particles: Vec<Particle<S>>,
    /// Low-order part of each position \[m\], the fourth number 0.
    pub low: Vec<[S; 4]>,
    /// Current rest length of each spring \[m\].
    pub rest: Vec<S>,
    /// Accumulated plastic elongation Σ|ΔL_p| of each spring \[m\].
    pub flow: Vec<S>,
    /// Whether each spring has broken.
    pub broken: Vec<bool>,
}

impl<S: Scalar> Particle<S> {
    /// Its swing, or 1/m where it has none: a free node swings.
    pub(crate) fn sound_swing(&self) -> S {
        if self.swings_soundly() {
            self.swing
        } else {
            self.inv_mass
        }
    }

    /// Whether it has a swing if it is free, and none if it is pinned.
    pub(crate) fn swings_soundly(&self) -> bool {
        (self.swing > S::ZERO) == (self.inv_mass > S::ZERO) && self.swing.is_finite()
    }
}

impl<S: Scalar> State<S> {
    /// A state of nodes at rest positions, and springs of given rest lengths.
    pub fn new(
        nodes: impl IntoIterator<Item = ([S; 3], [S; 3], S)>,
        rest: impl IntoIterator<Item = S>,
    ) -> Self {
        let particles: Vec<_> = nodes
            .into_iter()
            .map(|(x, v, inv_mass)| Particle {
                x,
                inv_mass,
                v,
                swing: inv_mass,
            })
            .collect();
        let rest: Vec<S> = rest.into_iter().collect();
        Self {
            origin: DVec3::ZERO,
            low: vec![[S::ZERO; 4]; particles.len()],
            flow: vec![S::ZERO; rest.len()],
            broken: vec![false; rest.len()],
            particles,
            rest,
        }
    }

    /// Position of a node relative to the origin, both parts \[m\].
    #[inline]
    pub fn local(&self, node: usize) -> DVec3 {
        let (x, low) = (self.particles[node].x, self.low[node]);
        DVec3::new(
            x[0].f64() + low[0].f64(),
            x[1].f64() + low[1].f64(),
            x[2].f64() + low[2].f64(),
        )
    }

    /// Position of a node in the world \[m\].
    #[inline]
    pub fn position(&self, node: usize) -> DVec3 {
        self.origin + self.local(node)
    }

    /// Velocity of a node \[m/s\].
    #[inline]
    pub fn velocity(&self, node: usize) -> DVec3 {
        let v = self.particles[node].v;
        DVec3::new(v[0].f64(), v[1].f64(), v[2].f64())
    }

    /// Puts a node somewhere in the world \[m\].
    pub fn set_position(&mut self, node: usize, world: DVec3) {
        let local = (world - self.origin).to_array();
        for (axis, value) in local.into_iter().enumerate() {
            let high = S::of(value);
            self.particles[node].x[axis] = high;
            self.low[node][axis] = S::of(value - high.f64());
        }
    }

    /// Sets the velocity of a node \[m/s\].
    pub fn set_velocity(&mut self, node: usize, v: DVec3) {
        self.particles[node].v = [S::of(v.x), S::of(v.y), S::of(v.z)];
    }

    /// Sets the inverse mass of a node \[1/kg\], 0 to pin it. It counts as one that swings as far for its mass as any, until it
    /// is known better.
    pub fn set_inv_mass(&mut self, node: usize, inv_mass: S) {
        let free = self.particles.iter().filter(|p| p.inv_mass > S::ZERO);
        let most = free.fold(S::ZERO, |most, p| (p.swing / p.inv_mass).max(most));
        let most = if most > S::ZERO { most } else { S::ONE };
        let particle = &mut self.particles[node];
        (particle.inv_mass, particle.swing) = (inv_mass, inv_mass * most);
    }

    /// Moves a node by `by` \[m\] without losing what is below the spacing of its position.
    #[inline(always)]
    pub fn displace(&mut self, node: usize, by: [S; 3]) {
        let (x, low) = (&mut self.particles[node].x, &mut self.low[node]);
        for axis in 0..3 {
            (x[axis], low[axis]) = two_sum(x[axis], by[axis] + low[axis]);
        }
    }

    /// Takes over the nodes of another state of the same body without new memory.
    pub(crate) fn take_over_nodes(&mut self, other: &Self) {
        self.origin = other.origin;
        self.particles.clone_from(&other.particles);
        self.low.clone_from(&other.low);
    }

    /// The same for what springs have become.
    pub(crate) fn take_over_springs(&mut self, other: &Self) {
        self.rest.clone_from(&other.rest);
        self.flow.clone_from(&other.flow);
        self.broken.clone_from(&other.broken);
    }

    /// Mean position of the nodes in the world \[m\].
    pub fn centre(&self) -> DVec3 {
        let n = self.particles.len().max(1) as f64;
        let sum: DVec3 = (0..self.particles.len()).map(|i| self.local(i)).sum();
        self.origin + sum / n
    }

    /// Moves the origin to the body once it has strayed by more than the body's own size, or by more than `most` or a metre: what `f32`
    /// tells apart is a share of the distance to the origin. The shift is rounded to a thousandth of the size and applied to high and low
    /// part together, so that no position changes.
    pub fn recentre(&mut self, most: f64) {
        let n = self.particles.len().max(1) as f64;
        let (mut sum, mut squares) = (DVec3::ZERO, 0.0);
        for i in 0..self.particles.len() {
            let local = self.local(i);
            sum += local;
            squares += local.length_squared();
        }
        let offset = sum / n;
        // Twice the radius of gyration: the side of a cube. A point has none.
        let size = 2.0 * (squares / n - offset.length_squared()).max(0.0).sqrt();
        let size = if size > 1e-9 { size.min(1.0) } else { 1.0 };
        if offset.length() <= size.min(most) || !offset.is_finite() {
            return;
        }
        let grain = size.log2().floor().exp2() / 1024.0;
        let shift = ((offset / grain).round() * grain)
            .to_array()
            .map(|c| S::of(c));
        self.origin += DVec3::from_array(shift.map(|c| c.f64()));
        for (p, low) in self.particles.iter_mut().zip(&mut self.low) {
            for axis in 0..3 {
                // The shift is large: adding it to the low part first would round that away.
                let (high, error) = two_sum(p.x[axis], -shift[axis]);
                (p.x[axis], low[axis]) = two_sum(high, low[axis] + error);
            }
        }
    }

    /// Whether every position and velocity is finite.
    pub fn is_finite(&self) -> bool {
        self.particles
            .iter()
            .all(|p| p.x.iter().chain(&p.v).all(|c| c.is_finite()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_node_far_out_moves() {
        let mut s = State::<f32>::new([([2.0; 3], [0.0; 3], 1.0)], []);
        for _ in 0..1_000_000 {
            s.displace(0, [1.0e-9, 0.0, 0.0]);
        }
        assert!((s.local(0).x - 2.001).abs() < 1e-6, "{}", s.local(0).x);
    }

    #[test]
    fn recentring_moves_nothing() {
        let mut s = State::<f32>::new([([0.123, -0.7, 0.31], [0.0; 3], 1.0)], []);
        s.set_position(0, DVec3::new(10_000.000_123, 3.3, -700.7));
        let before = s.position(0);
        s.recentre(1.0);
        assert!(s.local(0).length() < 0.01);
        assert_eq!((s.position(0) - before).length(), 0.0);
    }

    /// A body of 2 mm that flies a few centimetres is as exact as where it began.
    #[test]
    fn the_origin_follows_a_small_body() {
        let corner = |i: u32| [0, 1, 2].map(|k| 0.002 * (i >> k & 1) as f32);
        let nodes = (0..8).map(|i| (corner(i), [0.0; 3], 1.0));
        let mut s = State::<f32>::new(nodes, []);
        for _ in 0..30 {
            (0..8).for_each(|i| s.displace(i, [1e-3, 2e-3, 0.0]));
            let before: Vec<_> = (0..8).map(|i| s.position(i)).collect();
            s.recentre(1.0);
            for (i, before) in before.into_iter().enumerate() {
                assert!(s.local(i).length() < 0.005, "{}", s.local(i));
                assert!((s.position(i) - before).length() < 1e-15);
            }
        }
    }
}
