//! Where a straight edge of a deformable crosses an edge or a rim of a solid.
//!
//! The place where a signed distance is least along a segment is no help there: under a box that lies flush it is anywhere,
//! and jumps. The crossing stays where it is, and has a normal perpendicular to both edges.

use super::edges::corner;
use super::rim::Rim;
use super::{Core, Solid, primitive};
use crate::contact::closest::between_segments;
use crate::math::DVec3;

/// A crossing of a segment and an edge of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Which edge of the solid.
    pub edge: u32,
    /// The part of the way along the segment.
    pub t: f64,
    /// Outward unit normal, between those of the faces at the edge.
    pub normal: DVec3,
    /// Signed distance of the segment along it \[m\].
    pub distance: f64,
}

/// The ends of an edge \[m\] and the outward unit normals of its faces.
pub type StraightEdge = ([DVec3; 2], [DVec3; 2]);

/// How far a normal may lie outside the faces at an edge: a segment that rests on one of them rocks a little.
const LEAN: f64 = 0.05;

/// From here on corners are numbered as edges are.
const CORNERS: u32 = 1 << 31;

impl Solid {
    /// Calls `found` for the crossings of the segment `a`–`b` \[m\] with the edges of a convex solid, in the order of the
    /// edges; what is more than `within` m away may be left out. Balls and capsules have none, nor have the mantles
    /// of cylinders and cones.
    pub fn for_each_crossing(
        &self,
        a: DVec3,
        b: DVec3,
        within: f64,
        found: &mut dyn FnMut(Crossing),
    ) {
        let mut edge = 0;
        let margin = DVec3::splat(within + self.radius);
        let (lo, hi) = (a.min(b) - margin, a.max(b) + margin);
        let mut give = |meeting: Option<(f64, DVec3, f64)>| {
            if let Some((t, normal, distance)) = meeting {
                found(Crossing {
                    edge,
                    t,
                    normal,
                    distance: distance - self.radius,
                });
            }
            edge += 1;
        };
        match &self.core {
            Core::Cuboid(half) => {
                let near = cuboid_edges_near(*half, lo, hi);
                for i in 0..12 {
                    let meeting = (near >> i & 1 == 1).then(|| {
                        let (ends, normals) = cuboid_edge(i, *half);
                        cross([a, b], ends, normals)
                    });
                    give(meeting.flatten());
                }
            }
            Core::Hull(hull) => {
                hull.for_each_edge(&mut |[p, q], normals| {
                    let apart = p.max(q).cmplt(lo) | p.min(q).cmpgt(hi);
                    let meeting = (!apart.any()).then(|| cross([a, b], [p, q], normals));
                    give(meeting.flatten());
                });
            }
            Core::Cylinder(..) | Core::Cone(..) => {
                for rim in self.rims() {
                    let met = rim.meetings(a, b - a, within + self.radius);
                    met.into_iter().for_each(&mut give);
                }
            }
            Core::Point
            | Core::Segment(..)
            | Core::HalfSpace(_)
            | Core::Compound(_)
            | Core::Voxels(_) => {}
        }
    }

    /// A straight edge by its number, as [`Self::for_each_crossing`] counts them: its ends \[m\] and the outward normals of
    /// its faces.
    pub fn straight_edge(&self, number: u32) -> Option<StraightEdge> {
        match &self.core {
            Core::Cuboid(half) => (number < 12).then(|| cuboid_edge(number as usize, *half)),
            Core::Hull(hull) => {
                let (mut i, mut edge) = (0, None);
                hull.for_each_edge(&mut |ends, normals| {
                    if i == number {
                        edge = Some((ends, normals));
                    }
                    i += 1;
                });
                edge
            }
            _ => None,
        }
    }

    /// The crossing of the segment `a`–`b` \[m\] with one of its straight edges.
    pub fn crossing(
        &self,
        [a, b]: [DVec3; 2],
        (edge, (ends, normals)): (u32, StraightEdge),
    ) -> Option<Crossing> {
        let (t, normal, distance) = cross([a, b], ends, normals)?;
        Some(Crossing {
            edge,
            t,
            normal,
            distance: distance - self.radius,
        })
    }

