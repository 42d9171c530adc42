//! Joints between rigid bodies and their motors.

use super::super::check::{FINITE, NOT_NEGATIVE, POINT, POSITIVE, RIGID};
use super::super::decode::Decoder;
use super::super::schema::{choice, record};
use super::super::tree::Node;
use crate::math::Vector;

record! {
    /// A joint of two rigid bodies.
    pub struct Joint {
        /// Its name.
        name: String = String::new();
        /// What it leaves free.
        kind: JointKind;
        /// One body.
        a: String, RIGID;
        /// The other.
        b: String, RIGID;
        /// The joint's place on the first body \[m\].
        anchor_a: [f64; 3] = [0.0; 3], POINT;
        /// The joint's place on the second body \[m\].
        anchor_b: [f64; 3] = [0.0; 3], POINT;
        /// From where to where it may go \[m\] or \[rad\]; of a hinge or a slider.
        limits: Option<[f64; 2]> = None, FINITE;
        /// What drives a hinge or a slider.
        motor: Option<Motor> = None;
        /// Whether the two bodies touch each other.
        contacts: bool = true;
    }
    then fits
}

choice! {
    /// What a joint leaves free.
    pub enum JointKind {
        /// Nothing.
        Fixed;
        /// All turning: a ball joint.
        Spherical;
        /// Turning about one axis: a hinge. The axis is on both bodies, any length.
        Revolute([f64; 3], FINITE);
        /// Sliding along one axis.
        Prismatic([f64; 3], FINITE);
        /// A distance of at most this \[m\].
        Rope(f64, POSITIVE);
        /// A spring and a damper.
        Spring {
            /// Length without force \[m\].
            rest_length: f64, NOT_NEGATIVE;
            /// Stiffness \[N/m\].
            stiffness: f64, POSITIVE;
            /// Damping \[N·s/m\].
            damping: f64 = 0.0, NOT_NEGATIVE;
        };
    }
}

record! {
    /// What drives a joint: a spring and a damper towards a place and a velocity.
    pub struct Motor {
        /// Place that is aimed at \[m\] or \[rad\].
        position: f64 = 0.0, FINITE;
        /// Velocity that is aimed at \[m/s\] or \[rad/s\].
        velocity: f64 = 0.0, FINITE;
        /// Stiffness \[N/m\] or \[N·m/rad\].
        stiffness: f64 = 0.0, NOT_NEGATIVE;
        /// Damping \[N·s/m\] or \[N·m·s/rad\].
        damping: f64 = 0.0, NOT_NEGATIVE;
        /// Most that it exerts \[N\] or \[N·m\].
        max_force: f64 = 3.4e38, NOT_NEGATIVE;
        /// Whether stiffness and damping are accelerations: per kg, independent of the mass that is moved.
        per_mass: bool = false;
    }
}

fn fits(joint: &Joint, node: &Node, d: &mut Decoder) -> Option<()> {
    let axis = match joint.kind {
        JointKind::Revolute(axis) | JointKind::Prismatic(axis) => Some(axis),
        _ => None,
    };
    let complaint = if axis.is_some_and(|a| {
        Vector::from_array(a.map(|x| x as f32))
            .try_normalize()
            .is_none()
    }) {
        "the axis has no length"
    } else if axis.is_none() && (joint.motor.is_some() || joint.limits.is_some()) {
        "only hinges and sliders have limits and motors"
    } else if joint.limits.is_some_and(|[from, to]| from > to) {
        "the first limit must not be above the second"
    } else if joint.a == joint.b {
        "a body can't be joined to itself"
    } else {
        return Some(());
    };
    d.wrong(node.at, |_| complaint.into());
    None
}
