//! Solids that act as one. Outside, the nearest part counts. Inside, parts have faces that are not on the surface: two
//! boxes side by side are one floor, and a node just under its top must not be pushed into the gap between them. So the
//! ways out through all faces of the parts around a point are gathered, and one that ends in another part is no way out.

mod steps;

use super::parts::Parts;
use super::{Solid, edges};
use crate::contact::target::wide_rotation;
use crate::math::{DMat3, DQuat, DVec3, wide};
use rapier3d::parry::shape;
use steps::{Exit, through_corner, through_edge};

/// Parts in one frame.
#[derive(Debug, PartialEq)]
pub struct Compound {
    parts: Parts,
    lo: DVec3,
    hi: DVec3,
    /// How far behind a face another part must begin to hide it \[m\]: a few roundings of Rapier's `f32` poses.
    seam: f64,
}

/// A solid in the frame of the compound.
#[derive(Debug, PartialEq)]
pub struct Part {
    solid: Solid,
    position: DVec3,
    rotation: DQuat,
    axes: DMat3,
    /// Its box in the compound's frame.
    pub lo: DVec3,
    /// The other corner of that.
    pub hi: DVec3,
}

impl Part {
    fn local(&self, p: DVec3) -> DVec3 {
        self.axes.transpose() * (p - self.position)
    }

    /// Signed distance and normal, in the compound's frame.
    pub fn signed_distance(&self, p: DVec3) -> (f64, DVec3) {
        let (d, n) = self.solid.signed_distance(self.local(p));
        (d, self.axes * n)
    }

    /// Whether `p` is inside or less than `margin` m outside.
    fn holds(&self, p: DVec3, margin: f64) -> bool {
        self.away(p) <= margin && self.signed_distance(p).0 < margin
    }

    /// A lower bound of the distance, from its box.
    fn away(&self, p: DVec3) -> f64 {
        (self.lo - p).max(p - self.hi).max(DVec3::ZERO).length()
    }
}

/// Nearest ways out, the nearest first. Farther ones than fit are not looked at.
struct Exits {
    list: [Exit; Self::MOST],
    len: usize,
}

impl Exits {
    const MOST: usize = 32;

    fn add(&mut self, exit: Exit) {
        let place = self.list[..self.len].partition_point(|e| e.height >= exit.height);
        if place == Self::MOST {
            return;
        }
        self.len = (self.len + 1).min(Self::MOST);
        self.list.copy_within(place..self.len - 1, place + 1);
        self.list[place] = exit;
    }

    fn iter(&self) -> impl Iterator<Item = &Exit> {
        self.list[..self.len].iter()
    }
}

impl Compound {
    /// From parry's; `None` with a part that is no solid.
    pub fn of(compound: &shape::Compound) -> Option<Self> {
        let mut parts = Vec::new();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut extent = 0.0_f64;
        for (pose, shape) in compound.shapes() {
            let solid = Solid::of(&**shape)?;
            let (position, rotation) = (wide(pose.translation), wide_rotation(pose.rotation));
            let axes = DMat3::from_quat(rotation);
            let (lo, hi) = turned(&axes, position, solid.bounds());
            (low, high) = (low.min(lo), high.max(hi));
            for end in [lo, hi] {
                if end.is_finite() {
                    extent = extent.max(end.abs().max_element());
                }
            }
            parts.push(Part {
                solid,
                position,
                rotation,
                axes,
                lo,
                hi,
            });
        }
        Some(Self {
            parts: Parts::new(parts),
            lo: low,
            hi: high,
            seam: 8.0 * f64::from(f32::EPSILON) * extent,
        })
    }

