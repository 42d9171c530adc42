//! Where scenes come from: a disk, the crate itself, or text.

use super::parse::MOST_BYTES;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Most bytes of a file of data, such as a mesh.
const MOST_DATA_BYTES: u64 = 64 << 20;

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
    /// A disk: the folder of the scene, which files must be in, or why it is none; nothing if they may be elsewhere.
    Disk {
        root: Option<Result<PathBuf, String>>,
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
            root: (!allow_outside).then(|| folder.canonicalize().map_err(|e| e.to_string())),
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
                size(path, MOST_BYTES as u64)?;
                let failed = |e| format!("can't be read: {e}");
                let file = std::fs::File::open(path).map_err(failed)?;
                let mut text = String::new();
                // One byte more, which is refused later: the file may have grown.
                let mut file = file.take(MOST_BYTES as u64 + 1);
                file.read_to_string(&mut text).map_err(failed)?;
                Ok(text)
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
                    Some(Err(what)) => Err(format!("the scene's folder can't be read: {what}")),
                    Some(Ok(root)) if !found.starts_with(root) => Err(format!(
                        "{text:?} is outside of the scene's folder {}; --allow-outside allows it",
                        root.display()
                    )),
                    _ => Ok(found),
                }
            }
        }
    }

    /// The file of data that `text` means in the file `from`, and its size \[bytes\].
    pub fn data(&self, from: &Path, text: &str) -> Result<(PathBuf, u64), String> {
        let found = self.locate(from, text)?;
        let ending = |path: &Path| path.extension().map(|e| e.to_ascii_lowercase());
        if ending(&found) != ending(Path::new(text)) {
            let found = found.display();
            return Err(format!(
                "{text:?} leads to {found}, which has another ending"
            ));
        }
        let bytes = size(&found, MOST_DATA_BYTES).map_err(|what| format!("{text:?} {what}"))?;
        Ok((found, bytes))
    }
}

/// The size of a plain file of at most `most` bytes.
fn size(path: &Path, most: u64) -> Result<u64, String> {
    let meta = std::fs::metadata(path).map_err(|e| format!("can't be read: {e}"))?;
    match meta.len() {
        _ if !meta.is_file() => Err("is not a file".into()),
        n if n > most => Err(format!("has {n} bytes, at most {most} are read")),
        n => Ok(n),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_cant_be_found_holds_nothing() {
        let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.ron");
        let nowhere = Source::disk(Path::new("/there/is/no/such/folder/a.ron"), false);
        assert!(nowhere.locate(&here, "Cargo.toml").is_err());
        assert!(
            Source::disk(&here, false)
                .locate(&here, "Cargo.toml")
                .is_ok()
        );
    }
}
