//! Wavefront OBJ surfaces.
//!
//! `tobj` reads the file, but it accepts "NaN" as a number, drops faces of two vertices silently, stumbles over comments behind a line
//! and some weights of vertices, makes triangles of lines, and does not say which line is wrong. A scan of the `v` and `f` lines before it
//! turns each mistake into an error with a line number, and leaves only what is wanted to it.

use super::ImportError;
use crate::body::{Group, Surface};
use crate::math::Vector;
use std::collections::HashMap;
use std::io::BufReader;
use std::path::Path;

/// Reads the file at `path`; see [`parse`].
///
/// # Errors
/// [`ImportError::Read`] if it can't be read, [`ImportError::NotText`] if it is not UTF-8, and those of [`parse`].
pub fn load(path: impl AsRef<Path>) -> Result<Surface, ImportError> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|source| ImportError::Read {
        path: path.into(),
        source,
    })?;
    let text = std::str::from_utf8(&bytes).map_err(|e| ImportError::NotText {
        path: path.into(),
        line: 1 + bytes[..e.valid_up_to()]
            .iter()
            .filter(|&&b| b == b'\n')
            .count(),
    })?;
    parse(text, path)
}

/// Reads OBJ `text`, in metres; `name` is what errors call it. All objects and groups become one surface with their names
/// in [`Surface::groups`]. Vertices at the same position become one, since exporters split them where normals or
/// textures differ; polygons are cut into fans. Normals, textures, materials, weights, lines and points are left out,
/// and so are vertices that no face uses.
///
/// # Errors
/// [`ImportError::Line`] for a coordinate that is not a finite number, a face with fewer than three vertices or an index
/// out of range; [`ImportError::Empty`] without faces; [`ImportError::Format`] for anything else `tobj` refuses.
pub fn parse(text: &str, name: &Path) -> Result<Surface, ImportError> {
    let text = scan(text.trim_start_matches('\u{feff}'), name)?;
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index: true,
        ..tobj::LoadOptions::default()
    };
    let (models, _) = tobj::load_obj_buf(&mut BufReader::new(text.as_bytes()), &options, |_| {
        Ok(Default::default())
    })
    .map_err(|source| ImportError::Format {
        path: name.into(),
        source,
    })?;
    let mut surface = Surface::default();
    let mut known = HashMap::new();
    for model in models {
        let welded: Vec<u32> = model
            .mesh
            .positions
            .chunks_exact(3)
            .map(|p| {
                // Adding zero makes −0 the same place as 0.
                let at = Vector::new(p[0], p[1], p[2]) + Vector::ZERO;
                *known
                    .entry(at.to_array().map(f32::to_bits))
                    .or_insert_with(|| {
                        surface.vertices.push(at);
                        surface.vertices.len() as u32 - 1
                    })
            })
            .collect();
        let first = surface.triangles.len();
        surface.triangles.extend(
            model
                .mesh
                .indices
                .chunks_exact(3)
                .map(|t| [t[0], t[1], t[2]].map(|i| welded[i as usize])),
        );
        if surface.triangles.len() > first {
            surface.groups.push(Group {
                name: model.name,
                triangles: first..surface.triangles.len(),
            });
        }
    }
    if surface.triangles.is_empty() {
        return Err(ImportError::Empty { path: name.into() });
    }
    Ok(surface)
}