    /// Its box.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        (self.lo, self.hi)
    }

    /// Smallest width of a part.
    pub fn width(&self) -> f64 {
        let widths = self.parts.iter().map(|p| p.solid.width());
        widths.fold(f64::INFINITY, f64::min)
    }

    /// Visits the parts.
    pub fn for_each_convex(&self, f: &mut dyn FnMut(DVec3, DQuat, &Solid)) {
        for part in self.parts.iter() {
            part.solid
                .for_each_convex(&mut |position, rotation, solid| {
                    let position = part.position + part.axes * position;
                    f(position, part.rotation * rotation, solid);
                });
        }
    }

    /// The first entry into any part; `None` from inside one.
    pub fn cast(&self, a: DVec3, b: DVec3) -> Option<(f64, DVec3)> {
        let (low, high) = (a.min(b), a.max(b));
        let mut first: Option<(f64, DVec3)> = None;
        for part in self.parts.meeting(low, high) {
            if part.lo.cmpgt(high).any() || part.hi.cmplt(low).any() {
                continue;
            }
            let (from, to) = (part.local(a), part.local(b));
            match part.solid.cast(from, to) {
                Some((t, n)) if first.is_none_or(|f| t < f.0) => first = Some((t, part.axes * n)),
                None if part.away(a) <= 0.0 && part.solid.signed_distance(from).0 < 0.0 => {
                    return None;
                }
                _ => {}
            }
        }
        first
    }

    /// Whether all of the segment `a`–`b` is farther off each part than `least` m.
    pub fn is_off(&self, a: DVec3, b: DVec3, least: f64) -> bool {
        let margin = DVec3::splat(least.max(0.0));
        let (low, high) = (a.min(b) - margin, a.max(b) + margin);
        let mut near = self.parts.meeting(low, high);
        near.all(|part| part.solid.is_off(part.local(a), part.local(b), least))
    }

    /// Whether several parts, or one with hollows, may be within `reach` m of a point, as far as their boxes tell.
    pub fn has_hollow_at(&self, p: DVec3, reach: f64) -> bool {
        let mut near = self.parts.near(p, reach);
        let first = near.find(|part| part.away(p) <= reach);
        let is_hollow = first.is_some_and(|part| part.solid.is_hollow());
        is_hollow || near.any(|part| part.away(p) <= reach)
    }

    /// Signed distance and normal.
    pub fn signed_distance(&self, p: DVec3) -> (f64, DVec3) {
        let mut best = (f64::INFINITY, DVec3::Y);
        let mut near = 0;
        for part in self.parts.near(p, self.parts.within(p).max(self.seam)) {
            if part.away(p) > best.0.max(self.seam) {
                continue;
            }
            let (d, n) = part.signed_distance(p);
            near += usize::from(d < self.seam);
            if d < best.0 {
                best = (d, n);
            }
        }
        // One part alone, or on its surface far from the others: its own answer.
        if near == 0 || (near == 1 && !self.hidden(p, best.0, best.1)) {
            return best;
        }
        self.inside(p)
    }

    /// Whether the way out from `p` along `normal` to a face at `height` ends in some part, or on its surface: a point in
    /// the gap between two boxes, level with their tops, is not out on either side.
    fn hidden(&self, p: DVec3, height: f64, normal: DVec3) -> bool {
        self.covered(p + normal * (self.seam - height))
    }

    fn covered(&self, end: DVec3) -> bool {
        let margin = 0.5 * self.seam;
        let mut near = self.parts.near(end, margin);
        near.any(|part| part.holds(end, margin))
    }

    /// Visits the faces, as seen from `p`, of the parts in which `end` lies.
    fn for_each_exit(&self, p: DVec3, end: DVec3, f: &mut dyn FnMut(&Exit)) {
        let margin = 0.5 * self.seam;
        let near = self.parts.near(end, margin);
        for part in near.filter(|part| part.holds(end, margin)) {
            part.solid.exits(part.local(p), &mut |height, n| {
                let normal = part.axes * n;
                f(&Exit { height, normal });
            });
        }
    }

    /// The nearest way out of the parts around `p`: through a face, or through the line in which a face meets one of the
    /// part that hides it, the inner edge of an L, or the point in which three meet, its inner corner.
    fn inside(&self, p: DVec3) -> (f64, DVec3) {
        let mut exits = Exits {
            list: [Exit::default(); Exits::MOST],
            len: 0,
        };
        for part in self.parts.near(p, self.seam) {
            if part.away(p) <= self.seam && part.signed_distance(p).0 < self.seam {
                part.solid.exits(part.local(p), &mut |height, n| {
                    let normal = part.axes * n;
                    exits.add(Exit { height, normal });
                });
            }
        }
        let mut best = (f64::NEG_INFINITY, DVec3::Y);
        let mut closed = 0;
        for exit in exits.iter() {
            if !self.hidden(p, exit.height, exit.normal) {
                best = (exit.height, exit.normal);
                break;
            }
            closed += 1;
        }
        // The direction of a step no longer than the seam is rounding.
        let way = |step: DVec3, length: f64, exit: &Exit| {
            let is_long = length > self.seam;
            (-length, if is_long { step / length } else { exit.normal })
        };
        for exit in &exits.list[..closed] {
            let end = p + exit.normal * (self.seam - exit.height);
            self.for_each_exit(p, end, &mut |other| {
                let Some(step) = through_edge(exit, other) else {
                    return;
                };
                let length = step.length();
                if -length <= best.0 {
                    return;
                }
                // Off both faces.
                let off = (exit.normal + other.normal) / (1.0 + exit.normal.dot(other.normal));
                let end = p + step + off * self.seam;
                if !self.covered(end) {
                    best = way(step, length, exit);
                    return;
                }
                self.for_each_exit(p, end, &mut |third| {
                    let Some((step, off)) = through_corner([exit, other, third]) else {
                        return;
                    };
                    let length = step.length();
                    if -length > best.0 && !self.covered(p + step + off * self.seam) {
                        best = way(step, length, exit);
                    }
                });
            });
        }
        if best.0 > f64::NEG_INFINITY {
            best
        } else {
            self.straight(p, &exits)
        }
    }

    /// The faces of the parts around a point through which it is out of the whole; `false` where there are none.
    pub fn exits(&self, p: DVec3, f: &mut dyn FnMut(f64, DVec3)) -> bool {
        let mut any = false;
        for part in self.parts.near(p, self.seam) {
            part.solid.exits(part.local(p), &mut |height, n| {
                let normal = part.axes * n;
                if height < self.seam && !self.hidden(p, height, normal) {
                    any = true;
                    f(height, normal);
                }
            });
        }
        any
    }

    /// The faces of the parts around a point, whether they are out of the whole or not.
    pub fn faces(&self, p: DVec3, f: &mut dyn FnMut(f64, DVec3)) {
        for part in self.parts.near(p, self.seam) {
            let mut turned = |height: f64, n: DVec3| f(height, part.axes * n);
            part.solid.faces(part.local(p), &mut turned);
        }
    }

    /// Where every face is hidden, as for a ball that sticks out of a box: the shortest straight way out among the faces'
    /// directions and the axes, from part to part.
    fn straight(&self, p: DVec3, exits: &Exits) -> (f64, DVec3) {
        let mut best = (f64::NEG_INFINITY, DVec3::Y);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let both = axes.into_iter().flat_map(|axis| [axis, -axis]);
        for n in both.chain(exits.iter().map(|e| e.normal)) {
            let way = self.way_out(p, n);
            if -way > best.0 {
                best = (-way, n);
            }
        }
        if best.0 > f64::NEG_INFINITY {
            best
        } else {
            (0.0, DVec3::Y)
        }
    }

    /// How far it is from `p` along a unit `n` out of all parts \[m\]; `None` from outside, or where there is no end.
    pub fn depth_along(&self, p: DVec3, n: DVec3) -> Option<f64> {
        let way = self.way_out(p, n);
        (way > 0.0 && way.is_finite()).then_some(way)
    }

    /// How far it is from `p` along `n` out of all parts; infinite where there is no end.
    fn way_out(&self, p: DVec3, n: DVec3) -> f64 {
        let beyond = (self.hi - self.lo).length();
        let mut way = 0.0;
        // Every round leaves a part for good, as parts are convex.
        for _ in 0..=self.parts.len() {
            let at = p + n * (way + self.seam);
            let mut farther = way;
            for part in self.parts.near(at, 0.0) {
                if !part.holds(at, 0.0) {
                    continue;
                }
                // Back from far outside: where it enters is where the way leaves.
                let (from, to) = (part.local(at + n * beyond), part.local(at));
                farther = match part.solid.cast(from, to) {
                    Some((t, _)) => farther.max(way + self.seam + (1.0 - t) * beyond),
                    None => f64::INFINITY,
                };
            }
            if farther <= way {
                return way;
            }
            way = farther;
            if !way.is_finite() {
                break;
            }
        }
        f64::INFINITY
    }
}

/// The box that holds a turned box.
fn turned(axes: &DMat3, position: DVec3, (lo, hi): (DVec3, DVec3)) -> (DVec3, DVec3) {
    if !(lo.is_finite() && hi.is_finite()) {
        return (DVec3::NEG_INFINITY, DVec3::INFINITY);
    }
    let (centre, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for i in 0..8 {
        let p = position + *axes * (centre + half * edges::corner(i));
        (low, high) = (low.min(p), high.max(p));
    }
    (low, high)
}
