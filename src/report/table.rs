//! The numbers of a run for a terminal: a name, a value, its unit, one per line.
//!
//! Values keep four significant digits and line up on their decimal points, since a reader compares them down the column;
//! exact values are what [`write_csv`](crate::record::write_csv) is for. Widths are counted in characters, not bytes, as
//! units are full of `²` and `·`.

use std::fmt::{Display, Formatter, Result};

/// Rows of a name, a value and its unit; [`Display`] aligns them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    rows: Vec<(String, f64, String)>,
}

impl Table {
    /// No rows.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a row; `unit` may be empty.
    pub fn row(
        &mut self,
        name: impl Into<String>,
        value: f64,
        unit: impl Into<String>,
    ) -> &mut Self {
        self.rows.push((name.into(), value, unit.into()));
        self
    }

    /// The rows, in the order they were added.
    pub fn rows(&self) -> &[(String, f64, String)] {
        &self.rows
    }
}

impl<N: Into<String>, U: Into<String>> FromIterator<(N, f64, U)> for Table {
    fn from_iter<I: IntoIterator<Item = (N, f64, U)>>(rows: I) -> Self {
        let rows = rows.into_iter().map(|(n, v, u)| (n.into(), v, u.into()));
        Self {
            rows: rows.collect(),
        }
    }
}

impl Display for Table {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let cells: Vec<(String, String)> = self.rows.iter().map(|r| split(&number(r.1))).collect();
        let width = |texts: &mut dyn Iterator<Item = &str>| {
            texts.map(|t| t.chars().count()).max().unwrap_or(0)
        };
        let name = width(&mut self.rows.iter().map(|r| r.0.as_str()));
        let whole = width(&mut cells.iter().map(|c| c.0.as_str()));
        let rest = width(&mut cells.iter().map(|c| c.1.as_str()));
        for (row, cell) in self.rows.iter().zip(&cells) {
            let line = format!(
                "{:name$}  {:>whole$}{:rest$}  {}",
                row.0, cell.0, cell.1, row.2
            );
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

/// Counts as they are, the rest with four significant digits: plain from a thousandth to ten millions, scientific beyond.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    if value.fract() == 0.0 && size < 1.0e7 {
        return format!("{value:.0}");
    }
    if !(1.0e-3..1.0e7).contains(&size) {
        return format!("{value:.3e}");
    }
    let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
    format!("{value:.decimals$}")
}

/// What stands left of the decimal point, and the rest with it.
fn split(number: &str) -> (String, String) {
    let at = number.find(['.', 'e']).unwrap_or(number.len());
    (number[..at].to_owned(), number[at..].to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_line_up() {
        let mut table = Table::new();
        table
            .row("peak force (CFC 60)", 312_345.6, "N")
            .row("crush", 0.41257, "m")
            .row("hits", 3.0, "");
        table
            .row("section", 1.25e-7, "m²")
            .row("no value", f64::NAN, "J");
        let expected = "\
peak force (CFC 60)  312346         N
crush                     0.4126    m
hits                      3
section                   1.250e-7  m²
no value                NaN         J
";
        assert_eq!(table.to_string(), expected);
        assert_eq!(Table::new().to_string(), "");
    }

    #[test]
    fn numbers_have_four_digits() {
        for (value, text) in [
            (0.0, "0"),
            (-12.3456, "-12.35"),
            (9999.6, "10000"),
            (1.0e9, "1.000e9"),
        ] {
            assert_eq!(number(value), text);
        }
        assert_eq!(number(f64::NEG_INFINITY), "-inf");
    }
}
