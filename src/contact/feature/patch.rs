//! A face of a deformable as a patch of surface: a flat triangle, or the bilinear patch between the corners of a quad.

use crate::contact::closest::on_triangle;
use crate::math::DVec3;

/// Corners \[m\], in order round the face; a triangle has three.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    corners: [DVec3; 4],
    count: usize,
}

/// A point of a patch.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    /// Weights of the corners.
    pub weights: [f64; 4],
    /// The point \[m\].
    pub point: DVec3,
    /// Unit normal there, outward.
    pub normal: DVec3,
}

impl Patch {
    /// From three or four corners.
    pub fn new(corners: impl ExactSizeIterator<Item = DVec3>) -> Self {
        let count = corners.len().min(4);
        let mut patch = Self {
            corners: [DVec3::ZERO; 4],
            count,
        };
        for (place, corner) in patch.corners.iter_mut().zip(corners) {
            *place = corner;
        }
        patch
    }

    /// Its corners \[m\].
    pub fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// A ball around it: middle and radius \[m\].
    pub fn ball(&self) -> (DVec3, f64) {
        let middle = self.corners().iter().sum::<DVec3>() / self.count as f64;
        let far = self.corners().iter().map(|c| c.distance_squared(middle));
        (middle, far.fold(0.0, f64::max).sqrt())
    }

    /// Unit normal of its middle; `None` for a patch without area.
    pub fn normal(&self) -> Option<DVec3> {
        let [a, b, c, d] = self.corners;
        let n = if self.count == 3 {
            (b - a).cross(c - a)
        } else {
            (c - a).cross(d - b)
        };
        n.try_normalize()
    }

    /// How high the lowest of some points is over its highest corner along `n` \[m\].
    pub fn lowest(&self, points: &[DVec3], n: DVec3) -> f64 {
        let height = |point: &DVec3| {
            let over = self.corners().iter().map(|c| (*point - *c).dot(n));
            over.fold(f64::INFINITY, f64::min)
        };
        points.iter().map(height).fold(f64::INFINITY, f64::min)
    }

    /// By how much the normals at its corners differ, about \[rad\]; 0 for a triangle.
    pub fn twist(&self) -> f64 {
        let [a, b, c, d] = self.corners;
        if self.count == 3 {
            return 0.0;
        }
        (a - b + c - d).length() / a.distance(c).max(b.distance(d))
    }

    /// By how much its middle rises over the ends of its diagonals, or these over it \[m\]; 0 for a triangle.
    pub fn highest_rise(&self) -> DVec3 {
        let [a, b, c, d] = self.corners;
        if self.count == 3 {
            return DVec3::ZERO;
        }
        (a - b + c - d) * 0.25
    }

    /// By how much its middle rises over the ends of a line on it that goes through that in a direction, from side to side, about
    /// \[m\].
    pub fn rise(&self, along: DVec3) -> DVec3 {
        let [a, b, c, d] = self.corners;
        let (u, v) = (0.5 * (b - a + c - d), 0.5 * (d - a + c - b));
        let n = u.cross(v);
        let (du, dv) = (along.cross(v).dot(n), u.cross(along).dot(n));
        // x'' = 2u'v'·(a − b + c − d), and a chord of length 1 in the larger of u and v.
        (a - b + c - d) * (-0.25 * du * dv / du.abs().max(dv.abs()).powi(2))
    }

    /// Where a point comes down on it; `None` outside.
    pub fn foot(&self, p: DVec3) -> Option<Foot> {
        let n = self.normal()?;
        if self.count == 3 {
            self.on_triangle(p, n)
        } else {
            self.on_quad(p, n)
        }
    }

    /// The nearest place of the border.
    pub fn foot_on_border(&self, p: DVec3) -> Option<Foot> {
        let n = self.count;
        let feet = (0..n).map(|k| {
            let (a, b) = (self.corners[k], self.corners[(k + 1) % n]);
            let share = ((p - a).dot(b - a) / a.distance_squared(b)).clamp(0.0, 1.0);
            (k, share, a.lerp(b, share))
        });
        let far = |(_, _, point): &(usize, f64, DVec3)| point.distance_squared(p);
        let (k, share, point) = feet.min_by(|a, b| far(a).total_cmp(&far(b)))?;
        let mut weights = [0.0; 4];
        (weights[k], weights[(k + 1) % n]) = (1.0 - share, share);
        Some(Foot {
            weights,
            point,
            normal: self.normal()?,
        })
    }

    fn on_triangle(&self, p: DVec3, n: DVec3) -> Option<Foot> {
        let [a, b, c, _] = self.corners;
        let area = (b - a).cross(c - a).dot(n);
        let u = (c - b).cross(p - b).dot(n) / area;
        let v = (a - c).cross(p - c).dot(n) / area;
        let weights = [u, v, 1.0 - u - v, 0.0];
        self.inside(weights).then(|| Foot {
            weights,
            point: p - n * (p - a).dot(n),
            normal: n,
        })
    }

