//! Triangles into pixels: near clipping, a z-buffer on 1/distance, perspective-correct colours, two-sided light.
//!
//! Light is worked out at the corners and spread over the triangle: a key light over the viewer's left shoulder
//! (Lambert), a weak fill light from the right, and an ambient that is brighter from above than from below. Skins of
//! crushed bodies fold and turn inside out, so a side that faces away is lit as if it faced the viewer.

use super::camera::{Camera, View};
use super::mesh::Mesh;
use super::picture::Picture;
use crate::math::{Real, Vector};

/// A corner: place in the eye's frame and lit colour, squared.
type Corner = (Vector, Vector);

impl Picture {
    /// Draws a mesh with depth test. Triangles with a corner that is missing or not finite are left out.
    pub fn draw_mesh(&mut self, camera: &Camera, mesh: &Mesh) {
        let [width, height] = self.fine_size().map(|n| n as Real);
        let Some(view) = View::new(camera, [width, height]) else {
            return;
        };
        let normals = if mesh.smooth {
            mesh.normals()
        } else {
            Vec::new()
        };
        for &triangle in &mesh.triangles {
            let Some(points) = mesh.corners(triangle) else {
                continue;
            };
            let flat = (points[1] - points[0]).cross(points[2] - points[0]);
            let Some(flat) = flat.try_normalize() else {
                continue;
            };
            let side = if flat.dot(points[0] - view.eye) > 0.0 {
                -1.0
            } else {
                1.0
            };
            let corners = [0, 1, 2].map(|k| {
                let normal = normals.get(triangle[k] as usize).copied().unwrap_or(flat);
                let color = Vector::from_array(mesh.color(triangle[k]));
                let light = brightness(&view, camera.up, side * normal);
                (view.local(points[k]), color * color * light)
            });
            let polygon = clip(&corners, view.near);
            for k in 2..polygon.len() {
                self.fill_triangle(&view, [polygon[0], polygon[k - 1], polygon[k]]);
            }
        }
    }

    fn fill_triangle(&mut self, view: &View, corners: [Corner; 3]) {
        let p = corners.map(|c| view.project(c.0));
        let area = cross(p[0], p[1], p[2]);
        if !area.is_finite() || area == 0.0 {
            return;
        }
        let size = self.fine_size();
        let range = |k: usize| {
            let low = p[0][k].min(p[1][k]).min(p[2][k]) - 0.5;
            let high = p[0][k].max(p[1][k]).max(p[2][k]) + 0.5;
            let most = size[k] as Real;
            low.floor().clamp(0.0, most) as usize..high.ceil().clamp(0.0, most) as usize
        };
        // Colours over distance are linear on the screen; colours are not.
        let tint = [0, 1, 2].map(|k| corners[k].1 * p[k][2]);
        for y in range(1) {
            for x in range(0) {
                let at = [x as Real + 0.5, y as Real + 0.5, 0.0];
                let share = [
                    cross(p[1], p[2], at) / area,
                    cross(p[2], p[0], at) / area,
                    cross(p[0], p[1], at) / area,
                ];
                if share.iter().any(|s| *s < 0.0) {
                    continue;
                }
                let w = share[0] * p[0][2] + share[1] * p[1][2] + share[2] * p[2][2];
                if w > self.depth([x, y]) {
                    let color = (tint[0] * share[0] + tint[1] * share[1] + tint[2] * share[2]) / w;
                    self.set([x, y], color.to_array().map(Real::sqrt), w);
                }
            }
        }
    }
}

/// How bright a side with this normal is, 0 to about 1.1.
fn brightness(view: &View, up: Vector, normal: Vector) -> Real {
    let sky = up.try_normalize().unwrap_or(view.up);
    let fill = view.right - 0.5 * view.forward + 0.2 * sky;
    let ambient = 0.36 + 0.10 * normal.dot(sky);
    let key = 0.66 * normal.dot(view.light).max(0.0);
    let fill = 0.13 * normal.dot(fill).max(0.0);
    ambient + key + fill
}

/// Twice the signed area of a triangle on the screen.
fn cross(a: [Real; 3], b: [Real; 3], c: [Real; 3]) -> Real {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The part of a triangle beyond the near plane: no, three or four corners.
fn clip(corners: &[Corner; 3], near: Real) -> Vec<Corner> {
    let mut polygon = Vec::with_capacity(4);
    for k in 0..3 {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let [da, db] = [a.0.z - near, b.0.z - near];
        if da >= 0.0 {
            polygon.push(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            let t = da / (da - db);
            polygon.push((a.0 + (b.0 - a.0) * t, a.1 + (b.1 - a.1) * t));
        }
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_thousand_triangles_are_quick() {
        let n = 71_u32;
        let place = |i: u32| {
            Vector::new(
                (i % n) as f32 / 35.0 - 1.0,
                (i / n) as f32 / 35.0 - 1.0,
                ((i * i) % 7) as f32 * 0.02,
            )
        };
        let quad = |i: u32| [[i, i + 1, i + n + 1], [i, i + n + 1, i + n]];
        let triangles = (0..n * (n - 1))
            .filter(|i| i % n + 1 < n)
            .flat_map(quad)
            .collect();
        let mesh = Mesh::new((0..n * n).map(place).collect(), triangles, [0.6; 3]).smooth();
        assert!(mesh.triangles.len() > 9_700);
        let camera = Camera::framing(
            Vector::splat(-1.0),
            Vector::splat(1.0),
            Vector::new(0.3, 0.4, 1.0),
            1.5,
        );
        let start = std::time::Instant::now();
        let mut picture = Picture::new(900, 600);
        picture.draw_mesh(&camera, &mesh);
        picture.draw_ground(
            &camera,
            &super::super::Ground {
                origin: Vector::new(0.0, -1.0, 0.0),
                ..Default::default()
            },
            &[&mesh],
        );
        let seconds = start.elapsed().as_secs_f64();
        println!("{seconds:.3} s");
        // 0.1 s or so in release; the bound is for a debug build on a busy machine.
        assert!(seconds < 5.0, "{seconds} s");
    }
}
