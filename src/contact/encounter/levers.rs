//! Levers of rows between two deformables, see [`Row::levers`](crate::solve::rows::Row::levers).

use super::edge::Crossing;
use crate::math::DVec3;

/// Where a surface is seen so steeply, or is so thick for its elements, that a lever is longer than this, it and all that belong to the same
/// couple are shortened: that is not whole then.
const LONGEST: f64 = 1.0;

/// Sine of the angle between an element and the normal below which it can't take a couple across that: what is left of it is
/// rounding.
const SEEN: f64 = 1e-6;

/// Those of the corners of an element that an impulse acts beside, `gap` m away along the normal. An element with two corners
/// in one place is an edge, which takes couples across it alone.
pub fn of_face([a, b, c]: [DVec3; 3], normal: DVec3, gap: f64) -> [DVec3; 3] {
    let flat = |d| flat(d, normal);
    let (u, v) = (flat(b - a), flat(c - a));
    let [to_b, to_c] = if v == DVec3::ZERO || c == b {
        [u / u.length_squared(), DVec3::ZERO]
    } else {
        dual(u, v)
    };
    shortened([-(to_b + to_c), to_b, to_c].map(|l| l * gap))
}

/// Those of the second ends of two edges that cross; the first ends have the opposite ones.
pub fn of_edges([a, b]: [DVec3; 2], [c, d]: [DVec3; 2], found: &Crossing) -> [DVec3; 2] {
    let flat = |d| flat(d, found.normal);
    shortened(dual(flat(b - a), flat(d - c)).map(|l| l * found.gap))
}

/// That of the second end of a spring that belongs to no face; the first end has the opposite one. It fills `part` m of the gap, and what acts
/// on its surface acts so far from its axis. A rope can't be turned about that: if what it meets took the rope's couple
/// too, it would give way to friction as if it could roll round the rope's axis.
pub fn of_spring([a, b]: [DVec3; 2], normal: DVec3, part: f64) -> DVec3 {
    let flat = flat(b - a, normal);
    let [lever] = shortened([flat * (part / flat.length_squared())]);
    lever
}

/// What of a side of an element is square to the normal, 0 where that is rounding.
fn flat(side: DVec3, normal: DVec3) -> DVec3 {
    let flat = side - normal * side.dot(normal);
    let is_seen = flat.length_squared() > SEEN * SEEN * side.length_squared();
    if is_seen { flat } else { DVec3::ZERO }
}

/// The two vectors in the plane of u and v that have 1 along the one and 0 along the other.
fn dual(u: DVec3, v: DVec3) -> [DVec3; 2] {
    let across = u.cross(v);
    let square = across.length_squared();
    let least = SEEN * SEEN * u.length_squared() * v.length_squared();
    if square <= least {
        return [DVec3::ZERO; 2];
    }
    [v.cross(across) / square, across.cross(u) / square]
}

