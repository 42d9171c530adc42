//! The plots that every crash report has: force over time, raw and filtered, and the energies.

use super::plot::{Plot, Series, Stroke};
use crate::record::{BodyRecord, Cfc, FilterError, Resampled};

/// A channel over time in milliseconds, raw and in CFC 60. `factor` brings its values to the unit of `y_label`.
///
/// # Errors
/// [`FilterError`] where the channel can't be filtered.
pub fn filtered(
    title: &str,
    y_label: &str,
    channel: &Resampled,
    factor: f64,
) -> Result<Plot, FilterError> {
    let smooth = channel.filtered(Cfc::Cfc60)?;
    let x: Vec<f64> = channel.times.iter().map(|t| t * 1.0e3).collect();
    let series = |name: &str, values: &[f64], style| Series {
        name: name.into(),
        x: x.clone(),
        y: values.iter().map(|v| v * factor).collect(),
        style,
    };
    Ok(Plot {
        title: title.into(),
        x_label: "time [ms]".into(),
        y_label: y_label.into(),
        series: vec![
            series("raw", &channel.values, Stroke::Thin),
            series("CFC 60", &smooth.values, Stroke::Bold),
        ],
        ..Plot::default()
    })
}

/// The energies of a deformable over time, in kJ; terms that stay below half a hundredth of the largest are left out. The
/// balance is drawn too: a straight line.
pub fn energies(title: &str, record: &BodyRecord) -> Plot {
    let lines = record.energy_lines();
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let all = lines.iter().map(|(_, v)| largest(v)).fold(0.0, f64::max);
    let x: Vec<f64> = record.ledger.iter().map(|s| s.time * 1.0e3).collect();
    Plot {
        title: title.into(),
        x_label: "time [ms]".into(),
        y_label: "energy [kJ]".into(),
        series: lines
            .into_iter()
            .filter(|(_, values)| largest(values) > 5.0e-3 * all)
            .map(|(name, values)| Series {
                name: name.into(),
                x: x.clone(),
                y: values.iter().map(|v| v * 1.0e-3).collect(),
                style: Stroke::Bold,
            })
            .collect(),
        ..Plot::default()
    }
}
