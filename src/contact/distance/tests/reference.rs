//! Slow, plain references.

use crate::math::{DVec3, wide};
use rapier3d::geometry::{SharedShape, TypedShape};
use rapier3d::math::{IVector, Pose, Vector};
use rapier3d::parry::transformation::convex_hull;
use std::collections::BTreeSet;

/// A linear congruential generator.
pub struct Random(pub u64);

impl Random {
    /// From 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Each component from −1 to 1.
    pub fn vector(&mut self) -> DVec3 {
        let mut one = || 2.0 * self.unit() - 1.0;
        DVec3::new(one(), one(), one())
    }
}

/// parry's projection, for the shapes whose projection is right: sharp primitives, and round ones as their core less the
/// radius.
pub fn parry_distance(shape: &SharedShape, p: DVec3) -> Option<f64> {
    use TypedShape as T;
    let (core, radius) = match shape.as_typed_shape() {
        T::Ball(_) | T::Cuboid(_) | T::Capsule(_) | T::Cylinder(_) | T::Cone(_) => {
            (shape.clone(), 0.0)
        }
        T::RoundCuboid(s) => (SharedShape::new(s.inner_shape), s.border_radius),
        T::RoundCylinder(s) => (SharedShape::new(s.inner_shape), s.border_radius),
        T::RoundCone(s) => (SharedShape::new(s.inner_shape), s.border_radius),
        _ => return None,
    };
    let p = p.as_vec3();
    let foot = core.project_local_point(p, false);
    let sign = if foot.is_inside { -1.0 } else { 1.0 };
    Some(f64::from((p - foot.point).length()) * sign - f64::from(radius))
}

/// parry's triangles of a hull.
pub fn triangles(points: &[Vector]) -> Vec<[DVec3; 3]> {
    let (vertices, indices) = convex_hull(points);
    indices
        .iter()
        .map(|t| t.map(|i| wide(vertices[i as usize])))
        .collect()
}

/// Over all triangles of a convex body.
pub fn distance_to_triangles(mesh: &[[DVec3; 3]], p: DVec3) -> f64 {
    let mut highest = f64::NEG_INFINITY;
    let mut nearest = f64::INFINITY;
    for &[a, b, c] in mesh {
        let n = (b - a).cross(c - a).normalize();
        highest = highest.max((p - a).dot(n));
        nearest = nearest.min((p - on_triangle(p, a, b, c)).length());
    }
    if highest > 0.0 { nearest } else { highest }
}

/// The nearest point of a triangle: in its plane if that lies within, else on its edges.
fn on_triangle(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    let n = (b - a).cross(c - a).normalize();
    let foot = p - n * (p - a).dot(n);
    let edges = [(a, b), (b, c), (c, a)];
    if edges
        .iter()
        .all(|&(s, e)| (e - s).cross(foot - s).dot(n) >= 0.0)
    {
        return foot;
    }
    let on_edges = edges.map(|(s, e)| {
        let t = (p - s).dot(e - s) / (e - s).length_squared();
        s + (e - s) * t.clamp(0.0, 1.0)
    });
    on_edges
        .into_iter()
        .min_by(|x, y| p.distance(*x).total_cmp(&p.distance(*y)))
        .unwrap()
}

/// A box over cells of 0.25 m, with its pose.
pub fn inner_box(lo: [i32; 3], hi: [i32; 3]) -> (Pose, SharedShape) {
    let half = |i: usize| (hi[i] - lo[i]) as f32 * 0.125;
    let middle = |i: usize| (hi[i] + lo[i]) as f32 * 0.125;
    (
        Pose::translation(middle(0), middle(1), middle(2)),
        SharedShape::cuboid(half(0), half(1), half(2)),
    )
}

/// Filled cells, and the empty ones up to four cells around them.
pub fn cells(filled: &[IVector]) -> (Vec<IVector>, Vec<IVector>) {
    let key = |c: IVector| (c.x, c.y, c.z);
    let set: BTreeSet<_> = filled.iter().map(|&c| key(c)).collect();
    let mut empty = BTreeSet::new();
    for &c in filled {
        for i in 0..9_i32.pow(3) {
            let other = c + IVector::new(i % 9 - 4, i / 9 % 9 - 4, i / 81 - 4);
            if !set.contains(&key(other)) {
                empty.insert(key(other));
            }
        }
    }
    let empty = empty.into_iter().map(|(x, y, z)| IVector::new(x, y, z));
    (filled.to_vec(), empty.collect())
}

/// To the nearest filled cell, or less the distance to the nearest empty one.
pub fn distance_to_cells(all: &(Vec<IVector>, Vec<IVector>), cell: f64, p: DVec3) -> f64 {
    let nearest = |list: &[IVector]| {
        let away = |c: &IVector| {
            let low = c.as_dvec3() * cell;
            (low - p)
                .max(p - low - DVec3::splat(cell))
                .max(DVec3::ZERO)
                .length()
        };
        list.iter().map(away).fold(f64::INFINITY, f64::min)
    };
    let out = nearest(&all.0);
    if out > 0.0 { out } else { -nearest(&all.1) }
}
