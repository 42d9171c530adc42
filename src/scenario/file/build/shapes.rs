//! Shapes of colliders.

use super::super::check::FARTHEST;
use super::super::model::shape::Placed;
use super::super::model::{Axis, Mesh, Shape};
use super::terrain::terrain;
use super::{RunError, surface, vector};
use crate::math::{Real, Rotation, Vector};
use rapier3d::geometry::SharedShape;
use rapier3d::math::Pose;
use rapier3d::parry::transformation::vhacd::{VHACD, VHACDParameters};
use rapier3d::parry::utils::Array2;
use std::panic::AssertUnwindSafe;

/// Most triangles of a surface that is cut into convex parts.
const MOST_TO_CUT: usize = 100_000;

/// Makes a shape for the rigid body `name`.
pub(super) fn shape(shape: &Shape, name: &str) -> Result<SharedShape, RunError> {
    let wrong = |what| RunError::Shape {
        name: name.into(),
        what,
    };
    if let Some(what) = shape.complaint() {
        return Err(wrong(what));
    }
    let points = |list: &[[f64; 3]]| list.iter().copied().map(vector).collect::<Vec<_>>();
    Ok(match shape {
        Shape::Ball(radius) => SharedShape::ball(*radius as Real),
        Shape::Cuboid { half, border } => cuboid(vector(*half), *border as Real),
        Shape::Capsule {
            half_height,
            radius,
            axis,
        } => {
            let (h, r) = (*half_height as Real, *radius as Real);
            match axis {
                Axis::X => SharedShape::capsule_x(h, r),
                Axis::Y => SharedShape::capsule_y(h, r),
                Axis::Z => SharedShape::capsule_z(h, r),
            }
        }
        Shape::Cylinder {
            half_height,
            radius,
            border,
        } => match [half_height, radius, border].map(|x| *x as Real) {
            [h, r, 0.0] => SharedShape::cylinder(h, r),
            [h, r, b] => SharedShape::round_cylinder(h, r, b),
        },
        Shape::Cone {
            half_height,
            radius,
            border,
        } => match [half_height, radius, border].map(|x| *x as Real) {
            [h, r, 0.0] => SharedShape::cone(h, r),
            [h, r, b] => SharedShape::round_cone(h, r, b),
        },
        Shape::HalfSpace { normal } => {
            let normal = vector(*normal).try_normalize();
            SharedShape::halfspace(normal.ok_or(wrong("the normal has no length"))?)
        }
        Shape::Segment { a, b } => SharedShape::segment(vector(*a), vector(*b)),
        Shape::Triangle { a, b, c, border } => {
            let [a, b, c] = [a, b, c].map(|p| vector(*p));
            match *border as Real {
                0.0 => SharedShape::triangle(a, b, c),
                border => SharedShape::round_triangle(a, b, c, border),
            }
        }
        Shape::Polyline { points: list } => SharedShape::polyline(points(list), None),
        Shape::TriMesh(mesh) => {
            let mesh = surface(mesh, name)?;
            let made = SharedShape::trimesh(mesh.vertices, mesh.triangles);
            made.map_err(|_| wrong("Rapier can't make a mesh of these triangles"))?
        }
        Shape::HeightField { heights, size } => field(heights, *size).map_err(wrong)?,
        Shape::Terrain {
            height,
            size,
            cell,
            mesh,
        } => terrain(height, *size, *cell, *mesh).map_err(wrong)?,
        Shape::Hull {
            points: list,
            border,
        } => {
            let list = points(list);
            let hull = || match *border as Real {
                0.0 => SharedShape::convex_hull(&list),
                border => SharedShape::round_convex_hull(&list, border),
            };
            let hull = contained(hull).flatten().filter(has_volume);
            hull.ok_or(wrong("the points have no hull with a volume"))?
        }
        Shape::Decomposition(mesh) => decomposition(mesh, name)?,
        Shape::Voxels { size, points: list } => {
            SharedShape::voxels_from_points(vector(*size), &points(list))
        }
        Shape::Compound(parts) => compound(parts, name)?,
    })
}

