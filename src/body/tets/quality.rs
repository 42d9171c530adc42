//! How good the tets of a mesh are.

use super::{TetMesh, volume};
use crate::law::basis;
use crate::math::DVec3;

/// How many tets a report names.
const NAMED: usize = 8;

/// The worst tet in some measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// Its index.
    pub tet: u32,
    /// What it has.
    pub value: f64,
}

/// Shape and size of the tets of a mesh, by their corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// How many tets.
    pub tets: usize,
    /// Sum of their volumes \[m³\].
    pub volume: f64,
    /// The least volume \[m³\].
    pub smallest: Worst,
    /// The least angle between two faces \[degrees\]; 70.5 in a regular tet. Below about 10 accuracy and the stable step
    /// suffer.
    pub dihedral: Worst,
    /// The least 3·inradius/circumradius; 1 for a regular tet, 0 for a flat one.
    pub radius_ratio: Worst,
    /// The mean of 3·inradius/circumradius.
    pub mean_radius_ratio: f64,
    /// The tets with the least radius ratios, the worst first, eight at most.
    pub worst: Vec<u32>,
}

impl TetMesh {
    /// The quality of the mesh, or `None` without tets.
    pub fn quality(&self) -> Option<Quality> {
        let measured: Vec<[f64; 3]> = self
            .tets
            .iter()
            .map(|tet| measure(self.corners(tet)))
            .collect();
        let least = |m: usize| {
            (0..measured.len() as u32)
                .map(|tet| Worst {
                    tet,
                    value: measured[tet as usize][m],
                })
                .min_by(|a, b| a.value.total_cmp(&b.value))
        };
        let mut order: Vec<u32> = (0..measured.len() as u32).collect();
        order.sort_by(|&a, &b| measured[a as usize][2].total_cmp(&measured[b as usize][2]));
        order.truncate(NAMED);
        Some(Quality {
            tets: measured.len(),
            volume: measured.iter().map(|m| m[0]).sum(),
            smallest: least(0)?,
            dihedral: least(1)?,
            radius_ratio: least(2)?,
            mean_radius_ratio: measured.iter().map(|m| m[2]).sum::<f64>() / measured.len() as f64,
            worst: order,
        })
    }
}

/// Volume, least dihedral angle in degrees, radius ratio; the ratio of an inverted tet is negative.
fn measure(p: [DVec3; 4]) -> [f64; 3] {
    let volume = volume(p);
    let normals = basis::FACES.map(|[a, b, c]| (p[b] - p[a]).cross(p[c] - p[a]));
    let mut dihedral = 180.0_f64;
    for i in 0..4 {
        for j in 0..i {
            let cos = -normals[i].dot(normals[j]) / (normals[i].length() * normals[j].length());
            dihedral = dihedral.min(cos.clamp(-1.0, 1.0).acos().to_degrees());
        }
    }
    let area: f64 = normals.iter().map(|n| 0.5 * n.length()).sum();
    // Products of opposite edges give the circumradius: 24·V·R = √((u+v+w)(−u+v+w)(u−v+w)(u+v−w)).
    let opposite =
        |a: usize, b: usize, c: usize, d: usize| p[a].distance(p[b]) * p[c].distance(p[d]);
    let (u, v, w) = (
        opposite(0, 1, 2, 3),
        opposite(0, 2, 1, 3),
        opposite(0, 3, 1, 2),
    );
    let root = ((u + v + w) * (v + w - u) * (u + w - v) * (u + v - w))
        .max(0.0)
        .sqrt();
    let ratio = if root > 0.0 && area > 0.0 {
        // r = 3V/area, R = root/(24|V|).
        216.0 * volume * volume.abs() / (area * root)
    } else {
        0.0
    };
    [volume, dihedral, ratio]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_regular_and_a_corner_tet() {
        let regular = [
            DVec3::new(1.0, 1.0, 1.0),
            DVec3::new(1.0, -1.0, -1.0),
            DVec3::new(-1.0, 1.0, -1.0),
            DVec3::new(-1.0, -1.0, 1.0),
        ];
        let mut regular = regular;
        if volume(regular) < 0.0 {
            regular.swap(0, 1);
        }
        let [v, dihedral, ratio] = measure(regular);
        assert!((v - 8.0 / 3.0).abs() < 1e-12);
        assert!((dihedral - (1.0_f64 / 3.0).acos().to_degrees()).abs() < 1e-9);
        assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
        // Inradius 1/(3 + √3), circumradius √3/2.
        let [v, dihedral, ratio] = measure([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]);
        let s = 3.0_f64.sqrt();
        assert!((v - 1.0 / 6.0).abs() < 1e-15);
        assert!((dihedral - (1.0 / s).acos().to_degrees()).abs() < 1e-9);
        assert!(
            (ratio - 3.0 / (3.0 + s) / (s / 2.0)).abs() < 1e-12,
            "{ratio}"
        );
    }
}
