//! Nodes near a surface without thickness, and their rows.
//!
//! A node keeps the point where it was last known to be on its side for as long as it stays in the list, through new lists
//! and rigid steps: that point, and not the facet that is nearest now, tells whether the node has been pushed through.

use super::feature::{BORDER, Features};
use super::nodes::add;
use super::roll::Roll;
use super::site::Site;
use super::soup::{self, Exit, Margins, NodeFacets, Overhang, Soup};
use super::target::{Frame, Target};
use super::touches::{Hold, Touches, along};
use crate::body::state::State;
use crate::math::{DVec3, Real};
use crate::solve::rows::{Row, Rows};

/// Farther from where it was on its side a node is on the other one, and not on the surface \[m\].
const THROUGH: f64 = 1e-6;

/// The nodes of one body near one soup.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct SoupNodes {
    facets: NodeFacets,
    /// Where each node of the list was last on its side, in the collider's frame \[m\].
    sides: Vec<Option<DVec3>>,
    /// Nodes deep inside an oriented mesh, far from all facets, and their ways out.
    deep: Vec<(u32, Exit)>,
    /// How far things may still move before the lists are stale \[m\].
    budget: f64,
    touches: Touches,
    /// The nodes of the list before, and their sides.
    before: Vec<(u32, Option<DVec3>)>,
    places: Vec<DVec3>,
    #[cfg_attr(feature = "serde-serialize", serde(skip))]
    overhangs: Vec<Overhang>,
    #[cfg_attr(feature = "serde-serialize", serde(skip))]
    bearing: Vec<u32>,
}

impl Default for SoupNodes {
    fn default() -> Self {
        Self {
            facets: NodeFacets::default(),
            sides: Vec::new(),
            deep: Vec::new(),
            budget: -1.0,
            touches: Touches::default(),
            before: Vec::new(),
            places: Vec::new(),
            overhangs: Vec::new(),
            bearing: Vec::new(),
        }
    }
}

impl SoupNodes {
    /// Uses up the budget by what has moved \[m\] besides the substeps.
    pub fn spend(&mut self, moved: f64) {
        self.budget -= moved;
    }

    /// Forgets which nodes touch, and their sides.
    pub fn forget(&mut self) {
        self.touches.forget();
        self.sides.fill(None);
    }

    /// Makes the list anew when it might lack something within `farthest` m; see [`super::nodes::Nodes::refresh`]. Every
    /// facet in the list is looked at in every substep, so it is kept narrower than that of a solid.
    pub fn refresh(
        &mut self,
        (soup, skin): (&Soup, f64),
        state: &State<Real>,
        frame: &Frame,
        moved: f64,
        farthest: f64,
    ) {
        self.budget -= moved;
        // Contacts are looked for within the reach and along the motion: thrice the motion and not twice.
        let needed = 1.5 * farthest;
        if self.budget >= needed {
            return;
        }
        let margin = 2.0 * needed + 16.0 * moved;
        self.budget = margin;
        self.before.clear();
        let known = self.facets.nodes().iter().zip(&self.sides);
        self.before.extend(known.map(|(&i, &side)| (i, side)));
        self.places.clear();
        let all = 0..state.particles.len() as u32;
        self.places
            .extend(all.clone().map(|i| frame.to_local(state, i)));
        // A node that something else pushes through, an attachment say, may be deep: as long as its side is known, the
        // surface between is near.
        let mut before = self.before.iter().peekable();
        let places = all.zip(&self.places).map(|(i, &place)| {
            while before.next_if(|(j, _)| *j < i).is_some() {}
            let known = before.next_if(|(j, _)| *j == i);
            let deep = known
                .and_then(|(_, side)| *side)
                .map_or(0.0, |side| side.distance(place));
            (i, place, skin + margin + deep)
        });
        self.facets.gather_each(soup, places);
        self.keep_sides();
        self.find_deep(soup);
    }

    /// Takes the sides over into the new list.
    fn keep_sides(&mut self) {
        self.sides.clear();
        let mut before = self.before.iter().peekable();
        for &i in self.facets.nodes() {
            while before.next_if(|(j, _)| *j < i).is_some() {}
            let known = before.next_if(|(j, _)| *j == i);
            self.sides.push(known.and_then(|(_, side)| *side));
        }
    }

    /// Looks among the nodes that are not in the list for those inside.
    fn find_deep(&mut self, soup: &Soup) {
        self.deep.clear();
        if !soup.oriented() {
            return;
        }
        let mut near = self.facets.nodes().iter().peekable();
        for (i, &place) in (0..).zip(&self.places) {
            if near.next_if(|&&j| j == i).is_none()
                && let Some(exit) = soup.inside(place)
            {
                self.deep.push((i, exit));
            }
        }
    }

