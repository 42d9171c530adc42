//! Files that are none.

use crumple::body::BuildError;
use crumple::import::{ImportError, obj};
use crumple::prelude::*;
use std::path::Path;

const TETRAHEDRON: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

#[test]
fn wrong_lines_are_named() {
    for (from, to, line, value) in [
        ("v 1 0 0", "v 1 NaN 0", 2, "NaN"),
        ("v 0 1 0", "v 0 -inf 0", 3, "-inf"),
        ("v 0 0 1", "v 0 zero 1", 4, "zero"),
        ("f 1 2 4", "f 1 2 5", 6, "5"),
        ("f 1 2 4", "f 1 2 0", 6, "0"),
        ("f 1 4 3", "f 1 4", 8, "f 1 4"),
    ] {
        let text = TETRAHEDRON.replacen(from, to, 1);
        match obj::parse(&text, Path::new("car.obj")) {
            Err(ImportError::Line {
                path,
                line: at,
                value: wrong,
                ..
            }) => {
                assert_eq!(
                    (path.as_path(), at, wrong.as_str()),
                    (Path::new("car.obj"), line, value)
                );
            }
            other => panic!("{to}: {other:?}"),
        }
    }
}

#[test]
fn files_without_a_surface() {
    let missing = obj::load("/nowhere/car.obj").unwrap_err();
    assert!(
        matches!(&missing, ImportError::Read { path, .. } if path.ends_with("car.obj")),
        "{missing}"
    );
    assert!(matches!(
        obj::load(env!("CARGO_MANIFEST_DIR")),
        Err(ImportError::Read { .. })
    ));
    assert!(matches!(
        obj::parse("# nothing\n", Path::new("x")),
        Err(ImportError::Empty { .. })
    ));
}

#[test]
fn a_file_with_a_hole_is_read_but_not_filled() {
    let open = TETRAHEDRON.replace("f 1 4 3\n", "");
    let surface = obj::parse(&open, Path::new("x.obj")).unwrap();
    assert!(matches!(
        filled(&surface, 0.1),
        Err(BuildError::OpenSurface { triangles: 1, .. })
    ));
}
