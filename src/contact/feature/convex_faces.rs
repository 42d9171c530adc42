//! A face of one body against the corners, round sides and edges of a convex part of a solid.

use super::bulge::{self, Ridge};
use super::making::{Lie, Making, Met};
use super::part::Convex;
use super::patch::{Foot, Patch};
use super::recall::Recall;
use crate::contact::closest::bounds;
use crate::contact::cone::can_push;
use crate::math::DVec3;

/// A point of a part that meets a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenPoint {
    point: u32,
    /// In the frame of the part \[m\].
    place: DVec3,
    lie: Lie,
    /// On which side of the face it is: 1 on that of its normal, −1 on the other.
    side: f64,
}

impl Making<'_, '_> {
    /// Collects the points of the part that meet a face. Of a closed surface the outside is that of its winding; of an open
    /// one the side on which the middle of the part is. Returns how far the face is from any, or less \[m\].
    pub(super) fn meet(
        &self,
        part: &Convex,
        (p, f, bound): (u32, u32, f64),
        seen: &mut Recall<SeenPoint>,
        points: &mut Vec<DVec3>,
        met: &mut Vec<Met>,
    ) -> f64 {
        if self.site.side.topology.torn.face(f) {
            return f64::INFINITY;
        }
        let nodes = self.site.side.topology.faces[f as usize].nodes();
        let patch = Patch::new(self.corners(nodes));
        if let Some(apart) = self.meet_again(part, [p, f], &patch, seen, met) {
            return apart;
        }
        let before = met.len();
        let apart = self.meet_anew(part, (p, f, bound), (nodes, &patch), points, met);
        let found = &met[before..];
        // Points of what is round, or where a face bulges, are others in every substep.
        let stays = |m: &Met| part.solid.is_sharp() && (m.point as usize) < points.len();
        if found.iter().all(stays)
            && let Some(n) = patch.normal()
        {
            let point = |m: &Met| SeenPoint {
                point: m.point,
                place: m.place,
                lie: m.lie,
                side: -1.0_f64.copysign(m.normal.dot(n)),
            };
            seen.note(
                [p, f],
                patch.corners(),
                (apart, self.near),
                found.iter().map(point),
            );
        }
        apart
    }

    /// The points that a face which has not moved has met before; `None` where it must be looked at anew.
    fn meet_again(
        &self,
        part: &Convex,
        key: [u32; 2],
        patch: &Patch,
        seen: &mut Recall<SeenPoint>,
        met: &mut Vec<Met>,
    ) -> Option<f64> {
        let (apart, points) = seen.of(key, patch.corners())?;
        let [p, f] = key;
        let before = met.len();
        for seen in points {
            let found = || {
                let (lie, foot) = self.foot(patch, seen.place)?;
                let at = (lie, &foot, foot.normal * seen.side);
                let point = (seen.point, seen.place);
                let mut found = self.over(point, (f, patch), at, self.deepest_point())?;
                found.cuts = self.is_cut(part, p, patch, &found);
                (lie == seen.lie).then_some(found)
            };
            let Some(found) = found() else {
                met.truncate(before);
                return None;
            };
            met.push(found);
        }
        seen.go_on();
        Some(apart)
    }

    fn meet_anew(
        &self,
        part: &Convex,
        (p, f, bound): (u32, u32, f64),
        (nodes, patch): (&[u32], &Patch),
        points: &mut Vec<DVec3>,
        met: &mut Vec<Met>,
    ) -> f64 {
        points.clear();
        let topology = self.site.side.topology;
        let off = Off::of(part, patch, topology.spacing);
        let apart = off.apart.max(bound);
        let knows = self.touches.knows_last(p, f);
        let Some(reach) = self.reach_of(knows, apart, (nodes, patch.corners())) else {
            return apart;
        };
        let (middle, radius) = patch.ball();
        let away = part.away(middle, patch.corners());
        if away > reach {
            return apart.max(away);
        }
        let Some(mut n) = patch.normal() else {
            return apart;
        };
        let bulges = off.flat_for <= 0.0;
        let ridge = |n| bulges.then(|| Ridge::of(patch, n, topology.spacing))?;
        if off.points > self.near && !knows && ridge(n).is_none() {
            return apart;
        }
        let known = self.side(part, p, (nodes, patch, n));
        if known.unwrap_or_else(|| (part.centre - middle).dot(n)) < 0.0 {
            if topology.closed {
                return apart;
            }
            n = -n;
        }
        part.solid.feature_points(n, points);
        let facing = Facing {
            part,
            key: [p, f],
            patch,
            around: (middle, radius + self.near.max(self.deepest_point())),
            normal: n,
            told: known.is_some() || topology.closed,
            cone: points,
        };
        let before = met.len();
        let all = (0..).zip(points.iter().copied());
        let radius = part.solid.edge_radius();
        met.extend(all.filter_map(|point| self.meet_point(&facing, point, point.1 + n * radius)));
        let lowest = patch.lowest(points, n);
        if lowest < self.near
            && let Some(ridge) = ridge(n)
        {
            ridge.lowest_of(&part.solid, self.near, points, &mut |point, core| {
                met.extend(self.meet_point(&facing, point, core));
            });
        }
        if met.len() > before {
            // What touches may be deeper next time.
            return 0.0;
        }
        if part.solid.has_rim() {
            // The other points of a rim are as high over all corners.
            return apart.max(lowest);
        }
        // Lines may be nearer than their ends to a face that bulges, but no nearer than all that is.
        let most = off.flat_for.max(away);
        if most <= apart {
            return apart;
        }
        apart.max(facing.off_points().min(most))
    }

