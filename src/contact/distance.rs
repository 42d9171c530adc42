//! Signed distance and outward normal of a point to a convex primitive, in the primitive's own frame.
//!
//! Closed forms in `f64` instead of parry's projections: a projection that lands on the point itself has no direction,
//! and the `f32` direction of one that lands a micrometre away is noise that tilts a resting box by tens of degrees.
//! Here the normal on the surface is that of the face, and continuous through it.

use crate::math::DVec3;
use rapier3d::geometry::{Shape, TypedShape};

/// A collider shape nodes can touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    /// Of a radius \[m\].
    Ball(f64),
    /// Of half extents \[m\].
    Cuboid(DVec3),
    /// A segment and a radius \[m\].
    Capsule(DVec3, DVec3, f64),
    /// Along y: half height and radius \[m\].
    Cylinder(f64, f64),
    /// Everything below a plane through 0 with this outward normal.
    HalfSpace(DVec3),
}

impl Primitive {
    /// The primitive of a parry shape, if it is one.
    pub fn of(shape: &dyn Shape) -> Option<Self> {
        Some(match shape.as_typed_shape() {
            TypedShape::Ball(s) => Self::Ball(s.radius.into()),
            TypedShape::Cuboid(s) => Self::Cuboid(s.half_extents.as_dvec3()),
            TypedShape::Capsule(s) => Self::Capsule(
                s.segment.a.as_dvec3(),
                s.segment.b.as_dvec3(),
                s.radius.into(),
            ),
            TypedShape::Cylinder(s) => Self::Cylinder(s.half_height.into(), s.radius.into()),
            TypedShape::HalfSpace(s) => Self::HalfSpace(s.normal.as_dvec3()),
            _ => return None,
        })
    }

    /// Signed distance (negative inside) \[m\] and outward unit normal at `p` \[m\].
    #[inline]
    pub fn signed_distance(&self, p: DVec3) -> (f64, DVec3) {
        match *self {
            Self::Ball(radius) => {
                let (length, n) = direction(p, DVec3::Y);
                (length - radius, n)
            }
            Self::Cuboid(half) => cuboid(p, half),
            Self::Capsule(a, b, radius) => {
                let ab = b - a;
                let t =
                    ((p - a).dot(ab) / ab.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                let (length, n) =
                    direction(p - (a + ab * t), ab.any_orthogonal_vector().normalize());
                (length - radius, n)
            }
            Self::Cylinder(half_height, radius) => cylinder(p, half_height, radius),
            Self::HalfSpace(normal) => (p.dot(normal), normal),
        }
    }
}

/// Length and direction of `v`; `fallback` where it has none.
#[inline]
fn direction(v: DVec3, fallback: DVec3) -> (f64, DVec3) {
    let length = v.length();
    if length > 0.0 {
        (length, v / length)
    } else {
        (0.0, fallback)
    }
}

fn cuboid(p: DVec3, half: DVec3) -> (f64, DVec3) {
    let sign = DVec3::new(
        1.0_f64.copysign(p.x),
        1.0_f64.copysign(p.y),
        1.0_f64.copysign(p.z),
    );
    let q = p.abs() - half;
    let outside = q.max(DVec3::ZERO);
    if outside != DVec3::ZERO {
        let (distance, n) = direction(outside * sign, DVec3::Y);
        return (distance, n);
    }
    // Inside or on the surface: the nearest face, ties in the order x, y, z.
    let face = if q.x >= q.y && q.x >= q.z {
        (q.x, DVec3::X)
    } else if q.y >= q.z {
        (q.y, DVec3::Y)
    } else {
        (q.z, DVec3::Z)
    };
    (face.0, face.1 * sign)
}

fn cylinder(p: DVec3, half_height: f64, radius: f64) -> (f64, DVec3) {
    let (rho, radial) = direction(DVec3::new(p.x, 0.0, p.z), DVec3::X);
    let cap = DVec3::Y * 1.0_f64.copysign(p.y);
    let (out, up) = (rho - radius, p.y.abs() - half_height);
    if out > 0.0 && up > 0.0 {
        direction(radial * out + cap * up, cap)
    } else if out > up {
        (out, radial)
    } else {
        (up, cap)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::geometry::SharedShape;
    use rapier3d::math::Vector;

    /// parry's projection is the reference where it is well defined: away from the surface and from medial points.
    #[test]
    fn agrees_with_parry_on_ten_thousand_points() {
        let shapes = [
            SharedShape::ball(0.7),
            SharedShape::cuboid(0.5, 0.3, 0.8),
            SharedShape::capsule(
                Vector::new(-0.2, -0.4, 0.1),
                Vector::new(0.3, 0.5, 0.0),
                0.25,
            ),
            SharedShape::cylinder(0.5, 0.35),
        ];
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f32 / (1 << 23) as f32 - 1.0
        };
        for shape in &shapes {
            let primitive = Primitive::of(&**shape).unwrap();
            for _ in 0..10_000 {
                let p = Vector::new(random(), random(), random()) * 1.2;
                let (d, n) = primitive.signed_distance(p.as_dvec3());
                let reference = shape.project_local_point(p, false);
                let sign = if reference.is_inside { -1.0 } else { 1.0 };
                let distance = f64::from((p - reference.point).length()) * sign;
                assert!(
                    (d - distance).abs() < 2e-6,
                    "{primitive:?} at {p}: {d} against {distance}"
                );
                assert!((n.length() - 1.0).abs() < 1e-9);
                // The normal is the gradient of the distance.
                let step = 1e-4;
                let further = primitive.signed_distance(p.as_dvec3() + n * step).0;
                assert!(
                    (further - d - step).abs() < 1e-6,
                    "{primitive:?} at {p}: normal {n}"
                );
            }
        }
    }

    #[test]
    fn the_normal_on_the_surface_is_that_of_the_face() {
        let half = DVec3::new(0.5, 0.3, 0.8);
        for offset in [-1e-9, 0.0, 1e-9] {
            let (_, n) =
                Primitive::Cuboid(half).signed_distance(DVec3::new(0.1, 0.3 + offset, 0.2));
            assert_eq!(n, DVec3::Y);
        }
        assert!(
            Primitive::Ball(1.0)
                .signed_distance(DVec3::ZERO)
                .1
                .is_finite()
        );
    }
}
