//! Draws frames of a run: skins coloured by plastic strain, rigid shapes, the ground.
//!
//! One camera for all frames of a run, placed so that everything that moves stays in the picture, because a series of
//! pictures is compared by eye. What a car is recognised by (glass, tyres, rims, lamps) keeps its own colour; the rest
//! shows the damage.

use super::camera::Camera;
use super::color::{ColorBar, colormap, mix};
use super::ground::Ground;
use super::mesh::Mesh;
use super::picture::Picture;
use super::rigid;
use crate::math::{Pose, Real, Vector};
use crate::record::frame::{Frame, FrameBody};
use rapier3d::geometry::ColliderHandle;
use std::ops::Range;

/// Share of a picture's width that is left to the colour scale \[1\].
const LEGEND: Real = 0.16;

/// How the frames of a run are drawn.
#[derive(Clone, Debug)]
pub struct Stage {
    /// From where.
    pub camera: Camera,
    /// Width and height \[pixels\].
    pub size: [u32; 2],
    /// Runs of the first deformable's triangles with a colour of their own, by name: `glass`, `tyre`, `rim`, `lamp`;
    /// others show their strain. They hold for every deformable with as many triangles as the first.
    pub parts: Vec<(String, Range<usize>)>,
    /// The collider that is drawn as a plane, if it is a box or a half-space.
    pub ground: Option<ColliderHandle>,
    /// Strain at the end of the colour scale \[1\].
    pub max_strain: f64,
    /// What the colour scale is of.
    pub label: &'static str,
    /// Radius of the beads that stand for the nodes of a body without triangles \[m\].
    pub bead: Real,
}

/// Radius of a bead, over the diagonal of what moves \[1\].
const BEAD: Real = 0.004;

impl Stage {
    /// A camera that looks along −`from` and sees everything that moves in any of the frames.
    pub fn framing(frames: &[Frame], from: Vector, size: [u32; 2]) -> Self {
        let mut corners = (Vector::INFINITY, Vector::NEG_INFINITY);
        let mut take = |p: Vector| {
            if p.is_finite() {
                corners = (corners.0.min(p), corners.1.max(p));
            }
        };
        for frame in frames {
            frame
                .bodies
                .iter()
                .flat_map(|b| &b.vertices)
                .for_each(|v| take(*v));
            for c in frame.colliders.iter().filter(|c| c.dynamic) {
                let aabb = c.shape.compute_aabb(&c.pose);
                take(aabb.mins);
                take(aabb.maxs);
            }
        }
        let (lo, hi) = if corners.0.x <= corners.1.x {
            corners
        } else {
            (Vector::splat(-1.0), Vector::ONE)
        };
        let aspect = size[0] as Real / size[1].max(1) as Real;
        let mut camera = Camera::framing(lo, hi, from, aspect * (1.0 - LEGEND));
        // Aside, so that the colour scale stands beside what moves and not over it.
        let along = camera.target - camera.eye;
        let width = 2.0 * along.length() * (0.5 * camera.fov_y).tan() * aspect;
        if let Some(right) = along.cross(camera.up).try_normalize() {
            camera.eye += right * (0.5 * LEGEND * width);
            camera.target += right * (0.5 * LEGEND * width);
        }
        Self {
            camera,
            size,
            parts: Vec::new(),
            ground: None,
            max_strain: 0.4,
            label: "plastic strain",
            bead: BEAD * (hi - lo).length(),
        }
    }

    /// The picture of a frame, with its time and, where something is damaged, the colour scale.
    pub fn draw(&self, frame: &Frame) -> Picture {
        let [width, height] = self.size;
        let mut picture = Picture::new(width, height);
        let mut meshes = Vec::new();
        let first = frame.bodies.first().map_or(0, |b| b.triangles.len());
        for body in &frame.bodies {
            self.body(body, body.triangles.len() == first, &mut meshes);
        }
        let soft = meshes.len();
        let plane = self.plane(frame);
        for collider in &frame.colliders {
            if plane.is_none() || Some(collider.collider) != self.ground {
                rigid::draw(collider, &mut meshes);
            }
        }
        for mesh in &meshes {
            picture.draw_mesh(&self.camera, mesh);
        }
        for mesh in &meshes[soft..] {
            picture.draw_outline(&self.camera, mesh, [0.30, 0.30, 0.33], 0.8);
        }
        if let Some(ground) = plane {
            let casters: Vec<&Mesh> = meshes.iter().collect();
            picture.draw_ground(&self.camera, &ground, &casters);
        }
        let text = format!("{:.0} ms", frame.time * 1000.0);
        let size = height as f32 / 22.0;
        picture.draw_text([size, size], size, [0.2, 0.22, 0.25], &text);
        if self.max_strain > 0.0 {
            picture.draw_color_bar(&ColorBar {
                label: self.label.into(),
                unit: String::new(),
                min: 0.0,
                max: self.max_strain,
            });
        }
        picture
    }

    fn body(&self, body: &FrameBody, has_parts: bool, meshes: &mut Vec<Mesh>) {
        let strain_colors: Vec<[f32; 3]> = body
            .strain
            .iter()
            .map(|s| colormap(*s / self.max_strain.max(1.0e-9) as f32))
            .collect();
        let part = |triangles: &[[u32; 3]], tint: Option<[f32; 3]>| Mesh {
            vertices: body.vertices.clone(),
            colors: match tint {
                None => strain_colors.clone(),
                Some(tint) => strain_colors.iter().map(|c| mix(tint, *c, 0.12)).collect(),
            },
            triangles: triangles.to_vec(),
            smooth: true,
        };
        if body.triangles.is_empty() {
            let beads = body.vertices.iter().zip(&strain_colors);
            meshes.extend(
                beads.map(|(at, c)| Mesh::ball(self.bead, &Pose::from_translation(*at), *c)),
            );
        }
        let mut drawn = vec![false; body.triangles.len()];
        for (name, range) in self.parts.iter().filter(|_| has_parts) {
            let Some(triangles) = body.triangles.get(range.clone()) else {
                continue;
            };
            drawn[range.clone()].fill(true);
            meshes.push(part(triangles, tint(name)));
        }
        let rest = body.triangles.iter().zip(&drawn).filter(|(_, d)| !**d);
        let rest: Vec<[u32; 3]> = rest.map(|(t, _)| *t).collect();
        if !rest.is_empty() {
            meshes.push(part(&rest, None));
        }
    }

    /// The plane that is drawn for the ground, if that is one.
    fn plane(&self, frame: &Frame) -> Option<Ground> {
        let handle = self.ground?;
        let ground = frame.colliders.iter().find(|c| c.collider == handle)?;
        rigid::ground(ground)
    }
}

fn tint(name: &str) -> Option<[f32; 3]> {
    Some(match name {
        "glass" => [0.22, 0.28, 0.34],
        "tyre" => [0.16, 0.16, 0.17],
        "rim" => [0.62, 0.63, 0.65],
        "lamp" => [0.96, 0.93, 0.78],
        _ => return None,
    })
}
