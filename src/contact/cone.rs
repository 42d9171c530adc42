//! Along which directions a corner or an edge can push: those that nothing of its surface goes.

use crate::math::DVec3;

/// How far, as a sine, what is beside a point that is to touch may lean over: a face rocks a little.
const LEAN: f64 = 0.1;

/// The same beside a point that touched last: what it presses bends round it.
const HELD: f64 = 0.5;

/// Whether a corner or an edge can push along a unit `direction`; `cone` are unit directions of its surface away from it, 0 for
/// what is not there.
pub fn can_push(cone: impl IntoIterator<Item = DVec3>, direction: DVec3, touched: bool) -> bool {
    let lean = if touched { HELD } else { LEAN };
    cone.into_iter().all(|c| c.dot(direction) <= lean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leans_over_can_push_only_if_it_touched() {
        let leaning = |sine: f64| [DVec3::new((1.0 - sine * sine).sqrt(), sine, 0.0), -DVec3::Y];
        assert!(can_push(leaning(0.05), DVec3::Y, false));
        assert!(!can_push(leaning(0.2), DVec3::Y, false));
        assert!(can_push(leaning(0.2), DVec3::Y, true));
        assert!(!can_push(leaning(0.6), DVec3::Y, true));
        assert!(can_push([DVec3::ZERO; 2], DVec3::Y, false));
    }
}
