//! The rotation nearest to a deformation, for every deformation: F = R·S with R a proper rotation.
//!
//! R maximises tr(RᵀF). The trace of S is the largest root t of a quartic whose coefficients are invariants of F, and
//! R = ∂t/∂F is rational in F and t (Lin, Chitalu & Komura, *Isotropic ARAP Energy Using Cauchy–Green Invariants*, 2022).
//! That needs no case for inverted or flat elements: where det F < 0, S has one negative eigenvalue, the smallest in size,
//! which is the choice that lets an inverted element turn back (Irving, Teran & Fedkiw 2004). A polar
//! decomposition by Newton's iteration or by singular values would need the sign repaired afterwards.
//!
//! Where two stretches nearly cancel, the quotient loses its digits. There R comes from a quaternion q, as the
//! eigenvector to t of the 4×4 matrix K for which tr(RᵀF) = qᵀKq (Davenport's q-method; Horn 1987). The one place where R is
//! not unique is det F < 0 with the two smallest stretches equal: there R is one of the nearest rotations.
//!
//! The root is found by Newton's method from the bound t ≤ √3·‖F‖, which converges from above; for a rotation the bound is
//! the root.

use super::tensor::{Mat, add_scaled, cofactor, contract, det, from_fn, mul, scale, transpose_mul};
use crate::math::{LANES, Number};

/// More than this many Newton steps are never needed outside the double root, where the last few change nothing of use.
const STEPS: usize = 24;

/// Below this product of the sums of two stretches, over ½‖F‖³, the quotient is not used; 3.08 for a rotation. The
/// quotient loses digits as ε/CLOSE²: at this value its rotations are orthonormal to 3·10⁻¹³ in `f64`.
const CLOSE: f64 = 3e-2;

/// R and S of F = R·S, R a proper rotation, S symmetric. R is the unit matrix for F = 0 and has no meaning for entries that
/// are not finite.
#[inline(always)]
pub fn polar<S: Number>(f: &Mat<S>) -> (Mat<S>, Mat<S>) {
    let r = rotation(f);
    let s = transpose_mul(&r, f);
    (r, super::tensor::symmetric(&s))
}

/// The proper rotation nearest to `f`.
#[inline(always)]
pub fn rotation<S: Number>(f: &Mat<S>) -> Mat<S> {
    let c = cofactor(f);
    let j = f[0][0] * c[0][0] + f[0][1] * c[0][1] + f[0][2] * c[0][2];
    let square = contract(f, f);
    let size = square.sqrt();
    let two = S::of(2.0);
    let t = trace_of_stretch(square, size, contract(&c, &c), j);
    let gap = t * (t * t - square) - two * j;
    let sum = scale(f, t * t + square);
    let sum = add_scaled(&sum, -two, &mul(f, &transpose_mul(f, f)));
    let r = scale(&add_scaled(&sum, two * t, &c), S::ONE / gap);
    let least = S::of(CLOSE) * square * size;
    if gap.all_above(least) {
        return r;
    }
    one_by_one(f, &r, S::above(gap, least, S::ONE, S::ZERO))
}

/// The largest root of (t² − ‖F‖²)² − 4‖cof F‖² − 8·det(F)·t.
#[inline(always)]
fn trace_of_stretch<S: Number>(square: S, size: S, cofactors: S, j: S) -> S {
    let (four, eight) = (S::of(4.0), S::of(8.0));
    let mut root = S::of(3.0_f64.sqrt()) * size;
    // A lane that has arrived stays, so that its root does not depend on its neighbours.
    let mut going = S::ONE;
    for _ in 0..STEPS {
        let over = root * root - square;
        let value = over * over - four * cofactors - eight * j * root;
        let slope = four * root * over - eight * j;
        let step = value / slope;
        root -= S::above(going, S::ZERO, step, S::ZERO);
        going = S::above(S::of(S::COARSE) * root, step.abs(), S::ZERO, going);
        if S::ONE.all_above(going) {
            break;
        }
    }
    root
}

/// The rotation of each lane by itself, in `f64`, where it is not `known`.
#[cold]
#[inline(never)]
fn one_by_one<S: Number>(f: &Mat<S>, r: &Mat<S>, known: S) -> Mat<S> {
    let mut lanes = [super::tensor::zero(); LANES];
    for (lane, rotation) in lanes.iter_mut().enumerate().take(S::LANES) {
        *rotation = if known.lane(lane) > 0.0 {
            from_fn(|i, j| r[i][j].lane(lane))
        } else {
            by_quaternion(&from_fn(|i, j| f[i][j].lane(lane)))
        };
    }
    from_fn(|i, j| S::of_lanes(|lane| lanes[lane][i][j]))
}

