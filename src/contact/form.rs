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
    /// A volume, with an inside; small convex meshes too.
    Solid(Solid),
    /// A surface or curve, without one.
    Soup(Soup),
}

impl Form {
    /// The form of a shape; `None` for custom shapes, for compounds with a part that has no volume, and for shapes that are
    /// not finite.
    fn of(shape: &SharedShape) -> Option<Self> {
        if let Some(solid) = Solid::of(&**shape) {
            return Some(Self::Solid(solid));
        }
        let soup = Soup::of(shape)?;
        let mesh = shape.as_trimesh().filter(|_| soup.oriented());
        let solid = mesh.and_then(Solid::of_convex_mesh);
        Some(solid.map_or(Self::Soup(soup), Self::Solid))
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

    /// Whether it tells what is inside: a volume does, and a closed mesh by its winding.
    pub fn has_inside(&self) -> bool {
        match self {
            Self::Solid(_) => true,
            Self::Soup(soup) => soup.oriented(),
        }
    }

    /// The smallest extent of a volume \[m\]; of a surface that is not known.
    pub fn width(&self) -> Option<f64> {
        match self {
            Self::Solid(solid) => Some(solid.width()),
            Self::Soup(_) => None,
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

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::geometry::TriMeshFlags;
    use rapier3d::math::Vector;

    #[test]
    fn soups_of_the_same_numbers_are_equal() {
        let mesh = |x: f32, flags| {
            let points = vec![Vector::ZERO, Vector::X * x, Vector::Y];
            SharedShape::trimesh_with_flags(points, vec![[0, 1, 2]], flags).unwrap()
        };
        let form = |x, flags| Form::of(&mesh(x, flags)).unwrap();
        let plain = TriMeshFlags::empty();
        assert_eq!(form(1.0, plain), form(1.0, plain));
        assert_ne!(form(1.0, plain), form(1.5, plain));
        assert_ne!(form(1.0, plain), form(1.0, TriMeshFlags::ORIENTED));
        let triangle = |y: f32| {
            Form::of(&SharedShape::triangle(
                Vector::ZERO,
                Vector::X,
                Vector::Y * y,
            ))
            .unwrap()
        };
        assert_eq!(triangle(1.0), triangle(1.0));
        assert_ne!(triangle(1.0), triangle(2.0));
        assert_ne!(triangle(1.0), form(1.0, plain));
    }

    /// A mesh whose winding tells its outside is a solid where it is convex.
    #[test]
    fn a_convex_mesh_is_a_solid() {
        let far = Vector::new(50.0, -20.0, 30.0);
        let (points, triangles) =
            rapier3d::geometry::Cuboid::new(Vector::new(0.3, 0.02, 0.1)).to_trimesh();
        let points: Vec<Vector> = points.into_iter().map(|p| p + far).collect();
        let form = |points: &[Vector], triangles: &[[u32; 3]], flags| {
            let mesh = SharedShape::trimesh_with_flags(points.to_vec(), triangles.to_vec(), flags);
            Form::of(&mesh.unwrap()).unwrap()
        };
        let is_solid = |form: &Form| matches!(form, Form::Solid(_));
        let oriented = TriMeshFlags::ORIENTED;
        let solid = form(&points, &triangles, oriented);
        assert!(is_solid(&solid));
        let width = solid.width().unwrap();
        assert!((width - 0.04).abs() < 1e-5, "{width}");
        assert!(!is_solid(&form(&points, &triangles, TriMeshFlags::empty())));
        // Inside out, open, dented.
        let turned: Vec<[u32; 3]> = triangles.iter().map(|[a, b, c]| [*b, *a, *c]).collect();
        assert!(!is_solid(&form(&points, &turned, oriented)));
        assert!(!is_solid(&form(&points, &triangles[1..], oriented)));
        let mut dented = points.clone();
        dented[0] = far + Vector::splat(0.015);
        assert!(!is_solid(&form(&dented, &triangles, oriented)));
    }

    #[test]
    fn a_form_is_there_for_every_kind_that_is_taken() {
        let triangle = SharedShape::triangle(Vector::ZERO, Vector::X, Vector::Y);
        let compound = SharedShape::compound(vec![(Default::default(), triangle.clone())]);
        for (shape, taken) in [
            (SharedShape::ball(1.0), true),
            (SharedShape::segment(Vector::ZERO, Vector::X), true),
            (triangle, true),
            (compound, false),
        ] {
            assert_eq!(Form::takes(&*shape), taken);
            assert_eq!(Form::of(&shape).is_some(), taken);
        }
    }
}
