//! The rows of faces and edges of one body against points and edges of a target.

use super::meet::ALIKE;
use super::patch::{Foot, Patch};
use crate::contact::beside::SAME;
use crate::contact::roll::Roll;
use crate::contact::site::Site;
use crate::contact::target::{Frame, Target};
use crate::contact::touches::{Hold, Key, Touches, along};
use crate::math::DVec3;
use crate::solve::rows::Row;

/// A point of a target over or under a face of the deformable, in the target's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub point: u32,
    pub face: u32,
    weights: [f64; 4],
    patch: Patch,
    normal: DVec3,
    depth: f64,
    /// How much deeper it is than what may have come from outside within the substep \[m\].
    excess: f64,
    /// Whether the point is over no face, and this is the foot on the border of one.
    beside: bool,
    /// Whether what the point belongs to is cut by the face.
    pub cuts: bool,
}

/// How near the border of a face or the end of an edge counts as on it, in distances that count as touching.
pub const BORDER: f64 = 10.0;

impl Met {
    /// Whether the point is on the border of this face, within `width` m, and well within another one that looks elsewhere: what
    /// slides over a ridge does not meet it with its side. In a fold the point bears on both.
    fn yields_to(&self, other: &Self, width: f64) -> bool {
        other.is_shallow()
            && !other.beside
            && self.normal.dot(other.normal) < SAME
            && self.is_ridge_with(other)
            && self.inset() < width
            && self.inset() < other.inset()
    }

    /// Whether the other face goes on behind this one, as seen from the point.
    fn is_ridge_with(&self, other: &Self) -> bool {
        let [own, far] = [self, other].map(|met| {
            let corners = met.patch.corners();
            corners.iter().sum::<DVec3>() / corners.len() as f64
        });
        (far - own).dot(self.normal) > 0.0
    }

    /// Whether it may have come from outside within the substep, or must have at some time.
    fn is_shallow(&self) -> bool {
        !self.is_deep() || self.cuts
    }

    /// Whether it is deeper than what may have come from outside within the substep.
    pub fn is_deep(&self) -> bool {
        self.excess > 0.0
    }

    /// A length that goes to zero at the border \[m\].
    fn inset(&self) -> f64 {
        let corners = self.patch.corners();
        let side = corners[0].distance(corners[1]);
        let n = corners.len();
        // The weights of two neighbours are left at a side.
        let sides = (0..n).map(|i| 1.0 - self.weights[i] - self.weights[(i + 1) % n]);
        side * sides.fold(f64::INFINITY, f64::min)
    }
}

/// The rows of faces or edges in the making.
pub(super) struct Making<'a, 's> {
    pub target: &'a Target,
    pub pair: u32,
    /// Of the part of the target that is looked at.
    pub frame: Frame,
    /// Distance that is kept from it \[m\].
    pub skin: f64,
    /// How it turns, and by how much it is grown \[m\].
    pub roll: Roll,
    pub radius: f64,
    pub site: &'a mut Site<'s>,
    pub touches: &'a mut Touches,
    /// How far anything can be from what is sharp and still matter \[m\].
    pub near: f64,
    /// Whether points that are known to touch are looked for wherever they may be, however slow things are.
    pub deep: bool,
}

/// A point of a face or an edge that meets the target, in its frame.
pub(super) struct Point<'a> {
    nodes: &'a [u32],
    corners: &'a [DVec3],
    weights: [f64; 4],
    normal: DVec3,
    depth: f64,
}