fn by_quaternion(f: &Mat<f64>) -> Mat<f64> {
    let size = contract(f, f).sqrt();
    if !(size > 0.0 && size.is_finite()) {
        return super::tensor::unit();
    }
    // Entries of about 1 keep the quartic within range.
    let f = scale(f, 1.0 / size);
    from_quaternion(eigenvector(&davenport(&f), largest_root(&f)))
}

/// K, whose quadratic form over unit quaternions (w, x, y, z) is tr(RᵀF).
fn davenport(f: &Mat<f64>) -> [[f64; 4]; 4] {
    let (xx, yy, zz) = (f[0][0], f[1][1], f[2][2]);
    let (x, y, z) = (f[2][1] - f[1][2], f[0][2] - f[2][0], f[1][0] - f[0][1]);
    let (xy, xz, yz) = (f[0][1] + f[1][0], f[0][2] + f[2][0], f[1][2] + f[2][1]);
    [
        [xx + yy + zz, x, y, z],
        [x, xx - yy - zz, xy, xz],
        [y, xy, yy - xx - zz, yz],
        [z, xz, yz, zz - xx - yy],
    ]
}

/// The largest root of det(K − λI) = λ⁴ − 2‖F‖²λ² − 8·det(F)·λ + det K, for ‖F‖ = 1.
fn largest_root(f: &Mat<f64>) -> f64 {
    let c = super::tensor::cofactor(f);
    // With stretches σ: det K = Σσ⁴ − 2Σσᵢ²σⱼ² = ‖F‖⁴ − 4‖cof F‖².
    let constant = 1.0 - 4.0 * contract(&c, &c);
    let linear = 8.0 * det(f);
    let two = 2.0;
    let mut root = 3.0_f64.sqrt();
    for _ in 0..STEPS {
        let square = root * root;
        let value = (square - two) * square - linear * root + constant;
        let slope = 4.0 * (square - 1.0) * root - linear;
        if slope <= 0.0 || value <= 0.0 {
            break;
        }
        let next = root - value / slope;
        if next == root {
            break;
        }
        root = next;
    }
    root
}

/// The eigenvector of a simple eigenvalue: the longest column of the adjugate of K − λI.
fn eigenvector(k: &[[f64; 4]; 4], root: f64) -> [f64; 4] {
    let mut m = *k;
    for (i, row) in m.iter_mut().enumerate() {
        row[i] -= root;
    }
    let mut best = ([1.0, 0.0, 0.0, 0.0], 0.0);
    for column in 0..4 {
        let q = adjugate_column(&m, column);
        let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
        if square > best.1 {
            best = (q, square);
        }
    }
    best.0
}

fn adjugate_column(m: &[[f64; 4]; 4], column: usize) -> [f64; 4] {
    let others =
        |skip: usize| -> [usize; 3] { std::array::from_fn(|i| i + usize::from(i >= skip)) };
    let rows = others(column);
    std::array::from_fn(|i| {
        let columns = others(i);
        let minor = det(&super::tensor::from_fn(|a, b| m[rows[a]][columns[b]]));
        if (i + column).is_multiple_of(2) {
            minor
        } else {
            -minor
        }
    })
}

/// The rotation of a quaternion (w, x, y, z) of any length but zero.
fn from_quaternion(q: [f64; 4]) -> Mat<f64> {
    let largest = q.iter().fold(0.0, |m, c| m.max(c.abs()));
    if largest <= 0.0 {
        return super::tensor::unit();
    }
    let q = q.map(|c| c / largest);
    let [w, x, y, z] = q;
    let s = 2.0 / (w * w + x * x + y * y + z * z);
    [
        [
            1.0 - s * (y * y + z * z),
            s * (x * y - w * z),
            s * (x * z + w * y),
        ],
        [
            s * (x * y + w * z),
            1.0 - s * (x * x + z * z),
            s * (y * z - w * x),
        ],
        [
            s * (x * z - w * y),
            s * (y * z + w * x),
            1.0 - s * (x * x + y * y),
        ],
    ]
}