    /// Newton's method for x(u, v) = a(1−u)(1−v) + bu(1−v) + cuv + d(1−u)v seen along the normal. For a parallelogram it
    /// ends in one step.
    fn on_quad(&self, p: DVec3, n: DVec3) -> Option<Foot> {
        let [a, b, c, d] = self.corners;
        let (mut u, mut v) = (0.5, 0.5);
        let mut last = None;
        for _ in 0..6 {
            let along_u = (b - a) * (1.0 - v) + (c - d) * v;
            let along_v = (d - a) * (1.0 - u) + (c - b) * u;
            let weights = weights(u, v);
            let point = a * weights[0] + b * weights[1] + c * weights[2] + d * weights[3];
            let normal = along_u.cross(along_v);
            let area = normal.dot(n);
            last = Some((weights, point, normal));
            // Folded over.
            if area <= 0.0 || area.is_nan() {
                return None;
            }
            let off = p - point;
            let (du, dv) = (
                off.cross(along_v).dot(n) / area,
                along_u.cross(off).dot(n) / area,
            );
            if du.abs().max(dv.abs()) < 1e-9 {
                break;
            }
            (u, v) = (u + du, v + dv);
        }
        let (weights, point, normal) = last?;
        let normal = normal.try_normalize()?;
        self.inside(weights).then_some(Foot {
            weights,
            point,
            normal,
        })
    }

    /// Where a ball around a point touches it, or would: from there the way to the point is along the normal. A flat patch has no
    /// other such place than [`Self::foot`]; only for quads. Newton's method for the least distance.
    pub fn foot_of_ball(&self, centre: DVec3) -> Option<Foot> {
        let [a, b, c, d] = self.corners;
        let twist = a - b + c - d;
        let (mut u, mut v) = (0.5, 0.5);
        for _ in 0..8 {
            let (point, along_u, along_v) = self.at(u, v);
            let off = centre - point;
            let (uu, vv) = (along_u.length_squared(), along_v.length_squared());
            let uv = along_u.dot(along_v) - off.dot(twist);
            let area = uu * vv - uv * uv;
            // So far from a patch so twisted no place is nearest.
            if area <= 0.0 || area.is_nan() {
                return None;
            }
            let (fu, fv) = (off.dot(along_u), off.dot(along_v));
            let (du, dv) = ((fu * vv - fv * uv) / area, (fv * uu - fu * uv) / area);
            (u, v) = (u + du, v + dv);
            if du.abs().max(dv.abs()) < 1e-9 {
                break;
            }
        }
        let (point, along_u, along_v) = self.at(u, v);
        let weights = weights(u, v);
        let normal = along_u.cross(along_v).try_normalize()?;
        self.inside(weights).then_some(Foot {
            weights,
            point,
            normal,
        })
    }

    /// The place \[u, v\] of a quad, and how that moves with u and with v \[m\].
    fn at(&self, u: f64, v: f64) -> (DVec3, DVec3, DVec3) {
        let [a, b, c, d] = self.corners;
        let twist = a - b + c - d;
        let (from_u, from_v) = (b - a, d - a);
        let (along_u, along_v) = (from_u + twist * v, from_v + twist * u);
        (a + along_u * u + from_v * v, along_u, along_v)
    }

    /// Whether the way from one point, which is close to it, to another goes through it.
    pub fn is_between(&self, near: DVec3, far: DVec3) -> bool {
        let Some(foot) = self.foot(near) else {
            return false;
        };
        let [from, to] = [near, far].map(|p| (p - foot.point).dot(foot.normal));
        from * to < 0.0 && self.foot(near.lerp(far, from / (from - to))).is_some()
    }

    /// The unit normal of a quad under a point, on the side of `n`, which is that of its middle or the opposite; `None` beside
    /// it. Found as [`Self::foot`] is, from the place \[u, v\] of one nearby, well enough for a normal.
    pub fn normal_below(&self, p: DVec3, n: DVec3, [u, v]: &mut [f64; 2]) -> Option<DVec3> {
        let [a, b, c, d] = self.corners;
        let front = (c - a).cross(d - b).dot(n);
        for _ in 0..6 {
            let (point, along_u, along_v) = self.at(*u, *v);
            let normal = along_u.cross(along_v);
            let area = normal.dot(n);
            // Folded over.
            if area * front <= 0.0 || area.is_nan() {
                return None;
            }
            let off = p - point;
            let du = off.cross(along_v).dot(n) / area;
            let dv = along_u.cross(off).dot(n) / area;
            (*u, *v) = (*u + du, *v + dv);
            if du.abs().max(dv.abs()) < 1e-4 {
                let inside = u.min(*v) >= -1e-9 && u.max(*v) <= 1.0 + 1e-9;
                return inside.then(|| normal.normalize() * 1.0_f64.copysign(front));
            }
        }
        None
    }

    /// How far a point is from it, or less \[m\].
    pub fn apart(&self, p: DVec3) -> f64 {
        let [a, b, c, d] = self.corners;
        let far = |corners: [DVec3; 3]| on_triangle(p, &corners).point(&corners).distance(p);
        if self.count == 3 {
            return far([a, b, c]);
        }
        // The patch is nowhere farther from two triangles over its corners than a quarter of its twist.
        let twist = (a - b + c - d).length();
        far([a, b, c]).min(far([a, c, d])) - 0.25 * twist
    }

    fn inside(&self, weights: [f64; 4]) -> bool {
        weights.iter().all(|w| *w >= -1e-9)
    }
}

/// The weights of the corners of a quad at the place \[u, v\].
fn weights(u: f64, v: f64) -> [f64; 4] {
    [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v]
}

#[cfg(test)]
mod tests;