    /// Calls `found` for the crossings of the segment `a`–`b` \[m\] with the corners of a grown polyhedron, which are balls as
    /// a skin over it makes them too, in their order; what is more than `within` m away may be left out.
    pub fn for_each_corner(
        &self,
        a: DVec3,
        b: DVec3,
        within: f64,
        found: &mut dyn FnMut(Crossing),
    ) {
        let margin = within + self.radius;
        let mut edge = CORNERS;
        let mut try_out = |corner: DVec3| {
            edge += 1;
            let t = primitive::along(corner, a, b);
            let way = a.lerp(b, t) - corner;
            let away = way.length();
            if !(t > 0.0 && t < 1.0 && away > 0.0 && away < margin) {
                return;
            }
            // Elsewhere an edge or a face is nearer.
            let (distance, normal) = self.signed_distance(corner + way);
            let over = distance + self.radius;
            let foot = way - normal * over;
            if over > 0.0 && foot.length() <= LEAN * away {
                found(Crossing {
                    edge,
                    t,
                    normal: way / away,
                    distance: away - self.radius,
                });
            }
        };
        match &self.core {
            Core::Cuboid(half) => (0..8).for_each(|i| try_out(corner(i) * *half)),
            Core::Hull(hull) => hull.vertices().iter().for_each(|&p| try_out(p)),
            _ => {}
        }
    }

    /// The rims of a cylinder or a cone.
    pub fn rims(&self) -> impl Iterator<Item = Rim> + use<> {
        let (rims, count) = match self.core {
            Core::Cylinder(half_height, radius) => {
                let rim = |cap: DVec3| Rim {
                    centre: cap * half_height,
                    radius,
                    cap,
                    slope: 0.0,
                };
                ([rim(DVec3::NEG_Y), rim(DVec3::Y)], 2)
            }
            Core::Cone(half_height, radius) => {
                let height = 2.0 * half_height;
                let rim = Rim {
                    centre: DVec3::NEG_Y * half_height,
                    radius,
                    cap: DVec3::NEG_Y,
                    slope: radius / height.max(f64::MIN_POSITIVE),
                };
                ([rim; 2], 1)
            }
            _ => ([Rim::default(); 2], 0),
        };
        rims.into_iter().take(count)
    }

    /// How far the segment `a`–`b` \[m\] is from the straight edges of a convex solid, or less, up to `within` m: −∞ where it has
    /// rims, or is not convex.
    pub fn edges_from(&self, a: DVec3, b: DVec3, within: f64) -> f64 {
        let margin = DVec3::splat(within + self.radius);
        let (lo, hi) = (a.min(b) - margin, a.max(b) + margin);
        let mut least = within + self.radius;
        let mut try_out = |ends| least = between_segments([a, b], ends).0.min(least);
        match &self.core {
            Core::Point | Core::Segment(..) | Core::HalfSpace(_) => {}
            Core::Cuboid(half) => {
                let near = cuboid_edges_near(*half, lo, hi);
                let near = (0..12).filter(|i| near >> i & 1 == 1);
                near.for_each(|i| try_out(cuboid_edge(i, *half).0));
            }
            Core::Hull(hull) => hull.for_each_edge(&mut |[p, q], _| {
                if !(p.max(q).cmplt(lo) | p.min(q).cmpgt(hi)).any() {
                    try_out([p, q]);
                }
            }),
            Core::Cylinder(..) | Core::Cone(..) | Core::Compound(_) | Core::Voxels(_) => {
                return f64::NEG_INFINITY;
            }
        }
        least - self.radius
    }

    /// Whether it has rims, of which a face touches other points the more it turns.
    pub fn has_rim(&self) -> bool {
        matches!(self.core, Core::Cylinder(..) | Core::Cone(..))
    }

    /// Whether a convex solid has a round side that a segment can touch between edges: that of a ball, a capsule, a cylinder
    /// or a cone.
    pub fn has_round_side(&self) -> bool {
        matches!(
            self.core,
            Core::Point | Core::Segment(..) | Core::Cylinder(..) | Core::Cone(..)
        )
    }
}

