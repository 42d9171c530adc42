//! The faces of a solid as ways out of it.

use super::{Core, Solid, primitive};
use crate::math::DVec3;

impl Solid {
    /// As [`Self::exits`], of a compound those of its parts, be they inside others or not.
    pub fn faces(&self, p: DVec3, f: &mut dyn FnMut(f64, DVec3)) {
        match &self.core {
            Core::Compound(whole) => {
                whole.faces(p, &mut |height, normal| f(height - self.radius, normal))
            }
            _ => self.exits(p, f),
        }
    }

    /// Every face of a solid as seen from a point: its height over it and the outward normal.
    pub fn exits(&self, p: DVec3, f: &mut dyn FnMut(f64, DVec3)) {
        let mut f = |height: f64, normal: DVec3| f(height - self.radius, normal);
        match &self.core {
            Core::Cuboid(half) => {
                for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                    f(p.dot(axis) - half.dot(axis), axis);
                    f(-p.dot(axis) - half.dot(axis), -axis);
                }
            }
            Core::Cylinder(half_height, radius) => {
                let (rho, away) = primitive::radial(p);
                f(rho - radius, away);
                f(p.y - half_height, DVec3::Y);
                f(-p.y - half_height, DVec3::NEG_Y);
            }
            Core::Cone(half_height, radius) => {
                let (rho, away) = primitive::radial(p);
                let mantle = (away * (2.0 * half_height) + DVec3::Y * *radius)
                    .try_normalize()
                    .unwrap_or(away);
                let apex = DVec3::Y * *half_height;
                f((away * rho + DVec3::Y * p.y - apex).dot(mantle), mantle);
                f(-p.y - half_height, DVec3::NEG_Y);
            }
            Core::Hull(hull) => hull.planes(p, &mut f),
            Core::Compound(whole) if whole.exits(p, &mut f) => {}
            Core::Point
            | Core::Segment(..)
            | Core::HalfSpace(_)
            | Core::Compound(_)
            | Core::Voxels(_) => {
                let (d, n) = self.signed_distance(p);
                f(d + self.radius, n);
            }
        }
    }
}