    /// A point of the part, by its number and place, that has grown from `core`, if it meets a face.
    fn meet_point(&self, facing: &Facing, (i, point): (u32, DVec3), core: DVec3) -> Option<Met> {
        let (patch, n, [p, f]) = (facing.patch, facing.normal, facing.key);
        // Bounds first: most points are far from most faces.
        let (middle, most) = facing.around;
        if point.distance_squared(middle) > most * most {
            return None;
        }
        let height = (point - patch.corners()[0]).dot(n);
        if height > self.skin + self.site.reach.farthest + self.site.side.topology.spacing {
            return None;
        }
        let away = facing.cone.iter();
        let away = away.map(|other| (*other - point).normalize_or_zero());
        let (point, lie, foot, outward) = match self.foot_of_grown(facing, core) {
            Some((point, foot, outward)) => (point, Lie::Over, foot, outward),
            None => {
                let (lie, foot) = self.foot(patch, point)?;
                if lie == Lie::Past && !facing.told {
                    return None;
                }
                // What is beside a face may be below it without having come through: past a ridge, its points tell.
                let out = if facing.told || patch.is_between(point, facing.part.centre) {
                    n
                } else {
                    point - foot.point
                };
                let outward = foot.normal * 1.0_f64.copysign(foot.normal.dot(out));
                (point, lie, foot, outward)
            }
        };
        if !can_push(away, -outward, self.touches.touched([p, i, f])) {
            return None;
        }
        let at = (lie, &foot, outward);
        let mut found = self.over((i, point), (f, patch), at, self.deepest_point())?;
        found.cuts = self.is_cut(facing.part, p, patch, &found);
        (!self.is_internal_corner(facing.part, point, -n)).then_some(found)
    }

    /// Whether the part is cut by a face of a sheet that lies between one of its points and its middle: what touched that has
    /// come there since, whichever way.
    fn is_cut(&self, part: &Convex, p: u32, patch: &Patch, met: &Met) -> bool {
        !self.site.side.topology.closed
            && met.lie == Lie::Over
            && met.is_deep()
            && self.touches.known(p).next().is_some()
            && patch.is_between(met.place, part.centre)
    }

    /// Where a ball about a place of a part, from which that is grown, touches a twisted face, the foot there and the normal towards it: not
    /// where it would if the normal was that of the middle of the face.
    fn foot_of_grown(&self, facing: &Facing, core: DVec3) -> Option<(DVec3, Foot, DVec3)> {
        let radius = facing.part.solid.edge_radius();
        // How much deeper that place may be.
        let dip = 0.5 * radius * facing.patch.twist().powi(2);
        if dip < self.site.reach.touching {
            return None;
        }
        let foot = facing.patch.foot_of_ball(core)?;
        let outward = foot.normal * 1.0_f64.copysign(foot.normal.dot(facing.normal));
        Some((core - outward * radius, foot, outward))
    }

    /// On which side of a face the part is, along the normal at its middle: where it was when it last touched this face or one
    /// beside it, or else where its centre is, if that is over the face, or else where other parts were.
    fn side(
        &self,
        part: &Convex,
        p: u32,
        (nodes, patch, n): (&[u32], &Patch, DVec3),
    ) -> Option<f64> {
        let last = |own: bool| self.last_side(nodes, n, |[part, ..]| (part == p) == own);
        let over = || {
            let foot = patch.foot(part.centre)?;
            Some((part.centre - foot.point).dot(n))
        };
        last(true).or_else(over).or_else(|| last(false))
    }
}

/// How far a face is from a part, or less, by their boxes \[m\].
struct Off {
    /// From its points.
    points: f64,
    /// From where it bulges, see [`bulge::flat_for`].
    flat_for: f64,
    /// From anything that it may meet.
    apart: f64,
}

impl Off {
    fn of(part: &Convex, patch: &Patch, spacing: f64) -> Self {
        let (lo, hi) = bounds(patch.corners().iter().copied());
        let points = part.solid.points_apart(lo, hi);
        // Between its edges a face meets nothing but points before it bulges.
        let flat_for = bulge::flat_for(&part.solid, patch, spacing);
        let apart = if flat_for < points {
            points.min(part.solid.edges_apart(lo, hi).max(flat_for))
        } else {
            points
        };
        Self {
            points,
            flat_for,
            apart,
        }
    }
}

/// A face that the part may meet.
struct Facing<'a> {
    part: &'a Convex,
    /// Of part and face.
    key: [u32; 2],
    patch: &'a Patch,
    /// A ball that holds all points that matter \[m\].
    around: (DVec3, f64),
    /// Of its middle, towards the part.
    normal: DVec3,
    /// Whether that is known for sure.
    told: bool,
    /// The points of the part.
    cone: &'a [DVec3],
}

impl Facing<'_> {
    /// How far the face is from the points of the part, or less \[m\].
    fn off_points(&self) -> f64 {
        // Grown points turn with the face, those they have grown from do not.
        let radius = self.part.solid.edge_radius();
        let far = |&point: &DVec3| self.patch.apart(point + self.normal * radius);
        self.cone.iter().map(far).fold(f64::INFINITY, f64::min) - radius
    }
}
