//! A node against the elements near it: which of them it touches, how deep, and which way is out.
//!
//! The nearest element gives a row, and a second one if it looks another way (the node lies in a corner or between two
//! folds). Sides are remembered by the normal of the last row: a node that has been pressed into a solid leaves it through
//! the face it came by, not through the one that happens to be nearest, and one pressed through a sheet is brought back.

use super::near::Near;
use super::posed::{Posed, Way};
use super::touch::Touch;
use crate::contact::closest::Feature;
use crate::contact::site::Reach;
use crate::math::DVec3;

/// Two solids touch only where their surfaces look at each other: the cosine of their normals is less than this.
const FACING: f64 = -0.1;

/// From this cosine on an edge comes along the surface of a node rather than on it.
const ALONG: f64 = -0.5;

/// How far beside a rim a node still counts as lying on it, per distance that counts as touching.
const RIM: f64 = 100.0;

/// By what share rounding may tell two distances to the same point apart.
const TIE: f64 = 1e-9;

/// A point of the other body that a node can touch.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// The element.
    pub element: u32,
    /// Weights of its corners.
    pub weights: [f64; 3],
    /// From the other body to the side of the node.
    pub normal: DVec3,
    /// Distance along it, negative inside \[m\].
    pub gap: f64,
}

impl Found {
    fn new(way: &Way, normal: DVec3, gap: f64) -> Self {
        Self {
            element: way.element,
            weights: way.nearest.weights,
            normal,
            gap,
        }
    }
}

/// A node and what is known of it.
pub struct Query<'a> {
    /// The other body.
    pub other: Posed<'a>,
    /// Where the node is \[m\].
    pub x: DVec3,
    /// How fast it moves \[m/s\].
    pub v: DVec3,
    /// Pairs of the node and elements near it.
    pub near: &'a mut [Near],
    /// How far both have moved since these were listed \[m\].
    pub way: f64,
    /// What it touched in the last substep.
    pub known: &'a [Touch],
    /// −1 for nodes of the second body: touches keep normals from the second body to the first.
    pub sign: f64,
    /// The node's own body.
    pub mine: Posed<'a>,
    /// The node.
    pub node: u32,
    /// How much farther inside it can be than it can have come in a substep \[m\].
    pub unseen: f64,
    /// Distance that both keep from each other \[m\].
    pub distance: f64,
    /// What is near enough to that.
    pub reach: Reach,
}

