//! Springs side by side, one of each row: where they reach, and what they do to the nodes of the rows.

use super::table::End;
use super::vector::Vector;
use crate::law::spring;

/// The nodes of a part of a slice, and what their springs sum to.
#[derive(Clone, Copy)]
pub struct Nodes<V> {
    pub at: [V; 3],
    pub velocity: [V; 3],
    pub elastic: [V; 3],
    pub damping: [V; 3],
}

/// A spring of each lane as if it had no limits.
#[derive(Clone, Copy)]
pub struct Trial<V> {
    /// From the row's node to the other \[m\].
    pub reach: [V; 3],
    pub length: V,
    /// 1/length \[1/m\].
    pub inverse: V,
    pub elongation: V,
}

#[inline(always)]
fn dot<V: Vector>(a: [V; 3], b: [V; 3]) -> V {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn difference<V: Vector>([x, y, z]: [V; 3], b: [V; 3]) -> [V; 3] {
    [x - b[0], y - b[1], z - b[2]]
}

/// How far springs reach: what there is to know before a root is taken.
#[derive(Clone, Copy)]
pub struct Reach<V> {
    /// From the row's node to the other \[m\].
    reach: [V; 3],
    /// Its square, and no less than what counts \[m²\].
    square: V,
}

impl<V: Vector> Reach<V> {
    #[inline(always)]
    pub fn new(at: [V; 3], far: &impl End<V>, part: usize) -> Self {
        let reach = difference(far.place(part), at);
        Self {
            reach,
            square: dot(reach, reach).max(V::of(spring::LEAST_SQUARE)),
        }
    }

    /// The springs of these rest lengths.
    #[inline(always)]
    pub fn trial(&self, rest: V) -> Trial<V> {
        self.of_root(self.square.root(), rest)
    }

    #[inline(always)]
    fn of_root(&self, [length, inverse]: [V; 2], rest: V) -> Trial<V> {
        Trial {
            reach: self.reach,
            length,
            inverse,
            elongation: length - rest,
        }
    }
}

impl<V: Vector> Trial<V> {
    /// By the divider: for passes that have so much else to do that it holds nothing up.
    #[inline(always)]
    pub fn new(at: [V; 3], far: &impl End<V>, part: usize, rest: V) -> Self {
        let reach = Reach::new(at, far, part);
        let length = reach.square.sqrt();
        reach.of_root([length, V::ONE / length], rest)
    }

    /// From the row's node to the other.
    #[inline(always)]
    pub fn direction(&self) -> [V; 3] {
        let d = self.reach;
        [
            d[0] * self.inverse,
            d[1] * self.inverse,
            d[2] * self.inverse,
        ]
    }

    /// The same, with neither length nor elongation in lanes that have no spring, and so no stiffness.
    #[inline(always)]
    pub fn without_strays<E: End<V>>(self, stiffness: V) -> Self {
        if !E::STRAYS {
            return self;
        }
        let held = |x| V::above(stiffness, V::ZERO, x, V::ZERO);
        Self {
            length: held(self.length),
            elongation: held(self.elongation),
            ..self
        }
    }
}

impl<V: Vector> Nodes<V> {
    /// Those that are a part of an end.
    #[inline(always)]
    pub fn of<const DAMPED: bool>(own: &impl End<V>, part: usize) -> Self {
        Self {
            at: own.place(part),
            velocity: if DAMPED {
                own.velocity(part)
            } else {
                [V::ZERO; 3]
            },
            elastic: [V::ZERO; 3],
            damping: [V::ZERO; 3],
        }
    }

    /// The same with the force of drag \[N·s/m\] at their velocities.
    #[inline(always)]
    pub fn dragged(mut self, own: &impl End<V>, part: usize, drag: f32) -> Self {
        self.velocity = own.velocity(part);
        let drag = V::of(drag.into());
        for k in 0..3 {
            self.damping[k] = -(drag * self.velocity[k]);
        }
        self
    }

    /// Adds springs of this tension \[N\].
    #[inline(always)]
    pub fn pull(&mut self, trial: &Trial<V>, tension: V) {
        let share = tension * trial.inverse;
        for k in 0..3 {
            self.elastic[k] += trial.reach[k] * share;
        }
    }

    /// Adds what damps them.
    #[inline(always)]
    pub fn damp(&mut self, trial: &Trial<V>, rate: V, viscosity: V) {
        let share = spring::damping(viscosity, rate) * trial.inverse;
        for k in 0..3 {
            self.damping[k] += trial.reach[k] * share;
        }
    }

    /// Rate of elongation \[m/s\].
    #[inline(always)]
    pub fn rate(&self, trial: &Trial<V>, far: &impl End<V>, part: usize) -> V {
        let velocity = difference(far.velocity(part), self.velocity);
        dot(velocity, trial.reach) * trial.inverse
    }
}
