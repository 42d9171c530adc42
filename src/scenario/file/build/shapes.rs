//! Shapes of colliders.

use super::super::model::shape::Placed;
use super::super::model::{Axis, Mesh, Shape};
use super::terrain::terrain;
use super::{RunError, surface, vector};
use crate::math::{Real, Rotation, Vector};
use rapier3d::geometry::SharedShape;
use rapier3d::math::Pose;
use rapier3d::parry::utils::Array2;

/// Makes a shape for the rigid body `name`.
pub(super) fn shape(shape: &Shape, name: &str) -> Result<SharedShape, RunError> {
    let wrong = |what| RunError::Shape {
        name: name.into(),
        what,
    };
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
        Shape::Polyline { points: list } if list.len() < 2 => {
            return Err(wrong("a polyline needs two points"));
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
            let hull = match *border as Real {
                0.0 => SharedShape::convex_hull(&list),
                border => SharedShape::round_convex_hull(&list, border),
            };
            hull.ok_or(wrong("the points have no hull with a volume"))?
        }
        Shape::Decomposition(mesh) => decomposition(mesh, name)?,
        Shape::Voxels { size, points: list } => {
            voxels(vector(*size), &points(list)).map_err(wrong)?
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

fn voxels(size: Vector, points: &[Vector]) -> Result<SharedShape, &'static str> {
    if points.is_empty() || points.len() > 1_000_000 {
        return Err("voxels need from one to a million points");
    }
    // Their coordinates are counted in `i32`, with room for neighbours.
    if points
        .iter()
        .any(|p| (*p / size).abs().max_element() >= 1.0e9)
    {
        return Err("a voxel must be less than a thousand million sizes from the middle");
    }
    Ok(SharedShape::voxels_from_points(size, points))
}

fn field(heights: &[Vec<f64>], size: [f64; 3]) -> Result<SharedShape, &'static str> {
    let (rows, columns) = (heights.len(), heights.first().map_or(0, Vec::len));
    if rows < 2 || columns < 2 {
        return Err("a height field needs two rows and two columns");
    }
    if heights.iter().any(|row| row.len() != columns) {
        return Err("the rows of a height field must be of one length");
    }
    let mut array = Array2::repeat(rows, columns, 0.0);
    for (i, row) in heights.iter().enumerate() {
        for (j, height) in row.iter().enumerate() {
            array[(i, j)] = *height as Real;
        }
    }
    Ok(SharedShape::heightfield(array, vector(size)))
}

fn decomposition(mesh: &Mesh, name: &str) -> Result<SharedShape, RunError> {
    let mesh = surface(mesh, name)?;
    mesh.check_closed().map_err(|_| RunError::Shape {
        name: name.into(),
        what: "only a closed surface can be cut into convex parts",
    })?;
    Ok(SharedShape::convex_decomposition(
        &mesh.vertices,
        &mesh.triangles,
    ))
}

fn compound(parts: &[Placed], name: &str) -> Result<SharedShape, RunError> {
    let part = |p: &Placed| {
        let turn = Rotation::from_scaled_axis(vector(p.rotation));
        let pose = Pose::from_parts(vector(p.translation), turn);
        let made = shape(&p.shape, name)?;
        if made.as_composite_shape().is_some() {
            return Err(RunError::Shape {
                name: name.into(),
                what: "a part of a compound can't itself be a compound, a mesh or a polyline",
            });
        }
        Ok((pose, made))
    };
    let parts: Result<Vec<_>, _> = parts.iter().map(part).collect();
    Ok(SharedShape::compound(parts?))
}
