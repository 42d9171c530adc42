//! The longest stable substep of each scheme, from a bound on the stiffness and the damping modes.
//!
//! `k` bounds λ(M⁻¹K) [1/s²] and `c` bounds λ(M⁻¹C) [1/s]. Damping enters: lagged damping lowers the limit of symplectic
//! Euler, so a limit from stiffness alone would be wrong.

use crate::math::Number;

/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
type Symmetric<S> = [S; 6];

/// How the springs of a node resist its motion: Σ along·nn⊤ + across·(1 − nn⊤) over their unit vectors n.
#[derive(Clone, Copy, Debug, Default)]
pub struct Resistance<S> {
    /// Σ (along − across)·nn⊤.
    directed: Symmetric<S>,
    /// Σ across.
    round: S,
}

impl<S: Number> Resistance<S> {
    /// Adds a spring that resists along n and, no more than that, across it.
    #[inline(always)]
    pub fn add(&mut self, n: [S; 3], along: S, across: S) {
        self.add_along(n, along - across);
        self.round += across;
    }

    /// Adds one that resists along n only.
    #[inline(always)]
    pub fn add_along(&mut self, n: [S; 3], along: S) {
        let [x, y, z] = [n[0] * along, n[1] * along, n[2] * along];
        let m = &mut self.directed;
        m[0] += x * n[0];
        m[1] += y * n[1];
        m[2] += z * n[2];
        m[3] += x * n[1];
        m[4] += x * n[2];
        m[5] += y * n[2];
    }

    /// How they resist where they do most; up to 3·10⁻⁶ more.
    #[inline(always)]
    pub fn largest(&self) -> S {
        largest_eigenvalue(&self.directed) + self.round
    }
}

/// The largest eigenvalue of a matrix that has none below 0, in closed form (Smith 1961); up to 3·10⁻⁶ more where nothing is
/// rounded.
#[inline(always)]
fn largest_eigenvalue<S: Number>(m: &Symmetric<S>) -> S {
    let (half, third) = (S::of(0.5), S::of(1.0 / 3.0));
    // By the trace, or products of large ones would be beyond `f32`.
    let trace = m[0] + m[1] + m[2];
    let per_trace = S::ONE / trace.max(S::of(1e-30));
    let [a, b, c, d, e, f] = m.map(|x| x * per_trace);
    let (a, b, c) = (a - third, b - third, c - third);
    let off = d * d + e * e + f * f;
    let spread = a * a + b * b + c * c + (off + off);
    let p = (spread * S::of(1.0 / 6.0)).sqrt();
    // A ball has no direction: any will do.
    let per_p = S::ONE / p.max(S::of(1e-15));
    let determinant = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e);
    let cos_of_thrice = determinant * per_p * per_p * per_p * half;
    let s = ((S::ONE + cos_of_thrice) * half)
        .max(S::ZERO)
        .min(S::ONE)
        .sqrt();
    // cos(⅔·acos s) from 0 to 1 and at most 3·10⁻⁶ more, by Chebyshev's interpolation.
    let [last, more @ ..] = [
        0.004_120_803,
        -0.019_121_829,
        0.047_634_507,
        -0.109_884_46,
        0.577_250_4,
        0.500_002_8,
    ]
    .map(S::of);
    let cos = more.into_iter().fold(last, |sum, next| sum * s + next);
    trace * (third + (p + p) * cos)
}

/// The share of its stiffness with which a stretched spring resists sideways, 1 − L/l; 0 for a pressed one. Nodes in one
/// place have no direction, n = 0, and may part in any: 1. (What is cut has n = 0 and L = l, and resists nowhere.) Wants L/l.
#[inline(always)]
pub fn sideways<S: Number>(n: [S; 3], shortness: S) -> S {
    let stretch = S::ONE - shortness;
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

/// Velocity Verlet with damping by half-step velocities: as [`leapfrog`], and the fixed-point passes for the half-step velocity,
/// which contract by ½hc, want hc ≤ ½.
pub fn verlet(k: f64, c: f64) -> f64 {
    leapfrog(k, c).min(0.5 / c)
}

/// RK4: its stability region holds the half disc of radius 2.6 about 0 (2.83 on the imaginary axis, 2.78 on the real), of which
/// 1.7 is used, and overdamped modes are resolved, hc ≤ 0.43: at the edge of stability they would lose energy that no force
/// accounts for. Rows of contact give their impulses at the start of a substep and reckon with h·Δv, of which a mode moves by
/// 1 − hc/2 + h²(c² − k)/6 + h³(2kc − c³)/24: half of it at 1.7, next to nothing at 2.6. At 2.5 blocks that were crushed gained
/// energy by that, at 2.2 the corner of one lay 4 mm deep in a floor, and at hc = 0.45 one trembled there without end.
pub fn rk4(k: f64, c: f64) -> f64 {
    let radius = 0.5 * (c + (c * c + 4.0 * k).sqrt());
    (1.7 / radius).min(0.43 / c)
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
    fn the_largest_eigenvalue_is_hardly_more() {
        // Diagonal ones, turned about z by an angle of 3:4:5 and then about x likewise.
        let turned = |[x, y, z]: [f64; 3]| {
            let (c, s) = (0.6, 0.8);
            let (xx, yy, xy) = (
                c * c * x + s * s * y,
                s * s * x + c * c * y,
                c * s * (x - y),
            );
            let (yy, zz, yz) = (
                c * c * yy + s * s * z,
                s * s * yy + c * c * z,
                c * s * (yy - z),
            );
            [xx, yy, zz, c * xy, s * xy, yz]
        };
        let mut seed = 1_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24)
        };
        let special = [
            [1.0; 3],
            [1.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 0.6, 0.6],
            [1.0, 1.0, 1.0 - 1e-6],
        ];
        let random = (0..1000).map(|_| [random(), random(), random()]);
        for values in special.into_iter().chain(random) {
            let exact = values.into_iter().fold(0.0, f64::max);
            let m = turned(values);
            let found = largest_eigenvalue(&m) / exact;
            assert!(
                (1.0 - 1e-12..1.0 + 3e-6).contains(&found),
                "{values:?}: {found}"
            );
            for scale in [1e-12, 1e12] {
                let found = largest_eigenvalue(&m.map(|x| (scale * x) as f32));
                let found = f64::from(found) / (scale * exact);
                assert!((found - 1.0).abs() < 2e-4, "{values:?}: {found} in f32");
            }
        }
        assert_eq!(largest_eigenvalue(&[0.0_f32; 6]), 0.0);
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
            assert!(moved > 0.5, "{c}: {moved}");
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
