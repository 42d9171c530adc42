//! Where scenes come from: a disk, the crate itself, or text.

use super::parse::MOST_BYTES;
use std::path::{Path, PathBuf};

macro_rules! embedded {
    ($($name:literal),* $(,)?) => {
        &[$((concat!($name, ".ron"), include_str!(concat!("../../../assets/scenes/", $name, ".ron")))),*]
    };
}

/// The scenes that come with the crate and what they include, by their paths below `assets/scenes`.
pub(crate) const EMBEDDED: &[(&str, &str)] = embedded![
    "parts/car",
    "parts/slope",
    "bar_on_wall",
    "cantilever",
    "cantilever_tets",
    "catenary",
    "column",
    "cradle",
    "damped_oscillator",
    "drop",
    "equal_bars",
    "free_fall",
    "gripper",
    "hanging_rope",
    "motor",
    "oscillator",
    "pendulum",
    "pile",
    "pole",
    "pulse",
    "rotor",
    "rubber_drop",
    "slalom",
    "sliding_block",
    "slope_slip",
    "slope_stick",
    "terrain",
    "thin_plate",
    "tow_rope",
    "trampoline",
    "wall",
    "weight",
    "yield_spring",
];

/// The names of the scenes that come with the crate.
pub fn embedded_names() -> impl Iterator<Item = &'static str> + Clone {
    let names = EMBEDDED
        .iter()
        .filter_map(|(file, _)| file.strip_suffix(".ron"));
    names.filter(|name| !name.contains('/'))
}

/// The name of a scene that comes with the crate that is nearest to `name`, if one is near.
pub fn nearest_embedded(name: &str) -> Option<&'static str> {
    super::problem::nearest(name, embedded_names())
}

/// The scene files of a folder with their names, in the order of the names; folders within it are not looked at.
///
/// # Errors
/// Those of reading the folder.
pub fn scenes_in(folder: impl AsRef<Path>) -> std::io::Result<Vec<(String, PathBuf)>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let ending = path.extension().and_then(|e| e.to_str());
        if let (Some("ron" | "json"), Some(name)) = (ending, path.file_stem()) {
            found.push((name.to_string_lossy().into_owned(), path));
        }
    }
    found.sort();
    Ok(found)
}

/// Where files are read from.
pub(crate) enum Source<'a> {
    /// A disk: the folder of the scene, which files must be in, unless they may be elsewhere.
    Disk {
        root: Option<PathBuf>,
    },
    Embedded,
    /// One file alone.
    Text(&'a str),
}

impl Source<'_> {
    /// The disk, for a scene at `path`.
    pub fn disk(path: &Path, allow_outside: bool) -> Self {
        let folder = match path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        Self::Disk {
            // A folder that can't be found has no scene to read.
            root: (!allow_outside).then(|| folder.canonicalize().unwrap_or_default()),
        }
    }

    /// The text of a file.
    pub fn read(&self, path: &Path) -> Result<String, String> {
        match self {
            Self::Text(text) => Ok((*text).into()),
            Self::Embedded => {
                let name = path.to_string_lossy();
                let found = EMBEDDED.iter().find(|(n, _)| *n == name);
                let text = found.map(|(_, text)| (*text).to_owned());
                text.ok_or_else(|| "there is no such scene in the crate".into())
            }
            Self::Disk { .. } => {
                let meta = std::fs::metadata(path).map_err(|e| format!("can't be read: {e}"))?;
                if !meta.is_file() {
                    return Err("is not a file".into());
                }
                if meta.len() > MOST_BYTES as u64 {
                    let n = meta.len();
                    return Err(format!("has {n} bytes, at most {MOST_BYTES} are read"));
                }
                std::fs::read_to_string(path).map_err(|e| format!("can't be read: {e}"))
            }
        }
    }

    /// The file that `text` means in the file `from`.
    pub fn locate(&self, from: &Path, text: &str) -> Result<PathBuf, String> {
        match self {
            Self::Text(_) => Err(format!("{text:?}: a scene from text can't name files")),
            Self::Embedded => {
                let known = EMBEDDED.iter().any(|(name, _)| *name == text);
                let found = known.then(|| PathBuf::from(text));
                found.ok_or_else(|| format!("{text:?}: there is no such file in the crate"))
            }
            Self::Disk { root } => {
                let folder = from.parent().unwrap_or(Path::new(""));
                let path = folder.join(text);
                let found = path.canonicalize();
                let found = found.map_err(|e| format!("{text:?} can't be read: {e}"))?;
                match root {
                    Some(root) if !found.starts_with(root) => Err(format!(
                        "{text:?} is outside of the scene's folder {}; --allow-outside allows it",
                        root.display()
                    )),
                    _ => Ok(found),
                }
            }
        }
    }
}
