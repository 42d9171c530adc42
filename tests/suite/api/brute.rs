//! Answers to queries by loops over all faces, and a body to ask about.

use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

pub const ALL: DeformableFilter = DeformableFilter {
    groups: None,
    exclude: None,
    predicate: None,
    line_radius: 0.0,
};

/// Numbers in −1..1, the same in every run.
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }

    pub fn vector(&mut self, size: f32) -> Vector {
        Vector::new(self.roll(), self.roll(), self.roll()) * size
    }
}

/// A block with an outline that nothing is aligned with: every node is shaken by up to 0.2 of a cell.
pub fn shaken(set: &mut DeformableWorld, at: Vector) -> DeformableHandle {
    let net = lattice(Vector::new(1.2, 0.8, 1.0), 0.1);
    let block = DeformableBuilder::new(net).material(Material::elastic(2.0e5, 200.0));
    let handle = set.insert(block.translation(at)).unwrap();
    let mut dice = Dice(3);
    let places: Vec<Vector> = set[handle].positions().collect();
    for (node, place) in (0..).zip(places) {
        assert!(set[handle].set_position(NodeId(node), place + dice.vector(0.02)));
    }
    handle
}

pub fn faces(body: &Deformable) -> Vec<[DVec3; 3]> {
    let at = |n: u32| body.position(NodeId(n)).unwrap();
    body.blueprint().faces.iter().map(|f| f.map(at)).collect()
}

/// Möller and Trumbore's test, so that it is another one than the crate's.
fn meets(origin: DVec3, dir: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let p = dir.cross(ac);
    let det = ab.dot(p);
    let u = (origin - a).dot(p) / det;
    let q = (origin - a).cross(ab);
    let (v, t) = (dir.dot(q) / det, ac.dot(q) / det);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0).then_some(t)
}

pub fn first(faces: &[[DVec3; 3]], ray: &Ray) -> Option<f64> {
    let (o, d) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
    let hits = faces.iter().filter_map(|f| meets(o, d, *f));
    hits.reduce(f64::min)
}

/// Distance by the signs of the borders.
pub fn apart(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let n = (b - a).cross(c - a).normalize();
    let side = |a: DVec3, b: DVec3| (b - a).cross(p - a).dot(n) >= 0.0;
    if side(a, b) && side(b, c) && side(c, a) {
        return (p - a).dot(n).abs();
    }
    let border = |a: DVec3, b: DVec3| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a + (b - a) * t)
    };
    border(a, b).min(border(b, c)).min(border(c, a))
}

/// Solid angle of all faces over 4π: 1 inside, 0 outside (van Oosterom & Strackee 1983).
pub fn winding(faces: &[[DVec3; 3]], p: DVec3) -> f64 {
    let angle = |f: &[DVec3; 3]| {
        let [a, b, c] = f.map(|v| v - p);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    faces.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}
