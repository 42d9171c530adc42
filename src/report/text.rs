//! Text in a picture, drawn over whatever is there: each character's strokes with round ends, smoothed at their edge.

use super::font::strokes;
use super::picture::{FINE, Picture};

/// Half the width of a stroke, in units of the font's grid.
const RADIUS: f32 = 0.42;

/// A point of a glyph on the font's grid.
type Point = [f32; 2];

impl Picture {
    /// Writes one line in a colour (display RGB). `at` is the upper left corner of its capitals, `size` their height, both in
    /// pixels; 12 is the smallest that reads well. What lies outside the picture is cut off.
    pub fn draw_text(&mut self, at: [f32; 2], size: f32, color: [f32; 3], text: &str) {
        let fine = FINE as f32;
        let unit = size * fine / (6.0 + 2.0 * RADIUS);
        if !(unit > 0.0 && unit.is_finite() && at[0].is_finite() && at[1].is_finite()) {
            return;
        }
        let mut left = (at[0] * fine / unit) + RADIUS;
        let top = (at[1] * fine / unit) + RADIUS;
        for c in text.chars() {
            let lines = segments(c);
            if !lines.is_empty() {
                self.draw_glyph(&lines, [left, top], unit, color);
            }
            left += advance(c);
        }
    }

    /// Width of a line of text \[pixels\].
    pub fn text_width(size: f32, text: &str) -> f32 {
        let units: f32 = text.chars().map(advance).sum();
        let gap = if text.is_empty() {
            0.0
        } else {
            1.8 - 2.0 * RADIUS
        };
        (units - gap) * size / (6.0 + 2.0 * RADIUS)
    }

    fn draw_glyph(&mut self, lines: &[[Point; 2]], at: Point, unit: f32, color: [f32; 3]) {
        let [columns, rows] = self.fine_size();
        // Range of pixels of a span on the grid, within the picture.
        let span = |low: f32, high: f32, most: usize| {
            let end = (high * unit).ceil().clamp(0.0, most as f32) as usize;
            ((low * unit).floor().clamp(0.0, most as f32) as usize).min(end)..end
        };
        let radius = RADIUS.max(0.6 / unit);
        for y in span(at[1] - 1.0, at[1] + 9.0, rows) {
            for x in span(at[0] - 1.0, at[0] + 7.0, columns) {
                let p = [
                    (x as f32 + 0.5) / unit - at[0],
                    (y as f32 + 0.5) / unit - at[1],
                ];
                let nearest = lines
                    .iter()
                    .map(|l| distance(p, l))
                    .fold(f32::INFINITY, f32::min);
                self.blend([x, y], color, (radius - nearest) * unit + 0.5);
            }
        }
    }
}

/// How far the next character starts, in grid units.
fn advance(c: char) -> f32 {
    let width = segments(c)
        .iter()
        .flatten()
        .map(|p| p[0])
        .fold(0.0, f32::max);
    if c == ' ' { 2.8 } else { width + 1.8 }
}

fn segments(c: char) -> Vec<[Point; 2]> {
    let mut lines = Vec::new();
    for polyline in strokes(c).split('|') {
        let points: Vec<Point> = polyline
            .split_whitespace()
            .map(|p| p.as_bytes())
            .filter(|p| p.len() == 2)
            .map(|p| [0, 1].map(|k| f32::from(p[k] - b'0')))
            .collect();
        lines.extend(points.windows(2).map(|w| [w[0], w[1]]));
    }
    lines
}

fn distance(p: Point, [a, b]: &[Point; 2]) -> f32 {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let [px, py] = [p[0] - a[0], p[1] - a[1]];
    let square = dx * dx + dy * dy;
    let t = if square > 0.0 {
        ((px * dx + py * dy) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (px - t * dx).hypot(py - t * dy)
}
