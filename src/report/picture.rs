//! A picture and its pixels.
//!
//! A picture is kept at twice its width and height and averaged when it is read: 2 × 2 supersampling smooths every edge
//! whatever drew it. Drawing takes the camera with each call instead of keeping a scene, so that one picture may hold
//! several views and nothing has to be owned. Colours are display RGB from 0 to 1; light is summed on their squares, a gamma
//! of 2, which is close to a screen's and costs no power function.

use super::error::ReportError;
use std::path::Path;

/// Samples per pixel along a side.
pub(super) const FINE: usize = 2;

/// An image that meshes, lines, ground and text can be drawn into.
#[derive(Clone, Debug)]
pub struct Picture {
    width: usize,
    height: usize,
    /// Samples, row by row from the top, `FINE` per pixel and side.
    color: Vec<[u8; 3]>,
    /// 1/distance of what each sample shows \[1/m\]; 0: the background.
    depth: Vec<f32>,
}

impl Picture {
    /// The colour of an empty picture (display RGB).
    pub const BACKGROUND: [f32; 3] = [0.957, 0.965, 0.973];

    /// An empty picture of at least one pixel, 900 × 600 for a document. It takes 28 bytes of memory per pixel.
    pub fn new(width: u32, height: u32) -> Self {
        let [width, height] = [width, height].map(|n| n.max(1) as usize);
        let samples = width * height * FINE * FINE;
        Self {
            width,
            height,
            color: vec![bytes(Self::BACKGROUND); samples],
            depth: vec![0.0; samples],
        }
    }

    /// Width \[pixels\].
    pub fn width(&self) -> u32 {
        self.width as u32
    }

    /// Height \[pixels\].
    pub fn height(&self) -> u32 {
        self.height as u32
    }

    /// The colour of a pixel, from the upper left corner; `None` outside.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 3]> {
        let [x, y] = [x as usize, y as usize];
        (x < self.width && y < self.height).then(|| self.average(x, y))
    }

    /// All pixels, row by row from the top, red, green and blue of each.
    pub fn rgb(&self) -> Vec<u8> {
        let rows = 0..self.height;
        rows.flat_map(|y| (0..self.width).flat_map(move |x| self.average(x, y)))
            .collect()
    }

    /// Writes the picture as a PNG, whatever the path ends in; an existing file is replaced.
    ///
    /// # Errors
    /// [`ReportError`] with the path where it can't be encoded or written.
    pub fn save_png(&self, path: &Path) -> Result<(), ReportError> {
        use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
        let mut png = Vec::new();
        PngEncoder::new(&mut png)
            .write_image(
                &self.rgb(),
                self.width(),
                self.height(),
                ExtendedColorType::Rgb8,
            )
            .map_err(|source| ReportError::Encode {
                path: path.to_owned(),
                source,
            })?;
        std::fs::write(path, png).map_err(|source| ReportError::Write {
            path: path.to_owned(),
            source,
        })
    }

    fn average(&self, x: usize, y: usize) -> [u8; 3] {
        let mut sum = [0_u32; 3];
        for row in 0..FINE {
            let start = (y * FINE + row) * self.width * FINE + x * FINE;
            for sample in &self.color[start..start + FINE] {
                for (sum, part) in sum.iter_mut().zip(sample) {
                    *sum += u32::from(*part);
                }
            }
        }
        let n = (FINE * FINE) as u32;
        sum.map(|s| ((s + n / 2) / n) as u8)
    }

    /// Columns and rows of samples.
    pub(super) fn fine_size(&self) -> [usize; 2] {
        [self.width * FINE, self.height * FINE]
    }

    /// 1/distance at a sample.
    pub(super) fn depth(&self, [x, y]: [usize; 2]) -> f32 {
        self.depth[y * self.width * FINE + x]
    }

    /// Sets a sample's colour and 1/distance.
    pub(super) fn set(&mut self, [x, y]: [usize; 2], color: [f32; 3], depth: f32) {
        let i = y * self.width * FINE + x;
        self.color[i] = bytes(color);
        self.depth[i] = depth;
    }

    /// Covers a sample with a colour; `cover` beyond 0 and 1 is clamped.
    pub(super) fn blend(&mut self, [x, y]: [usize; 2], color: [f32; 3], cover: f32) {
        if cover > 0.0 {
            let under = &mut self.color[y * self.width * FINE + x];
            let below = under.map(|c| f32::from(c) / 255.0);
            *under = bytes(super::color::mix(below, color, cover.min(1.0)));
        }
    }

    /// Fills a rectangle given by two corners \[pixels\] with a colour for each position \[pixels\], over whatever is there.
    pub(super) fn fill(
        &mut self,
        from: [f32; 2],
        to: [f32; 2],
        cover: f32,
        color: impl Fn(f32, f32) -> [f32; 3],
    ) {
        let size = self.fine_size();
        let at = |p: f32, k: usize| (p * FINE as f32).round().clamp(0.0, size[k] as f32) as usize;
        for y in at(from[1], 1)..at(to[1], 1) {
            for x in at(from[0], 0)..at(to[0], 0) {
                let [px, py] = [x, y].map(|i| (i as f32 + 0.5) / FINE as f32);
                self.blend([x, y], color(px, py), cover);
            }
        }
    }

    fn paste(&mut self, other: &Picture, [left, top]: [usize; 2]) {
        let [columns, rows] = other.fine_size();
        for y in 0..rows {
            let to = (top * FINE + y) * self.width * FINE + left * FINE;
            let from = y * columns;
            self.color[to..to + columns].copy_from_slice(&other.color[from..from + columns]);
        }
    }
}

/// Display RGB from 0 to 1 in bytes; NaN becomes 0.
fn bytes(color: [f32; 3]) -> [u8; 3] {
    color.map(|c| (c * 255.0 + 0.5) as u8)
}

/// Pictures side by side in rows of `columns` (at least 1), in the order given, with a white gap of 6 pixels. Cells are as
/// large as the largest picture; no pictures give one of a single pixel.
pub fn contact_sheet(pictures: &[Picture], columns: usize) -> Picture {
    const GAP: usize = 6;
    let columns = columns.clamp(1, pictures.len().max(1));
    let rows = pictures.len().div_ceil(columns);
    let width = pictures.iter().map(|p| p.width).max().unwrap_or(0);
    let height = pictures.iter().map(|p| p.height).max().unwrap_or(0);
    let total = |n: usize, size: usize| (n * (size + GAP)).saturating_sub(GAP) as u32;
    let mut sheet = Picture::new(total(columns, width), total(rows, height));
    sheet.color.fill([255; 3]);
    for (i, picture) in pictures.iter().enumerate() {
        let at = [
            (i % columns) * (width + GAP),
            (i / columns) * (height + GAP),
        ];
        sheet.paste(picture, at);
    }
    sheet
}
