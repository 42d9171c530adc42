//! Nodes near a solid, and their rows.

mod hollow;
mod rims;

use super::beside::SAME;
use super::cone::Pushed;
use super::distance::Solid;
use super::nodes::add;
use super::roll::Roll;
use super::site::Site;
use super::target::{Frame, Target};
use super::touches::{Hold, Key, Touch, Touches, along};
use super::watch::Watch;
use crate::body::state::State;
use crate::math::{DVec3, Real};
use crate::solve::rows::{Row, Rows};

/// The nodes of one body near one solid, and what is remembered of those that touch it.
#[derive(Clone, Debug, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct SolidNodes {
    /// Distances from the solid without its skin.
    nodes: Watch,
    touches: Touches,
}

impl SolidNodes {
    /// Forgets all distances, and which nodes touch.
    pub fn reset(&mut self) {
        self.nodes.reset();
        self.touches.forget();
    }

    /// A row for every node that can touch within the substep, after body and solid have moved by `way` m in all.
    pub fn add_rows(
        &mut self,
        solid: &Solid,
        (target, pair, have_features): (&Target, u32, bool),
        (frame, way): (&Frame, f64),
        site: &mut Site,
    ) {
        let Self { nodes, touches } = self;
        touches.begin();
        let count = site.side.state.particles.len();
        let roll = Roll::of(solid, frame, site.shadow);
        let reach = target.skin + site.reach.farthest;
        nodes.visit(count, way, (reach, site.reach.farthest), |i, _| {
            let place = frame.to_local(site.side.state, i);
            let found = solid.signed_distance(place);
            let mut making = Making {
                solid,
                target,
                pair,
                frame,
                roll,
                have_features,
                touches,
                site,
            };
            making.node(i, place, found);
            found.0
        });
    }

    /// The normal with which a node touched last.
    pub fn touched(&self, node: u32) -> Option<DVec3> {
        self.touches.normal([0, node, 0])
    }

    /// Remembers which nodes touch, after the rows have been solved.
    pub fn remember(&mut self, rows: &Rows, touching: f64) {
        self.touches.end(rows, touching);
    }

    /// Whether any node lies within `distance` m of the solid.
    pub fn any_within(
        &self,
        solid: &Solid,
        state: &State<Real>,
        (frame, way): (&Frame, f64),
        distance: f64,
    ) -> bool {
        let is_near = |i| solid.signed_distance(frame.to_local(state, i)).0 < distance;
        self.nodes.within(way, distance).any(is_near)
    }
}

/// The rows of nodes, in the making.
struct Making<'a, 's> {
    solid: &'a Solid,
    target: &'a Target,
    pair: u32,
    frame: &'a Frame,
    roll: Roll,
    /// Whether the faces and edges of the nodes have rows of their own.
    have_features: bool,
    touches: &'a mut Touches,
    site: &'a mut Site<'s>,
}

impl Making<'_, '_> {
    /// The rows of a node at a place of the collider's frame, at this distance and with this normal, if it can touch.
    fn node(&mut self, i: u32, place: DVec3, nearest: (f64, DVec3)) {
        if self.target.holds([i]) {
            return;
        }
        let first = self.nearest(i, place, nearest);
        if self.solid.is_hollow() {
            self.others(i, place, nearest, first);
        }
    }

    /// The row for what is nearest: its normal and how deep the node is, if it has got one.
    fn nearest(&mut self, i: u32, place: DVec3, nearest: (f64, DVec3)) -> Option<(f64, DVec3)> {
        let key = [0, i, 0];
        let last = self.touches.last(key).copied();
        let (distance, mut normal) = self.way_out(i, place, nearest, last);
        let Self {
            solid,
            target,
            frame,
            roll,
            have_features,
            ..
        } = *self;
        let mut depth = target.skin - distance;
        if depth < -self.site.reach.farthest {
            return None;
        }
        let (slip, gain) = self.motion(i, place);
        if depth < -self.site.reach.at(slip.length() + gain.length()) {
            return None;
        }
        let same_face = |touch: Touch| normal.dot(touch.normal) > PLANE;
        let is_shallow = depth <= self.site.reach.shallow();
        if have_features && is_shallow && !last.is_some_and(same_face) {
            let pushed = Pushed {
                place,
                normal,
                depth,
                skin: target.skin,
                touched: last.is_some(),
            };
            let around = || self.site.side.around(i, frame);
            let velocity = self.site.side.state.velocity(i as usize);
            let way = |point| self.site.way(velocity, frame, point);
            let turn = frame.axes.transpose() * roll.turn(self.site.reach.h);
            let motion = frame.axes.transpose() * (slip + gain) * self.site.reach.h;
            if pushed.lies_beside(solid, &self.site.reach, around, (way, turn))
                && !self.is_between(i, place, motion, (-depth, normal))
            {
                return None;
            }
        }
        let fresh = last.is_none_or(|touch| normal.dot(touch.normal) < SAME);
        if fresh && depth < self.site.reach.touching {
            let motion = frame.axes.transpose() * (slip + gain) * self.site.reach.h;
            if self.misses(i, place, motion, (-depth, normal)) {
                return None;
            }
        }
        if depth > 0.0
            && let Some(touch) = last.filter(|touch| normal.dot(touch.normal) < 0.0)
            && let Some(back) = self.back(place, slip, &touch)
        {
            (depth, normal) = back;
        }
        self.add((key, last), place, (depth, normal));
        Some((depth, normal))
    }

