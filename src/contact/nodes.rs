//! Nodes near one target, and their rows.

use super::distance::Solid;
use super::form::Form;
use super::site::{Reach, Site, slot};
use super::target::{Frame, Target};
use super::touches::{Hold, Touches, along};
use crate::body::state::State;
use crate::math::{DVec3, Real};
use crate::solve::rows::{Row, Rows, Term};

/// The nodes of one body near one target, and what is remembered of those that touch it.
#[derive(Clone, Debug)]
pub struct Nodes {
    /// In ascending order.
    near: Vec<u32>,
    /// How far things may still move before the list is stale \[m\].
    budget: f64,
    touches: Touches,
}

impl Default for Nodes {
    fn default() -> Self {
        Self {
            near: Vec::new(),
            budget: -1.0,
            touches: Touches::default(),
        }
    }
}

impl Nodes {
    /// Uses up the budget by what has moved \[m\] besides the substeps.
    pub fn spend(&mut self, moved: f64) {
        self.budget -= moved;
    }

    /// Forgets which nodes touch.
    pub fn forget(&mut self) {
        self.touches.forget();
    }

    /// Makes the list anew if, after `moved` m since the last look, it might lack a node that can get a row in the coming
    /// substep, which is any within `farthest` m. A list should last for a hundred substeps or so: the faster things move,
    /// the wider it is.
    pub fn refresh(
        &mut self,
        target: &Target,
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
        let Form::Solid(solid) = &target.form;
        let near =
            |i: &u32| solid.signed_distance(frame.to_local(state, *i)).0 < target.skin + margin;
        self.near
            .extend((0..state.particles.len() as u32).filter(near));
    }

    /// A row for every node that can touch within the substep.
    pub fn add_rows(&mut self, target: &Target, pair: u32, frame: &Frame, site: &mut Site) {
        self.touches.begin();
        let Form::Solid(solid) = &target.form;
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
            let motion = frame.axes.transpose() * slip * site.reach.h;
            if depth < 0.0 && misses(solid, place, motion, target.skin, normal, &site.reach) {
                continue;
            }
            let key = [0, i, 0];
            let last = self.touches.last(key);
            if let Some((before, _)) = last
                && depth > 0.0
                && normal.dot(before) < 0.0
                && let Some(back) = solid.depth_along(place, before)
            {
                // Squeezed past the middle of a thin solid: it goes back to where it came from.
                (depth, normal) = (target.skin + back, before);
            }
            let hold = last.and_then(|(_, hold)| hold).unwrap_or(Hold {
                weights: [1.0, 0.0, 0.0],
                anchor: place,
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

    /// Whether any node lies within `distance` m of the target.
    pub fn any_within(
        &self,
        target: &Target,
        state: &State<Real>,
        frame: &Frame,
        distance: f64,
    ) -> bool {
        let Form::Solid(solid) = &target.form;
        self.near
            .iter()
            .any(|&i| solid.signed_distance(frame.to_local(state, i)).0 < target.skin + distance)
    }
}

/// Adds the row of a node.
fn add(i: u32, target: &Target, row: Row, site: &mut Site) {
    let node = slot(site.side.body, i, site.side.state, site.slots, site.rows);
    let terms = site.rows.add_terms([Term {
        node,
        weight: 1.0,
        share: target.node_share,
    }]);
    site.rows.contacts.push(Row { terms, ..row });
}

/// Whether a node that would go through the tangent plane of the nearest point within the substep goes past the solid
/// instead: a plane has no end, but a plate has.
fn misses(
    solid: &Solid,
    place: DVec3,
    motion: DVec3,
    skin: f64,
    normal: DVec3,
    reach: &Reach,
) -> bool {
    let (gap, _) = solid.signed_distance(place);
    if gap - skin + motion.dot(normal) > 0.0 || motion.length() < 4.0 * reach.touching {
        return false;
    }
    let nearest = solid.nearest_on_path(place, place + motion);
    nearest - skin > reach.slack
}
