//! Boxes and filled surfaces of tetrahedra.

use super::cells::CellGrid;
use crate::body::error::positive;
use crate::body::{BuildError, Surface, TetMesh, Tets};
use crate::math::{DVec3, Real, Vector, wide};
use rapier3d::parry::transformation::{VolumeMeshParameters, volume_mesh};

/// How a cell of a box is cut into tets. Corner c of a cell is the far one along x, y, z where bits 0, 1, 2 of c are set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TetSplit {
    /// Five: one in the middle, one at each of four corners; mirrored from cell to cell, so that no direction is preferred
    /// over its mirror image.
    #[default]
    Five,
    /// Six around the diagonal from corner 0 to corner 7 (Kuhn), the same in every cell. All tets are alike, and with
    /// middle nodes every grid point of half the size is a node.
    Six,
}

/// Five tets of a cell whose place has an even sum; the others have the bits of x flipped.
const FIVE: [[usize; 4]; 5] = [
    [0, 3, 5, 6],
    [1, 0, 3, 5],
    [2, 0, 3, 6],
    [4, 0, 5, 6],
    [7, 3, 5, 6],
];

/// The paths from corner 0 to corner 7 along the axes.
const SIX: [[usize; 4]; 6] = [
    [0, 1, 3, 7],
    [0, 1, 5, 7],
    [0, 2, 3, 7],
    [0, 2, 6, 7],
    [0, 4, 5, 7],
    [0, 4, 6, 7],
];

/// A box of `size` \[m\] centred on the origin, of cells of about `cell` \[m\] cut into linear tets:
/// max(1, round(size/cell)) cells along each axis, stretched to fit. Nodes are numbered with x fastest, then y, then z.
///
/// # Errors
/// [`BuildError::Value`] if a size or the cell is not positive and finite, or if there would be more than fifty million
/// nodes.
pub fn tet_box(size: Vector, cell: Real, split: TetSplit) -> Result<TetMesh, BuildError> {
    positive("the cell size of the box", cell.into())?;
    let counts = (wide(size) / f64::from(cell)).round().max(DVec3::ONE);
    cut(size, counts, split)
}

/// As [`tet_box`], with a given number of cells along each axis.
///
/// # Errors
/// Those of [`tet_box`]; [`BuildError::Value`] for a count of zero.
pub fn tet_box_of_cells(
    size: Vector,
    cells: [u32; 3],
    split: TetSplit,
) -> Result<TetMesh, BuildError> {
    for count in cells {
        positive("the number of cells of the box", count.into())?;
    }
    cut(size, DVec3::from_array(cells.map(f64::from)), split)
}

fn cut(size: Vector, counts: DVec3, split: TetSplit) -> Result<TetMesh, BuildError> {
    for (what, value) in [
        ("the x size of the box", size.x),
        ("the y size of the box", size.y),
        ("the z size of the box", size.z),
    ] {
        positive(what, value.into())?;
    }
    let size = wide(size);
    let grid = CellGrid::new(counts.to_array(), true)?;
    let (sides, origin) = (size / counts, -0.5 * size);
    let [nx, ny, nz] = grid.counts;
    let mut nodes = Vec::with_capacity(grid.points());
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                nodes.push(origin + DVec3::new(i as f64, j as f64, k as f64) * sides);
            }
        }
    }
    let mut tets = Vec::new();
    for cell in 0..grid.occupied.len() {
        let at = grid.cell_at(cell);
        let corners = grid.corners(at);
        let (table, flip) = match split {
            TetSplit::Five => (&FIVE[..], (at[0] + at[1] + at[2]) % 2),
            TetSplit::Six => (&SIX[..], 0),
        };
        for tet in table {
            let mut tet = tet.map(|c| corners[c ^ flip] as u32);
            let [a, b, c, d] = tet.map(|n| nodes[n as usize]);
            if (b - a).cross(c - a).dot(d - a) < 0.0 {
                tet.swap(2, 3);
            }
            tets.push(tet);
        }
    }
    TetMesh::new(nodes, Tets::Linear(tets))
}

