//! Why there is no equilibrium.

use crate::math::DVec3;
use std::fmt;

/// A rigid motion nothing prevents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Velocity of the body's centre, of any unit.
    pub translation: DVec3,
    /// Angular velocity about its centre, in units of the same motion.
    pub rotation: DVec3,
    /// The body's centre \[m\].
    pub centre: DVec3,
}

impl fmt::Display for Motion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let write = |f: &mut fmt::Formatter<'_>, v: DVec3| {
            // Adding zero makes −0 a 0.
            let v = (v * 1e3).round() / 1e3 + DVec3::ZERO;
            write!(f, "({}, {}, {})", v.x, v.y, v.z)
        };
        let Some(axis) = self.rotation.try_normalize() else {
            f.write_str("translation along ")?;
            return write(f, self.translation.normalize_or_zero());
        };
        f.write_str("rotation about ")?;
        write(f, axis)?;
        f.write_str(" through ")?;
        let arm = self.rotation.cross(self.translation) / self.rotation.length_squared();
        write(f, self.centre + arm)?;
        let slide = axis.dot(self.translation) / self.rotation.length();
        if slide.abs() > 1e-6 {
            write!(f, " with {slide:.3} m along it per radian")?;
        }
        Ok(())
    }
}

/// Why a static solve has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StaticError {
    /// A list has another length than the body has nodes.
    #[error("{what} has {found} entries, but the body has {nodes} nodes")]
    Length {
        /// Name of the list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// How many nodes there are.
        nodes: usize,
    },
    /// A value is out of range.
    #[error("{what} of node {node} is {value}, it must be finite")]
    Node {
        /// Name of the value.
        what: &'static str,
        /// The node.
        node: u32,
        /// The value.
        value: DVec3,
    },
    /// A setting is out of range.
    #[error("{what} is {value}, it must be {must}")]
    Value {
        /// Name of the setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A part of the body can move as a whole.
    #[error(
        "the part of the body with node {node} ({nodes} nodes) is not supported against {}",
        listed(free)
    )]
    Supports {
        /// Its first node.
        node: u32,
        /// How many nodes it has.
        nodes: usize,
        /// The motions nothing prevents.
        free: Vec<Motion>,
    },
    /// The forces did not come to balance.
    #[error(
        "no equilibrium: at {:.1} % of the load node {node} is still out of balance by {residual:e} N ({allowed:e} N allowed) after {iterations} iterations; the load may exceed what the body can carry, or a part of it may be a mechanism",
        100.0 * load
    )]
    NotConverged {
        /// The part of the load that was on.
        load: f64,
        /// The node furthest from balance.
        node: u32,
        /// The force missing there \[N\].
        residual: f64,
        /// What would have been near enough \[N\].
        allowed: f64,
        /// Newton steps made in all.
        iterations: usize,
    },
    /// The factorisation ran out of memory or was given numbers it can't take.
    #[error("the linear solver failed on {unknowns} unknowns: {reason}")]
    Solver {
        /// How many unknowns.
        unknowns: usize,
        /// What it says.
        reason: String,
    },
}

fn listed(free: &[Motion]) -> String {
    let each: Vec<String> = free.iter().map(Motion::to_string).collect();
    each.join(", ")
}
