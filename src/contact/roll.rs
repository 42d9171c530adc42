//! The turning of a target, as far as it moves its surface.
//!
//! What turns comes to what it touches faster or slower, over a substep, than the velocity of the point says. But a spin that
//! maps a solid onto itself moves no surface: a ball that rolls is where it would be if it slid.

use super::distance::{Solid, Symmetry};
use super::target::Frame;
use crate::law::row::Turn;
use crate::math::DVec3;
use crate::solve::shadow::Shadow;

/// How a target turns.
#[derive(Clone, Copy, Debug)]
pub struct Roll {
    /// Its spin \[rad/s\].
    all: DVec3,
    /// The part of it that moves its surface \[rad/s\].
    swing: DVec3,
    /// From the shadow's centre of mass to where the rest of it is a spin about itself \[m\].
    centre: DVec3,
}

impl Roll {
    /// Of what looks different from all sides.
    pub fn of_any(shadow: &Shadow) -> Self {
        Self {
            all: shadow.w,
            swing: shadow.w,
            centre: DVec3::ZERO,
        }
    }

    /// Of a solid in this frame.
    pub fn of(solid: &Solid, frame: &Frame, shadow: &Shadow) -> Self {
        let any = Self::of_any(shadow);
        let at = |centre: DVec3| frame.position + frame.axes * centre - shadow.com;
        match solid.symmetry() {
            Symmetry::None => any,
            Symmetry::Axis { centre, along } => {
                let axis = frame.axes * along;
                Self {
                    swing: any.all - axis * any.all.dot(axis),
                    centre: at(centre),
                    ..any
                }
            }
            Symmetry::Point(centre) => Self {
                swing: DVec3::ZERO,
                centre: at(centre),
                ..any
            },
        }
    }

    /// By how much its surface turns in h s \[rad\].
    pub fn turn(&self, h: f64) -> DVec3 {
        self.swing * h
    }

    /// For a node that slides on its surface, which is flat at `arm`.
    pub fn under_node(&self, normal: DVec3, arm: DVec3) -> Turn {
        let off = arm - self.centre;
        let kept = (self.all - self.swing).cross(off);
        Turn {
            swing: self.swing,
            bend: normal.dot(self.swing.cross(kept) + self.bend(off)),
        }
    }

    /// For a flat face, over which a point of it at `arm` slides. What slides along an edge of it that turns is not accelerated
    /// by that.
    pub fn under_face(&self, normal: DVec3, arm: DVec3) -> Turn {
        Turn {
            swing: DVec3::ZERO,
            bend: normal.dot(self.bend(arm - self.centre)),
        }
    }

    /// Half the acceleration of its point so far off its centre \[m/s²\].
    fn bend(&self, off: DVec3) -> DVec3 {
        let about = |w: DVec3, arm: DVec3| 0.5 * w.cross(w.cross(arm));
        about(self.swing, off) + about(self.all, self.centre)
    }
}
