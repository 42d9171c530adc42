//! Solids of shapes already seen: working out a large hull takes milliseconds, and colliders keep their shapes for long.

use super::Solid;
use rapier3d::geometry::SharedShape;
use std::sync::Arc;

/// What became of the shapes asked for. Holding a shape keeps its address from being used again, and makes Rapier copy it
/// before it changes it, so an answer is never out of date.
#[derive(Clone, Default)]
pub struct Solids {
    known: Vec<(SharedShape, Option<Solid>)>,
}

impl Solids {
    /// As [`Solid::of`], from memory where the very same shape was asked for before.
    pub fn of(&mut self, shape: &SharedShape) -> Option<Solid> {
        let same = |(s, _): &&(SharedShape, Option<Solid>)| Arc::ptr_eq(&s.0, &shape.0);
        if let Some((_, solid)) = self.known.iter().find(same) {
            return solid.clone();
        }
        let solid = Solid::of(&**shape);
        self.known.push((shape.clone(), solid.clone()));
        solid
    }

    /// Forgets shapes that nobody else holds any more.
    pub fn forget_unused(&mut self) {
        self.known.retain(|(s, _)| Arc::strong_count(&s.0) > 1);
    }
}
