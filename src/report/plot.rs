//! Line plots of channels: raw and filtered forces, energies that must add up, force over displacement.
//!
//! The colours are those of Okabe and Ito ("Color Universal Design", 2008), which stay distinct for colour-blind readers;
//! a raw channel is a thin line drawn first, so that the filtered one lies on top of it. The legend stands beside the axes
//! where it never hides a peak.

use super::decimate::decimate;
use super::error::ReportError;
use kuva::plot::{LinePlot, legend::LegendEntry, legend::LegendShape};
use kuva::render::{layout::Layout, plots};
use std::path::Path;

/// Width and height of the image file \[pixels\].
const SIZE: [f64; 2] = [1200.0, 750.0];

/// Okabe and Ito's palette, without its yellow (too light on white), and a grey and a brown to make nine.
const COLORS: [[u8; 3]; 9] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [0, 0, 0],
    [230, 159, 0],
    [86, 180, 233],
    [140, 90, 43],
    [138, 138, 138],
];

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stroke {
    /// A thin line behind the others: a raw channel.
    Thin,
    /// A bold line: what the plot is about.
    #[default]
    Bold,
}

/// One curve. Points whose x or y is not finite are gaps in it; a point alone is not seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Its name in the legend; empty: not in the legend.
    pub name: String,
    /// Abscissae, in the unit of the plot's `x_label`.
    pub x: Vec<f64>,
    /// Ordinates, in the unit of the plot's `y_label`.
    pub y: Vec<f64>,
    /// How it is drawn.
    pub style: Stroke,
}

/// A plot of curves over common axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// Heading.
    pub title: String,
    /// Name and unit of the abscissa.
    pub x_label: String,
    /// Name and unit of the ordinate.
    pub y_label: String,
    /// The curves, in the order of their colours and of the legend.
    pub series: Vec<Series>,
    /// Whether both axes are logarithmic; then all values must be positive.
    pub logarithmic: bool,
}

impl Plot {
    /// Writes the plot as a PNG of 1200 × 750 pixels, whatever the number of points.
    ///
    /// # Errors
    /// [`ReportError`] with the path: a series whose x and y differ in length, or a file that can't be written.
    pub fn save_png(&self, path: &Path) -> Result<(), ReportError> {
        for s in &self.series {
            if s.x.len() != s.y.len() {
                return Err(ReportError::Lengths {
                    path: path.to_owned(),
                    series: s.name.clone(),
                    x: s.x.len(),
                    y: s.y.len(),
                });
            }
        }
        let curves = self.curves();
        let layout = self.layout(&curves);
        let png =
            kuva::render_to_raster(curves, layout, 1.0).map_err(|reason| ReportError::Draw {
                path: path.to_owned(),
                reason,
            })?;
        std::fs::write(path, png).map_err(|source| ReportError::Write {
            path: path.to_owned(),
            source,
        })
    }

    /// The pieces of every curve, thin ones first.
    fn curves(&self) -> Vec<plots::Plot> {
        let mut curves = Vec::new();
        for style in [Stroke::Thin, Stroke::Bold] {
            for (i, s) in self
                .series
                .iter()
                .enumerate()
                .filter(|(_, s)| s.style == style)
            {
                for line in decimate(&s.x, &s.y, SIZE[0] as usize) {
                    let curve = LinePlot::new()
                        .with_data(line)
                        .with_color(color(i, style))
                        .with_stroke_width(if style == Stroke::Thin { 0.8 } else { 3.0 });
                    curves.push(plots::Plot::Line(curve));
                }
            }
        }
        if curves.is_empty() {
            // Axes want a range even where there is nothing to show.
            let nothing = LinePlot::new()
                .with_data([(0.0, 0.0), (1.0, 0.0)])
                .with_stroke_width(0.0);
            curves.push(plots::Plot::Line(nothing));
        }
        curves
    }

    fn layout(&self, curves: &[plots::Plot]) -> Layout {
        let legend = self
            .series
            .iter()
            .enumerate()
            .filter(|(_, s)| !s.name.is_empty());
        let legend: Vec<LegendEntry> = legend
            .map(|(i, s)| LegendEntry {
                label: plain(&s.name),
                color: color(i, s.style),
                shape: LegendShape::Line,
                dasharray: None,
            })
            .collect();
        let mut layout = Layout::auto_from_plots(curves)
            .with_width(SIZE[0])
            .with_height(SIZE[1])
            .with_title(plain(&self.title))
            .with_x_label(plain(&self.x_label))
            .with_y_label(plain(&self.y_label))
            .with_title_size(24)
            .with_label_size(19)
            .with_tick_size(16)
            .with_body_size(16);
        let [x, y] = [
            range(self.series.iter().flat_map(|s| &s.x), 0.0),
            range(self.series.iter().flat_map(|s| &s.y), 0.05),
        ];
        if self.logarithmic {
            layout = layout.with_log_scale();
        } else {
            if let Some([low, high]) = x {
                layout = layout.with_x_axis_min(low).with_x_axis_max(high);
            }
            if let Some([low, high]) = y {
                layout = layout.with_y_axis_min(low).with_y_axis_max(high);
            }
        }
        if legend.is_empty() {
            layout
        } else {
            layout.with_legend_entries(legend)
        }
    }
}

/// The colour of a curve; a thin one is half as strong, as its ringing covers an area.
fn color(i: usize, style: Stroke) -> String {
    let [r, g, b] = COLORS[i % COLORS.len()].map(|c| match style {
        Stroke::Thin => 128 + c / 2,
        Stroke::Bold => c,
    });
    format!("#{r:02X}{g:02X}{b:02X}")
}

/// The range of the finite among values, a little wider; `None` without any.
fn range<'a>(values: impl Iterator<Item = &'a f64>, margin: f64) -> Option<[f64; 2]> {
    let finite = values.copied().filter(|v| v.is_finite());
    let (low, high) = finite
        .map(|v| (v, v))
        .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    let width = high - low;
    if !(width > 1.0e-9 * low.abs().max(high.abs()) && width.is_finite()) {
        return None;
    }
    let wider = |v: f64, by: f64| if v == 0.0 { v } else { v + by };
    Some([wider(low, -margin * width), wider(high, margin * width)])
}

/// Text with its dollars as dollars: the plotting library reads `$…$` as mathematics.
fn plain(text: &str) -> String {
    text.replace('$', "\\$")
}
