//! A closed surface filled with cells.
//!
//! A crash body needs an interior: a shell of springs folds like paper, while cells carry the load across. Cubes cut by
//! the surface would make slivers whose short springs set the time step of the whole body, so the cells stay whole and
//! only the nodes on the boundary move onto the surface, as far as every cell around stays a good one. What the eye sees
//! is the surface itself, carried along as a skin.

use super::cells::{CellGrid, corner};
use super::lattice::CellSections;
use super::{hexahedron, inside, skin};
use crate::body::error::positive;
use crate::body::{BuildError, Net, Surface};
use crate::math::{DVec3, Real, narrow, wide};
use rapier3d::parry::query::PointQuery;
use rapier3d::parry::shape::TriMesh;

/// How far a boundary node may move, per cell size \[1\].
const REACH: f64 = 0.5;
/// The least volume the edges at a corner may span, of the cube's \[1\]: enough for the inverse map to converge.
const WORST_CORNER: f64 = 0.3;
/// The solid inside a closed `surface`, cut into cells of side `cell` \[m\], with the surface as its skin.
///
/// The cells whose centre is inside are kept, of these the largest connected piece, and its boundary nodes are moved up
/// to half a cell onto the surface where every cell keeps corners of at least 0.3 of the cube's. Node volumes are those
/// of the moved cells. A moved cell keeps the cube's pattern of stiffnesses, scaled so that the mean over all directions
/// of its modulus is exact (Σ k·L² = 6E·V); inner cells are exactly those of [`lattice`](super::lattice), with ν = ¼.
/// What a moved node costs in time step is small: the largest k/m is 1.7 to 1.8 times a cube's for the car that comes
/// with the crate. Every vertex of the surface is bound to the nearest cell so that the rest position is reproduced.
///
/// # Errors
/// Those of [`Surface::check_closed`] and [`Surface::check_self_intersection`]; [`BuildError::Value`] for a cell that is
/// not positive and finite, a surface turned inside out, or more than fifty million cell corners;
/// [`BuildError::CellTooLarge`] if no cell has its centre inside.
pub fn filled(surface: &Surface, cell: Real) -> Result<Net, BuildError> {
    let side = positive("the cell size of the filled surface", cell.into())?;
    surface.check_closed()?;
    surface.check_self_intersection()?;
    if surface.volume() <= 0.0 {
        return Err(BuildError::Value {
            what: "the volume of the surface",
            value: surface.volume(),
            must: "positive: its triangles must be counter-clockwise seen from outside",
        });
    }
    let (grid, origin) = cells_inside(surface, side)?;
    let mut places = vec![DVec3::ZERO; grid.points()];
    grid.each_point(|at, point| {
        places[point] = origin + DVec3::from_array(at.map(|v| v as f64)) * side;
    });
    snap(&grid, &mut places, surface, side);

    let cube = CellSections::of_box(DVec3::splat(side));
    let mut shares = vec![[0.0; 8]; grid.occupied.len()];
    let mut scale = vec![0.0; grid.occupied.len()];
    for c in 0..grid.occupied.len() {
        if grid.occupied[c] {
            let corners = grid.places(c, &places);
            shares[c] = hexahedron::shares(&corners);
            scale[c] = 6.0 * shares[c].iter().sum::<f64>() / cube.modulus_sum(&corners);
        }
    }
    let (mut net, node_of) = grid.net(
        |at| places[grid.point(at)],
        |c, corner| shares[c][corner],
        |c, kind, length| scale[c] * cube.section(kind, length),
    );
    net.skin = Some(skin::bind(surface, &grid, &places, &node_of, origin, side));
    Ok(net)
}

