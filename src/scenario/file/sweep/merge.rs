//! The results of a sweep in one place: sorted, as lines and as a table.

use super::log::{IDENTITY, SweepError, failed, read};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// The results of a sweep in the order of the variants.
#[derive(Clone, Debug, PartialEq)]
pub struct Merged {
    /// The lines of the finished variants, with their ends.
    pub lines: String,
    /// The variables that change, in their order.
    pub variables: Vec<String>,
    /// How many variants the sweep has.
    pub total: usize,
    /// The finished variants.
    pub variants: Vec<Value>,
}

/// Reads the logs of one sweep from one or several folders.
///
/// # Errors
/// [`SweepError`]: a folder without a sweep, folders of different sweeps, or different results for one variant.
pub fn merge(folders: &[impl AsRef<Path>]) -> Result<Merged, SweepError> {
    let mut all: BTreeMap<usize, String> = BTreeMap::new();
    let mut identity: Option<String> = None;
    for folder in folders.iter().map(AsRef::as_ref) {
        let path = folder.join(IDENTITY);
        let Ok(own) = std::fs::read_to_string(&path) else {
            return Err(SweepError::NoSweep {
                path: folder.into(),
            });
        };
        if identity.as_ref().is_some_and(|i| *i != own) {
            return Err(SweepError::Other {
                path: folder.into(),
            });
        }
        identity = Some(own);
        for (variant, line) in read(folder)? {
            match all.get(&variant) {
                Some(before) if *before != line => {
                    return Err(SweepError::Differs {
                        variant,
                        path: folder.into(),
                    });
                }
                Some(_) => {}
                None => _ = all.insert(variant, line),
            }
        }
    }
    let identity: Value = identity
        .and_then(|text| serde_json::from_str(&text).ok())
        .unwrap_or_default();
    let order = identity["order"].as_array().cloned().unwrap_or_default();
    let variables: Vec<String> = order
        .iter()
        .filter_map(|v| v.as_str().map(str::to_owned))
        .collect();
    let size = |name: &String| identity["axes"][name].as_array().map_or(1, Vec::len);
    Ok(Merged {
        total: variables.iter().map(size).product(),
        variants: all
            .values()
            .filter_map(|line| serde_json::from_str(line).ok())
            .collect(),
        lines: all.into_values().collect(),
        variables,
    })
}

impl Merged {
    /// The names of what was checked, in the order of the scene.
    pub fn checks(&self) -> Vec<String> {
        let some = self.variants.iter().find_map(|v| v["checks"].as_array());
        let names = some
            .into_iter()
            .flatten()
            .filter_map(|c| c["name"].as_str());
        names.map(str::to_owned).collect()
    }

    /// What a check of a variant measured; NaN where it measured nothing.
    pub fn measured(variant: &Value, check: usize) -> f64 {
        let value = &variant["checks"][check]["measured"];
        // JSON has no number for inf.
        let word = || value.as_str().and_then(|text| text.parse().ok());
        value.as_f64().or_else(word).unwrap_or(f64::NAN)
    }

    /// The value of a variable of a variant.
    pub fn value(variant: &Value, variable: &str) -> f64 {
        variant["set"][variable].as_f64().unwrap_or(f64::NAN)
    }

    /// Variants as rows: the variables, what was measured, whether everything was as expected.
    pub fn csv(&self) -> String {
        let plain = |name: &str| name.replace([',', '"', '\n'], " ");
        let checks = self.checks();
        let mut head: Vec<String> = vec!["variant".into()];
        head.extend(self.variables.iter().map(|v| plain(v)));
        head.extend(checks.iter().map(|c| plain(c)));
        head.push("passed".into());
        let mut text = head.join(",") + "\n";
        for variant in &self.variants {
            let mut row = vec![variant["variant"].to_string()];
            row.extend(
                self.variables
                    .iter()
                    .map(|v| Self::value(variant, v).to_string()),
            );
            row.extend((0..checks.len()).map(|i| Self::measured(variant, i).to_string()));
            row.push(u8::from(variant["passed"] == true).to_string());
            text += &(row.join(",") + "\n");
        }
        text
    }

    /// Writes `merged.jsonl` and `merged.csv` into a folder.
    ///
    /// # Errors
    /// [`SweepError::File`].
    pub fn write(&self, folder: &Path) -> Result<(), SweepError> {
        std::fs::create_dir_all(folder).map_err(failed(folder))?;
        for (name, text) in [("merged.jsonl", &self.lines), ("merged.csv", &self.csv())] {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(failed(&path))?;
        }
        Ok(())
    }
}