impl Making<'_, '_> {
    /// The corners of a face or an edge \[m\].
    pub(super) fn corners<'n>(
        &self,
        nodes: &'n [u32],
    ) -> impl ExactSizeIterator<Item = DVec3> + use<'_, 'n> {
        let (frame, state) = (self.frame, self.site.side.state);
        nodes.iter().map(move |&i| frame.to_local(state, i))
    }

    /// The ends of an edge \[m\].
    pub(super) fn ends(&self, nodes: &[u32; 2]) -> [DVec3; 2] {
        nodes.map(|i| self.frame.to_local(self.site.side.state, i))
    }

    /// The foot of a point on a face, and whether it is that on its border, which is looked for where points that were known to
    /// touch are over no face.
    pub(super) fn foot(&self, patch: &Patch, point: DVec3) -> (bool, Option<Foot>) {
        let over = patch.foot(point);
        if over.is_some() || !self.deep {
            return (false, over);
        }
        (true, patch.foot_on_border(point))
    }

    /// A point that comes down on a face, or `beside` it, by its number and place, if it may touch; `outward` is the normal at
    /// the foot, away from the body.
    pub(super) fn over(
        &self,
        (number, point): (u32, DVec3),
        (face, patch): (u32, &Patch),
        (beside, foot, outward): (bool, &Foot, DVec3),
        deepest: f64,
    ) -> Option<Met> {
        let depth = self.skin - (point - foot.point).dot(outward);
        let nodes = self.site.side.topology.faces[face as usize].nodes();
        let [reach, come] = self.closing(nodes, patch.corners(), &foot.weights, -outward);
        (depth >= -reach && depth <= deepest).then_some(Met {
            point: number,
            face,
            weights: foot.weights,
            patch: *patch,
            normal: -outward,
            depth,
            excess: depth - come,
            beside,
            cuts: false,
        })
    }

    /// The point of an edge of the deformable that meets one of the target at `t` of its length, unless it is too far for a row or, for
    /// what is not `known` to touch, too deep.
    pub(super) fn across<'a>(
        &self,
        known: bool,
        (nodes, corners): (&'a [u32; 2], &'a [DVec3; 2]),
        (t, normal, distance): (f64, DVec3, f64),
        deepest: f64,
    ) -> Option<Point<'a>> {
        let depth = self.skin - distance;
        if depth < -self.site.reach.farthest || depth > deepest {
            return None;
        }
        let weights = [1.0 - t, t, 0.0, 0.0];
        let [reach, come] = self.closing(nodes, corners, &weights, normal);
        (depth >= -reach && (known || depth <= come)).then_some(Point {
            nodes,
            corners,
            weights,
            normal,
            depth,
        })
    }

    /// How deep a point can be behind a face and still belong to it \[m\].
    pub(super) fn deepest_point(&self) -> f64 {
        self.skin + 0.5 * self.site.side.topology.spacing
    }

    /// Whether a point that touched last has not been met where it may get a row; those met are in ascending order.
    pub(super) fn misses_some(&self, p: u32, met: &[Met]) -> bool {
        let is_met = |point: u32| {
            let met = &met[met.partition_point(|m| m.point < point)..];
            let met = met.iter().take_while(|m| m.point == point);
            let mut met = met.map(|m| m.is_shallow() || self.touches.touched([p, point, m.face]));
            met.any(|is| is)
        };
        self.touches.known(p).any(|[_, point, _]| !is_met(point))
    }

    /// The rows of one point. A point that is deep below a face has come in through another one, unless it was known to touch,
    /// about as deep; then it leaves by the nearest. Points of `rims` are others for every face: this one is known where any
    /// touched a face that looks about the same way; over no face, it is beside a body and not as deep in it as it seems.
    pub(super) fn point(&mut self, p: u32, met: &[Met], rims: bool) {
        let mut any = false;
        for m in met.iter().filter(|m| !m.beside) {
            if met
                .iter()
                .any(|other| m.yields_to(other, BORDER * self.site.reach.touching))
            {
                continue;
            }
            if m.is_shallow() || self.touches.touched([p, m.point, m.face]) {
                any = true;
                self.add_met(p, m);
            }
        }
        if any {
            return;
        }
        if let Some(deepest) = self.touches.deepest([p, met[0].point])
            && let Some(nearest) = met.iter().min_by(|a, b| a.depth.total_cmp(&b.depth))
        {
            let on_rim = |[part, ..]: Key| rims && part == p;
            let alike = self.touches.deepest_along(nearest.normal, ALIKE, on_rim);
            let as_deep = |before: f64| nearest.excess <= before;
            if as_deep(deepest) || alike.is_some_and(|before| !nearest.beside || as_deep(before)) {
                self.add_met(p, nearest);
            }
        }
    }

    fn add_met(&mut self, p: u32, m: &Met) {
        let point = Point {
            nodes: self.site.side.topology.faces[m.face as usize].nodes(),
            corners: m.patch.corners(),
            weights: m.weights,
            normal: m.normal,
            depth: m.depth,
        };
        self.add([p, m.point, m.face], point);
    }

    /// From how far a point of the deformable can touch within the substep, and how deep it can have come within the last one,
    /// `normal` being that of its row \[m\].
    fn closing(
        &self,
        nodes: &[u32],
        corners: &[DVec3],
        weights: &[f64; 4],
        normal: DVec3,
    ) -> [f64; 2] {
        let arm = self.arm(weigh(weights, corners.iter().copied()));
        let state = self.site.side.state;
        let velocities = nodes.iter().map(|&i| state.velocity(i as usize));
        let slip = weigh(weights, velocities) - self.site.shadow.velocity_at(arm);
        let into = -slip.dot(self.frame.axes * normal);
        let reach = self.site.reach;
        [reach.at(slip.length()), reach.come(into)]
    }

    /// From what distance on no point of a face or an edge can touch within the substep \[m\]: none moves faster relative to the
    /// collider than the fastest corner does.
    pub(super) fn reach(&self, nodes: &[u32], corners: &[DVec3]) -> f64 {
        if self.deep {
            return self.near;
        }
        let Site { side, shadow, .. } = &*self.site;
        let relative = |(&node, &corner): (&u32, &DVec3)| {
            let velocity = side.state.velocity(node as usize);
            (velocity - shadow.velocity_at(self.arm(corner))).length_squared()
        };
        let squared = nodes.iter().zip(corners).map(relative);
        let fastest = squared.fold(0.0, f64::max).sqrt();
        self.skin + self.site.reach.at(fastest)
    }

    /// From the collider's centre of mass to a point of the frame \[m\].
    fn arm(&self, point: DVec3) -> DVec3 {
        self.frame.axes * point + (self.frame.position - self.site.shadow.com)
    }

    /// The row of a point.
    pub(super) fn add(&mut self, key: Key, point: Point) {
        // Both sides take the impulse at one point, that of the deformable, or angular momentum would be lost.
        let touched = weigh(&point.weights, point.corners.iter().copied());
        let arm = self.arm(touched);
        let corners = || point.corners.iter().copied();
        let last = self.touches.last(key);
        let held = last.and_then(|touch| touch.hold);
        let (normal_impulse, friction_impulse) =
            last.map_or(Default::default(), |touch| touch.impulse);
        let drift = held.map_or(DVec3::ZERO, |h| {
            h.drift + weigh(&h.weights, corners()) - h.anchor
        });
        let hold = Hold {
            weights: point.weights,
            anchor: touched,
            drift,
        };
        let Site {
            side,
            slots,
            rows,
            reach,
            ..
        } = &mut *self.site;
        self.touches
            .found(key, rows.contacts.len(), point.normal, hold);
        let first = rows.terms.len();
        for (&i, weight) in point.nodes.iter().zip(point.weights) {
            let part = (weight, self.target.node_share, None);
            side.carrier.add_terms(i, part, slots, rows);
        }
        let terms = rows.merge_terms_since(first, None);
        let normal = self.frame.axes * point.normal;
        rows.contacts.push(Row {
            normal,
            depth: point.depth,
            normal_impulse,
            friction_impulse,
            arm,
            turn: self.roll.under_face(normal, arm - normal * self.radius),
            drift: self.frame.axes * along(drift, point.normal),
            ..self.target.row(terms, self.pair, reach.h)
        });
    }
}

fn weigh(weights: &[f64; 4], values: impl Iterator<Item = DVec3>) -> DVec3 {
    values.zip(weights).map(|(v, w)| v * *w).sum()
}