/// How R changes along `d`: dR = R·\[ω\]ₓ with (tr(S)·I − S)·ω the axial vector of Rᵀd − dᵀR. It grows without bound where
/// R is not unique; there the change is held finite.
#[inline(always)]
pub fn rotation_differential<S: Number>(r: &Mat<S>, s: &Mat<S>, d: &Mat<S>) -> Mat<S> {
    let a = transpose_mul(r, d);
    let axial = [a[2][1] - a[1][2], a[0][2] - a[2][0], a[1][0] - a[0][1]];
    let t = super::tensor::trace(s);
    let g = super::tensor::from_fn(|i, j| if i == j { t - s[i][j] } else { -s[i][j] });
    let c = super::tensor::cofactor(&g);
    let determinant = g[0][0] * c[0][0] + g[0][1] * c[0][1] + g[0][2] * c[0][2];
    let size = contract(s, s);
    let floor = S::of(1e-9) * size * size.sqrt() + S::of(1e-30);
    // g is at least positive semidefinite, so rounding alone can make its determinant negative.
    let w = super::tensor::apply(&c, axial).map(|x| x / determinant.max(floor));
    let cross = [
        [S::ZERO, -w[2], w[1]],
        [w[2], S::ZERO, -w[0]],
        [-w[1], w[0], S::ZERO],
    ];
    super::tensor::mul(r, &cross)
}

#[cfg(test)]
mod tests {
    use super::super::tensor::*;
    use super::*;
    use proptest::prelude::*;

    fn far(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
        let d = sub(a, b);
        contract(&d, &d).sqrt()
    }

    fn turned(axis: [f64; 3], stretch: [f64; 3], other: [f64; 3]) -> (Mat<f64>, Mat<f64>) {
        let u = from_quaternion([1.0, axis[0], axis[1], axis[2]]);
        let v = from_quaternion([1.0, other[0], other[1], other[2]]);
        let s = mul_transpose(
            &mul(&v, &from_fn(|i, j| if i == j { stretch[i] } else { 0.0 })),
            &v,
        );
        (u, s)
    }

    proptest! {
        #[test]
        fn the_factors_come_back(
            axis in prop::array::uniform3(-3.0..3.0_f64),
            other in prop::array::uniform3(-3.0..3.0_f64),
            stretch in prop::array::uniform3(0.05..4.0_f64),
            inverted in prop::bool::ANY,
        ) {
            let mut stretch = stretch;
            stretch.sort_by(f64::total_cmp);
            if inverted {
                stretch[0] = -stretch[0].min(0.9 * stretch[1]);
            }
            let (r, s) = turned(axis, stretch, other);
            let f = mul(&r, &s);
            let (found_r, found_s) = polar(&f);
            prop_assert!(far(&found_r, &r) < 1e-9, "{}", far(&found_r, &r));
            prop_assert!(far(&found_s, &s) < 1e-9);
            let f32s = from_fn(|i, j| f[i][j] as f32);
            let (r32, _) = polar(&f32s);
            // The gap of the two largest eigenvalues of K is 2(σ₀ + σ₁). A wide one leaves the rounding of nine entries.
            let gap = ((stretch[0] + stretch[1]) / stretch[2]).min(1.0);
            let wide = from_fn(|i, j| f64::from(r32[i][j]));
            prop_assert!(far(&wide, &r) < 2e-6 / gap.powi(2), "{} {gap}", far(&wide, &r));
        }

        #[test]
        fn any_matrix_gives_a_proper_rotation(f in prop::array::uniform9(-2.0..2.0_f64), zeros in 0u32..512) {
            let f: Mat<f64> = from_fn(|i, j| if zeros >> (3 * i + j) & 1 == 1 { 0.0 } else { f[3 * i + j] });
            let r = rotation(&f);
            prop_assert!(far(&mul_transpose(&r, &r), &unit()) < 1e-12 && det(&r) > 0.0);
        }
    }

    #[test]
    fn the_differential_is_the_slope() {
        for stretch in [[0.6, 1.1, 1.7], [-0.3, 0.8, 1.2]] {
            let (r, s) = turned([0.3, -0.8, 0.4], stretch, [0.9, 0.1, -0.5]);
            let f = mul(&r, &s);
            let d = [[0.3, -0.1, 0.7], [0.2, 0.9, -0.3], [0.1, 0.4, -0.6]];
            let e = 1e-6;
            let slope = scale(
                &sub(
                    &rotation(&add_scaled(&f, e, &d)),
                    &rotation(&add_scaled(&f, -e, &d)),
                ),
                0.5 / e,
            );
            assert!(far(&slope, &rotation_differential(&r, &s, &d)) < 1e-7);
        }
    }

    #[test]
    fn hopeless_matrices_give_something_finite() {
        for f in [
            zero(),
            scale(&unit(), -1.0),
            scale(&unit(), 1e-300),
            scale(&unit(), 1e200),
            [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]],
            scale(&unit(), f64::NAN),
        ] {
            let r = rotation(&f);
            assert!(far(&mul_transpose(&r, &r), &unit()) < 1e-12, "{f:?}");
        }
    }
}
