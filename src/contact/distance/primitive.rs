//! Closed forms of the signed distance to simple cores. Inside, the nearest face counts, ties in the order x, y, z; where
//! a point has no direction (a centre, an axis) a fixed one is taken.

use crate::math::DVec3;

/// Length and direction of `v`; `fallback` where it has none.
#[inline]
pub fn direction(v: DVec3, fallback: DVec3) -> (f64, DVec3) {
    let length = v.length();
    if length > 0.0 {
        (length, v / length)
    } else {
        (0.0, fallback)
    }
}

/// Distance from the y axis and direction away from it.
#[inline]
pub fn radial(v: DVec3) -> (f64, DVec3) {
    direction(DVec3::new(v.x, 0.0, v.z), DVec3::X)
}

/// +1 or −1 per axis.
#[inline]
pub fn signs(v: DVec3) -> DVec3 {
    DVec3::new(
        1.0_f64.copysign(v.x),
        1.0_f64.copysign(v.y),
        1.0_f64.copysign(v.z),
    )
}

/// Where on the segment `a`–`b` the point nearest to `p` lies, 0 to 1.
#[inline]
pub fn along(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let ab = b - a;
    ((p - a).dot(ab) / ab.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
}

/// The segment `a`–`b`, which has no inside.
#[inline]
pub fn segment(p: DVec3, a: DVec3, b: DVec3) -> (f64, DVec3) {
    let nearest = a + (b - a) * along(p, a, b);
    let (length, n) = direction(p - nearest, DVec3::ZERO);
    if length > 0.0 {
        return (length, n);
    }
    let across = (b - a).try_normalize().unwrap_or(DVec3::X);
    (length, across.any_orthonormal_vector())
}

/// A box of half extents `half`.
#[inline]
pub fn cuboid(p: DVec3, half: DVec3) -> (f64, DVec3) {
    let sign = signs(p);
    let q = p.abs() - half;
    let outside = q.max(DVec3::ZERO);
    if outside != DVec3::ZERO {
        return direction(outside * sign, DVec3::Y);
    }
    let face = if q.x >= q.y && q.x >= q.z {
        (q.x, DVec3::X)
    } else if q.y >= q.z {
        (q.y, DVec3::Y)
    } else {
        (q.z, DVec3::Z)
    };
    (face.0, face.1 * sign)
}

/// A cylinder along y.
#[inline]
pub fn cylinder(p: DVec3, half_height: f64, radius: f64) -> (f64, DVec3) {
    let (rho, away) = radial(p);
    let cap = DVec3::Y * 1.0_f64.copysign(p.y);
    let (out, up) = (rho - radius, p.y.abs() - half_height);
    if out > 0.0 && up > 0.0 {
        direction(away * out + cap * up, cap)
    } else if out > up {
        (out, away)
    } else {
        (up, cap)
    }
}

/// A cone along y with its apex at +`half_height`, in the half-plane of the point: its base, its mantle, the apex and the
/// rim between them each have their region.
#[inline]
pub fn cone(p: DVec3, half_height: f64, radius: f64) -> (f64, DVec3) {
    let (rho, away) = radial(p);
    let height = 2.0 * half_height;
    let slant = height.hypot(radius);
    let below = -half_height - p.y;
    if slant <= 0.0 {
        return direction(p, DVec3::Y);
    }
    let (out, up) = (rho - radius, p.y + half_height);
    if below >= 0.0 && out <= 0.0 {
        return (below, DVec3::NEG_Y);
    }
    // Height over the mantle, and how far up along it.
    let over = (out * height + up * radius) / slant;
    let climbed = (up * height - out * radius) / slant;
    if over > 0.0 && climbed >= slant {
        return direction(p - DVec3::Y * half_height, DVec3::Y);
    }
    if climbed < 0.0 && (over > 0.0 || below > 0.0) {
        return direction(away * out - DVec3::Y * below, DVec3::NEG_Y);
    }
    if over >= below {
        (over, (away * height + DVec3::Y * radius) / slant)
    } else {
        (below, DVec3::NEG_Y)
    }
}
