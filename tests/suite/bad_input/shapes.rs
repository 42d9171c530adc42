//! Shape functions refuse sizes that are none, and surfaces that hold nothing.

use crumple::body::{BuildError, Net, Surface};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape::sheet_with_bending;

const BAD: [f32; 4] = [f32::NAN, f32::INFINITY, -1.0, 0.0];

#[track_caller]
fn refused(net: Result<Net, BuildError>, name: &str) {
    match net {
        Err(BuildError::Value { what, .. }) => assert!(what.contains(name), "{what}, not {name}"),
        other => panic!("{name}: {:?}", other.map(|net| net.nodes.len())),
    }
}

#[test]
fn sizes_and_cells() {
    for bad in BAD {
        for axis in 0..3 {
            let mut size = Vector::splat(1.0);
            size[axis] = bad;
            refused(lattice(size, 0.1), "size");
        }
        refused(lattice(Vector::ONE, bad), "cell");
        refused(sheet(bad, 1.0, 3, 3, 0.1), "width");
        refused(sheet(1.0, bad, 3, 3, 0.1), "height");
        refused(sheet(1.0, 1.0, 3, 3, bad), "thickness");
        refused(rope(Vector::ZERO, Vector::X, 3, bad), "section");
        refused(filled(&cube(), bad), "cell");
    }
    for bad in [f32::NAN, f32::INFINITY] {
        refused(rope(Vector::splat(bad), Vector::X, 3, 0.1), "length");
        refused(rope(Vector::ZERO, Vector::splat(bad), 3, 0.1), "length");
    }
    refused(rope(Vector::X, Vector::X, 3, 0.1), "length");
    refused(rope(Vector::ZERO, Vector::X, 0, 0.1), "segments");
    refused(sheet(1.0, 1.0, 1, 3, 0.1), "nodes");
    refused(sheet(1.0, 1.0, 3, 0, 0.1), "nodes");
    for bad in [f32::NAN, 1.0, -0.1] {
        refused(sheet_with_bending(1.0, 1.0, 3, 3, 0.1, bad), "bending");
    }
    // Too many nodes, before any memory is asked for.
    refused(lattice(Vector::splat(1e6), 1e-3), "");
    refused(sheet(1.0, 1.0, usize::MAX, 2, 0.1), "nodes");
    refused(rope(Vector::ZERO, Vector::X, usize::MAX, 0.1), "segments");
}

#[test]
fn a_builder_passes_the_error_of_its_shape_on() {
    let error = DeformableBuilder::new(lattice(Vector::ONE, f32::NAN))
        .material(Material::rubber())
        .build()
        .unwrap_err();
    assert!(matches!(error, BuildError::Value { value, .. } if value.is_nan()));
}

/// A cube of 1 m.
fn cube() -> Surface {
    let vertices = (0..8)
        .map(|i| Vector::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32))
        .collect();
    let quads: [[u32; 4]; 6] = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    Surface {
        vertices,
        triangles,
        ..Surface::default()
    }
}

#[test]
fn surfaces() {
    assert!(filled(&cube(), 0.25).is_ok());
    let refused = |change: fn(&mut Surface)| {
        let mut surface = cube();
        change(&mut surface);
        filled(&surface, 0.25).expect_err("must be refused")
    };
    let open = refused(|s| {
        s.triangles.pop();
    });
    assert!(
        matches!(open, BuildError::OpenSurface { triangles: 1, .. }),
        "{open:?}"
    );
    let twisted = refused(|s| s.triangles[0].swap(0, 1));
    assert!(
        matches!(twisted, BuildError::OpenSurface { .. }),
        "{twisted:?}"
    );
    let flat = refused(|s| s.vertices[7] = s.vertices[6]);
    assert!(
        matches!(flat, BuildError::FlatTriangle { area, .. } if area == 0.0),
        "{flat:?}"
    );
    // A second cube that overlaps the first.
    let crossing = refused(|s| {
        let shifted: Vec<Vector> = s.vertices.iter().map(|v| *v + Vector::splat(0.5)).collect();
        let second: Vec<[u32; 3]> = s.triangles.iter().map(|t| t.map(|v| v + 8)).collect();
        s.vertices.extend(shifted);
        s.triangles.extend(second);
    });
    assert!(
        matches!(crossing, BuildError::SelfIntersecting { first, second } if first < 12 && second >= 12),
        "{crossing:?}"
    );
    let inside_out = refused(|s| s.triangles.iter_mut().for_each(|t| t.swap(0, 1)));
    assert!(
        matches!(inside_out, BuildError::Value { what: "the volume of the surface", value, .. } if (value + 1.0).abs() < 1e-6)
    );
    let nan = refused(|s| s.vertices[3].x = f32::NAN);
    assert!(!nan.to_string().is_empty());
    let index = refused(|s| s.triangles[4][1] = 99);
    assert!(index.to_string().contains("99"), "{index}");
    assert!(filled(&Surface::default(), 0.1).is_err());
}

#[test]
fn a_cell_too_large_says_what_would_do() {
    // Two corners of one side are pulled in so far that the fold between them passes the centre.
    let mut wedge = cube();
    wedge.vertices[1].x = 0.05;
    wedge.vertices[7].x = 0.05;
    match filled(&wedge, 1.0) {
        Err(BuildError::CellTooLarge { cell, enough }) => {
            assert_eq!(cell, 1.0);
            assert!(filled(&wedge, enough as f32).is_ok());
        }
        other => panic!("{:?}", other.map(|net| net.nodes.len())),
    }
}
