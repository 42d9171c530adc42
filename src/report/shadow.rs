//! Shadows on the ground, and the plane's own coordinates they are kept in.
//!
//! Shadows are thrown on the plane alone: the meshes are flattened along the light into a small map in the plane's
//! coordinates, which is blurred. Their edge is then as soft near the viewer as far away, and overlapping triangles darken
//! the ground once.

use super::mesh::Mesh;
use crate::math::{Real, Vector};

/// A plane with coordinates \[m\].
pub(super) struct Plane {
    origin: Vector,
    axes: [Vector; 2],
    up: Vector,
}

impl Plane {
    pub fn new(origin: Vector, up: Vector) -> Self {
        // Along the world's axes where it can be, so that the grid is theirs.
        let x = if up.x.abs() < 0.9 {
            Vector::X
        } else {
            Vector::Y
        };
        let first = (x - up * x.dot(up)).normalize_or_zero();
        let axes = [first, up.cross(first)];
        Self { origin, axes, up }
    }

    pub fn flat(&self, p: Vector) -> [Real; 2] {
        self.axes.map(|a| (p - self.origin).dot(a))
    }
}

/// Cells along the longer side of a shadow map.
const CELLS: Real = 600.0;
/// Radius of each of the three passes of blur \[cells\].
const BLUR: usize = 4;

/// What share of the key light is blocked, on a grid over part of a plane.
pub(super) struct Shadow {
    low: [Real; 2],
    cell: Real,
    columns: usize,
    rows: usize,
    map: Vec<f32>,
}

impl Shadow {
    pub fn new(plane: &Plane, light: Vector, casters: &[&Mesh]) -> Self {
        let slope = light.dot(plane.up).max(0.05);
        let drop =
            |p: Vector| plane.flat(p - light * ((p - plane.origin).dot(plane.up).max(0.0) / slope));
        let triangles = casters
            .iter()
            .flat_map(|m| m.triangles.iter().filter_map(|t| m.corners(*t)));
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
        let mut shadow = Self {
            low,
            cell,
            columns: 0,
            rows: 0,
            map: Vec::new(),
        };
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
        let side = |a: [Real; 2], b: [Real; 2], c: [Real; 2]| {
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
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
    pub fn at(&self, p: [Real; 2]) -> f32 {
        let [x, y] = [0, 1].map(|k| (p[k] - self.low[k]) / self.cell - 0.5);
        let is_inside = |x: Real, cells: usize| x >= 0.0 && x + 1.0 < cells as Real;
        if !is_inside(x, self.columns) || !is_inside(y, self.rows) {
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
