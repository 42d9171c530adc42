//! The longest stable substep of each scheme, from a bound on the stiffness and the damping modes.
//!
//! `k` bounds λ(M⁻¹K) [1/s²] and `c` bounds λ(M⁻¹C) [1/s]. Damping enters: lagged damping lowers the limit of symplectic
//! Euler, so a limit from stiffness alone would be wrong.

use crate::math::Number;

/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
pub type Symmetric<S> = [S; 6];

/// Adds along·nn⊤ + across·(1 − nn⊤) for a unit vector n.
#[inline(always)]
pub fn add_spring<S: Number>(m: &mut Symmetric<S>, n: [S; 3], along: S, across: S) {
    let d = along - across;
    m[0] += across + d * n[0] * n[0];
    m[1] += across + d * n[1] * n[1];
    m[2] += across + d * n[2] * n[2];
    m[3] += d * n[0] * n[1];
    m[4] += d * n[0] * n[2];
    m[5] += d * n[1] * n[2];
}

/// A cheap upper bound of the largest eigenvalue of a positive matrix: the lesser of trace and row-sum norm.
#[inline(always)]
pub fn cheap_bound<S: Number>(m: &Symmetric<S>) -> S {
    let row = |a: S, b: S, c: S| a + b.abs() + c.abs();
    let norm = row(m[0], m[3], m[4])
        .max(row(m[1], m[3], m[5]))
        .max(row(m[2], m[4], m[5]));
    norm.min(m[0] + m[1] + m[2])
}

/// An estimate of the largest eigenvalue of a positive matrix, at most that and at least 0.85 of it: (tr M⁴/tr M²)^½.
#[inline(always)]
pub fn about_largest<S: Number>(m: &Symmetric<S>) -> S {
    // By the trace, or the fourth powers of large ones would be beyond `f32`.
    let trace = (m[0] + m[1] + m[2]).max(S::of(1e-30));
    let [a, b, c, d, e, f] = m.map(|x| x / trace);
    let square = |[a, b, c, d, e, f]: Symmetric<S>| {
        let off = d * d + e * e + f * f;
        a * a + b * b + c * c + (off + off)
    };
    let squared = [
        a * a + d * d + e * e,
        d * d + b * b + f * f,
        e * e + f * f + c * c,
        a * d + d * b + e * f,
        a * e + d * f + e * c,
        d * e + b * f + f * c,
    ];
    let lengths = [
        square(squared),
        square([a, b, c, d, e, f]).max(S::of(1e-30)),
    ];
    trace * (lengths[0] / lengths[1]).sqrt()
}

/// The share of its stiffness with which a stretched spring resists sideways, 1 − L/l; 0 for a pressed one. Nodes in one
/// place have no direction, n = 0, and may part in any: 1. (What is cut has n = 0 and L = l, and resists nowhere.)
#[inline(always)]
pub fn sideways<S: Number>(n: [S; 3], rest: S, length: S) -> S {
    let stretch = S::ONE - rest / length;
    let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    let lost = (S::ONE - (square + square)).max(S::ZERO);
    let apart = stretch.max(S::ZERO - stretch).min(S::ONE);
    stretch.max(lost * apart).max(S::ZERO)
}

/// Symplectic Euler and velocity Verlet with the damping of the last velocity: h²k + 2hc < 4.
pub fn leapfrog(k: f64, c: f64) -> f64 {
    if k == 0.0 && c == 0.0 {
        return f64::INFINITY;
    }
    // The positive root, written so that k = 0 needs no case of its own.
    4.0 / (c + (c * c + 4.0 * k).sqrt())
}

/// Velocity Verlet with damping by half-step velocities: as [`leapfrog`], and the two fixed-point passes for the half-step
/// velocity, which contract by ½hc, want hc ≤ ½.
pub fn verlet(k: f64, c: f64) -> f64 {
    leapfrog(k, c).min(0.5 / c)
}

/// RK4: its stability region holds the half disc of radius 2.6 about 0 (2.83 on the imaginary axis, 2.78 on the real), of which
/// 2.2 is used, and overdamped modes are resolved, hc ≤ 0.43: at the edge of stability they would lose energy that no force
/// accounts for. Rows of contact give their impulses at the start of a substep and reckon with h·Δv, of which a mode moves by
/// 1 − hc/2 + h²(c² − k)/6 + h³(2kc − c³)/24: at 2.6 next to nothing. At 2.5 blocks that were crushed gained energy by
/// that, and at hc = 0.45 one that lay on a floor trembled there without end, 1.4 mm deep.
pub fn rk4(k: f64, c: f64) -> f64 {
    let radius = 0.5 * (c + (c * c + 4.0 * k).sqrt());
    (2.2 / radius).min(0.43 / c)
}

