//! The form of a collider as contact sees it, worked out once per shape.

use super::distance::Solid;
use crate::math::DVec3;
use rapier3d::geometry::{Shape, SharedShape};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What a collider is to a node.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// A volume, with an inside.
    Solid(Solid),
}

impl Form {
    /// The form of a shape; `None` for custom shapes, and for those that are not finite.
    fn of(shape: &SharedShape) -> Option<Self> {
        Solid::of(&**shape).map(Self::Solid)
    }

    /// Signed distance \[m\] and outward unit normal at a point.
    pub fn signed_distance(&self, p: DVec3) -> (f64, DVec3) {
        let Self::Solid(solid) = self;
        solid.signed_distance(p)
    }

    /// Whether a shape is of a kind that has a form, without working anything out.
    pub fn takes(shape: &dyn Shape) -> bool {
        Solid::takes(shape)
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
