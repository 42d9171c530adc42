//! The colour scale of a picture, and its legend.
//!
//! One scale, made for damage: what is intact looks like painted metal (a light grey-blue), what is hurt goes through
//! yellow and red to nearly black. Its lightness falls all the way, so that it survives grey printing and colour blindness,
//! and the low end is kept pale, so that most of a car stays calm and the eye goes to the crush.

use super::picture::Picture;
use super::table::number;

/// The scale at even steps from 0 to 1, in display RGB.
const SCALE: [[f32; 3]; 6] = [
    [0.73, 0.81, 0.90],
    [0.93, 0.71, 0.26],
    [0.91, 0.48, 0.13],
    [0.78, 0.20, 0.14],
    [0.50, 0.07, 0.17],
    [0.17, 0.03, 0.12],
];

/// Colour (display RGB, 0 to 1) of a value from 0, intact, to 1, the end of the scale. Values outside are clamped; NaN is a
/// flat grey that the scale does not have.
pub fn colormap(value: f32) -> [f32; 3] {
    if value.is_nan() {
        return [0.5; 3];
    }
    let at = value.clamp(0.0, 1.0) * (SCALE.len() - 1) as f32;
    let i = (at as usize).min(SCALE.len() - 2);
    mix(SCALE[i], SCALE[i + 1], at - i as f32)
}

/// `a` for 0, `b` for 1.
pub(super) fn mix(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t)
}

/// Four digits without the zeros at the end.
fn short(value: f64) -> String {
    let text = number(value);
    let (digits, power) = text.split_at(text.find('e').unwrap_or(text.len()));
    if !digits.contains('.') {
        return text;
    }
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    format!("{digits}{power}")
}

/// The legend of [`colormap`]: a vertical bar at the right edge of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColorBar {
    /// What the colours show, over the bar.
    pub label: String,
    /// Its unit, in brackets after the label; empty: none.
    pub unit: String,
    /// The value that is 0 on the scale, in `unit`.
    pub min: f64,
    /// The value that is 1 on the scale, in `unit`.
    pub max: f64,
}

impl ColorBar {
    /// The colour of a value in the bar's unit.
    pub fn color(&self, value: f64) -> [f32; 3] {
        colormap(((value - self.min) / (self.max - self.min)) as f32)
    }
}

impl Picture {
    /// Draws the legend at the right edge, half as high as the picture, on a pale panel over whatever is there.
    pub fn draw_color_bar(&mut self, bar: &ColorBar) {
        let [width, height] = [self.width() as f32, self.height() as f32];
        let (size, margin, thick) = ((height / 45.0).max(10.0), height / 25.0, height / 30.0);
        let ink = [0.2, 0.22, 0.25];
        let ticks = [0.0, 0.25, 0.5, 0.75, 1.0];
        let texts = ticks.map(|t| short(bar.min + (bar.max - bar.min) * t));
        let widest = texts
            .iter()
            .map(|t| Self::text_width(size, t))
            .fold(0.0, f32::max);
        let left = width - margin - widest - 0.6 * size - thick;
        let [top, bottom] = [0.27 * height, 0.77 * height];
        let title = match bar.unit.as_str() {
            "" => bar.label.clone(),
            unit => format!("{} [{unit}]", bar.label),
        };
        let title_left = (width - margin - Self::text_width(size, &title)).min(left);
        let panel = [title_left - 0.5 * margin, top - 3.4 * size];
        self.fill(
            panel,
            [width - 0.5 * margin, bottom + 1.5 * size],
            0.75,
            |_, _| Self::BACKGROUND,
        );
        self.draw_text([title_left, top - 2.4 * size], size, ink, &title);
        self.fill(
            [left - 1.0, top - 1.0],
            [left + thick + 1.0, bottom + 1.0],
            1.0,
            |_, _| ink,
        );
        self.fill([left, top], [left + thick, bottom], 1.0, |_, y| {
            colormap((bottom - y) / (bottom - top))
        });
        for (t, text) in ticks.iter().zip(&texts) {
            let y = bottom + (top - bottom) * *t as f32;
            self.fill(
                [left + thick, y - 0.5],
                [left + thick + 0.35 * size, y + 0.5],
                1.0,
                |_, _| ink,
            );
            self.draw_text([left + thick + 0.6 * size, y - 0.5 * size], size, ink, text);
        }
    }
}
