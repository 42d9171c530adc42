//! The ground: a plane with a metre grid that fades into the background, and the shadows on it.
//!
//! A crash is read off distances, so the grid is the scale of the picture. It is drawn sample by sample from the plane's
//! own coordinates rather than as lines, which lets it fade where its cells become smaller than pixels.

use super::camera::{Camera, View};
use super::color::mix;
use super::mesh::Mesh;
use super::picture::Picture;
use super::shadow::{Plane, Shadow};
use crate::math::{Real, Vector};

/// A horizontal (or any) plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// A point on it; grid lines go through it \[m\].
    pub origin: Vector,
    /// Its normal, any length.
    pub up: Vector,
    /// Distance of the grid lines \[m\]; 0: no grid.
    pub cell: Real,
    /// Display RGB of the plane.
    pub color: [f32; 3],
}

impl Default for Ground {
    /// The plane y = 0 with a line each metre.
    fn default() -> Self {
        Self {
            origin: Vector::ZERO,
            up: Vector::Y,
            cell: 1.0,
            color: [0.885, 0.895, 0.905],
        }
    }
}

impl Picture {
    /// Draws the ground behind or before what is there already, with the shadows of `casters` on it. It fades into the
    /// background with the distance from the camera's target: from 0.6 to 2.2 times what the camera stands away from it.
    /// From below it is not seen.
    pub fn draw_ground(&mut self, camera: &Camera, ground: &Ground, casters: &[&Mesh]) {
        let [columns, rows] = self.fine_size();
        let Some(view) = View::new(camera, [columns as Real, rows as Real]) else {
            return;
        };
        let Some(up) = ground.up.try_normalize() else {
            return;
        };
        let plane = Plane::new(ground.origin, up);
        let height = (view.eye - ground.origin).dot(up);
        if height.is_nan() || height <= 0.0 {
            return;
        }
        let shadow = Shadow::new(&plane, view.light, casters);
        let reach = (camera.target - camera.eye).length();
        let middle = plane.flat(camera.target);
        for y in 0..rows {
            for x in 0..columns {
                // Where the view through this sample and its neighbours meets the plane.
                let hit = |dx: Real, dy: Real| {
                    let ray = view.ray(x as Real + 0.5 + dx, y as Real + 0.5 + dy);
                    let distance = -height / ray.dot(up);
                    (distance > 0.0).then(|| (plane.flat(view.eye + ray * distance), distance))
                };
                let Some((at, distance)) = hit(0.0, 0.0) else {
                    continue;
                };
                let far = (at[0] - middle[0]).hypot(at[1] - middle[1]) / reach;
                let seen = 1.0 - smooth(0.6, 2.2, far);
                if seen <= 0.0 || 1.0 / distance * 0.9999 <= self.depth([x, y]) {
                    continue;
                }
                let mut color = ground.color;
                if let (Some((right, _)), Some((below, _)), true) =
                    (hit(1.0, 0.0), hit(0.0, 1.0), ground.cell > 0.0)
                {
                    let line = grid(at, right, below, ground.cell);
                    color = mix(color, color.map(|c| c * 0.80), line);
                }
                let dark = 0.46 * shadow.at(at);
                color = mix(color, [0.22, 0.24, 0.30], dark);
                self.set(
                    [x, y],
                    mix(Picture::BACKGROUND, color, seen),
                    1.0 / distance,
                );
            }
        }
    }
}

/// How much of a sample is covered by grid lines, from its place and those of its neighbours.
fn grid(at: [Real; 2], right: [Real; 2], below: [Real; 2], cell: Real) -> Real {
    let line = [0, 1].map(|k| {
        let step = (right[k] - at[k]).hypot(below[k] - at[k]) / cell;
        let place = at[k] / cell;
        let off = (place - place.round()).abs() / step.max(1.0e-9);
        (1.6 - off).clamp(0.0, 1.0) * (1.0 - smooth(0.08, 0.35, step))
    });
    line[0].max(line[1])
}

fn smooth(low: Real, high: Real, x: Real) -> Real {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
