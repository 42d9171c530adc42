//! What is wrong with a scene file: where, which key, and what was expected. All of it at once.

use super::super::catalog::distance;
use std::fmt::{Display, Formatter, Result};
use std::path::PathBuf;

/// Most problems that are listed.
pub(crate) const MOST: usize = 100;
/// Most names that one is compared with, so that the time mistakes take does not grow with the square of a file.
const COMPARED: usize = 200;

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The file.
    pub file: PathBuf,
    /// Its line, from 1; 0 for the file as a whole.
    pub line: u32,
    /// The column in characters, from 1.
    pub column: u32,
    /// The way to the key, like `deformables[2].material.young`; empty for the file as a whole.
    pub key: String,
    /// What is wrong and what was expected.
    pub what: String,
}

impl Display for Problem {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{}", self.file.display())?;
        if self.line > 0 {
            write!(f, ":{}:{}", self.line, self.column)?;
        }
        match self.key.as_str() {
            "" => write!(f, ": {}", self.what),
            key => write!(f, ": {key}: {}", self.what),
        }
    }
}

/// Why a scene can't be loaded: everything that is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", listed(problems, *more))]
pub struct LoadError {
    /// What is wrong, in the order of the files; a hundred at most.
    pub problems: Vec<Problem>,
    /// How many more were found until the search was given up.
    pub more: usize,
}

fn listed(problems: &[Problem], more: usize) -> String {
    let mut lines: Vec<String> = problems.iter().map(Problem::to_string).collect();
    if problems.len() == MOST {
        lines.push(format!("… and more may be wrong: {MOST} are listed"));
    } else if more > 0 {
        lines.push(format!("… and {more} more"));
    }
    lines.join("\n")
}

/// The known name that is nearest to one that is not known, if any is near.
pub(crate) fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    // Long names are compared at their beginnings: the comparison takes the product of the lengths.
    let cut = |s: &str| s.to_lowercase().chars().take(40).collect::<String>();
    let name = cut(name);
    let known = known.take(COMPARED);
    let best = known.map(|k| (distance(&name, &cut(k)), k)).min();
    best.filter(|(d, _)| 2 * d <= name.chars().count())
        .map(|(_, k)| k)
}

/// "`x` is not a known thing", with the nearest name or all of them.
pub(crate) fn unknown<'a>(
    thing: &str,
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> String {
    let name: String = name.chars().take(60).collect();
    if let Some(near) = nearest(&name, known.clone()) {
        return format!("there is no {thing} `{name}`; did you mean `{near}`?");
    }
    let all: Vec<&str> = known.take(41).collect();
    match all.len() {
        0 => format!("there is no {thing} `{name}`, and none at all"),
        41 => format!("there is no {thing} `{name}`"),
        _ => format!(
            "there is no {thing} `{name}`; there are: {}",
            all.join(", ")
        ),
    }
}