/// The same, none longer than [`LONGEST`]; none at all where there are none.
fn shortened<const N: usize>(levers: [DVec3; N]) -> [DVec3; N] {
    let longest = levers.iter().map(|l| l.length()).fold(0.0, f64::max);
    let sum: DVec3 = levers.iter().sum();
    if !sum.is_finite() {
        [DVec3::ZERO; N]
    } else if longest > LONGEST {
        levers.map(|l| l * (LONGEST / longest))
    } else {
        levers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What an impulse beside a face does to it is one at that place: the same sum, the same moment.
    #[test]
    fn a_face_takes_an_impulse_beside_it() {
        let corners = [
            DVec3::new(0.1, 0.2, 0.0),
            DVec3::new(1.3, -0.1, 0.1),
            DVec3::new(0.4, 0.9, -0.2),
        ];
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let normal = normal.normalize();
        let (weights, gap) = ([0.2, 0.5, 0.3], 0.07);
        let point: DVec3 = corners.iter().zip(weights).map(|(c, w)| *c * w).sum();
        let place = point + normal * gap;
        let levers = of_face(corners, normal, gap);
        let j = DVec3::new(0.3, -1.1, 0.8);
        // The face is the second side: it takes −j.
        let parts: Vec<DVec3> = (0..3)
            .map(|k| normal * levers[k].dot(j) - j * weights[k])
            .collect();
        let sum: DVec3 = parts.iter().sum();
        let moment: DVec3 = corners.iter().zip(&parts).map(|(c, p)| c.cross(*p)).sum();
        assert!((sum + j).length() < 1e-12, "{sum}");
        assert!((moment + place.cross(j)).length() < 1e-12, "{moment}");
    }

    /// Symptom: of two ropes that pushed each other end on the last nodes but one got a part of it now and then. Cause: levers across the
    /// way, by rounding.
    #[test]
    fn what_is_seen_end_on_takes_no_couple() {
        let (a, b) = (DVec3::new(0.3, 0.1, -0.2), DVec3::new(0.7, 1.3, 0.4));
        let along = (b - a).normalize();
        let c = b + along * 0.3;
        for tilt in [0.0, 1e-16, 1e-9] {
            let normal = (along + along.any_orthonormal_vector() * tilt).normalize();
            assert_eq!(of_face([a, b, b], normal, 0.01), [DVec3::ZERO; 3]);
            assert_eq!(of_face([a, b, c], normal, 0.01), [DVec3::ZERO; 3]);
            assert_eq!(of_spring([a, b], normal, 0.01), DVec3::ZERO);
        }
        let normal = (along + along.any_orthonormal_vector() * 0.1).normalize();
        let [_, lever, _] = of_face([a, b, b], normal, 0.01);
        let sine = along.cross(normal).length();
        assert!((lever.length() * a.distance(b) * sine - 0.01).abs() < 1e-9);
    }

    /// Two edges that cross at a distance get no moment in all.
    #[test]
    fn edges_take_no_couple() {
        let a = [DVec3::new(-0.5, 0.1, 0.02), DVec3::new(0.7, 0.1, 0.02)];
        let b = [DVec3::new(0.1, 0.0, -0.6), DVec3::new(0.2, 0.0, 0.4)];
        let normal = (a[1] - a[0]).cross(b[1] - b[0]).normalize();
        let (closest, along) = crate::contact::closest::between_segments(a, b);
        let along = along.expect("they cross");
        let way = a[0].lerp(a[1], along[0]) - b[0].lerp(b[1], along[1]);
        let gap = way.dot(normal);
        assert!((gap.abs() - closest).abs() < 1e-9);
        let found = Crossing { along, normal, gap };
        let [to_a, to_b] = of_edges(a, b, &found);
        let j = DVec3::new(0.3, -1.1, 0.8);
        let [s, t] = along;
        let terms = [
            (a[0], 1.0 - s, -to_a),
            (a[1], s, to_a),
            (b[0], t - 1.0, -to_b),
            (b[1], -t, to_b),
        ];
        let (mut sum, mut moment) = (DVec3::ZERO, DVec3::ZERO);
        for (place, weight, lever) in terms {
            let part = j * weight + normal * lever.dot(j);
            sum += part;
            moment += place.cross(part);
        }
        assert!(
            sum.length() < 1e-12 && moment.length() < 1e-12,
            "{sum} {moment}"
        );
    }

    /// What an impulse on its surface does to a spring is one at that place, but for what would turn it about itself.
    #[test]
    fn a_spring_takes_an_impulse_on_its_surface() {
        let a = [DVec3::new(-0.5, 0.1, 0.02), DVec3::new(0.7, 0.1, 0.02)];
        let b = [DVec3::new(0.1, 0.0, -0.6), DVec3::new(0.2, 0.0, 0.4)];
        let normal = (a[1] - a[0]).cross(b[1] - b[0]).normalize();
        let (closest, along) = crate::contact::closest::between_segments(a, b);
        let along = along.expect("they cross");
        let points = [a[0].lerp(a[1], along[0]), b[0].lerp(b[1], along[1])];
        let gap = (points[0] - points[1]).dot(normal);
        assert!((gap.abs() - closest).abs() < 1e-9);
        let [to_a, to_b] = [(a, 0.3), (b, 0.7)].map(|(e, part)| of_spring(e, normal, part * gap));
        let place = points[1].lerp(points[0], 0.7);
        let j = DVec3::new(0.3, -1.1, 0.8);
        let [s, t] = along;
        let of_a = [(a[0], 1.0 - s, -to_a), (a[1], s, to_a)];
        let of_b = [(b[0], t - 1.0, -to_b), (b[1], -t, to_b)];
        for (terms, edge, whole) in [(of_a, a, j), (of_b, b, -j)] {
            let (mut sum, mut moment) = (DVec3::ZERO, DVec3::ZERO);
            for (end, weight, lever) in terms {
                let part = j * weight + normal * lever.dot(j);
                sum += part;
                moment += (end - place).cross(part);
            }
            assert!((sum - whole).length() < 1e-12, "{sum}");
            let along = (edge[1] - edge[0]).normalize();
            let across = moment - along * moment.dot(along);
            assert!(across.length() < 1e-12, "{moment}");
        }
    }

    #[test]
    fn what_has_no_sides_has_no_levers() {
        let flat = of_face([DVec3::ZERO; 3], DVec3::Y, 0.1);
        assert_eq!(flat, [DVec3::ZERO; 3]);
        let [a, b, c] = of_face([DVec3::ZERO, DVec3::X, DVec3::X], DVec3::Y, 0.1);
        assert_eq!([a, b, c], [-0.1 * DVec3::X, 0.1 * DVec3::X, DVec3::ZERO]);
        let steep = of_face(
            [DVec3::ZERO, DVec3::Y + 1e-9 * DVec3::X, DVec3::Z],
            DVec3::Y,
            0.1,
        );
        assert!(steep.iter().all(|l| l.length() <= LONGEST * (1.0 + 1e-12)));
    }
}
