//! Nodes near a solid, and their rows.

use super::distance::Solid;
use super::nodes::add;
use super::site::{Reach, Site};
use super::target::{Frame, Target};
use super::touches::{Hold, Touches, along};
use crate::body::state::State;
use crate::math::{DVec3, Real};
use crate::solve::rows::{Row, Rows};

/// The nodes of one body near one solid, and what is remembered of those that touch it.
#[derive(Clone, Debug)]
pub struct SolidNodes {
    /// In ascending order.
    near: Vec<u32>,
    /// How far things may still move before the list is stale \[m\].
    budget: f64,
    touches: Touches,
}

impl Default for SolidNodes {
    fn default() -> Self {
        Self {
            near: Vec::new(),
            budget: -1.0,
            touches: Touches::default(),
        }
    }
}

impl SolidNodes {
    /// Uses up the budget by what has moved \[m\] besides the substeps.
    pub fn spend(&mut self, moved: f64) {
        self.budget -= moved;
    }

    /// Forgets which nodes touch.
    pub fn forget(&mut self) {
        self.touches.forget();
    }

    /// Makes the list anew when it might lack a node within `farthest` m; see [`super::nodes::Nodes::refresh`].
    pub fn refresh(
        &mut self,
        (solid, skin): (&Solid, f64),
        state: &State<Real>,
        frame: &Frame,
        moved: f64,
        farthest: f64,
    ) {
        self.budget -= moved;
        if self.budget >= farthest {
            return;
        }
        let margin = 4.0 * farthest + 100.0 * moved;
        self.budget = margin;
        self.near.clear();
        let near = |i: &u32| solid.signed_distance(frame.to_local(state, *i)).0 < skin + margin;
        self.near
            .extend((0..state.particles.len() as u32).filter(near));
    }

    /// A row for every node that can touch within the substep.
    pub fn add_rows(
        &mut self,
        solid: &Solid,
        (target, pair): (&Target, u32),
        frame: &Frame,
        site: &mut Site,
    ) {
        self.touches.begin();
        for &i in &self.near {
            let place = frame.to_local(site.side.state, i);
            let (distance, mut normal) = solid.signed_distance(place);
            let mut depth = target.skin - distance;
            // A bound first: most candidates are farther off than anything can go in a substep.
            if depth < -site.reach.farthest {
                continue;
            }
            let arm = frame.axes * place + (frame.position - site.shadow.com);
            let slip = site.side.state.velocity(i as usize) - site.shadow.velocity_at(arm);
            if depth < -site.reach.at(slip.length()) {
                continue;
            }
            let key = [0, i, 0];
            let last = self.touches.last(key);
            let fresh = last.is_none_or(|(before, _)| normal.dot(before) < SAME);
            if fresh && depth < site.reach.touching {
                let motion = frame.axes.transpose() * slip * site.reach.h;
                if misses(solid, place, motion, -depth, normal, &site.reach) {
                    continue;
                }
            }
            if let Some((before, _)) = last
                && depth > 0.0
                && normal.dot(before) < 0.0
                && let Some(back) = solid.depth_along(place, before)
            {
                // Squeezed past the middle of a thin solid: it goes back to where it came from.
                (depth, normal) = (target.skin + back, before);
            }
            let hold = last.and_then(|(_, hold)| hold).unwrap_or(Hold {
                weights: [1.0, 0.0, 0.0, 0.0],
                anchor: place,
                drift: DVec3::ZERO,
            });
            self.touches
                .found(key, site.rows.contacts.len(), normal, hold);
            let row = Row {
                normal: frame.axes * normal,
                depth,
                arm,
                drift: frame.axes * along(place - hold.anchor, normal),
                ..target.row(Default::default(), pair, site.reach.h)
            };
            add(i, target, row, site);
        }
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
        frame: &Frame,
        distance: f64,
    ) -> bool {
        self.near
            .iter()
            .any(|&i| solid.signed_distance(frame.to_local(state, i)).0 < distance)
    }
}

/// Cosine of an angle within which two normals are of one face.
const SAME: f64 = 0.7;

/// Whether a node that would go through the tangent plane of the nearest point, `gap` m away, goes past the solid instead, or
/// over its edge: a plane has no end, but a plate has, and a node that slides over a joint between two boxes, a nanometre
/// too low, does not meet the side of the next one.
fn misses(
    solid: &Solid,
    place: DVec3,
    motion: DVec3,
    gap: f64,
    normal: DVec3,
    reach: &Reach,
) -> bool {
    let length = motion.length();
    if length <= 0.0 || length.is_nan() {
        return false;
    }
    let way = motion * (20.0 * reach.touching / length).max(1.0);
    if gap + way.dot(normal) > 0.0 {
        return false;
    }
    let skin = solid.signed_distance(place).0 - gap;
    let (nearest, there) = solid.nearest_on_path(place, place + way);
    let nearest = nearest - skin;
    nearest > reach.slack || (nearest > -reach.touching && there.dot(normal) < SAME)
}

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
        let closing = -v.dot(normal);
        closing > threshold && distance < skin + closing * time
    })
}
