//! A facet, and the nearest point of one.

use crate::math::DVec3;

/// A facet as the shape has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Facet {
    /// Corners \[m\], counter-clockwise seen from its front.
    Triangle([DVec3; 3]),
    /// Ends \[m\].
    Segment([DVec3; 2]),
}

impl Facet {
    /// Its corners or ends \[m\].
    pub fn points(&self) -> &[DVec3] {
        match self {
            Self::Triangle(points) => points,
            Self::Segment(points) => points,
        }
    }

    /// Lowest and highest coordinates \[m\].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let points = self.points();
        points.iter().fold((points[0], points[0]), |(lo, hi), &p| {
            (lo.min(p), hi.max(p))
        })
    }
}

/// A triangle whose area is below this part of its longest side squared is as good as that side: its plane is unknown, and
/// the tolerance of crossings closes the slit it leaves.
const FLAT: f64 = 1.0e-12;

/// A facet with what every query of it needs.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Patch {
    /// The facet's id in its soup.
    pub id: u32,
    /// First corner \[m\].
    pub a: DVec3,
    /// To the second corner \[m\].
    pub ab: DVec3,
    /// To the third corner \[m\]; 0 for a line.
    pub ac: DVec3,
    /// Unit normal of the front; 0 for a line: a segment, or a triangle without area.
    pub normal: DVec3,
    /// Longest side \[m\].
    pub size: f64,
    /// ab·ab, ab·ac and ac·ac, over the square of twice the area.
    metric: [f64; 3],
    /// 1 over the squares of ab, bc and ca.
    per_side2: [f64; 3],
}

/// The point of a facet nearest to a given one.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    /// Squared distance \[m²\].
    pub distance2: f64,
    /// Where it is \[m\].
    pub point: DVec3,
    /// Whether it lies within the facet rather than on its rim.
    pub face: bool,
}

impl Patch {
    /// Prepares facet `id`.
    pub fn new(id: u32, facet: &Facet) -> Self {
        let [a, b, c] = match *facet {
            Facet::Segment([a, b]) => return Self::line(id, a, b),
            Facet::Triangle(corners) => corners,
        };
        let (ab, ac) = (b - a, c - a);
        let sides = [
            ab.length_squared(),
            (c - b).length_squared(),
            ac.length_squared(),
        ];
        let longest = sides[0].max(sides[1]).max(sides[2]);
        let cross = ab.cross(ac);
        let twice_area = cross.length();
        if twice_area > FLAT * longest {
            let scale = 1.0 / (twice_area * twice_area);
            return Self {
                id,
                a,
                ab,
                ac,
                normal: cross / twice_area,
                size: longest.sqrt(),
                metric: [sides[0] * scale, ab.dot(ac) * scale, sides[2] * scale],
                per_side2: sides.map(per),
            };
        }
        if sides[0] == longest {
            Self::line(id, a, b)
        } else if sides[1] == longest {
            Self::line(id, b, c)
        } else {
            Self::line(id, a, c)
        }
    }

    fn line(id: u32, a: DVec3, b: DVec3) -> Self {
        Self {
            id,
            a,
            ab: b - a,
            ac: DVec3::ZERO,
            normal: DVec3::ZERO,
            size: (b - a).length(),
            metric: [0.0; 3],
            per_side2: [per((b - a).length_squared()); 3],
        }
    }

    /// Whether it has length only.
    #[inline]
    pub fn is_line(&self) -> bool {
        self.normal == DVec3::ZERO
    }

    /// Signed distance from its plane, positive in front \[m\]; 0 for a line.
    #[inline]
    pub fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p - self.a)
    }

    /// Its sides as point and vector; a line has one.
    pub fn sides(&self) -> ([(DVec3, DVec3); 3], usize) {
        let sides = [
            (self.a, self.ab),
            (self.a + self.ab, self.ac - self.ab),
            (self.a + self.ac, -self.ac),
        ];
        (sides, if self.is_line() { 1 } else { 3 })
    }

    /// The nearest point to `p`.
    #[inline]
    pub fn foot(&self, p: DVec3) -> Foot {
        let ap = p - self.a;
        if self.is_line() {
            return on_side(self.a, self.ab, self.per_side2[0], p);
        }
        // Barycentric coordinates of the projection.
        let (d1, d2) = (self.ab.dot(ap), self.ac.dot(ap));
        let v = self.metric[2] * d1 - self.metric[1] * d2;
        let w = self.metric[0] * d2 - self.metric[1] * d1;
        let u = 1.0 - v - w;
        if u >= 0.0 && v >= 0.0 && w >= 0.0 {
            let height = self.normal.dot(ap);
            return Foot {
                distance2: height * height,
                point: p - self.normal * height,
                face: true,
            };
        }
        self.rim_foot(p, u, v, w)
    }

    /// The nearest point lies on one of the sides that `p` is beyond.
    fn rim_foot(&self, p: DVec3, u: f64, v: f64, w: f64) -> Foot {
        let mut best = Foot {
            distance2: f64::INFINITY,
            point: self.a,
            face: false,
        };
        let mut try_side = |a: DVec3, ab: DVec3, per: f64| {
            let foot = on_side(a, ab, per, p);
            if foot.distance2 < best.distance2 {
                best = foot;
            }
        };
        if w < 0.0 {
            try_side(self.a, self.ab, self.per_side2[0]);
        }
        if v < 0.0 {
            try_side(self.a, self.ac, self.per_side2[2]);
        }
        if u < 0.0 {
            try_side(self.a + self.ab, self.ac - self.ab, self.per_side2[1]);
        }
        best
    }
}

/// The inverse of a squared length, finite for none.
pub fn per(length2: f64) -> f64 {
    1.0 / length2.max(f64::MIN_POSITIVE)
}

/// The nearest point of the segment from `a` along `ab`, of which 1 over the squared length is `per`.
#[inline]
pub fn on_side(a: DVec3, ab: DVec3, per: f64, p: DVec3) -> Foot {
    let t = (p - a).dot(ab) * per;
    let point = a + ab * t.clamp(0.0, 1.0);
    Foot {
        distance2: p.distance_squared(point),
        point,
        face: false,
    }
}
