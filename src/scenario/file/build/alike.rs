//! Springs that are all alike.

use super::super::model::Alike;
use crate::body::Net;
use crate::math::Real;

/// Gives all springs of a net the same constants, and its nodes their shares of the mass by volume.
pub(super) fn alike(net: &mut Net, springs: &Alike, mass: Real) {
    let volume: Real = net.nodes.iter().map(|n| n.volume).sum();
    for node in &mut net.nodes {
        node.mass = mass * node.volume / volume;
        node.volume = 0.0;
    }
    let heaviest = net.nodes.iter().map(|n| n.mass).fold(0.0, Real::max);
    let (stiffness, ratio) = (springs.stiffness as Real, springs.damping_ratio as Real);
    for spring in &mut net.springs {
        spring.section = 0.0;
        spring.stiffness = stiffness;
        spring.damping = 2.0 * ratio * (stiffness * heaviest).sqrt();
    }
}