    /// How deep a node is along the normal of its last touch, and that, while it is still inside there: squeezed past the middle of a thin
    /// solid it goes back to where it came from.
    fn back(&self, place: DVec3, slip: DVec3, touch: &Touch) -> Option<(f64, DVec3)> {
        let depth = self.target.skin + self.solid.depth_along(place, touch.normal)?;
        let into = -slip.dot(self.frame.axes * touch.normal);
        // What is hollow goes on behind what was touched.
        let is_it = || depth <= touch.depth + self.site.reach.come(into);
        (!self.solid.is_hollow() || is_it()).then_some((depth, touch.normal))
    }

    /// How fast a node moves over the solid, and by how much forces will change that within the substep \[m/s\].
    fn motion(&self, i: u32, place: DVec3) -> (DVec3, DVec3) {
        let Self { frame, site, .. } = self;
        let arm = frame.axes * place + (frame.position - site.shadow.com);
        let slip = site.side.state.velocity(i as usize) - site.shadow.velocity_at(arm);
        (slip, site.side.gain(i, site.reach.h))
    }

    /// Adds the row of a node that is so deep under a face; `last` is what is known of it by this key.
    fn add(
        &mut self,
        (key, last): (Key, Option<Touch>),
        place: DVec3,
        (depth, normal): (f64, DVec3),
    ) {
        let Self {
            target,
            frame,
            roll,
            ..
        } = *self;
        let arm = frame.axes * place + (frame.position - self.site.shadow.com);
        // What has not arrived yet is held where it will: on an edge the way there is none along the surface of the next
        // substep.
        let arrives = depth < -self.site.reach.touching;
        let hold = last.and_then(|touch| touch.hold).unwrap_or(Hold {
            weights: [1.0, 0.0, 0.0, 0.0],
            anchor: place + normal * if arrives { depth } else { 0.0 },
            drift: DVec3::ZERO,
        });
        self.touches
            .found(key, self.site.rows.contacts.len(), normal, hold);
        let (normal_impulse, friction_impulse) =
            last.map_or(Default::default(), |touch| touch.impulse);
        let outward = frame.axes * normal;
        let row = Row {
            normal: outward,
            depth,
            arm,
            turn: roll.under_node(outward, arm),
            normal_impulse,
            friction_impulse,
            drift: frame.axes * along(place - hold.anchor, normal),
            ..target.row(Default::default(), self.pair, self.site.reach.h)
        };
        add(key[1], target, row, self.site);
    }
}

/// Cosine of an angle within which two normals are of one flat face.
const PLANE: f64 = 1.0 - 1e-12;

/// Whether any of the points, given with their velocities in the solid's frame, meets the solid faster than `threshold` m/s
/// within `time` s, being `skin` m thick.
pub fn is_hit(
    solid: &Solid,
    mut points: impl Iterator<Item = (DVec3, DVec3)>,
    skin: f64,
    time: f64,
    threshold: f64,
) -> bool {
    points.any(|(p, v)| {
        // Most nodes of a body at rest end here.
        if v.length_squared() < threshold * threshold {
            return false;
        }
        let (distance, normal) = solid.signed_distance(p);
        let closing = |normal: DVec3| -v.dot(normal);
        let is_fast = |normal: DVec3| closing(normal) > threshold;
        // Along what is nearest it may come to something else.
        let comes_to = || solid.cast(p, p + v * time);
        is_fast(normal) && distance < skin + closing(normal) * time
            || solid.is_hollow() && comes_to().is_some_and(|(_, normal)| is_fast(normal))
    })
}
