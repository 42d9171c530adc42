//! The ground: a plane with a metre grid that fades into the background, and the shadows on it.
//!
//! A crash is read off distances, so the grid is the scale of the picture. It is drawn sample by sample from the plane's
//! own coordinates rather than as lines, which lets it fade where its cells become smaller than pixels. Shadows are thrown
//! on the plane alone: the meshes are flattened along the light into a small map in the plane's coordinates, which is
//! blurred once; their edge is then as soft near the viewer as far away.

use super::camera::{Camera, View};
use super::color::mix;
use super::mesh::Mesh;
use super::picture::Picture;
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
            color: [0.845, 0.860, 0.875],
        }
    }
}

impl Picture {
    /// Draws the ground behind or before what is there already, with the shadows of `casters` on it. It fades into the
    /// background at two to four times the camera's distance from its target. From below it is not seen.
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
                if let (Some((right, _)), Some((below, _)), true) = (hit(1.0, 0.0), hit(0.0, 1.0), ground.cell > 0.0) {
                    let line = grid(at, right, below, ground.cell);
                    color = mix(color, color.map(|c| c * 0.80), line);
                }
                let dark = 0.42 * shadow.at(at);
                color = mix(color, [0.22, 0.24, 0.30], dark);
                self.set([x, y], mix(Picture::BACKGROUND, color, seen), 1.0 / distance);
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

/// A plane with coordinates.
struct Plane {
    origin: Vector,
    axes: [Vector; 2],
    up: Vector,
}

impl Plane {
    fn new(origin: Vector, up: Vector) -> Self {
        // Along the world's axes where it can be, so that the grid is theirs.
        let x = if up.x.abs() < 0.9 { Vector::X } else { Vector::Y };
        let first = (x - up * x.dot(up)).normalize_or_zero();
        let axes = [first, up.cross(first)];
        Self { origin, axes, up }
    }

    fn flat(&self, p: Vector) -> [Real; 2] {
        self.axes.map(|a| (p - self.origin).dot(a))
    }
}

/// Cells along the longer side of a shadow map.
const CELLS: Real = 600.0;
/// Radius of each of the three passes of blur \[cells\].
const BLUR: usize = 4;

/// What share of the key light is blocked, on a grid over part of a plane.
struct Shadow {
    low: [Real; 2],
    cell: Real,
    columns: usize,
    rows: usize,
    map: Vec<f32>,
}

impl Shadow {
    fn new(plane: &Plane, light: Vector, casters: &[&Mesh]) -> Self {
        let slope = light.dot(plane.up).max(0.05);
        let drop = |p: Vector| plane.flat(p - light * ((p - plane.origin).dot(plane.up).max(0.0) / slope));
        let triangles = casters.iter().flat_map(|m| m.triangles.iter().filter_map(|t| m.corners(*t)));
        let flat: Vec<[[Real; 2]; 3]> = triangles.map(|t| t.map(drop)).collect();
        let (mut low, mut high) = ([Real::INFINITY; 2], [Real::NEG_INFINITY; 2]);
        for p in flat.iter().flatten() {
            for k in 0..2 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        let size = [0, 1].map(|k| high[k] - low[k]);
        let cell = size[0].max(size[1]) / CELLS;
        let mut shadow = Self { low, cell, columns: 0, rows: 0, map: Vec::new() };
        if !(cell > 0.0 && cell.is_finite()) {
            return shadow;
        }
        let border = 4 * BLUR;
        shadow.low = low.map(|v| v - border as Real * cell);
        [shadow.columns, shadow.rows] = size.map(|s| (s / cell).ceil() as usize + 2 * border);
        shadow.map = vec![0.0; shadow.columns * shadow.rows];
        for triangle in &flat {
            shadow.fill(triangle);
        }
        for _ in 0..3 {
            shadow.map = blur(&shadow.map, shadow.columns, shadow.rows);
        }
        shadow
    }

    /// Blocks the cells whose middle is in a triangle.
    fn fill(&mut self, triangle: &[[Real; 2]; 3]) {
        let p = triangle.map(|p| [0, 1].map(|k| (p[k] - self.low[k]) / self.cell));
        let side = |a: [Real; 2], b: [Real; 2], c: [Real; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let turn = side(p[0], p[1], p[2]).signum();
        let range = |k: usize, most: usize| {
            let low = p[0][k].min(p[1][k]).min(p[2][k]);
            let high = p[0][k].max(p[1][k]).max(p[2][k]);
            low.max(0.0) as usize..(high.ceil() as usize).min(most)
        };
        for y in range(1, self.rows) {
            for x in range(0, self.columns) {
                let at = [x as Real + 0.5, y as Real + 0.5];
                let inside = (0..3).all(|k| side(p[k], p[(k + 1) % 3], at) * turn >= 0.0);
                if inside {
                    self.map[y * self.columns + x] = 1.0;
                }
            }
        }
    }

    /// The share at a point of the plane, between the cells around it.
    fn at(&self, p: [Real; 2]) -> f32 {
        let [x, y] = [0, 1].map(|k| (p[k] - self.low[k]) / self.cell - 0.5);
        if !(x >= 0.0 && y >= 0.0) || x as usize + 1 >= self.columns || y as usize + 1 >= self.rows {
            return 0.0;
        }
        let (i, j) = (x as usize, y as usize);
        let [u, v] = [x - i as Real, y - j as Real];
        let row = |j: usize| {
            let start = j * self.columns + i;
            self.map[start] * (1.0 - u) + self.map[start + 1] * u
        };
        row(j) * (1.0 - v) + row(j + 1) * v
    }
}

/// Means over 2·[`BLUR`] + 1 cells along each row, transposed twice to do the columns as well.
fn blur(map: &[f32], columns: usize, rows: usize) -> Vec<f32> {
    let once = |map: &[f32], columns: usize, rows: usize| {
        let mut out = vec![0.0; map.len()];
        for (y, row) in map.chunks(columns).enumerate() {
            let mut sum: f32 = row.iter().take(BLUR).sum();
            for x in 0..columns {
                sum += row.get(x + BLUR).copied().unwrap_or(0.0);
                out[x * rows + y] = sum / (2 * BLUR + 1) as f32;
                sum -= if x >= BLUR { row[x - BLUR] } else { 0.0 };
            }
        }
        out
    };
    once(&once(map, columns, rows), rows, columns)
}
