//! Supports: points that give way to nothing, pinned nodes most often, and hold a shadow.
//!
//! From the third on they hold it in more ways than it can move, and what each of them bears is not determined. One after
//! the other they would hand loads that only strain the body to and fro, and never come to an end. So they are solved at
//! once, for the least sum of squares: of what velocities they are still off by where they contradict each other, and then
//! of the impulses, which shares a load as supports of equal stiffness do.
//!
//! With C the response of the shadow and of what is tied to it, J the motions of the points by that of the shadow and e
//! the velocities that they lack, these impulses are K⁺·e with K = J·C·Jᵀ. With R² = C, G = Jᵀ·J and M = R·G·R that is
//! J·(R·M⁺²·R)·(Jᵀ·e): a matrix of six by six, however many supports there are.

use super::composite::{Composite, NONE, from_blocks};
use super::pass::Pass;
use super::settled::Felt;
use crate::math::na::{SMatrix, SVector, SymmetricEigen};
use crate::math::{DMat3, DVec3};
use crate::solve::shadow::Shadow;

pub(super) type Mat6 = SMatrix<f64, 6, 6>;
pub(super) type Vec6 = SVector<f64, 6>;

/// What counts as a motion that supports hold, in parts of the one that they hold most: those on a line don't keep a body
/// from turning about it, and rounding takes them off it by 1e-7 of their distances, which counts by its square.
const LEAST_HELD: f64 = 1e-9;
/// Iterations of an eigenvalue; two or three are usual.
const ITERATIONS: usize = 256;

/// Points of mass about the centre of a shadow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inertia {
    /// Σ m \[kg\], Σ m·r \[kg·m\] and Σ m·(r²·1 − r·rᵀ) \[kg·m²\].
    pub mass: f64,
    moment: DVec3,
    inertia: DMat3,
}

impl Inertia {
    /// That of none.
    pub const NONE: Self = Self {
        mass: 0.0,
        moment: DVec3::ZERO,
        inertia: DMat3::ZERO,
    };

    /// Adds a point of `m` kg at `r`.
    pub fn add(&mut self, m: f64, r: DVec3) {
        self.mass += m;
        self.moment += r * m;
        let outer = DMat3::from_cols(r * r.x, r * r.y, r * r.z);
        self.inertia += (DMat3::from_diagonal(DVec3::splat(r.length_squared())) - outer) * m;
    }

    /// Momentum and angular momentum by velocity and spin: Σ Jᵀ·m·J.
    pub fn matrix(&self) -> Mat6 {
        let s = self.moment;
        let turn = DMat3::from_cols(
            DVec3::new(0.0, s.z, -s.y),
            DVec3::new(-s.z, 0.0, s.x),
            DVec3::new(s.y, -s.x, 0.0),
        );
        let mass = DMat3::from_diagonal(DVec3::splat(self.mass));
        from_blocks(mass, -turn, turn, self.inertia)
    }
}

/// R·M⁺²·R for supports of unit mass and a shadow that answers with `c`.
pub(super) fn bearing(c: &Mat6, supports: &Inertia) -> Option<Mat6> {
    let root = of_eigenvalues(c, |x, _| x.max(0.0).sqrt())?;
    let held = root * supports.matrix() * root;
    let inverse = |x: f64, most: f64| {
        if x > LEAST_HELD * most {
            1.0 / (x * x)
        } else {
            0.0
        }
    };
    Some(root * of_eigenvalues(&held, inverse)? * root)
}

/// A function of a symmetric matrix, which gets each eigenvalue and the largest.
fn of_eigenvalues(m: &Mat6, f: impl Fn(f64, f64) -> f64) -> Option<Mat6> {
    let SymmetricEigen {
        eigenvectors,
        eigenvalues,
    } = SymmetricEigen::try_new(*m, f64::EPSILON, ITERATIONS)?;
    let most = eigenvalues.max();
    let values = Mat6::from_diagonal(&eigenvalues.map(|x| f(x, most)));
    Some(eigenvectors * values * eigenvectors.transpose())
}

/// How a shadow answers.
pub(super) fn response(shadow: &Shadow) -> Mat6 {
    let cross = shadow.cross.unwrap_or(DMat3::ZERO);
    from_blocks(
        shadow.inv_mass,
        cross,
        cross.transpose(),
        shadow.inv_inertia,
    )
}

impl Pass<'_> {
    /// Has the supports of a composite bear what they don't yet; whether anybody feels it.
    pub(super) fn bear(&mut self, composite: usize) -> bool {
        let Composite {
            shadow,
            first,
            supports,
            bearing: Some(bearing),
            ..
        } = self.composites.list[composite]
        else {
            return false;
        };
        let (mut off, mut turned) = (DVec3::ZERO, DVec3::ZERO);
        let mut i = first as usize;
        while i != NONE as usize {
            if self.composites.is_support(i) {
                let error = self.tie_error(i);
                off += error;
                turned += self.ties[i].arm.cross(error);
            }
            i = self.composites.next[i] as usize;
        }
        let (linear, angular) = times(&bearing, off, turned);
        let (impulse, torque) = times(&supports.matrix(), linear, angular);
        let shadow = &mut self.shadows[shadow as usize];
        shadow.take(impulse, torque);
        let mut felt = false;
        i = first as usize;
        while i != NONE as usize {
            if self.composites.is_support(i) {
                let tie = &mut self.ties[i];
                let change = linear + angular.cross(tie.arm);
                tie.impulse -= change;
                self.composites.followed[i] = (shadow.v, shadow.w);
                let (change, square) = (change.length_squared(), tie.impulse.length_squared());
                felt |= self.settled.felt(change, square, tie.give).shadows;
            }
            i = self.composites.next[i] as usize;
        }
        felt
    }

    /// The same for the composite of one of them, unless it has done so since its shadow last moved.
    pub(super) fn bear_again(&mut self, i: usize) -> bool {
        let shadow = self.ties[i].shadow;
        let Shadow { v, w, .. } = self.shadows[shadow as usize];
        let Some(composite) = self.composites.of_tie(i) else {
            return false;
        };
        if (v, w) == self.composites.followed[i] {
            return false;
        }
        let felt = Felt {
            nodes: false,
            shadows: self.bear(composite),
        };
        if felt.any() {
            self.worklist.change(&[], [shadow; 2], felt);
        }
        felt.any()
    }
}

/// The product with a motion or a wrench.
fn times(m: &Mat6, linear: DVec3, angular: DVec3) -> (DVec3, DVec3) {
    let product = m * motion(linear, angular);
    let part = |i: usize| DVec3::new(product[i], product[i + 1], product[i + 2]);
    (part(0), part(3))
}

/// A motion or a wrench of both parts.
pub(super) fn motion(linear: DVec3, angular: DVec3) -> Vec6 {
    let [a, b] = [linear, angular].map(|v| v.to_array());
    SVector::from([a[0], a[1], a[2], b[0], b[1], b[2]])
}
