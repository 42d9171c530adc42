//! Steps out of what several faces hide: over the line in which two of them meet, or the point of three.

use crate::math::{DMat3, DVec3};

/// A face as seen from a point.
#[derive(Clone, Copy, Default)]
pub struct Exit {
    /// Height of the point over it, negative below \[m\].
    pub height: f64,
    /// Outwards.
    pub normal: DVec3,
}

/// The step to the line in which two faces meet \[m\], or over the one that is to be passed where the other is not, as by a point on
/// its surface or a little over it; `None` of faces that are nearly parallel.
pub fn through_edge(a: &Exit, b: &Exit) -> Option<DVec3> {
    let c = a.normal.dot(b.normal);
    let sine = 1.0 - c * c;
    if sine < 1e-6 {
        return None;
    }
    // The shortest step s with a·s = −height of a, b·s = −height of b.
    let x = (-a.height + c * b.height) / sine;
    let y = (-b.height + c * a.height) / sine;
    Some(match (x < 0.0, y < 0.0) {
        (false, false) => a.normal * x + b.normal * y,
        (true, false) => b.normal * (-b.height).max(0.0),
        _ => a.normal * (-a.height).max(0.0),
    })
}

/// The step to the point in which three faces meet \[m\], as far as they are to be passed, and one by 1 over each of them; `None` where there
/// is no such point.
pub fn through_corner(faces: [&Exit; 3]) -> Option<(DVec3, DVec3)> {
    let normals = faces.map(|face| face.normal);
    let planes = DMat3::from_cols(normals[0], normals[1], normals[2]).transpose();
    if planes.determinant().abs() < 1e-3 {
        return None;
    }
    let inverse = planes.inverse();
    let depths = faces.map(|face| (-face.height).max(0.0));
    Some((inverse * DVec3::from(depths), inverse * DVec3::ONE))
}
