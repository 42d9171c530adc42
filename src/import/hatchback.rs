//! The car that comes with the crate.
//!
//! A crash needs a car, and one that is made by a program in the repository has a known origin, known dimensions and a
//! surface that is closed by construction. It is embedded so that a scene needs no path to find it by.

use super::{ImportError, obj};
use crate::body::Surface;
use std::path::Path;

/// A five-door-sized hatchback of 4.2 × 1.48 × 1.75 m: x forward with the front bumper at x = 2.1, y up with the tyres
/// down to y = 0, z to the right. Its groups are `body`, `glass`, `tyre`, `rim` and `lamp`. Made by
/// `assets/hatchback.rs`.
///
/// # Errors
/// Those of [`obj::parse`]; none for the file as it is shipped.
pub fn hatchback() -> Result<Surface, ImportError> {
    obj::parse(
        include_str!("../../assets/hatchback.obj"),
        Path::new("assets/hatchback.obj"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Net;
    use crate::math::{Real, Vector};
    use crate::shape::filled;

    #[test]
    fn the_car_is_closed_and_has_its_dimensions() {
        let surface = hatchback().unwrap();
        surface.check_closed().unwrap();
        surface.check_self_intersection().unwrap();
        assert!((2000..=6000).contains(&surface.triangles.len()));
        let (lo, hi) = surface
            .vertices
            .iter()
            .fold((Vector::INFINITY, Vector::NEG_INFINITY), |(lo, hi), v| {
                (lo.min(*v), hi.max(*v))
            });
        assert!(
            (lo - Vector::new(-2.1, 0.0, -0.875)).abs().max_element() < 0.01,
            "{lo}"
        );
        assert!(
            (hi - Vector::new(2.1, 1.48, 0.875)).abs().max_element() < 0.01,
            "{hi}"
        );
        let names: Vec<_> = surface.groups.iter().map(|g| g.name.as_str()).collect();
        assert_eq!(names, ["body", "glass", "tyre", "rim", "lamp"]);
    }

    /// How many sets of nodes the springs connect.
    fn pieces(net: &Net) -> usize {
        let mut parent: Vec<usize> = (0..net.nodes.len()).collect();
        fn root(parent: &mut [usize], mut i: usize) -> usize {
            while parent[i] != i {
                parent[i] = parent[parent[i]];
                i = parent[i];
            }
            i
        }
        for s in &net.springs {
            let [a, b] = s.nodes.map(|n| root(&mut parent, n as usize));
            parent[a] = b;
        }
        (0..parent.len()).filter(|&i| parent[i] == i).count()
    }

    #[test]
    fn the_car_can_be_filled() {
        let surface = hatchback().unwrap();
        for (cell, expected) in [(0.1, 7_000..11_000), (0.08, 13_000..20_000)] {
            let start = std::time::Instant::now();
            let net = filled(&surface, cell).unwrap();
            let seconds = start.elapsed().as_secs_f64();
            net.check().unwrap();
            let volume: f64 = net.nodes.iter().map(|n| f64::from(n.volume)).sum();
            let shortest = net
                .springs
                .iter()
                .map(|s| net.length(s))
                .fold(Real::INFINITY, Real::min);
            let lightest = net
                .nodes
                .iter()
                .map(|n| n.volume)
                .fold(Real::INFINITY, Real::min);
            println!(
                "cell {cell}: {} nodes, {} springs, {} faces, {volume:.3} of {:.3} m³, shortest spring {:.2} cells, \
                 lightest node {:.3} cells, {seconds:.2} s",
                net.nodes.len(),
                net.springs.len(),
                net.faces.len(),
                surface.volume(),
                shortest / cell,
                lightest / cell.powi(3),
            );
            assert_eq!(pieces(&net), 1);
            assert!(expected.contains(&net.nodes.len()), "{}", net.nodes.len());
            assert!((volume / surface.volume() - 1.0).abs() < 0.1);
            let boundary = Surface::new(
                net.nodes.iter().map(|n| n.position).collect(),
                net.faces.clone(),
            );
            boundary.check_closed().unwrap();
            let skin = net.skin.as_ref().unwrap();
            let mut worst: (Real, Real) = (0.0, 0.0);
            for (vertex, binding) in skin.vertices.iter().zip(&skin.bindings) {
                let place: Vector = (0..8)
                    .map(|i| net.nodes[binding.nodes[i] as usize].position * binding.weights[i])
                    .sum();
                worst.0 = worst.0.max(place.distance(*vertex));
                worst.1 = binding.weights.iter().fold(worst.1, |w, v| w.max(v.abs()));
            }
            println!(
                "skin: off by at most {} m, largest weight {}",
                worst.0, worst.1
            );
            assert!(worst.0 < 1e-4 * cell && worst.1 < 4.0, "{worst:?}");
        }
    }
}