/// Places, faces by the places of their corners, and all that names or divides them; or the first wrong `v` or `f` line.
fn scan(text: &str, name: &Path) -> Result<String, ImportError> {
    let key = |line: &str| line.split_whitespace().next().unwrap_or_default() == "v";
    let total = text.lines().filter(|line| key(line)).count();
    let (mut so_far, mut wanted) = (0, String::with_capacity(text.len()));
    for (index, line) in text.lines().enumerate() {
        let bad = |what, value: &str, must: String| ImportError::Line {
            path: name.into(),
            line: index + 1,
            what,
            value: value.into(),
            must,
        };
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                so_far += 1;
                let numbers: Vec<&str> = words.take_while(|w| !w.starts_with('#')).collect();
                if numbers.len() < 3 {
                    return Err(bad("a vertex", line, "three coordinates".into()));
                }
                for word in &numbers[..3] {
                    if !word.parse::<f32>().is_ok_and(f32::is_finite) {
                        return Err(bad("a coordinate", word, "a finite number".into()));
                    }
                }
                let [x, y, z] = [numbers[0], numbers[1], numbers[2]];
                wanted.extend(["v ", x, " ", y, " ", z]);
            }
            Some("f") => {
                let corners: Vec<&str> = words.take_while(|w| !w.starts_with('#')).collect();
                if corners.len() < 3 {
                    return Err(bad("a face", line, "three vertices or more".into()));
                }
                wanted.push('f');
                for word in corners {
                    let index = word.split('/').next().unwrap_or_default();
                    let known = match index.parse::<i64>() {
                        Ok(i) if i < 0 => i.unsigned_abs() <= so_far,
                        Ok(i) => i > 0 && i <= total as i64,
                        Err(_) => false,
                    };
                    if !known {
                        let must = format!("a vertex from 1 to {total}, or from -{so_far} to -1");
                        return Err(bad("the index of a face", word, must));
                    }
                    wanted.extend([" ", index]);
                }
            }
            Some("o" | "g") => wanted.push_str(line),
            _ => continue,
        }
        wanted.push('\n');
    }
    Ok(wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: &str = "# a corner\no thing\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
        g base\nf 1 3 2\ng rest\nf 1/1/1 2//2 4\nf -3 -2 -1\nf 1 4 3\n";

    fn read(text: &str) -> Result<Surface, ImportError> {
        parse(text, Path::new("test.obj"))
    }

    #[test]
    fn groups_are_merged_and_kept_by_name() {
        let text = TETRAHEDRON.replace("1/1/1 2//2", "1 2");
        let surface = read(&text).unwrap();
        surface.check_closed().unwrap();
        assert_eq!(surface.vertices.len(), 4);
        assert!((surface.volume() - 1.0 / 6.0).abs() < 1e-7);
        let names: Vec<_> = surface
            .groups
            .iter()
            .map(|g| (g.name.as_str(), g.triangles.clone()))
            .collect();
        assert_eq!(names, [("base", 0..1), ("rest", 1..4)]);
    }

    #[test]
    fn split_vertices_are_welded_and_polygons_cut() {
        let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv -0 0 0\n\
            f 9 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 4 8 7 3\nf 1 5 8 4\nf 2 3 7 6\n";
        let surface = read(cube).unwrap();
        surface.check_closed().unwrap();
        assert_eq!((surface.vertices.len(), surface.triangles.len()), (8, 12));
        assert!((surface.volume() - 1.0).abs() < 1e-6);
    }

    /// What other programs write beside places and faces: a mark of the order of bytes, weights, colours, comments, textures, lines and points.
    #[test]
    fn what_is_not_wanted_does_no_harm() {
        let plain = read(&TETRAHEDRON.replace("1/1/1 2//2", "1 2")).unwrap();
        let rich = TETRAHEDRON
            .replace("v 1 0 0", "v 1 0 0 2 # weight\nvt 0.5 0.5\nvn 0 0 1")
            .replace("v 0 1 0", "v 0 1 0 0.5 0.5 0.5 #colour")
            .replace("f 1 3 2", "l 1 2\np 1\ns off\nf 1 3 2 # a face")
            .replace("f 1 4 3", "l 1 2 3 4\nf 1/9 4/9 3/9\r\n");
        let rich = read(&format!("\u{feff}{rich}")).unwrap();
        assert_eq!(rich.vertices, plain.vertices);
        assert_eq!(rich.triangles, plain.triangles);
        let named = |s: &Surface| -> Vec<_> {
            let groups = s.groups.iter();
            groups
                .map(|g| (g.name.clone(), g.triangles.clone()))
                .collect()
        };
        assert_eq!(named(&rich), named(&plain));
        let marked = read("\u{feff}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").unwrap();
        assert_eq!(marked.vertices.len(), 3);
    }

    #[test]
    fn errors_name_the_file_and_the_line() {
        for (from, to, line, value) in [
            ("v 1 0 0", "v 1 NaN 0", 4, "NaN"),
            ("v 1 0 0", "v 1 inf 0", 4, "inf"),
            ("v 1 0 0", "v 1 1e99 0", 4, "1e99"),
            ("v 1 0 0", "v 1 x 0", 4, "x"),
            ("v 1 0 0", "v 1 0", 4, "v 1 0"),
            ("f 1 3 2", "f 1 3", 8, "f 1 3"),
            ("f 1 3 2", "f 1 3 5", 8, "5"),
            ("f 1 3 2", "f 1 3 0", 8, "0"),
            ("f 1 3 2", "f 1 3 -5", 8, "-5"),
        ] {
            let error = read(&TETRAHEDRON.replace(from, to)).unwrap_err();
            assert!(
                error.to_string().starts_with(&format!("test.obj:{line}: ")),
                "{error}"
            );
            assert!(
                matches!(&error, ImportError::Line { value: v, .. } if v == value),
                "{error}"
            );
        }
    }

    #[test]
    fn empty_binary_and_missing_files_are_errors() {
        for text in ["", "\n", "v 0 0 0\n"] {
            assert!(matches!(read(text), Err(ImportError::Empty { .. })));
        }
        assert!(matches!(
            load("/nowhere/x.obj"),
            Err(ImportError::Read { .. })
        ));
        let path = std::env::temp_dir().join(format!("crumple-{}.obj", std::process::id()));
        std::fs::write(&path, b"v 0 0 0\nv \xff 0 0\n").unwrap();
        let error = load(&path);
        std::fs::remove_file(&path).unwrap();
        assert!(matches!(error, Err(ImportError::NotText { line: 2, .. })));
    }
}