    /// Up to three rows for every node that can touch within the substep. At borders of the surface nodes are left to edges
    /// of theirs, among the features, that touch the border and lead round it.
    pub fn add_rows(
        &mut self,
        (target, pair, features): (&Target, u32, Option<&Features>),
        frame: &Frame,
        site: &mut Site,
    ) {
        self.touches.begin();
        self.find_overhangs(target, features, frame, site);
        let margins = Margins {
            border: BORDER * site.reach.touching,
            touching: site.reach.touching,
        };
        let mut overhangs = self.overhangs.as_slice();
        let mut found = soup::Touches::default();
        let nodes = self.facets.nodes().iter();
        let roll = Roll::of_any(site.shadow);
        for (index, (&i, side)) in nodes.zip(&mut self.sides).enumerate() {
            if target.holds([i]) {
                continue;
            }
            let place = frame.to_local(site.side.state, i);
            let arm = frame.axes * place + (frame.position - site.shadow.com);
            let slip = site.side.state.velocity(i as usize) - site.shadow.velocity_at(arm);
            let gain = site.side.gain(i, site.reach.h).length();
            let reach = site.reach.at(slip.length() + gain).min(site.reach.farthest);
            let mut near = self.facets.near(index);
            let mut back = DVec3::ZERO;
            let own = take_node(&mut overhangs, i);
            if !own.is_empty() {
                let (p, from) = (place, side.unwrap_or(place));
                (near, back) = soup::bearing(near, own, (p, from), margins, &mut self.bearing);
            }
            soup::touches(
                near,
                place,
                frame.axes.transpose() * slip * site.reach.h,
                *side,
                target.skin,
                reach,
                &mut found,
            );
            *side = found.anchor.map(|anchor| anchor + back);
            for (k, touch) in (0..).zip(found.as_slice()) {
                let normal = frame.axes * touch.normal;
                let mut row = Row {
                    normal,
                    depth: touch.depth,
                    arm,
                    turn: roll.under_node(normal, arm),
                    ..target.row(Default::default(), pair, site.reach.h)
                };
                // One anchor of friction holds the node, whatever else it touches.
                if k == 0 {
                    let key = [i, 0, 0];
                    let last = self.touches.last(key);
                    (row.normal_impulse, row.friction_impulse) =
                        last.map_or(Default::default(), |touch| touch.impulse);
                    let hold = last.and_then(|touch| touch.hold).unwrap_or(Hold {
                        weights: [1.0, 0.0, 0.0, 0.0],
                        anchor: place,
                        drift: DVec3::ZERO,
                    });
                    row.drift = frame.axes * along(place - hold.anchor, touch.normal);
                    let index = site.rows.contacts.len();
                    self.touches.found(key, index, touch.normal, hold);
                }
                add(i, target, row, site);
            }
        }
        let deep = self.deep.iter().filter(|(i, _)| !target.holds([*i]));
        for &(i, exit) in deep {
            let place = frame.to_local(site.side.state, i);
            let normal = frame.axes * exit.normal;
            let arm = frame.axes * place + (frame.position - site.shadow.com);
            let row = Row {
                normal,
                depth: target.skin + (exit.point - place).dot(exit.normal),
                arm,
                turn: roll.under_node(normal, arm),
                ..target.row(Default::default(), pair, site.reach.h)
            };
            add(i, target, row, site);
        }
    }

    /// Finds what hangs over borders. What keeps a distance meets a border that is as good as round, and has no use for it.
    fn find_overhangs(
        &mut self,
        target: &Target,
        features: Option<&Features>,
        frame: &Frame,
        site: &Site,
    ) {
        self.overhangs.clear();
        let thickness = target.skin + self.facets.radius();
        if let Some(features) = features
            && thickness < BORDER * site.reach.touching
        {
            features.overhangs(&site.side, frame, &mut self.overhangs);
        }
    }

    /// Where on the surface a node at `place` is that touches it or has been pushed through it, and the unit direction to the side
    /// where it belongs, in the collider's frame \[m\].
    pub fn standing(&self, node: u32, place: DVec3) -> Option<[DVec3; 2]> {
        let index = self.facets.nodes().binary_search(&node).ok()?;
        let side = self.sides.get(index).copied().flatten()?;
        if side.distance_squared(place) > THROUGH * THROUGH {
            return Some([side, (side - place).normalize()]);
        }
        Some([place, self.touches.normal([node, 0, 0])?])
    }

    /// Remembers which nodes touch, after the rows have been solved.
    pub fn remember(&mut self, rows: &Rows, touching: f64) {
        self.touches.end(rows, touching);
    }

    /// Whether any node lies within `distance` m of the surface, or inside.
    pub fn any_within(&self, state: &State<Real>, frame: &Frame, distance: f64) -> bool {
        !self.deep.is_empty()
            || self.facets.nodes().iter().enumerate().any(|(index, &i)| {
                let near = self.facets.near(index);
                near.nearest(frame.to_local(state, i))
                    .is_some_and(|nearest| nearest.distance < near.radius + distance)
            })
    }
}

/// Whether any of the points, given with their velocities in the soup's frame, meets the soup faster than `threshold` m/s
/// within `time` s, being `skin` m thick.
pub fn is_hit(
    soup: &Soup,
    points: impl Iterator<Item = (DVec3, DVec3)>,
    skin: f64,
    time: f64,
    threshold: f64,
) -> bool {
    let (mut facets, mut found) = (NodeFacets::default(), soup::Touches::default());
    points
        .filter(|(_, v)| v.length_squared() > threshold * threshold)
        .any(|(p, v)| {
            let way = v * time;
            facets.gather(soup, std::iter::once((0, p)), skin + way.length());
            soup::touches(facets.near(0), p, way, None, skin, 0.0, &mut found);
            let touches = found.as_slice().iter();
            touches.map(|t| -v.dot(t.normal)).any(|c| c > threshold)
        })
}

/// Takes the overhangs of a node off the front, and of those before it.
fn take_node<'a>(all: &mut &'a [Overhang], node: u32) -> &'a [Overhang] {
    let first = all.partition_point(|over| over.node < node);
    let end = all.partition_point(|over| over.node <= node);
    let own = &all[first..end];
    *all = &all[end..];
    own
}