/// The tets of about `cell` \[m\] that cover what is inside a closed surface: parry's lattice cover, its boundary drawn
/// towards the surface. The mesh contains the surface, so a surface skinned to it lies inside its elements, and is
/// up to a cell larger; its faces are the mesh's own, not the surface's.
///
/// # Errors
/// Those of [`Surface::check_closed`], [`BuildError::Value`] for a bad cell, [`BuildError::CellTooLarge`] if nothing can be
/// covered, and those of [`TetMesh::check`].
pub fn tet_filled(surface: &Surface, cell: Real) -> Result<TetMesh, BuildError> {
    positive("the cell size of the tets", cell.into())?;
    surface.check_closed()?;
    let (lo, hi) = surface
        .vertices
        .iter()
        .fold((Vector::INFINITY, Vector::NEG_INFINITY), |(lo, hi), v| {
            (lo.min(*v), hi.max(*v))
        });
    // The cover allocates by the box: refuse what can't be meant before it does.
    CellGrid::new((wide(hi - lo) / f64::from(cell)).ceil().to_array(), false)?;
    let mut parameters = VolumeMeshParameters::new(cell);
    parameters.cover_smoothing = 8;
    let mut mesh = volume_mesh(&surface.vertices, &surface.triangles, &parameters).ok_or(
        BuildError::CellTooLarge {
            cell: cell.into(),
            enough: 0.25 * f64::from((hi - lo).min_element()),
        },
    )?;
    mesh.compact();
    TetMesh::new(
        mesh.vertices.iter().map(|v| wide(*v)).collect(),
        Tets::Linear(mesh.cells),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_filled_without_gaps() {
        let size = Vector::new(0.4, 0.3, 0.2);
        for (split, per_cell) in [(TetSplit::Five, 5), (TetSplit::Six, 6)] {
            let mesh = tet_box(size, 0.1, split).unwrap();
            assert_eq!((mesh.nodes.len(), mesh.tets.len()), (60, 24 * per_cell));
            let quality = mesh.quality().unwrap();
            assert!((quality.volume - 0.024).abs() < 1e-8, "{quality:?}");
            assert!(quality.dihedral.value > 44.9, "{quality:?}");
            // Conforming: the boundary is that of the box and closed.
            assert_eq!(mesh.faces.len(), 2 * 2 * (12 + 8 + 6));
            for mesh in [mesh.clone(), mesh.quadratic()] {
                let vertices = mesh.nodes.iter().map(|n| n.as_vec3()).collect();
                let hull = Surface::new(vertices, mesh.faces);
                hull.check_closed().unwrap();
                assert!((hull.volume() - 0.024).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn six_tets_with_middle_nodes_have_the_nodes_of_the_halved_grid() {
        let mesh = tet_box(Vector::new(2.0, 0.5, 0.5), 0.5, TetSplit::Six).unwrap();
        assert_eq!(mesh.tets.len(), 24);
        assert_eq!(mesh.quadratic().nodes.len(), 9 * 3 * 3);
    }

    #[test]
    fn a_closed_surface_is_covered() {
        let ball = tet_box(Vector::splat(1.0), 0.25, TetSplit::Six).unwrap();
        let vertices = ball
            .nodes
            .iter()
            .map(|n| (*n * n.abs().max_element() / n.length().max(1e-9)).as_vec3())
            .collect();
        let surface = Surface::new(vertices, ball.faces);
        let mesh = tet_filled(&surface, 0.15).unwrap();
        let quality = mesh.quality().unwrap();
        let volume = f64::from(surface.volume() as f32);
        assert!(
            quality.volume > volume && quality.volume < 2.0 * volume,
            "{quality:?} {volume}"
        );
        assert!(quality.dihedral.value > 2.0, "{quality:?}");
        mesh.quadratic().check().unwrap();
    }

    #[test]
    fn bad_input_is_an_error() {
        assert!(tet_box(Vector::new(1.0, Real::NAN, 1.0), 0.1, TetSplit::Five).is_err());
        assert!(tet_box(Vector::splat(1.0), 1e-5, TetSplit::Five).is_err());
        assert!(tet_box_of_cells(Vector::splat(1.0), [1, 0, 1], TetSplit::Five).is_err());
        assert!(tet_filled(&Surface::default(), 0.1).is_err());
        let mesh = tet_box(Vector::splat(1.0), 0.5, TetSplit::Five).unwrap();
        let vertices = mesh.nodes.iter().map(|n| n.as_vec3()).collect();
        let surface = Surface::new(vertices, mesh.faces);
        assert!(tet_filled(&surface, 1e-5).is_err());
        assert!(tet_filled(&surface, Real::NAN).is_err());
    }

    /// Van Gelder's constants on a cube of one cell: edges, face diagonals and sums by hand.
    #[test]
    fn springs_have_the_sections_of_van_gelder() {
        let mesh = tet_box(Vector::splat(1.0), 1.0, TetSplit::Five).unwrap();
        let net = mesh.springs();
        net.check().unwrap();
        assert_eq!(net.springs.len(), 12 + 6);
        for s in &net.springs {
            let length = net.length(s);
            // An edge is in one corner tet of 1/6; a diagonal in two of them and in the middle one of 1/3.
            let expected = if length < 1.1 {
                1.0 / 6.0
            } else {
                2.0 / 3.0 / length
            };
            assert!((s.section - expected).abs() < 1e-6);
        }
        let volume: f32 = net.nodes.iter().map(|n| n.volume).sum();
        assert!((volume - 1.0).abs() < 1e-6);
        assert_eq!(mesh.quadratic().springs(), net);
    }
}