/// One bit for each edge of a cuboid that is anywhere in a box.
fn cuboid_edges_near(half: DVec3, lo: DVec3, hi: DVec3) -> u32 {
    let spans = (lo.cmple(half) & hi.cmpge(-half)).bitmask();
    let sides = [
        (lo.cmple(-half) & hi.cmpge(-half)).bitmask(),
        (lo.cmple(half) & hi.cmpge(half)).bitmask(),
    ];
    let mut near = 0;
    for i in 0..12 {
        let (along, first, second) = (i / 4, (i / 4 + 1) % 3, (i / 4 + 2) % 3);
        let within = spans >> along & sides[i & 1] >> first & sides[i >> 1 & 1] >> second & 1;
        near |= within << i;
    }
    near
}

/// Edge `i` of 12 of a cuboid: its ends and the normals of its faces.
pub(super) fn cuboid_edge(i: usize, half: DVec3) -> ([DVec3; 2], [DVec3; 2]) {
    let side = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let (along, first, second) = (i / 4, (i / 4 + 1) % 3, (i / 4 + 2) % 3);
    let normals = [axes[first] * side(0), axes[second] * side(1)];
    let middle = (normals[0] + normals[1]) * half;
    let reach = axes[along] * half;
    ([middle - reach, middle + reach], normals)
}

/// The meeting of a segment with an edge between faces of these normals.
fn cross([a, b]: [DVec3; 2], [p, q]: [DVec3; 2], normals: [DVec3; 2]) -> Option<(f64, DVec3, f64)> {
    let (d, u) = (b - a, q - p);
    let c = d.cross(u);
    let square = c.length_squared();
    // Parallel, or no numbers.
    let flat = square <= 1e-8 * d.length_squared() * u.length_squared();
    if flat || square.is_nan() {
        return None;
    }
    let t = (p - a).cross(u).dot(c) / square;
    let s = (p - a).cross(d).dot(c) / square;
    if !(t > 0.0 && t < 1.0 && (-1e-9..=1.0 + 1e-9).contains(&s)) {
        return None;
    }
    let n = between(c, normals)?;
    Some((t, n, (a + d * t - (p + u * s)).dot(n)))
}

