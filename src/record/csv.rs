//! Comma-separated columns with their units in the header (`time_s,force_n`), for any spreadsheet or script.
//!
//! The format is kept to what every reader agrees on: a header of plain names, a point for the decimal mark, the shortest
//! digits that read back as the same `f64`, a line feed after each row and no quoting. A header that would need quoting is
//! refused, because units belong into a suffix and not into brackets with commas.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Why a table can't be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CsvError {
    /// The file can't be created or written.
    #[error("can't write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Columns differ in length.
    #[error("{}: column `{column}` has {rows} rows, the first column has {expected}", path.display())]
    Lengths {
        /// The file that was not written.
        path: PathBuf,
        /// Header of the column.
        column: String,
        /// Its length.
        rows: usize,
        /// Length of the first column.
        expected: usize,
    },
    /// A header is empty or has a comma, a quote or a control character in it.
    #[error("{}: `{column}` can't be a header; give a name and a unit like `force_n`", path.display())]
    Header {
        /// The file that was not written.
        path: PathBuf,
        /// The header.
        column: String,
    },
}

/// Writes columns of equal length, each under its header (a name with its unit, like `force_n`).
///
/// A NaN is written as `NaN`, an infinity as `inf` or `-inf`. No columns give an empty file. An existing file is replaced;
/// nothing is touched where headers or lengths are wrong.
///
/// # Errors
/// [`CsvError`], which names the path.
pub fn write_csv(path: &Path, columns: &[(&str, &[f64])]) -> Result<(), CsvError> {
    let rows = columns.first().map_or(0, |c| c.1.len());
    for (header, values) in columns {
        let wrong = |c: char| c == ',' || c == '"' || c.is_control();
        if header.is_empty() || header.contains(wrong) {
            return Err(CsvError::Header {
                path: path.to_owned(),
                column: (*header).to_owned(),
            });
        }
        if values.len() != rows {
            return Err(CsvError::Lengths {
                path: path.to_owned(),
                column: (*header).to_owned(),
                rows: values.len(),
                expected: rows,
            });
        }
    }
    write(path, columns, rows).map_err(|source| CsvError::Write {
        path: path.to_owned(),
        source,
    })
}

fn write(path: &Path, columns: &[(&str, &[f64])], rows: usize) -> io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    if !columns.is_empty() {
        let headers: Vec<&str> = columns.iter().map(|c| c.0).collect();
        writeln!(out, "{}", headers.join(","))?;
    }
    for row in 0..rows {
        for (i, (_, values)) in columns.iter().enumerate() {
            if i > 0 {
                out.write_all(b",")?;
            }
            let value = values[row];
            // Both forms read back exactly; the plain one is the shorter in this range.
            if value == 0.0 || (1.0e-4..1.0e15).contains(&value.abs()) || !value.is_finite() {
                write!(out, "{value}")?;
            } else {
                write!(out, "{value:e}")?;
            }
        }
        out.write_all(b"\n")?;
    }
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("crumple-{}-{name}", std::process::id()))
    }

    #[test]
    fn what_is_written_reads_back() {
        let path = file("table.csv");
        let time = [0.0, 1.0e-4, 0.1 + 0.2];
        let force = [-1.25e5, 3.0e-300, f64::NAN];
        write_csv(&path, &[("time_s", &time), ("force_n", &force)]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[..3], ["time_s,force_n", "0,-125000", "0.0001,3e-300"]);
        let cells: Vec<f64> = lines[3].split(',').map(|c| c.parse().unwrap()).collect();
        assert_eq!(cells[0], time[2]);
        assert!(cells[1].is_nan());
    }

    #[test]
    fn errors_name_the_path() {
        let path = file("wrong.csv");
        let lengths = write_csv(&path, &[("a", &[1.0]), ("b", &[])]).unwrap_err();
        assert!(matches!(
            lengths,
            CsvError::Lengths {
                rows: 0,
                expected: 1,
                ..
            }
        ));
        let header = write_csv(&path, &[("a,b", &[])]).unwrap_err();
        assert!(!path.exists());
        let nowhere = path.join("table.csv");
        let write = write_csv(&nowhere, &[("a", &[1.0])]).unwrap_err();
        for (error, path) in [(lengths, &path), (header, &path), (write, &nowhere)] {
            assert!(
                error.to_string().contains(&path.display().to_string()),
                "{error}"
            );
        }
    }
}
