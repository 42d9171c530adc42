//! Meshes of the rigid shapes in a scene: crates, walls, barriers and poles.
//!
//! Round shapes are turned profiles. Each straight or round piece of a profile has vertices of its own, so that smooth
//! shading stops at a rim and the rim counts as an outline. As in Rapier, cylinders and capsules stand along their y axis.

use super::mesh::Mesh;
use crate::math::{Pose, Real, Vector};
use std::collections::BTreeMap;
use std::f32::consts::PI;

/// Segments around a round shape.
const AROUND: u32 = 40;

impl Mesh {
    /// A box with half its sides \[m\], in one display RGB.
    pub fn cuboid(half_extents: Vector, pose: &Pose, color: [f32; 3]) -> Self {
        let sign = |i: u32, bit: u32| if i & (1 << bit) == 0 { -1.0 } else { 1.0 };
        let corner = |i: u32| Vector::new(sign(i, 0), sign(i, 1), sign(i, 2)) * half_extents;
        let quads: [[u32; 4]; 6] = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        let triangles = quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let vertices = (0..8).map(|i| pose.transform_point(corner(i))).collect();
        Self::new(vertices, triangles.collect(), color)
    }

    /// A ball of a radius \[m\].
    pub fn ball(radius: Real, pose: &Pose, color: [f32; 3]) -> Self {
        revolve(&[arc(radius, 0.0, -0.5 * PI, 0.5 * PI, 20)], pose, color)
    }

    /// A cylinder along y with half its height and a radius \[m\].
    pub fn cylinder(half_height: Real, radius: Real, pose: &Pose, color: [f32; 3]) -> Self {
        let [low, high] = [[radius, -half_height], [radius, half_height]];
        let axis = |p: [Real; 2]| [0.0, p[1]];
        let pieces = [
            vec![axis(low), low],
            vec![low, high],
            vec![high, axis(high)],
        ];
        revolve(&pieces, pose, color)
    }

    /// A capsule along y: half the height of its straight part and a radius \[m\].
    pub fn capsule(half_height: Real, radius: Real, pose: &Pose, color: [f32; 3]) -> Self {
        let mut profile = arc(radius, -half_height, -0.5 * PI, 0.0, 10);
        profile.extend(arc(radius, half_height, 0.0, 0.5 * PI, 10));
        revolve(&[profile], pose, color)
    }

    /// Triangles over vertices in a frame of their own \[m\].
    pub fn triangles(
        vertices: &[Vector],
        triangles: Vec<[u32; 3]>,
        pose: &Pose,
        color: [f32; 3],
    ) -> Self {
        let vertices = vertices.iter().map(|v| pose.transform_point(*v));
        Self::new(vertices.collect(), triangles, color)
    }

    /// Triangles that may have corners of their own: equal ones are made one, so that neighbours are known as such and only
    /// creases are outlined.
    pub fn welded(
        corners: &[Vector],
        triangles: &[[u32; 3]],
        pose: &Pose,
        color: [f32; 3],
    ) -> Self {
        let (mut vertices, mut known) = (Vec::new(), BTreeMap::new());
        let ids: Vec<u32> = corners
            .iter()
            .map(|p| {
                *known
                    .entry(p.to_array().map(Real::to_bits))
                    .or_insert_with(|| {
                        vertices.push(*p);
                        vertices.len() as u32 - 1
                    })
            })
            .collect();
        let triangles = triangles.iter().map(|t| t.map(|i| ids[i as usize]));
        Self::triangles(&vertices, triangles.collect(), pose, color)
    }
}

/// Radius and height of points on a circle around height `middle`, from the angle `from` to `to` over the horizon.
fn arc(radius: Real, middle: Real, from: Real, to: Real, steps: u32) -> Vec<[Real; 2]> {
    let angle = |i: u32| from + (to - from) * i as Real / steps as Real;
    (0..=steps)
        .map(|i| [radius * angle(i).cos(), middle + radius * angle(i).sin()])
        .collect()
}