/// Explicit Euler: an underdamped mode needs h < c/k, so h must stay below the least c/k of any spring (`relaxation`);
/// an overdamped one h < 2/c. 0 where something is undamped: then no substep is stable.
pub fn explicit_euler(relaxation: f64, c: f64) -> f64 {
    relaxation.min(1.0 / c)
}

/// Midpoint: an undamped mode grows by (ωh)⁴/8 a step; damping 2ζω takes ζωh away, so h³ < 4·relaxation/k, of which half is
/// kept for what large motion adds to it; 2/c where overdamped.
pub fn midpoint(k: f64, c: f64, relaxation: f64) -> f64 {
    (2.0 * relaxation / k).cbrt().min(1.0 / c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_are_bounded_and_estimated() {
        // Diagonal ones, turned about z by an angle of 3:4:5.
        let (c, s) = (0.6_f32, 0.8);
        for (x, y, z) in [
            (1.0, 0.0, 0.0),
            (1.0, 1.0, 1.0),
            (1.0, 0.6, 0.6),
            (1.0, 0.6, 0.0),
            (0.3, 0.2, 1.0),
        ] {
            let scale = 1e12_f32;
            let m = [
                c * c * x + s * s * y,
                s * s * x + c * c * y,
                z,
                c * s * (x - y),
                0.0,
                0.0,
            ];
            let m = m.map(|m| m * scale);
            let bound = cheap_bound(&m) / scale;
            assert!((1.0 - 1e-6..=3.0).contains(&bound), "{x} {y} {z}: {bound}");
            let about = about_largest(&m) / scale;
            assert!((0.85..1.0 + 1e-6).contains(&about), "{x} {y} {z}: {about}");
        }
        assert_eq!(
            (cheap_bound(&[0.0; 6]), about_largest(&[0.0; 6])),
            (0.0, 0.0)
        );
    }

    #[test]
    fn one_spring_between_equal_nodes_has_the_textbook_limit() {
        // λ(K) = 2k/m, λ(C) = 2c/m, μ = m/2: h < (−c + √(c² + 4kμ))/k.
        let (k, c, m) = (1000.0_f64, 3.0, 0.5);
        let mu = 0.5 * m;
        let exact = (-c + (c * c + 4.0 * k * mu).sqrt()) / k;
        assert!((leapfrog(2.0 * k / m, 2.0 * c / m) - exact).abs() < 1e-12);
        assert!((leapfrog(2.0 * k / m, 0.0) - 2.0 / (2.0 * k / m).sqrt()).abs() < 1e-12);
    }

    /// Symptom: a block by RK4 that was crushed between others was pushed out of a floor with more energy than it had brought.
    /// Cause: at the longest substep an impulse hardly moved what it pushed, and rows pushed all the more.
    #[test]
    fn an_impulse_moves_what_it_pushes_by_rk4() {
        let k = 100.0_f64;
        for c in [0.0, 1.0, 5.0, 10.0, 20.0, 100.0] {
            let h = rk4(k, c);
            // Where RK4 takes x'' = −k·x − c·x' from x = 0, as a share of h·v.
            let moved = 1.0 - h * c / 2.0
                + h * h * (c * c - k) / 6.0
                + h * h * h * (2.0 * k * c - c * c * c) / 24.0;
            assert!(moved > 0.19, "{c}: {moved}");
        }
    }

    #[test]
    fn the_limits_separate_decay_from_growth() {
        // One damped oscillator x'' = -k x - c x', its amplification matrix applied many times just inside each limit.
        let (k, c) = (100.0_f64, 3.0);
        let grows = |h: f64, step: &dyn Fn(f64, f64, f64) -> (f64, f64)| {
            let (mut x, mut v) = (1.0, 0.0);
            for _ in 0..20_000 {
                (x, v) = step(x, v, h);
                if x.abs() > 1e6 || x.is_nan() {
                    return true;
                }
            }
            false
        };
        let euler = |x: f64, v: f64, h: f64| (x + h * v, v + h * (-k * x - c * v));
        let limit = explicit_euler(c / k, c);
        assert!(!grows(0.99 * limit, &euler) && grows(1.02 * limit, &euler));
        let symplectic = |x: f64, v: f64, h: f64| {
            let v = v + h * (-k * x - c * v);
            (x + h * v, v)
        };
        let limit = leapfrog(k, c);
        assert!(!grows(0.99 * limit, &symplectic) && grows(1.02 * limit, &symplectic));
        let midpoint_step = |x: f64, v: f64, h: f64| {
            let (xm, vm) = (x + 0.5 * h * v, v + 0.5 * h * (-k * x - c * v));
            (x + h * vm, v + h * (-k * xm - c * vm))
        };
        assert!(!grows(0.95 * midpoint(k, c, c / k), &midpoint_step));
    }
}