impl Query<'_> {
    /// What the node can touch.
    pub fn find(&mut self) -> [Option<Found>; 2] {
        let most = self.most();
        let (nearest, faces) = self.nearest(most);
        let Some(best) = nearest.filter(|best| best.squared.sqrt() <= most) else {
            return [None; 2];
        };
        let seen = self.see(&best);
        let seen = seen.filter(|f| f.gap <= self.farthest() && self.can_be(f));
        let Some(first) = seen else {
            return [None; 2];
        };
        let is_hit = best.nearest.feature == Feature::Face && best.element == first.element;
        let others = faces > u32::from(is_hit);
        let second = others.then(|| self.second(&first)).flatten();
        [Some(first), second]
    }

    /// The nearest point, if any may be within `most` m, and how many faces are hit inside.
    fn nearest(&mut self, most: f64) -> (Option<Way>, u32) {
        let deepest = self.deepest_unknown() + self.deepest_known();
        let mut best: Option<Way> = None;
        let mut faces = 0;
        for near in &mut *self.near {
            // What is farther off than the node can be inside, and than another, is nothing to it.
            let at_least = near.at_least(self.way);
            let is_behind =
                |best: &Way| at_least > deepest && at_least * at_least > (1.0 + TIE) * best.squared;
            if at_least > most || best.as_ref().is_some_and(is_behind) {
                continue;
            }
            if self.other.outline.is_gone(near.other, self.other.state) {
                continue;
            }
            let way = self.other.nearest(near.other, self.x);
            near.note(self.way, way.squared.sqrt());
            faces += u32::from(way.nearest.feature == Feature::Face);
            if best.is_none_or(|b| way.squared < b.squared) {
                best = Some(way);
            }
        }
        (best, faces)
    }

    /// How far off the nearest element may be for the node to touch anything \[m\].
    fn most(&self) -> f64 {
        if !self.other.outline.closed {
            self.farthest()
        } else if self.known.is_empty() {
            // Under a rim the nearest element is not the one that bears the node.
            self.deepest_unknown().max(RIM * self.reach.touching)
        } else {
            f64::INFINITY
        }
    }

    /// No row for what is farther off than this \[m\].
    fn farthest(&self) -> f64 {
        self.distance + self.reach.farthest
    }

    /// How deep inside something can be that did not touch, at most \[m\].
    fn deepest_unknown(&self) -> f64 {
        self.farthest() + self.unseen
    }

    /// How deep it was \[m\].
    fn deepest_known(&self) -> f64 {
        self.known.iter().map(|t| t.depth).fold(0.0, f64::max)
    }

    /// Whether the node can have come that deep since the last substep. If not, a crumpled surface has turned inside out, or
    /// the node slid round an edge and this is not the face that bears it.
    fn can_be(&self, found: &Found) -> bool {
        let was = self.deepest_known();
        let other = self.other.velocity(found.element, found.weights);
        let into = (other - self.v).dot(found.normal);
        self.distance - found.gap <= was.max(self.distance) + self.reach.come(into) + self.unseen
    }

    /// The last normal, towards the node, of a touch with this element or one beside it.
    fn last(&self, element: u32) -> Option<DVec3> {
        let known = self.known.iter();
        known
            .filter(|t| self.other.outline.are_neighbours(t.other, element))
            .map(|t| t.normal * self.sign)
            .next()
    }

    fn see(&self, way: &Way) -> Option<Found> {
        if self.other.outline.closed {
            self.see_solid(way)
        } else {
            Some(self.see_sheet(way))
        }
    }

    fn see_solid(&self, way: &Way) -> Option<Found> {
        let mut found = self.outside_of(way);
        if !self.is_opposite(found.normal) {
            let own = self.own_normal().normalize_or_zero();
            let facing = found.normal.dot(own);
            if way.nearest.feature != Feature::Face && FACING >= facing && facing > ALONG {
                // A rim that comes along the surface of the node: a row along the way between them would stop it as a wall does, though nothing
                // stands in its way if it goes over the node.
                let height = -way.way.dot(own);
                let passes =
                    (self.other.velocity(way.element, way.nearest.weights) - self.v).dot(own);
                if height < self.reach.touching {
                    // It is the face that will lie on it.
                    let normal = self.other.facing(way.element, way.nearest.feature, own);
                    if normal.dot(own) < facing {
                        found = Found::new(way, normal, way.way.dot(normal));
                    }
                } else if height + passes * self.reach.h >= 0.0 {
                    return None;
                }
            }
            if own != DVec3::ZERO && facing > FACING {
                // The surfaces do not look at each other: a node under the very rim of a solid is nearest to its side, and
                // would be caught by it, or be let down beside it.
                let back = self.way_back(-own)?;
                let slight = (self.x - self.other.point(back.element, back.weights)).length();
                return (found.gap < 0.0 || slight < RIM * self.reach.touching).then_some(back);
            }
        }
        if found.gap >= 0.0 {
            return Some(found);
        }
        match self.last(way.element) {
            Some(last) if found.normal.dot(last) < 0.5 => self.way_back(last).or(Some(found)),
            _ => Some(found),
        }
    }

    /// Whether the node's own surface surely looks against the one that has this unit `normal`, as nearly everywhere: found without
    /// roots.
    fn is_opposite(&self, normal: DVec3) -> bool {
        self.mine.outline.closed && self.mine.all_against(self.node, normal, ALONG)
    }

    /// The outward normal of the node's own body there; zero if that has two sides or no face there.
    fn own_normal(&self) -> DVec3 {
        // What has two sides looks both ways.
        if self.mine.outline.closed {
            self.mine.node_normal(self.node)
        } else {
            DVec3::ZERO
        }
    }

    /// The nearest point of a solid, the side told by the normals around it.
    fn outside_of(&self, way: &Way) -> Found {
        let feature = way.nearest.feature;
        let length = way.squared.sqrt();
        if feature != Feature::Face && length < self.reach.touching {
            // On an edge or a corner: the way is noise, and one of the faces is what the node's own surface lies on.
            let against = self.own_normal();
            let normal = if against == DVec3::ZERO {
                let around = self.other.normal_at(way.element, feature);
                around.normalize_or_zero()
            } else {
                self.other.facing(way.element, feature, against)
            };
            return Found::new(way, normal, way.way.dot(normal));
        }
        let normal = self.other.normal_at(way.element, feature);
        if feature == Feature::Face {
            return Found::new(way, normal, way.way.dot(normal));
        }
        if way.way.dot(normal) < 0.0 {
            return Found::new(way, way.way / -length, -length);
        }
        self.toward(way, length)
    }

    /// A point of an edge or a corner, `length` m away, in the direction in which the node will be where it comes to the distance that both
    /// keep, or nearest to it, within the substep: a rim is round by that distance, and what passes over it is not met by the plane
    /// that touches it on the side from which the node comes.
    fn toward(&self, way: &Way, length: f64) -> Found {
        let straight = Found::new(way, way.way / length, length);
        let mut by = self.v - self.other.velocity(way.element, way.nearest.weights);
        if let Feature::Side(k) = way.nearest.feature {
            // The nearest point of an edge goes along.
            let corners = self.other.corners(way.element);
            let along = (corners[(k + 1) % 3] - corners[k]).normalize_or_zero();
            by -= along * along.dot(by);
        }
        by *= self.reach.h;
        let (square, closing) = (by.length_squared(), -way.way.dot(by));
        // Without a distance the way there is noise.
        if length <= self.distance || self.distance <= 0.0 || closing <= 0.0 {
            return straight;
        }
        // |way + t·by| = distance, or where that is least.
        let inside = closing * closing - square * (way.squared - self.distance * self.distance);
        let t = (closing - inside.max(0.0).sqrt()) / square;
        let normal = (way.way + by * t.min(1.0)).normalize_or(straight.normal);
        Found::new(way, normal, way.way.dot(normal))
    }

    /// For a node inside a solid: the nearest face that looks the way it came.
    fn way_back(&self, last: DVec3) -> Option<Found> {
        let mut best: Option<(f64, Found)> = None;
        for &Near { other: element, .. } in &*self.near {
            let normal = self.other.face_normal(element);
            if normal.dot(last) < 0.5 {
                continue;
            }
            let way = self.other.nearest(element, self.x);
            let gap = way.way.dot(normal);
            let found = Found::new(&way, normal, gap);
            let nearer = best.as_ref().is_none_or(|b| way.squared < b.0);
            if gap <= 0.0 && nearer && self.can_be(&found) {
                best = Some((way.squared, found));
            }
        }
        best.map(|b| b.1)
    }

    /// The nearest point of something with two sides.
    fn see_sheet(&self, way: &Way) -> Found {
        let last = self.last(way.element);
        if way.nearest.feature == Feature::Face {
            let normal = self.other.face_normal(way.element);
            let side = last.map_or(way.way.dot(normal), |last| last.dot(normal));
            let normal = if side < 0.0 { -normal } else { normal };
            return Found::new(way, normal, way.way.dot(normal));
        }
        let length = way.squared.sqrt();
        if length < 1e-3 * self.reach.touching {
            let normal = last.unwrap_or_else(|| {
                let along = self.other.normal_at(way.element, way.nearest.feature);
                along.try_normalize().unwrap_or(DVec3::Y)
            });
            return Found::new(way, normal, 0.0);
        }
        let normal = way.way / length;
        // Well past the side it was on; what goes round a border turns by less.
        if last.is_some_and(|last| last.dot(normal) < -0.5) {
            Found::new(way, -normal, -length)
        } else {
            self.toward(way, length)
        }
    }

    /// The nearest face, hit inside, that looks another way than the first.
    fn second(&self, first: &Found) -> Option<Found> {
        let mut best: Option<(f64, Found)> = None;
        for &Near { other: element, .. } in &*self.near {
            let outline = self.other.outline;
            let is_face = (element as usize) < outline.faces && !outline.is_torn(element);
            if !is_face || element == first.element {
                continue;
            }
            let way = self.other.nearest(element, self.x);
            let worse = best.as_ref().is_some_and(|b| way.squared >= b.0);
            if way.nearest.feature != Feature::Face || worse {
                continue;
            }
            let found = if self.other.outline.closed {
                self.outside_of(&way)
            } else {
                self.see_sheet(&way)
            };
            // Behind a face that it never touched, a node is merely on the far side of the solid.
            let known = || {
                let last = self.last(element);
                last.is_some_and(|last| last.dot(found.normal) > 0.7)
            };
            if found.gap <= self.farthest()
                && found.normal.dot(first.normal) < 0.7
                && (found.gap >= 0.0 || known() && self.can_be(&found))
            {
                best = Some((way.squared, found));
            }
        }
        best.map(|b| b.1)
    }
}