/// Turns each piece of a profile (radius, height; upward) around the y axis.
fn revolve(pieces: &[Vec<[Real; 2]>], pose: &Pose, color: [f32; 3]) -> Mesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for piece in pieces {
        let widest = piece.iter().fold(0.0, |w: Real, p| w.max(p[0]));
        // The vertices of each ring: one where the profile meets the axis.
        let mut rings: Vec<Vec<u32>> = Vec::new();
        for [radius, height] in piece {
            let count = if *radius <= 1.0e-5 * widest {
                1
            } else {
                AROUND
            };
            let first = vertices.len() as u32;
            for i in 0..count {
                let (sin, cos) = (2.0 * PI * i as Real / AROUND as Real).sin_cos();
                vertices.push(pose.transform_point(Vector::new(
                    radius * cos,
                    *height,
                    radius * sin,
                )));
            }
            rings.push((0..AROUND).map(|i| first + i % count).collect());
        }
        for ring in rings.windows(2) {
            for i in 0..AROUND as usize {
                let next = (i + 1) % AROUND as usize;
                let [a, b, c, d] = [ring[0][i], ring[1][i], ring[1][next], ring[0][next]];
                triangles.extend(
                    [[a, b, c], [a, c, d]]
                        .into_iter()
                        .filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]),
                );
            }
        }
    }
    Mesh::new(vertices, triangles, color).smooth()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume enclosed, positive where triangles turn outward \[m³\].
    fn volume(mesh: &Mesh) -> Real {
        let of = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
            a.dot(b.cross(c)) / 6.0
        };
        mesh.triangles.iter().map(of).sum()
    }

    #[test]
    fn shapes_are_closed_and_turn_outward() {
        let pose = Pose::new(Vector::new(1.0, 2.0, 3.0), Vector::new(0.3, 0.2, 0.1));
        let grey = [0.5; 3];
        let near = |mesh: Mesh, expected: Real| {
            let v = volume(&mesh);
            assert!((v / expected - 1.0).abs() < 0.02, "{v} for {expected}");
        };
        near(Mesh::cuboid(Vector::new(0.5, 1.0, 1.5), &pose, grey), 6.0);
        near(Mesh::ball(1.0, &pose, grey), 4.0 / 3.0 * PI);
        near(Mesh::cylinder(1.5, 0.5, &pose, grey), 0.75 * PI);
        near(Mesh::capsule(1.0, 0.5, &pose, grey), 0.5 * PI + PI / 6.0);
    }

    #[test]
    fn a_height_field_is_one_sheet_where_it_stands() {
        let heights = rapier3d::parry::utils::Array2::repeat(4, 3, 0.5);
        let field = rapier3d::geometry::HeightField::new(heights, Vector::new(2.0, 1.0, 3.0));
        let pose = Pose::from_translation(Vector::new(0.0, 1.0, 10.0));
        let (corners, triangles) = field.to_trimesh();
        let mesh = Mesh::welded(&corners, &triangles, &pose, [0.5; 3]);
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (12, 12));
        let (lo, hi) = mesh.bounds().unwrap();
        assert!(lo.distance(Vector::new(-1.0, 1.5, 8.5)) < 1.0e-5, "{lo}");
        assert!(hi.distance(Vector::new(1.0, 1.5, 11.5)) < 1.0e-5, "{hi}");
        // The rim only: neighbours share their edges.
        assert_eq!(mesh.outline().len(), 10);
    }

    #[test]
    fn a_box_is_outlined_by_its_twelve_edges() {
        let edges = Mesh::cuboid(Vector::ONE, &Pose::IDENTITY, [0.5; 3]).outline();
        assert_eq!(edges.len(), 12);
        assert_eq!(
            Mesh::ball(1.0, &Pose::IDENTITY, [0.5; 3]).outline().len(),
            0
        );
        assert_eq!(
            Mesh::cylinder(1.0, 1.0, &Pose::IDENTITY, [0.5; 3])
                .outline()
                .len(),
            4 * AROUND as usize
        );
        assert!(
            edges
                .iter()
                .all(|[a, b]| (a.distance(*b) - 2.0).abs() < 1.0e-6)
        );
    }
}