fn cuboid(half: Vector, border: Real) -> SharedShape {
    match border {
        0.0 => SharedShape::cuboid(half.x, half.y, half.z),
        border => SharedShape::round_cuboid(half.x, half.y, half.z, border),
    }
}

fn field(heights: &[Vec<f64>], size: [f64; 3]) -> Result<SharedShape, &'static str> {
    let (rows, columns) = (heights.len(), heights.first().map_or(0, Vec::len));
    let mut array = Array2::repeat(rows, columns, 0.0);
    for (i, row) in heights.iter().enumerate() {
        for (j, height) in row.iter().enumerate() {
            if (height * size[1]).abs() > FARTHEST {
                return Err("a height times the factor on heights is more than 1e6 m");
            }
            array[(i, j)] = *height as Real;
        }
    }
    Ok(SharedShape::heightfield(array, vector(size)))
}

/// Hulls and decompositions panic where points are almost in a plane, so close to it that no test beforehand tells all of
/// them: such a panic is no hull.
fn contained<T>(make: impl FnOnce() -> T) -> Option<T> {
    std::panic::catch_unwind(AssertUnwindSafe(make)).ok()
}

fn has_volume(shape: &SharedShape) -> bool {
    let mass = shape.mass_properties(1.0).mass();
    mass.is_normal() && mass > 0.0
}

fn decomposition(mesh: &Mesh, name: &str) -> Result<SharedShape, RunError> {
    let mesh = surface(mesh, name)?;
    let wrong = |what| RunError::Shape {
        name: name.into(),
        what,
    };
    if mesh.triangles.len() > MOST_TO_CUT {
        return Err(wrong(
            "a surface of more than a hundred thousand triangles is not cut into parts",
        ));
    }
    let closed = mesh.check_closed();
    closed.map_err(|_| wrong("only a closed surface can be cut into convex parts"))?;
    // Against the box around it: what is thinner than rounding has no inside.
    let (low, high) = mesh
        .vertices
        .iter()
        .fold((Vector::INFINITY, Vector::NEG_INFINITY), |(lo, hi), v| {
            (lo.min(*v), hi.max(*v))
        });
    let size = f64::from((high - low).max_element());
    let volume = mesh.volume();
    if volume.is_nan() || volume <= 1.0e-9 * size.powi(3) {
        return Err(wrong(
            "a surface without a volume can't be cut into convex parts",
        ));
    }
    let cut = || {
        let parts = VHACD::decompose(
            &VHACDParameters::default(),
            &mesh.vertices,
            &mesh.triangles,
            true,
        );
        let hulls = parts.compute_exact_convex_hulls(&mesh.vertices, &mesh.triangles);
        let convex = |(points, faces): (Vec<_>, Vec<_>)| SharedShape::convex_mesh(points, &faces);
        let parts: Vec<_> = hulls
            .into_iter()
            .filter_map(convex)
            .filter(has_volume)
            .collect();
        let still = parts.into_iter().map(|part| (Pose::IDENTITY, part));
        still.collect::<Vec<_>>()
    };
    let parts = contained(cut).filter(|parts| !parts.is_empty());
    let parts = parts.ok_or_else(|| wrong("this surface can't be cut into convex parts"))?;
    Ok(SharedShape::compound(parts))
}

fn compound(parts: &[Placed], name: &str) -> Result<SharedShape, RunError> {
    let part = |p: &Placed| {
        let turn = Rotation::from_scaled_axis(vector(p.rotation));
        let pose = Pose::from_parts(vector(p.translation), turn);
        Ok::<_, RunError>((pose, shape(&p.shape, name)?))
    };
    let parts: Result<Vec<_>, _> = parts.iter().map(part).collect();
    Ok(SharedShape::compound(parts?))
}
