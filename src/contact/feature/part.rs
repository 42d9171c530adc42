//! A convex part of a target, and what of a body may come near its corners, edges and curved parts.

use crate::contact::distance::Solid;
use crate::contact::target::Frame;
use crate::contact::watch::Watch;
use crate::math::{DMat3, DQuat, DVec3};

/// How much farther off than what can be reached a body is watched.
const AHEAD: f64 = 8.0;

/// A convex part and what is watched of a body.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub convex: Convex,
    pub faces: Watch,
    pub edges: Watch,
    pub state: Waking,
}

/// Whether anything is watched at all: the middle of a large floor has nothing that faces and edges could miss.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub(super) enum Waking {
    /// Until the way at which the body may come near any edge \[m\].
    Asleep(f64),
    Awake,
}

/// A convex solid in the collider's frame.
#[derive(Clone, Debug)]
pub(super) struct Convex {
    offset: DVec3,
    turn: DQuat,
    pub solid: Solid,
    /// A place within it, in its own frame: the mean of its corners. The middle of its box may be outside of it.
    pub centre: DVec3,
}

impl Convex {
    pub fn frame(&self, collider: &Frame) -> Frame {
        Frame {
            position: collider.position + collider.axes * self.offset,
            axes: collider.axes * DMat3::from_quat(self.turn),
        }
    }

    /// A place in the collider's frame.
    pub fn to_collider(&self, place: DVec3) -> DVec3 {
        self.offset + self.turn * place
    }

    /// How far what lies between some corners is from the solid, or less \[m\]: all of that lies behind the plane across its way out at
    /// `middle`, a place between the corners.
    pub fn away(&self, middle: DVec3, corners: &[DVec3]) -> f64 {
        let (distance, normal) = self.solid.signed_distance(middle);
        let nearer = corners.iter().map(|corner| (*corner - middle).dot(normal));
        distance + nearer.fold(0.0, f64::min)
    }

    /// How far a box of the collider's frame is from any edge, or less \[m\].
    fn edges_apart(&self, (lo, hi): (DVec3, DVec3)) -> f64 {
        let axes = DMat3::from_quat(self.turn).transpose();
        let (middle, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        let middle = axes * (middle - self.offset);
        let half =
            axes.x_axis.abs() * half.x + axes.y_axis.abs() * half.y + axes.z_axis.abs() * half.z;
        self.solid.edges_apart(middle - half, middle + half)
    }
}

impl Part {
    pub fn new(offset: DVec3, turn: DQuat, solid: Solid) -> Self {
        let mut points = Vec::new();
        solid.feature_points(DVec3::Y, &mut points);
        let mean = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let centre = mean + DVec3::Y * solid.edge_radius();
        Self {
            convex: Convex {
                offset,
                turn,
                solid,
                centre,
            },
            faces: Watch::default(),
            edges: Watch::default(),
            state: Waking::Asleep(f64::NEG_INFINITY),
        }
    }

    /// Forgets all distances.
    pub fn reset(&mut self) {
        self.faces.reset();
        self.edges.reset();
        self.state = Waking::Asleep(f64::NEG_INFINITY);
    }

    pub fn is_awake(&self) -> bool {
        self.state == Waking::Awake
    }

    /// Begins to watch a while before the box around the body may come within `near` m of an edge. To watch a few elements costs
    /// less than to find that box again and again for a body that slides along beside an edge.
    pub fn awake(&mut self, bounds: &mut dyn FnMut() -> (DVec3, DVec3), way: f64, near: f64) {
        let Waking::Asleep(due) = self.state else {
            return;
        };
        if due - way > near {
            return;
        }
        let apart = self.convex.edges_apart(bounds());
        self.state = if apart > AHEAD * near {
            Waking::Asleep(way + apart)
        } else {
            Waking::Awake
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rapier3d::geometry::SharedShape;
    use rapier3d::math::Vector;

    fn place() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0..1.0f64).prop_map(DVec3::from_array)
    }

    proptest! {
        /// Nor does it say less than a ball round the corners would.
        #[test]
        fn nothing_between_the_corners_is_nearer(
            corners in prop::array::uniform4(place()),
            weights in prop::array::uniform4(0.0..1.0f64),
        ) {
            let points = [Vector::X, Vector::Y, Vector::Z, -Vector::ONE].map(|p| p * 0.3);
            let shapes = [
                SharedShape::ball(0.3),
                SharedShape::capsule_x(0.3, 0.1),
                SharedShape::cuboid(0.4, 0.2, 0.1),
                SharedShape::cylinder(0.3, 0.2),
                SharedShape::cone(0.3, 0.2),
                SharedShape::convex_hull(&points).unwrap(),
            ];
            let middle = corners.iter().sum::<DVec3>() / 4.0;
            let sum: f64 = weights.iter().sum();
            let all = corners.iter().zip(weights);
            let between = all.map(|(c, w)| *c * (w / sum)).sum();
            let radius = corners.map(|c| c.distance(middle)).into_iter().fold(0.0, f64::max);
            for shape in shapes {
                let solid = Solid::of(&*shape).unwrap();
                let part = Part::new(DVec3::ZERO, DQuat::IDENTITY, solid).convex;
                let away = part.away(middle, &corners);
                let [there, at_middle] =
                    [between, middle].map(|p| part.solid.signed_distance(p).0);
                prop_assert!(away <= there + 1e-9, "{shape:?}: {away} of {there} m");
                prop_assert!(away >= at_middle - radius - 1e-9);
            }
        }
    }
}