/// The unit normal along `c`, outward; `None` unless it lies between those of the faces.
pub(super) fn between(c: DVec3, [first, second]: [DVec3; 2]) -> Option<DVec3> {
    let outward = c.dot(first + second);
    let n = c.try_normalize()? * 1.0_f64.copysign(outward);
    let (g, x, y) = (first.dot(second), n.dot(first), n.dot(second));
    // n = αn₁ + βn₂, for all three are perpendicular to the edge.
    let scale = 1.0 - g * g;
    (x - g * y >= -LEAN * scale && y - g * x >= -LEAN * scale && scale > 1e-6).then_some(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::geometry::SharedShape;

    fn crossings(shape: &SharedShape, a: [f64; 3], b: [f64; 3]) -> Vec<Crossing> {
        let mut found = Vec::new();
        let (a, b) = (DVec3::from_array(a), DVec3::from_array(b));
        Solid::of(&**shape)
            .unwrap()
            .for_each_crossing(a, b, 1.0, &mut |c| found.push(c));
        found
    }

    #[test]
    fn a_segment_flush_under_a_box_or_a_cylinder_crosses_its_lower_edges() {
        let box_of_20_cm = SharedShape::cuboid(0.1, 0.1, 0.1);
        let corners: Vec<_> = box_of_20_cm.as_cuboid().unwrap().to_trimesh().0;
        let hull = SharedShape::convex_hull(&corners).unwrap();
        for shape in [box_of_20_cm, hull, SharedShape::cylinder(0.1, 0.1)] {
            for gap in [-1e-6, 0.0, 1e-3] {
                let found = crossings(&shape, [-0.3, -0.1 - gap, 0.0], [0.3, -0.1 - gap, 0.0]);
                let low: Vec<_> = found.iter().filter(|c| c.normal.y < -0.99).collect();
                assert_eq!(low.len(), 2, "{found:?}");
                for c in low {
                    assert!((c.distance - gap).abs() < 1e-8, "{c:?}");
                    assert!((c.t - 1.0 / 3.0).abs() < 1e-7 || (c.t - 2.0 / 3.0).abs() < 1e-7);
                }
            }
        }
    }

    #[test]
    fn a_segment_across_an_edge_meets_it_along_both_perpendiculars() {
        let shape = SharedShape::cuboid(0.1, 0.1, 0.1);
        // Across the edge x = y = .1, a centimetre off.
        let off = 0.1 + 0.01 / 2.0_f64.sqrt();
        let found = crossings(
            &shape,
            [off - 0.05, off + 0.05, 0.02],
            [off + 0.05, off - 0.05, 0.02],
        );
        let near: Vec<_> = found.iter().filter(|c| c.distance.abs() < 0.05).collect();
        assert_eq!(near.len(), 1, "{found:?}");
        assert!((near[0].distance - 0.01).abs() < 1e-7 && (near[0].t - 0.5).abs() < 1e-6);
        assert!((near[0].normal - DVec3::new(1.0, 1.0, 0.0).normalize()).length() < 1e-6);
    }

    /// Past the ends of edges it is the corner that a grown box or a skin touches with.
    #[test]
    fn a_segment_past_a_round_corner_meets_it_where_no_edge_is_nearest() {
        let outward = DVec3::ONE.normalize();
        let along = DVec3::new(1.0, -1.0, 0.0).normalize();
        let middle = DVec3::splat(0.1) + outward * 0.03;
        let (a, b) = (middle - along * 0.05, middle + along * 0.15);
        let sharp = SharedShape::cuboid(0.1, 0.1, 0.1);
        let corners: Vec<_> = sharp.as_cuboid().unwrap().to_trimesh().0;
        let hull = SharedShape::round_convex_hull(&corners, 0.02).unwrap();
        let round = SharedShape::round_cuboid(0.1, 0.1, 0.1, 0.02);
        for (shape, radius) in [(sharp, 0.0), (round, 0.02), (hull, 0.02)] {
            assert!(crossings(&shape, a.into(), b.into()).is_empty());
            let solid = Solid::of(&*shape).unwrap();
            let mut found = Vec::new();
            solid.for_each_corner(a, b, 0.05, &mut |c| found.push(c));
            let [c] = found[..] else {
                panic!("{found:?}");
            };
            assert!((c.t - 0.25).abs() < 1e-6 && (c.distance - 0.03 + radius).abs() < 1e-6);
            assert!((c.normal - outward).length() < 1e-5, "{c:?}");
            // A centimetre beside, over a face and over an edge.
            for way in [DVec3::X, DVec3::new(1.0, 1.0, 0.0).normalize()] {
                let shift = DVec3::new(0.1, 0.1, 0.09) + way * 0.03 - middle;
                let (a, b) = (a + shift, b + shift);
                solid.for_each_corner(a, b, 0.05, &mut |c| found.push(c));
            }
            assert_eq!(found.len(), 1, "{found:?}");
        }
    }

    /// The bits are those of the boxes around the edges, tested one by one.
    #[test]
    fn edges_of_a_cuboid_that_are_near_are_known_by_their_bits() {
        let half = DVec3::new(0.3, 0.2, 0.1);
        let (mut some, mut seed) = (0, 1_u32);
        let mut number = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        for _ in 0..10_000 {
            let a = DVec3::new(number(), number(), number());
            let b = a + DVec3::new(number(), number(), number()) * 2.0;
            let (lo, hi) = (a.min(b), a.max(b));
            let near = cuboid_edges_near(half, lo, hi);
            for i in 0..12 {
                let ([p, q], _) = cuboid_edge(i, half);
                let apart = p.max(q).cmplt(lo) | p.min(q).cmpgt(hi);
                assert_eq!(near >> i & 1 == 1, !apart.any(), "edge {i}, {lo} to {hi}");
            }
            some += near.count_ones();
        }
        assert!(some > 1000, "{some}");
    }

    #[test]
    fn numbers_that_are_none_cross_nothing() {
        for shape in [
            SharedShape::cuboid(0.1, 0.1, 0.0),
            SharedShape::cylinder(0.0, 0.0),
            SharedShape::cone(0.0, 0.1),
        ] {
            for c in crossings(&shape, [f64::NAN; 3], [0.3, 0.0, 0.0]) {
                assert!(c.normal.is_finite());
            }
            for c in crossings(&shape, [0.0; 3], [0.0; 3]) {
                assert!(c.normal.is_finite());
            }
        }
    }
}
