//! The rows of faces and edges of one body against points and edges of a target.

use super::meet::ALIKE;
use super::patch::{Foot, Patch};
use crate::contact::beside::SAME;
use crate::contact::nodes::Nodes;
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
    /// Where the point is \[m\].
    pub place: DVec3,
    pub normal: DVec3,
    depth: f64,
    /// How much deeper it is than what may have come from outside within the substep \[m\].
    excess: f64,
    pub lie: Lie,
    /// Whether what the point belongs to is cut by the face.
    pub cuts: bool,
    /// Whether the point gets a row for this face.
    bears: bool,
}

/// How a point lies to a face that it meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Lie {
    /// Over or under it.
    Over,
    /// Beside it and over no other, its foot on the border.
    Beside,
    /// Past its border, in a crease that it makes with the next face.
    Past,
}

/// How near the border of a face or the end of an edge counts as on it, in distances that count as touching.
pub const BORDER: f64 = 10.0;

impl Met {
    /// Whether the point is on the border of this face, within `width` m, and well within another one that looks elsewhere: what
    /// slides over a ridge does not meet it with its side. In a fold the point bears on both.
    fn yields_to(&self, other: &Self, width: f64) -> bool {
        other.is_shallow()
            && other.lie == Lie::Over
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
    /// Those of the body by which its faces and edges know on which side of a surface they are.
    pub nodes: Option<&'a Nodes>,
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

    /// How a point lies to a face, and its foot there.
    pub(super) fn foot(&self, patch: &Patch, point: DVec3) -> Option<(Lie, Foot)> {
        if let Some(foot) = patch.foot(point) {
            return Some((Lie::Over, foot));
        }
        let foot = patch.foot_on_border(point)?;
        let square = foot.point.distance_squared(point);
        let height = (point - foot.point).dot(foot.normal);
        // Under the crease between two faces that bend away from it, a point is over neither.
        if self.deep && square <= 2.0 * height * height {
            return Some((Lie::Beside, foot));
        }
        let near = self.skin + self.site.reach.farthest;
        (square <= near * near).then_some((Lie::Past, foot))
    }

    /// A point that comes down on a face, or lies beside it, by its number and place, if it may touch; `outward` is the normal at
    /// the foot, away from the body.
    pub(super) fn over(
        &self,
        (number, point): (u32, DVec3),
        (face, patch): (u32, &Patch),
        (lie, foot, outward): (Lie, &Foot, DVec3),
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
            place: point,
            normal: -outward,
            depth,
            excess: depth - come,
            lie,
            cuts: false,
            bears: false,
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
            let mut met = met.filter(|m| m.lie != Lie::Past);
            met.any(|m| m.is_shallow() || self.touches.touched([p, point, m.face]))
        };
        self.touches.known(p).any(|[_, point, _]| !is_met(point))
    }

    /// The rows of one point. A point that is deep below a face has come in through another one, unless it was known to touch,
    /// about as deep; then it leaves by the nearest. Points of `rims` are others for every face: this one is known where any
    /// touched a face that looks about the same way; over no face, it is beside a body and not as deep in it as it seems.
    pub(super) fn point(&mut self, p: u32, met: &mut [Met], rims: bool) {
        let width = BORDER * self.site.reach.touching;
        for i in 0..met.len() {
            let m = &met[i];
            let touches = m.is_shallow() || self.touches.touched([p, m.point, m.face]);
            let over = m.lie == Lie::Over && touches;
            met[i].bears = over && !met.iter().any(|other| met[i].yields_to(other, width));
        }
        let deepest = self.touches.deepest([p, met[0].point]);
        if !met.iter().any(|m| m.bears) {
            let alone = |m: &Met| m.lie != Lie::Past || met.iter().any(|o| self.are_crease(m, o));
            let all = (0..met.len()).filter(|&i| alone(&met[i]));
            let nearest = all.min_by(|&i, &k| met[i].depth.total_cmp(&met[k].depth));
            let (Some(deepest), Some(nearest)) = (deepest, nearest) else {
                return;
            };
            let m = &met[nearest];
            let on_rim = |[part, ..]: Key| rims && part == p;
            let alike = self.touches.deepest_along(m.normal, ALIKE, on_rim);
            let as_deep = |before: f64| m.excess <= before;
            let on_rim = alike.is_some_and(|before| m.lie == Lie::Over || as_deep(before));
            if !as_deep(deepest) && !on_rim {
                return;
            }
            met[nearest].bears = true;
        }
        // From face to face round a node.
        let bears_too = |met: &[Met]| {
            met.iter().position(|m| {
                let as_deep = m.is_shallow() || deepest.is_some_and(|before| m.excess <= before);
                let mut bearing = met.iter().filter(|other| other.bears);
                let open = !m.bears && m.lie != Lie::Over && as_deep;
                open && bearing.any(|other| self.are_crease(m, other))
            })
        };
        while let Some(i) = bears_too(met) {
            met[i].bears = true;
        }
        for m in met.iter().filter(|m| m.bears) {
            self.add_met(p, m);
        }
    }

    /// Whether two faces make a crease in which the point lies that has met both: it bears on both, though it is past the border of
    /// one.
    fn are_crease(&self, a: &Met, b: &Met) -> bool {
        let faces = &self.site.side.topology.faces;
        let [of_a, of_b] = [a, b].map(|met| faces[met.face as usize].nodes());
        of_a.iter().filter(|node| of_b.contains(node)).count() == 2
            && a.normal.dot(b.normal) < SAME
            && !a.is_ridge_with(b)
            && !b.is_ridge_with(a)
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

    /// How far from the part a face or an edge may be and still touch it within the substep \[m\]; `None` if it is `apart` m away at least
    /// and that is farther. What is `known` to touch is looked for as far as anything goes.
    pub(super) fn reach_of(
        &self,
        known: bool,
        apart: f64,
        (nodes, corners): (&[u32], &[DVec3]),
    ) -> Option<f64> {
        if known {
            return Some(self.near);
        }
        if apart > self.near {
            return None;
        }
        let reach = self.reach(nodes, corners).min(self.near);
        (apart <= reach).then_some(reach)
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

    /// The row of a point, unless the collider's body holds all that would bear it.
    pub(super) fn add(&mut self, key: Key, point: Point) {
        let bearing = point.nodes.iter().zip(point.weights);
        let bearing = bearing.filter(|(_, weight)| *weight != 0.0);
        if self.target.holds(bearing.map(|(node, _)| *node)) {
            return;
        }
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
