//! Nodes at the rims of a solid: by which face they leave it, and what goes past.

use super::{Making, PLANE};
use crate::contact::beside::SAME;
use crate::contact::site::{Reach, Site};
use crate::contact::touches::Touch;
use crate::math::DVec3;

/// Where a node goes along other solids that hold it.
#[derive(Clone, Copy, PartialEq)]
enum Course {
    /// None holds it, or they may lead it to this solid.
    Here,
    /// Into the nearest face of this solid.
    Into,
    /// Past this solid.
    Past,
    /// In between this solid and what holds it, which touch with faces that look at each other: there is no way.
    Between,
}

impl Making<'_, '_> {
    /// How far a node is from the surface, and the normal there. By an edge, where rounding alone tells which face is nearest, it is that
    /// of the face that the node touched last, and no face where the way out ends in what lies flush beside the solid: on a
    /// joint of two tiles a node is not between them.
    pub(super) fn way_out(
        &self,
        i: u32,
        place: DVec3,
        nearest: (f64, DVec3),
        last: Option<Touch>,
    ) -> (f64, DVec3) {
        let Site { reach, beside, .. } = &*self.site;
        let touched = |normal: DVec3| last.is_some_and(|touch| normal.dot(touch.normal) > SAME);
        let is_same = last.is_none() || touched(nearest.1);
        let is_face = last.is_some_and(|touch| nearest.1.dot(touch.normal) > PLANE);
        let notch = || self.notch(i, place, nearest, last?);
        // Looked for first: beyond the bottom of a notch a node may be farther out than what counts as touching.
        if !is_face && let Some(face) = notch() {
            return face;
        }
        if nearest.0 >= reach.touching || (is_same && beside.is_empty()) {
            return nearest;
        }
        let is_near = |height: f64, normal: DVec3| height >= -reach.shallow() || touched(normal);
        let mut near = 0;
        let mut kept = None;
        self.solid.exits(place, &mut |height, normal| {
            near += usize::from(is_near(height, normal));
            if !is_same && touched(normal) && height >= -reach.touching {
                kept = Some((height, normal));
            }
        });
        if near < 2 {
            return nearest;
        }
        let room = |way| beside.room(self.frame, place, way);
        let is_open = |room: f64| room >= 0.5 * reach.touching;
        let kept = kept.map(|way| (room(way), way));
        if let Some((_, kept)) = kept.filter(|(room, _)| is_open(*room)) {
            return kept;
        }
        let most = room(nearest);
        if is_open(most) {
            return nearest;
        }
        if let Some((_, kept)) = kept.filter(|(room, _)| *room > most) {
            return kept;
        }
        if is_face && let Some(face) = notch() {
            return face;
        }
        // The nearest that is open, or where none is, as at the foot of a box, the one that has most room. None leads in between
        // two faces that look at each other.
        let facing = beside.nearest(self.frame, place, reach.shallow());
        let looks_at = |normal: DVec3| facing.is_some_and(|(_, n)| normal.dot(n) < -INWARD);
        let mut best = (most, nearest);
        self.solid.exits(place, &mut |height, normal| {
            if is_near(height, normal) && !looks_at(normal) {
                let room = room((height, normal)).min(0.5 * reach.touching);
                if room > best.0 || (room == best.0 && height > best.1.0) {
                    best = (room, (height, normal));
                }
            }
        });
        best.1
    }

    /// The face that a node touched last, its height over it and its normal, where the node touched a face of another solid, or of another
    /// part of this one, as well that leans by more than [`SAME`]: at the bottom of such a notch the rims of the two may meet in a line,
    /// beyond which both have their ends. If it touched a rim, it is the face beside that which does not look at the other one.
    pub(super) fn notch(
        &self,
        i: u32,
        place: DVec3,
        nearest: (f64, DVec3),
        last: Touch,
    ) -> Option<(f64, DVec3)> {
        let Site { reach, beside, .. } = &*self.site;
        if nearest.0.abs() > reach.shallow() / STEEPEST {
            return None;
        }
        let crosses = |normal: &DVec3| normal.dot(last.normal) < SAME;
        let parts = self
            .solid
            .is_hollow()
            .then(|| self.touches.normals_of([0, i]));
        let others = beside.touched(self.frame, i);
        let other = others.chain(parts.into_iter().flatten()).find(crosses)?;
        // Who has sunk so far below the line where the faces meet is less deep under them.
        let share = (0.5 * (last.normal + other).length()).max(STEEPEST);
        if nearest.0.abs() > reach.shallow() / share {
            return None;
        }
        let mut face = None;
        let mut closest = SLANTED;
        self.solid.faces(place, &mut |height, normal| {
            let alike = normal.dot(last.normal);
            let is_beside = alike > closest && normal.dot(other) > -INWARD;
            if (alike > PLANE || is_beside) && height.abs() <= reach.shallow() {
                (closest, face) = (alike, Some((height, normal)));
            }
        });
        face
    }