/// The grid around the surface, centred on it so that a symmetric surface gets a symmetric net, and its low corner.
fn cells_inside(surface: &Surface, side: f64) -> Result<(CellGrid, DVec3), BuildError> {
    let (lo, hi) = surface
        .vertices
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), v| {
            (lo.min(wide(*v)), hi.max(wide(*v)))
        });
    let attempt = |side: f64| {
        // A box of whole cells must not gain a layer by rounding.
        let counts = ((hi - lo) / side - 1.0e-4).ceil().max(DVec3::ONE);
        let origin = 0.5 * (lo + hi) - 0.5 * side * counts;
        let mut grid = CellGrid::new(counts.to_array(), false)?;
        inside::fill(&mut grid, surface, origin, side);
        inside::keep_largest(&mut grid);
        inside::close_hinges(&mut grid);
        Ok((grid, origin))
    };
    let first = attempt(side)?;
    if first.0.occupied.contains(&true) {
        return Ok(first);
    }
    // Halve until something is inside, to say what would do.
    let mut smaller = side;
    loop {
        smaller *= 0.5;
        if attempt(smaller)?.0.occupied.contains(&true) {
            return Err(BuildError::CellTooLarge {
                cell: side,
                enough: smaller,
            });
        }
    }
}

/// Moves boundary points onto the surface. Three rounds, since a node that was held back by a neighbour may follow it.
fn snap(grid: &CellGrid, places: &mut [DVec3], surface: &Surface, side: f64) {
    let Ok(mesh) = TriMesh::new(surface.vertices.clone(), surface.triangles.clone()) else {
        return; // Only for an empty surface, which is refused before.
    };
    let mut boundary = vec![false; places.len()];
    for cell in 0..grid.occupied.len() {
        if grid.occupied[cell] {
            grid.faces(cell, |quad| {
                quad.into_iter().for_each(|p| boundary[p] = true)
            });
        }
    }
    let mut moves = Vec::new();
    grid.each_point(|at, point| {
        if boundary[point] {
            let start = places[point];
            let target = wide(mesh.project_local_point(narrow(start), false).point) - start;
            moves.push((at, point, start, target.clamp_length_max(REACH * side)));
        }
    });
    for _ in 0..3 {
        for &(at, point, start, by) in &moves {
            let before = places[point];
            for part in [1.0, 0.75, 0.5, 0.25] {
                let there = start + by * part;
                if (before - start).length() >= (there - start).length() {
                    break;
                }
                places[point] = there;
                if around(grid, at).all(|c| {
                    hexahedron::worst_corner(&grid.places(c, places)) >= WORST_CORNER * side.powi(3)
                }) {
                    break;
                }
                places[point] = before;
            }
        }
    }
}

