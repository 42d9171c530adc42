//! The trilinear hexahedron: a cube whose eight corners were moved.
//!
//! A cell on a curved surface is not a cube any more, and its volume, its nodes' shares and the place of a point in it
//! must come from where its corners are, or the body is too heavy and its skin swims. The trilinear map is the one whose
//! weights a skin binding holds. Corners are numbered as in the grid: bit d is the far side of axis d.

use crate::math::{DMat3, DVec3};

/// Weights of the corners at ξ (0 to 1 along each axis inside the cell); they sum to 1.
pub(super) fn weights(xi: DVec3) -> [f64; 8] {
    let x = xi.to_array();
    std::array::from_fn(|c| {
        (0..3)
            .map(|d| if c >> d & 1 == 1 { x[d] } else { 1.0 - x[d] })
            .product()
    })
}

/// The point with these weights \[m\].
pub(super) fn blend(corners: &[DVec3; 8], weights: &[f64; 8]) -> DVec3 {
    corners.iter().zip(weights).map(|(p, w)| *p * *w).sum()
}

/// ∂x/∂ξ at ξ.
fn jacobian(corners: &[DVec3; 8], xi: DVec3) -> DMat3 {
    let x = xi.to_array();
    let column = |axis: usize| -> DVec3 {
        (0..8)
            .map(|c| {
                let weight: f64 = (0..3)
                    .map(|d| match (d == axis, c >> d & 1 == 1) {
                        (true, far) => f64::from(far as u8) * 2.0 - 1.0,
                        (false, true) => x[d],
                        (false, false) => 1.0 - x[d],
                    })
                    .product();
                corners[c] * weight
            })
            .sum()
    };
    DMat3::from_cols(column(0), column(1), column(2))
}

/// The smallest volume spanned by the three edges at a corner \[m³\]; the side cubed for a cube, negative for a corner
/// turned inside out.
pub(super) fn worst_corner(corners: &[DVec3; 8]) -> f64 {
    (0..8_usize)
        .map(|c| {
            let edge = |d: usize| {
                let out = corners[c ^ (1 << d)] - corners[c];
                if c >> d & 1 == 1 { -out } else { out }
            };
            edge(0).dot(edge(1).cross(edge(2)))
        })
        .fold(f64::INFINITY, f64::min)
}

/// Each corner's share of the volume, ∫ N dV \[m³\]. Two Gauss points per axis integrate it exactly.
pub(super) fn shares(corners: &[DVec3; 8]) -> [f64; 8] {
    let offset = 0.5 / 3.0_f64.sqrt();
    let mut out = [0.0; 8];
    for g in 0..8 {
        let sign = |d: usize| if g >> d & 1 == 1 { offset } else { -offset };
        let xi = DVec3::new(0.5 + sign(0), 0.5 + sign(1), 0.5 + sign(2));
        let volume = jacobian(corners, xi).determinant() / 8.0;
        for (share, w) in out.iter_mut().zip(weights(xi)) {
            *share += w * volume;
        }
    }
    out
}

/// ξ of `point` by Newton's method, to `tolerance` \[m\]; `None` where it does not converge, which happens only well
/// outside a distorted cell.
pub(super) fn inverse(corners: &[DVec3; 8], point: DVec3, tolerance: f64) -> Option<DVec3> {
    let mut xi = DVec3::splat(0.5);
    for _ in 0..25 {
        let miss = point - blend(corners, &weights(xi));
        if miss.length() <= tolerance {
            return Some(xi);
        }
        let j = jacobian(corners, xi);
        // A Jacobian this far from the cell's own is past a fold of the map.
        if j.determinant() <= 1.0e-3 * jacobian(corners, DVec3::splat(0.5)).determinant() {
            return None;
        }
        xi += j.inverse() * miss;
        if xi.abs().max_element() > 10.0 {
            return None;
        }
    }
    None
}

/// Weights that sum to 1 and reproduce `point` exactly by the cell's mean affine map. They exist for every point, grow
/// only linearly with its distance, and serve where the trilinear ones fold or would extrapolate too far.
pub(super) fn affine_weights(corners: &[DVec3; 8], point: DVec3) -> [f64; 8] {
    let sign = |c: usize| {
        let s = |d: usize| if c >> d & 1 == 1 { 1.0 } else { -1.0 };
        DVec3::new(s(0), s(1), s(2))
    };
    let centre = blend(corners, &[0.125; 8]);
    // x = centre + J·η for the weights (1 + s·η)/8, with J = Σ x sᵀ / 8.
    let column = |d: usize| -> DVec3 { (0..8).map(|c| corners[c] * (sign(c)[d] / 8.0)).sum() };
    let j = DMat3::from_cols(column(0), column(1), column(2));
    let eta = j.inverse() * (point - centre);
    std::array::from_fn(|c| (1.0 + sign(c).dot(eta)) / 8.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moved_cube() -> [DVec3; 8] {
        std::array::from_fn(|c| {
            let p = DVec3::new((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2) as f64);
            p + 0.15
                * DVec3::new(
                    (c as f64 * 1.7).sin(),
                    (c as f64 * 2.3).cos(),
                    (c as f64).sin(),
                )
        })
    }

    #[test]
    fn shares_of_a_box_are_eighths_and_sum_to_the_volume() {
        let brick = std::array::from_fn(|c| {
            DVec3::new(
                (c & 1) as f64,
                2.0 * (c >> 1 & 1) as f64,
                3.0 * (c >> 2) as f64,
            )
        });
        assert!(shares(&brick).iter().all(|s| (s - 0.75).abs() < 1e-12));
        assert!((worst_corner(&brick) - 6.0).abs() < 1e-12);
        // A sheared box keeps its volume.
        let sheared = brick.map(|p| p + DVec3::X * p.y);
        assert!((shares(&sheared).iter().sum::<f64>() - 6.0).abs() < 1e-12);
    }

    #[test]
    fn both_weights_reproduce_points() {
        let cell = moved_cube();
        assert!(worst_corner(&cell) > 0.2);
        for point in [[0.5, 0.5, 0.5], [0.1, 0.9, 0.3], [1.2, 0.5, -0.1]].map(DVec3::from_array) {
            let xi = inverse(&cell, point, 1e-10).unwrap();
            assert!((blend(&cell, &weights(xi)) - point).length() < 1e-9);
        }
        let far = DVec3::new(3.0, -2.0, 1.0);
        let w = affine_weights(&cell, far);
        assert!((blend(&cell, &w) - far).length() < 1e-9);
        assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}