    /// The motion of a substep, or so much longer, by a factor, that it shows where it leads; `None` for none.
    fn long_way(&self, motion: DVec3) -> Option<(DVec3, f64)> {
        let length = motion.length();
        let longer = (20.0 * self.site.reach.touching / length).max(1.0);
        (length > 0.0).then_some((motion * longer, longer))
    }

    /// Where a node that moves so in the substep, `gap` m away from a face with this normal, goes by what it lies on or comes to first.
    fn course(&self, place: DVec3, motion: DVec3, (gap, normal): (f64, DVec3)) -> Course {
        let (site, skin) = (&*self.site, self.target.skin);
        let held = self.long_way(motion).and_then(|(way, longer)| {
            let whole = (way, longer * site.reach.h);
            let by = (self.frame, site.shadow);
            site.beside.held(by, place, whole, gap)
        });
        let Some([from, to]) = held else {
            return Course::Here;
        };
        // What else pushes it may take it farther.
        let (least, there) = self.solid.nearest_on_path(from, from + (to - from) * 2.0);
        let lifted = (from - place).normalize_or_zero();
        if least < skin && there.dot(lifted) < -INWARD {
            Course::Between
        } else if self.solid.is_off(from, to, skin - site.reach.touching) {
            Course::Past
        } else if self
            .solid
            .cast(from, to)
            .is_some_and(|(_, n)| n.dot(normal) > SAME)
        {
            Course::Into
        } else {
            Course::Here
        }
    }

    /// Whether a node that touches another solid goes in between that and this one, `gap` m away.
    pub(super) fn is_between(
        &self,
        i: u32,
        place: DVec3,
        motion: DVec3,
        face: (f64, DVec3),
    ) -> bool {
        let touches_others = self.site.beside.touched(self.frame, i).next().is_some();
        touches_others && self.course(place, motion, face) == Course::Between
    }

    /// Whether a node that would go through the tangent plane of the nearest point, `gap` m away, goes past the solid instead, or
    /// over its edge: a plane has no end, but a plate has. One that comes down just on the edge goes past if there is room there and
    /// nothing of its body is over the plate; a node that slides over a joint between two boxes, a nanometre too low, does not
    /// meet the side of the next one, which is hidden by the first.
    pub(super) fn misses(
        &self,
        i: u32,
        place: DVec3,
        motion: DVec3,
        (gap, normal): (f64, DVec3),
    ) -> bool {
        let Self {
            solid,
            target,
            frame,
            site,
            ..
        } = self;
        let Reach {
            touching, slack, ..
        } = site.reach;
        let Some((way, _)) = self.long_way(motion) else {
            return false;
        };
        let closing = -way.dot(normal);
        if gap > closing {
            return false;
        }
        // What is nearer holds it before it can come here.
        match self.course(place, motion, (gap, normal)) {
            Course::Between | Course::Into => return false,
            Course::Past => return true,
            Course::Here => {}
        }
        let (mut nearest, mut there) = solid.nearest_on_path(place, place + way);
        if solid.is_hollow() && nearest <= touching && there.dot(normal) < SAME {
            // Along what it lies on or comes to first.
            let from = place + there * (2.0 * touching);
            let along = way - there * way.dot(there).min(0.0);
            (nearest, there) = solid.nearest_on_path(from, from + along);
        }
        nearest -= target.skin;
        if nearest > slack {
            return true;
        }
        if nearest <= -touching || there.dot(normal) >= SAME {
            return false;
        }
        let entry = if closing > 0.0 {
            place + way * (gap / closing).max(0.0)
        } else {
            place
        };
        let most = 0.5 * touching;
        let is_filled = |to: DVec3| {
            let point = entry + to * (2.0 * touching);
            site.beside.distance(frame, point, most) < most
        };
        if is_filled(there - normal) {
            return false;
        }
        let is_over = |direction: DVec3| direction.dot(there) < -INWARD;
        is_filled(normal) || !site.side.around(i, frame).any(is_over)
    }
}

/// Cosine of an angle within which the normal at a rim may be of one of its faces.
const SLANTED: f64 = 0.3;

/// Cosine of the slope of the sides of a notch, up to which it is told how deep a node is in there by how deep it is under them.
const STEEPEST: f64 = 0.2;

/// The sine by which what is beside a node goes behind a face at least to be behind it.
const INWARD: f64 = 0.1;
