//! The form of a collider as contact sees it, worked out once per shape.

use super::distance::Solid;
use super::soup::Soup;
use super::{solid_nodes, soup_nodes};
use crate::math::DVec3;
use rapier3d::geometry::{Shape, SharedShape};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What a collider is to a node.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// A volume, with an inside.
    Solid(Solid),
    /// A surface or curve, without one.
    Soup(Soup),
}

impl Form {
    /// The form of a shape; `None` for custom shapes, for compounds with a part that has no volume, and for shapes that are
    /// not finite.
    fn of(shape: &SharedShape) -> Option<Self> {
        let soup = || Soup::of(shape).map(Self::Soup);
        Solid::of(&**shape).map(Self::Solid).or_else(soup)
    }

    /// Whether any of the points, given with their velocities in the frame of the shape, meets it faster than `threshold`
    /// m/s within `time` s, being `skin` m thick.
    pub fn is_hit(
        &self,
        points: impl Iterator<Item = (DVec3, DVec3)>,
        skin: f64,
        time: f64,
        threshold: f64,
    ) -> bool {
        match self {
            Self::Solid(solid) => solid_nodes::is_hit(solid, points, skin, time, threshold),
            Self::Soup(soup) => soup_nodes::is_hit(soup, points, skin, time, threshold),
        }
    }

    /// Whether a shape is of a kind that has a form, without working anything out.
    pub fn takes(shape: &dyn Shape) -> bool {
        Solid::takes(shape) || Soup::takes(shape)
    }
}

/// The forms of all shapes met so far: working out a large hull takes milliseconds, and colliders keep their shapes for
/// long. Holding a shape keeps its address from being used again, and makes Rapier copy it before it changes it, so a form
/// is never out of date.
#[derive(Clone, Debug, Default)]
pub struct Forms {
    known: BTreeMap<usize, (SharedShape, Option<Form>)>,
}

impl Forms {
    /// The form of a shape, from memory where the very same one was asked for before.
    pub fn of(&mut self, shape: &SharedShape) -> Option<Form> {
        let (_, form) = self
            .known
            .entry(address(shape))
            .or_insert_with(|| (shape.clone(), Form::of(shape)));
        form.clone()
    }

    /// Forgets shapes that nobody else holds any more.
    pub fn forget_unused(&mut self) {
        self.known
            .retain(|_, (shape, _)| Arc::strong_count(&shape.0) > 1);
    }
}

/// What tells one shape from another.
pub fn address(shape: &SharedShape) -> usize {
    Arc::as_ptr(&shape.0).cast::<()>() as usize
}
