//! Lines in a scene: springs, edges, outlines, paths.
//!
//! A line has a width in pixels, not in metres, so that a lattice reads the same from near and far. It is tested against
//! what is already drawn, a little in its favour: an edge lies on the very surface whose edge it is. Draw meshes first.

use super::camera::{Camera, View};
use super::mesh::Mesh;
use super::picture::{FINE, Picture};
use crate::math::{Real, Vector};

/// How much nearer than the surface a line counts, relative to its distance.
const FAVOUR: Real = 1.004;

impl Picture {
    /// Draws a straight line between two points \[m\] in a display RGB, `width` pixels wide. Points that are not finite draw
    /// nothing.
    pub fn draw_line(
        &mut self,
        camera: &Camera,
        from: Vector,
        to: Vector,
        color: [f32; 3],
        width: f32,
    ) {
        self.draw_lines(camera, &[[from, to]], color, width);
    }

    /// Draws many straight lines: the same as [`draw_line`](Self::draw_line) for each.
    pub fn draw_lines(
        &mut self,
        camera: &Camera,
        lines: &[[Vector; 2]],
        color: [f32; 3],
        width: f32,
    ) {
        let size = self.fine_size().map(|n| n as Real);
        let Some(view) = View::new(camera, size) else {
            return;
        };
        let half = (0.5 * width * FINE as f32).max(0.25);
        for [from, to] in lines {
            let ends = [view.local(*from), view.local(*to)];
            if let Some(ends) = clip(ends, view.near) {
                self.fill_line(ends.map(|p| view.project(p)), color, half);
            }
        }
    }

    /// Draws the outline of a mesh: its borders and the edges over which it turns by more than 30°.
    pub fn draw_outline(&mut self, camera: &Camera, mesh: &Mesh, color: [f32; 3], width: f32) {
        self.draw_lines(camera, &mesh.outline(), color, width);
    }

    fn fill_line(&mut self, [a, b]: [[Real; 3]; 2], color: [f32; 3], half: f32) {
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        // Walks along the longer axis and fills across.
        let (along, across) = if dx.abs() >= dy.abs() { (0, 1) } else { (1, 0) };
        let (a, b) = if a[along] <= b[along] { (a, b) } else { (b, a) };
        let length = b[along] - a[along];
        let size = self.fine_size();
        let within = |v: Real, k: usize| v.clamp(0.0, size[k] as Real) as usize;
        if !(length.is_finite() && dx.is_finite() && dy.is_finite()) {
            return;
        }
        let slope = if length > 0.0 {
            (b[across] - a[across]) / length
        } else {
            0.0
        };
        let reach = half * slope.hypot(1.0) + 0.5;
        for i in within((a[along] - 0.5).floor(), along)..within((b[along] + 0.5).ceil(), along) {
            let step = (i as Real + 0.5 - a[along]).clamp(0.0, length);
            let t = if length > 0.0 { step / length } else { 0.0 };
            let w = a[2] + (b[2] - a[2]) * t;
            let middle = a[across] + slope * step;
            for j in
                within((middle - reach).floor(), across)..within((middle + reach).ceil(), across)
            {
                let mut at = [i; 2];
                at[across] = j;
                if w * FAVOUR >= self.depth(at) {
                    let off = (j as Real + 0.5 - middle).abs() / slope.hypot(1.0);
                    self.blend(at, color, half + 0.5 - off);
                }
            }
        }
    }
}

/// The part of a line beyond the near plane; `None` without one or where it is not finite.
fn clip([a, b]: [Vector; 2], near: Real) -> Option<[Vector; 2]> {
    if !(a.is_finite() && b.is_finite()) || (a.z < near && b.z < near) {
        return None;
    }
    let at = |from: Vector, to: Vector| {
        let t = (near - from.z) / (to.z - from.z);
        if from.z < near {
            from + (to - from) * t
        } else {
            from
        }
    };
    Some([at(a, b), at(b, a)])
}