/// The solid cells around a grid point.
fn around(grid: &CellGrid, at: [usize; 3]) -> impl Iterator<Item = usize> + '_ {
    (0..8).filter_map(move |c| grid.solid(corner(at, c).map(|v| v as i64 - 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::surface::tests::{cuboid, joined};
    use crate::math::Vector;

    /// A sphere of radius `r`: an octahedron split `n` times.
    fn sphere(r: f64, n: usize) -> Surface {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        let mut triangles = Vec::new();
        for (a, b) in [(x, y), (y, -x), (-x, -y), (-y, x)] {
            triangles.extend([[a, b, z], [b, a, -z]]);
        }
        for _ in 0..n {
            triangles = triangles
                .into_iter()
                .flat_map(|[a, b, c]| {
                    let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
        }
        let mut surface = Surface::default();
        for t in triangles {
            let ids = t.map(|p| {
                let v = narrow(p * r);
                let known = surface
                    .vertices
                    .iter()
                    .position(|w| w.distance(v) < 1e-6 * r as Real);
                known.unwrap_or_else(|| {
                    surface.vertices.push(v);
                    surface.vertices.len() - 1
                }) as u32
            });
            surface.triangles.push(ids);
        }
        surface
    }

    fn volume(net: &Net) -> f64 {
        net.nodes.iter().map(|n| f64::from(n.volume)).sum()
    }

    fn check_skin(net: &Net, cell: Real) {
        let skin = net.skin.as_ref().unwrap();
        for (vertex, binding) in skin.vertices.iter().zip(&skin.bindings) {
            let sum: Real = binding.weights.iter().sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum}");
            let place: Vector = (0..8)
                .map(|i| net.nodes[binding.nodes[i] as usize].position * binding.weights[i])
                .sum();
            assert!(place.distance(*vertex) < 1e-4 * cell, "{place} {vertex}");
            assert!(binding.weights.iter().all(|w| w.abs() < 4.0), "{binding:?}");
        }
    }

    #[test]
    fn a_sphere_has_its_volume_its_skin_and_a_closed_boundary() {
        let surface = sphere(0.5, 4);
        surface.check_closed().unwrap();
        for cell in [0.2, 0.1, 0.07] {
            let net = filled(&surface, cell).unwrap();
            net.check().unwrap();
            let off = volume(&net) / surface.volume() - 1.0;
            assert!(off.abs() < 0.05, "cell {cell}: volume off by {off}");
            check_skin(&net, cell);
            let boundary = Surface::new(
                net.nodes.iter().map(|n| n.position).collect(),
                net.faces.clone(),
            );
            boundary.check_closed().unwrap();
            assert!((boundary.volume() / volume(&net) - 1.0).abs() < 0.01);
            assert!(net.springs.iter().all(|s| s.section > 0.0));
            println!(
                "cell {cell}: {} nodes, volume off by {off}",
                net.nodes.len()
            );
        }
    }

    #[test]
    fn a_box_on_the_grid_is_the_lattice() {
        let surface = cuboid([-0.2, -0.1, -0.15], [0.2, 0.1, 0.15]);
        let mut net = filled(&surface, 0.05).unwrap();
        net.skin = None;
        let lattice = crate::shape::lattice(Vector::new(0.4, 0.2, 0.3), 0.05).unwrap();
        assert_eq!(net.nodes.len(), lattice.nodes.len());
        assert_eq!(net.faces, lattice.faces);
        for (a, b) in net.springs.iter().zip(&lattice.springs) {
            assert_eq!(a.nodes, b.nodes);
            assert!((a.section / b.section - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn bad_surfaces_and_cells_are_errors() {
        let good = cuboid([0.0; 3], [1.0; 3]);
        let mut open = good.clone();
        open.triangles.pop();
        assert!(matches!(
            filled(&open, 0.1),
            Err(BuildError::OpenSurface { .. })
        ));
        let crossed = joined(good.clone(), &cuboid([0.5; 3], [1.5; 3]));
        assert!(matches!(
            filled(&crossed, 0.1),
            Err(BuildError::SelfIntersecting { .. })
        ));
        let mut inverted = good.clone();
        inverted.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(matches!(
            filled(&inverted, 0.1),
            Err(BuildError::Value { .. })
        ));
        for cell in [0.0, -1.0, Real::NAN, Real::INFINITY, 1e-5] {
            assert!(
                matches!(filled(&good, cell), Err(BuildError::Value { .. })),
                "{cell}"
            );
        }
        // Two lumps on a thin bar: the centre of a large cell misses both.
        let apart = joined(cuboid([0.0; 3], [0.1; 3]), &cuboid([0.9; 3], [1.0; 3]));
        let error = filled(&apart, 2.0).unwrap_err();
        assert!(matches!(error, BuildError::CellTooLarge { .. }), "{error}");
    }

    #[test]
    fn only_the_largest_piece_is_kept() {
        let two = joined(
            cuboid([0.0; 3], [1.0; 3]),
            &cuboid([2.0, 0.0, 0.0], [2.5, 0.5, 0.5]),
        );
        let net = filled(&two, 0.125).unwrap();
        assert!((volume(&net) - 1.0).abs() < 0.02, "{}", volume(&net));
        assert!(net.bounds().1.x < 1.1);
    }
}
