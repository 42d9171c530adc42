//! Faces and edges of one body against the convex parts of a solid.

use super::convex_edges::SeenEdge;
use super::convex_faces::SeenPoint;
use super::making::{Making, Met};
use super::part::{Convex, Part};
use super::recall::Recall;
use crate::contact::distance::Solid;
use crate::contact::roll::Roll;
use crate::contact::site::Site;
use crate::contact::target::{Frame, Target};
use crate::contact::touches::Touches;
use crate::math::DVec3;
use crate::solve::rows::Rows;

/// A convex part rounder than this many spacings needs no feature contacts: an edge dips into it by a two-hundredth of its length. What
/// rolls or slides over stiff nodes alone hops from one to the next, and loses a share of its energy on the way of one radius that is
/// a quarter of the spacing over the radius: a hundredth from here on.
const ROUND: f64 = 24.0;

/// Faces and edges of one body near the convex parts of one target.
#[derive(Clone, Debug)]
pub struct ConvexFeatures {
    pub(super) parts: Vec<Part>,
    /// Whether these are all parts of the target.
    pub(super) all_parts: bool,
    points: Vec<DVec3>,
    met: Vec<Met>,
    pub(super) on_faces: Touches,
    pub(super) on_edges: Touches,
    seen_faces: Recall<SeenPoint>,
    seen_edges: Recall<SeenEdge>,
}

/// What is looked at.
pub(super) struct Look<'a> {
    pub target: &'a Target,
    pub pair: u32,
    /// The collider's frame.
    pub collider: &'a Frame,
    /// How far off anything may be and still matter \[m\].
    pub near: f64,
}

impl Look<'_> {
    /// What makes the rows of a part.
    pub fn making<'a, 's>(
        &'a self,
        part: &Convex,
        site: &'a mut Site<'s>,
        touches: &'a mut Touches,
    ) -> Making<'a, 's> {
        let frame = part.frame(self.collider);
        Making {
            target: self.target,
            pair: self.pair,
            nodes: None,
            frame,
            skin: self.target.skin,
            roll: Roll::of(&part.solid, &frame, site.shadow),
            radius: part.solid.edge_radius(),
            site,
            touches,
            near: self.near,
            deep: false,
        }
    }
}

impl ConvexFeatures {
    /// The features of a solid that a body with this spacing \[m\] needs; `None` if all its parts are too round to need any.
    pub fn of(solid: &Solid, spacing: f64) -> Option<Self> {
        let (mut parts, mut all_parts) = (Vec::new(), true);
        solid.for_each_convex(&mut |offset, turn, part| {
            let (lo, hi) = part.bounds();
            if (hi - lo).is_finite() && part.edge_radius() < ROUND * spacing {
                parts.push(Part::new(offset, turn, part.clone()));
            } else {
                all_parts = false;
            }
        });
        (!parts.is_empty()).then_some(Self {
            parts,
            all_parts,
            points: Vec::new(),
            met: Vec::new(),
            on_faces: Touches::default(),
            on_edges: Touches::default(),
            seen_faces: Recall::default(),
            seen_edges: Recall::default(),
        })
    }

    /// Forgets what touches and all distances.
    pub fn forget(&mut self) {
        self.parts.iter_mut().for_each(Part::reset);
        self.on_faces.forget();
        self.on_edges.forget();
        self.look_anew();
    }

    /// Has all be looked at anew in the next substep.
    pub fn look_anew(&mut self) {
        self.seen_faces.forget();
        self.seen_edges.forget();
    }

    /// Remembers what touches, after the rows have been solved.
    pub fn remember(&mut self, rows: &Rows, touching: f64) {
        self.on_faces.end(rows, touching);
        self.on_edges.end(rows, touching);
    }

    /// Adds the rows of faces and edges; `way` is how far body and collider have moved in all \[m\].
    pub fn add_rows(
        &mut self,
        target: &Target,
        pair: u32,
        collider: &Frame,
        site: &mut Site,
        way: f64,
    ) {
        self.on_faces.begin();
        self.on_edges.begin();
        self.seen_faces.begin(&site.reach);
        self.seen_edges.begin(&site.reach);
        let look = &Look {
            target,
            pair,
            collider,
            near: target.skin + site.reach.farthest,
        };
        let mut bounds = None;
        for part in &mut self.parts {
            let mut bounds = || *bounds.get_or_insert_with(|| site.side.bounds(collider));
            part.awake(&mut bounds, way, look.near);
        }
        self.look_at_faces(look, site, way);
        self.look_at_edges(look, site, way);
    }

    fn look_at_faces(&mut self, look: &Look, site: &mut Site, way: f64) {
        let Self {
            parts,
            points,
            met,
            on_faces,
            seen_faces: seen,
            ..
        } = self;
        let awake = |(_, part): &(u32, &mut Part)| part.is_awake();
        for (p, part) in (0..).zip(parts).filter(awake) {
            let convex = &part.convex;
            let mut making = look.making(convex, site, on_faces);
            let count = making.site.side.topology.faces.len();
            let mut look_at_all =
                |making: &mut Making, met: &mut Vec<Met>, seen: &mut Recall<_>| {
                    met.clear();
                    let reach = (making.near, look.near);
                    part.faces.visit(count, way, reach, |f, bound| {
                        making.meet(convex, (p, f, bound), seen, points, met)
                    });
                    met.sort_unstable_by_key(|m| (m.point, m.face));
                };
            look_at_all(&mut making, met, seen);
            if making.misses_some(p, met) {
                // A point that was known may have come deep under another face.
                making.near = look.near.max(making.deepest_point());
                making.deep = true;
                seen.forget();
                look_at_all(&mut making, met, seen);
                seen.forget();
            }
            for met in met.chunk_by_mut(|a, b| a.point == b.point) {
                making.point(p, met, convex.solid.has_rim());
            }
        }
    }

    fn look_at_edges(&mut self, look: &Look, site: &mut Site, way: f64) {
        let Self {
            parts,
            on_edges,
            seen_edges: seen,
            ..
        } = self;
        let awake = |(_, part): &(u32, &mut Part)| part.is_awake();
        for (p, part) in (0..).zip(parts).filter(awake) {
            let convex = &part.convex;
            let mut making = look.making(convex, site, on_edges);
            let count = making.site.side.topology.edges.len();
            let reach = (look.near, look.near);
            part.edges.visit(count, way, reach, |e, bound| {
                making.edge(convex, ([p, e], bound), seen)
            });
        }
    }
}
