//! Along which directions a corner or an edge can push, or be pushed: those that nothing of its surface goes.

use super::beside::SAME;
use super::distance::Solid;
use super::site::Reach;
use crate::math::DVec3;

/// How far, as a sine, what is beside a point that is to touch may lean over: a face rocks a little.
const LEAN: f64 = 0.1;

/// The same beside a point that touched last: what it presses bends round it.
const HELD: f64 = 0.5;

/// Whether a corner or an edge can push along a unit `direction`; `cone` are unit directions of its surface away from it, 0 for
/// what is not there.
pub fn can_push(cone: impl IntoIterator<Item = DVec3>, direction: DVec3, touched: bool) -> bool {
    let lean = if touched { HELD } else { LEAN };
    cone.into_iter().all(|c| c.dot(direction) <= lean)
}

/// The least and the largest cosine of a direction with those of a cone, or 0.
fn range(cone: &[DVec3], direction: DVec3) -> (f64, f64) {
    let along = cone.iter().map(|c| c.dot(direction));
    along.fold((0.0_f64, 0.0_f64), |(lo, hi), x| (lo.min(x), hi.max(x)))
}

/// Whether the unit `normal` is slanted by more than the sine `lean`: a part of the surface goes into what would push it so and a
/// part away from it. A normal between those of the faces beside the point is not slanted, nor is one over a hollow that is
/// wrapped round what pushes it.
fn is_slanted(cone: &[DVec3], normal: DVec3, lean: f64) -> bool {
    let (lo, hi) = range(cone, normal);
    lo < -lean && (hi > lean || lo <= -ACROSS)
}

/// Directions in which the surface around a point can be pushed there: those nearest to a unit `normal` that is slanted, and where
/// the surface stands out the outermost ones, as those of both faces at a rim along which the normal lies.
fn upright(cone: &[DVec3], normal: DVec3) -> impl Iterator<Item = DVec3> {
    let signs = [1.0, -1.0].into_iter();
    let nearest = signs.filter_map(move |sign| nearest(cone, normal, sign));
    nearest.chain(outermost(cone, normal))
}

/// The direction nearest to `normal` in which a surface can be pushed that stands out here, or by a `sign` of -1 one that is hollow as
/// seen from what pushes it.
fn nearest(cone: &[DVec3], normal: DVec3, sign: f64) -> Option<DVec3> {
    let mut n = normal;
    for _ in 0..SWEEPS {
        let before = n;
        for c in cone {
            n -= c * (sign * (sign * c.dot(n)).min(0.0));
        }
        if n == before {
            break;
        }
    }
    // Of what is along the surface nothing is left but rounding.
    let n = (n.length_squared() > ROUNDING * ROUNDING).then(|| n.normalize())?;
    let (lo, hi) = range(cone, n);
    let leans = if sign > 0.0 { -lo } else { hi };
    (leans <= ROUNDING).then_some(n)
}

/// The outermost directions across the one that lies most along `normal`, in which a surface can be pushed that stands out.
fn outermost(cone: &[DVec3], normal: DVec3) -> impl Iterator<Item = DVec3> {
    let along = cone.iter().copied();
    let along = along.max_by(|a, b| a.dot(normal).abs().total_cmp(&b.dot(normal).abs()));
    let along = along.unwrap_or_default();
    let across = cone.iter().map(move |c| along.cross(*c));
    let across = across.filter(|n| n.length_squared() > LEAN * LEAN);
    let both = across.map(DVec3::normalize).flat_map(|n| [n, -n]);
    let outermost = both.filter(|n| range(cone, *n).0 >= -ROUNDING);
    // There are two at most, found once for each edge that lies in their faces.
    let mut known = [DVec3::ZERO; 2];
    outermost.filter(move |n| {
        let is_new = known
            .iter()
            .all(|k| k.distance_squared(*n) > ROUNDING * ROUNDING);
        if is_new {
            known = [known[1], *n];
        }
        is_new
    })
}

/// A point of a surface that a solid may push along a unit normal, in the solid's frame.
#[derive(Clone, Copy, Debug)]
pub struct Pushed {
    /// Where it is \[m\].
    pub place: DVec3,
    /// The direction in which it would be pushed.
    pub normal: DVec3,
    /// How deep it is along that \[m\], `skin` m being kept from the solid.
    pub depth: f64,
    /// The distance that is kept \[m\].
    pub skin: f64,
    /// Whether it touched last.
    pub touched: bool,
}

impl Pushed {
    /// Whether it lies beside the solid, although that would push it in this substep: its normal is slanted, see `is_slanted`, and in some
    /// direction in which its surface can be pushed no point of the solid reaches over it by more than what counts as shallow, nor
    /// does after the `way` of this point relative to that one \[m\] while the solid makes its `turn` \[rad\], or it passes below the
    /// rim of what would push it, see `passes_rim`. Then it is a face beside the point that is touched, if anything is, and a normal
    /// force at the point would brake what slides there and turn what rolls: a cube that slides over a flat sheet does not meet the
    /// edges ahead with its side, nor does a ball. What touched bears something as yet, and must be slanted more to be left.
    ///
    /// `cone` are unit directions of the surface away from the point, 0 for what is not there; more than 16 are not looked at.
    pub fn lies_beside<I: Iterator<Item = DVec3>>(
        &self,
        solid: &Solid,
        reach: &Reach,
        cone: impl FnOnce() -> I,
        (way, turn): (impl Fn(DVec3) -> DVec3, DVec3),
    ) -> bool {
        let Self { place, normal, .. } = *self;
        // What is not reached brakes nothing.
        if self.depth - way(place).dot(normal) < -reach.shallow() {
            return false;
        }
        let (mut directions, mut count) = ([DVec3::ZERO; MOST], 0);
        for (to, from) in directions.iter_mut().zip(cone()) {
            *to = from;
            count += 1;
        }
        let is_apart = |n: DVec3| {
            let over = solid.farthest_over(place, n);
            if !over.is_some_and(|over| self.skin + over.dot(n) <= reach.shallow()) {
                return false;
            }
            // The point that is farthest when the solid has turned.
            let over = solid.farthest_over(place, n + n.cross(turn));
            over.is_some_and(|over| {
                self.skin + (over - way(place + over)).dot(n) <= reach.shallow()
            })
        };
        let lean = if self.touched { LEAN } else { ROUNDING };
        let cone = &directions[..count];
        if !is_slanted(cone, normal, lean) {
            return false;
        }
        if upright(cone, normal).any(is_apart) || self.passes_rim(solid, reach, cone) {
            return true;
        }
        // At a rim or a corner, one of its faces may look between the outermost directions. One that is not the face which would
        // push may lean over them: a sheet slopes up a little ahead of what it bears.
        let mut beside = false;
        solid.exits(place, &mut |height, n| {
            let lean = if n.dot(normal) < SAME { LEAN } else { ROUNDING };
            beside |= height >= self.skin - reach.shallow()
                && cone.iter().all(|c| c.dot(n) >= -lean)
                && is_apart(n);
        });
        beside
    }

    /// Whether its surface, nearly flat here, goes straight into what would push it and comes out beyond the rim of that: behind the face
    /// that would push, it is outside of the solid. However it bends farther on, and whatever comes down on it: the rim meets it first.
    fn passes_rim(&self, solid: &Solid, reach: &Reach, cone: &[DVec3]) -> bool {
        let is_level = |n: DVec3| {
            n.dot(self.normal).abs() < LEVEL && cone.iter().all(|c| c.dot(n).abs() < LEVEL)
        };
        if !upright(cone, self.normal).any(is_level) {
            return false;
        }
        // Not through a thin plate.
        let behind = (BEHIND * reach.shallow()).min(0.5 * solid.width());
        let least = self.skin - behind / BEHIND;
        let beyond = |c: DVec3| {
            let way = (self.skin - self.depth + behind) / -c.dot(self.normal);
            solid.signed_distance(self.place + c * way.max(0.0)).0 >= least
        };
        let into = |c: &&DVec3| c.dot(self.normal) < -STRAIGHT;
        let mut straight = cone.iter().filter(into).peekable();
        straight.peek().is_some() && straight.all(|c| beyond(*c))
    }
}

/// The sine by which a surface may be bent and count as nearly flat: round the corners of a heavy load it is folded, and held by
/// all that touches it.
const LEVEL: f64 = 0.35;

/// The cosine from which on a direction goes straight into a face: of four edges in a plane one goes so at least.
const STRAIGHT: f64 = 0.5;

/// How far behind a face it is looked whether a surface has gone into it or past its rim, per what counts as shallow: what has
/// gone in is deeper there.
const BEHIND: f64 = 4.0;

/// How many directions of a cone are looked at.
const MOST: usize = 16;

/// How often all of a cone is gone through.
const SWEEPS: usize = 4;

/// How slanted, as a sine, what counts as upright may be.
const ROUNDING: f64 = 1e-2;

/// The sine from which on what would push a border pushes it along its own face, from within.
const ACROSS: f64 = 0.9;

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::geometry::SharedShape;

    const REACH: Reach = Reach {
        h: 1e-3,
        touching: 1e-5,
        farthest: 0.1,
        slack: 1e-3,
    };

    #[test]
    fn what_is_slanted_is_set_upright() {
        let stays = |cone: &[DVec3], n| !is_slanted(cone, n, ROUNDING);
        let of = |cone: &[DVec3], n| {
            assert!(!stays(cone, n), "{n}");
            upright(cone, n).collect::<Vec<_>>()
        };
        let slanted = |sine: f64| DVec3::new(sine, -(1.0 - sine * sine).sqrt(), 0.0);
        let flat = [DVec3::X, -DVec3::X, DVec3::Z, -DVec3::Z];
        assert!(stays(&flat, -DVec3::Y));
        for sine in [0.05, 0.7, 0.99] {
            assert!(of(&flat, slanted(sine)).contains(&-DVec3::Y));
        }
        let up_and_down = [-DVec3::Y, DVec3::Y];
        let is_upright = |found: Vec<DVec3>| up_and_down.iter().all(|n| found.contains(n));
        assert!(is_upright(of(&flat, DVec3::X)));
        // On a ridge all normals between those of its sides stay; beyond one they end at that.
        let ridge = [DVec3::new(0.8, -0.6, 0.0), DVec3::new(-0.8, -0.6, 0.0)];
        assert!(stays(&ridge, -DVec3::Y) && stays(&ridge, slanted(0.5)));
        let most = of(&ridge, slanted(0.65));
        assert!(most[0].distance(slanted(0.6)) < 1e-6, "{most:?}");
        // A sheet that is wrapped round an edge is held by it.
        let wrapped = [-DVec3::X, -DVec3::Y];
        let out = DVec3::new(1.0, 1.0, 0.0).normalize();
        assert!(stays(&wrapped, out));
        // A border is pushed by what it runs into, not by what lies on its face.
        let border = [DVec3::ZERO, DVec3::X, DVec3::Z, -DVec3::Z];
        assert!(stays(&border, DVec3::X));
        assert!(is_upright(of(&border, -DVec3::X)));
        // Along a rim, a little bent, it may be any between those of its two faces.
        let ahead = DVec3::new(1.0, 4e-4, 2e-4).normalize();
        let rim = [-DVec3::Y, -DVec3::X, ahead, DVec3::Z];
        for along in [DVec3::X, -DVec3::X] {
            let found = of(&rim, along);
            let has = |n: DVec3| found.iter().any(|m| m.distance(n) < 1e-3);
            assert!(has(-DVec3::Y) && has(DVec3::Z), "{found:?}");
            assert!(!has(DVec3::Y) && !has(-DVec3::Z), "{found:?}");
        }
    }

    /// Whether a point of a flat surface under a solid lies beside it, as it goes and turns.
    fn on_a_plane(
        solid: &Solid,
        (place, normal): (DVec3, DVec3),
        touched: bool,
        (way, turn): (DVec3, DVec3),
    ) -> bool {
        let flat = [DVec3::X, -DVec3::X, DVec3::Z, -DVec3::Z];
        let pushed = Pushed {
            place,
            normal,
            depth: -solid.signed_distance(place).0,
            skin: 0.0,
            touched,
        };
        let way = |p: DVec3| way - turn.cross(p);
        pushed.lies_beside(solid, &REACH, || flat.into_iter(), (way, turn))
    }

    #[test]
    fn a_flat_surface_is_under_a_cube_and_not_ahead_of_it() {
        let cube = Solid::of(&*SharedShape::cuboid(1.0, 1.0, 1.0)).unwrap();
        let at_turning = |x: f64, y: f64, way: f64, turn: DVec3| {
            let at = (DVec3::new(x, y, 0.0), DVec3::X);
            on_a_plane(&cube, at, false, (DVec3::new(-0.2, way, 0.0), turn))
        };
        let at = |x, y, way| at_turning(x, y, way, DVec3::ZERO);
        assert!(at(1.1, -1.00002, 0.0));
        assert!(at(1.1, -0.99995, 0.0));
        // What stands against its side is held by that.
        assert!(!at(1.1, -0.9, 0.0));
        // Its lower face comes down on what is ahead of it, not its side.
        assert!(at(1.1, -1.0, 0.01));
        // What is not reached is not looked at.
        assert!(!at(1.3, -1.0, 0.0));
        for turn in [DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::X] {
            assert!(at_turning(1.1, -1.0, 0.0, 0.01 * turn));
        }
    }

    /// A sheet is under a cube though it slopes up ahead of it; what is as far from flat before a wall is held by that.
    #[test]
    fn a_slope_is_under_a_cube_and_a_ripple_is_before_a_wall() {
        let cube = Solid::of(&*SharedShape::cuboid(1.0, 1.0, 1.0)).unwrap();
        let beside = |place: DVec3, cone: [DVec3; 4], way: f64| {
            let pushed = Pushed {
                place,
                normal: DVec3::X,
                depth: 1.0 - place.x,
                skin: 0.0,
                touched: false,
            };
            let way = |_| -DVec3::X * way;
            pushed.lies_beside(&cube, &REACH, || cone.into_iter(), (way, DVec3::ZERO))
        };
        let sloping = |sine: f64| DVec3::new((1.0 - sine * sine).sqrt(), sine, 0.0);
        let under = |sine| {
            let cone = [sloping(sine), -DVec3::X, DVec3::Z, -DVec3::Z];
            beside(DVec3::new(1.1, -1.00002, 0.0), cone, 0.2)
        };
        assert!(under(0.0) && under(0.05) && under(0.3) && !under(0.4));
        // What bulges up before it is under it as long as it is lower at its rim, and behind that.
        let bulging = |height: f64| {
            let cone = [sloping(-0.05), -sloping(0.05), DVec3::Z, -DVec3::Z];
            beside(DVec3::new(1.1, height - 1.0, 0.0), cone, 0.2)
        };
        assert!(bulging(0.001) && bulging(0.0049) && !bulging(0.0055) && !bulging(0.05));
        // What goes through a plate is not beyond its rim.
        for half in [1e-2, 1e-4, 1e-6] {
            let plate = Solid::of(&*SharedShape::cuboid(half as f32, 1.0, 1.0)).unwrap();
            let pushed = Pushed {
                place: DVec3::new(half + 0.01, 0.0, 0.0),
                normal: DVec3::X,
                depth: -0.01,
                skin: 0.0,
                touched: false,
            };
            let flat = [DVec3::X, -DVec3::X, DVec3::Z, -DVec3::Z];
            let way = |_| -DVec3::X * 0.1;
            assert!(!pushed.lies_beside(&plate, &REACH, || flat.into_iter(), (way, DVec3::ZERO)));
        }
        let ripple = DVec3::new(0.05, sloping(0.05).x, 0.0);
        let before = [ripple, -ripple, DVec3::Z, -DVec3::Z];
        assert!(!beside(DVec3::new(1.0002, 0.0, 0.0), before, 2.2e-4));
    }

    #[test]
    fn a_ball_touches_a_flat_surface_with_its_lowest_point() {
        let ball = Solid::of(&*SharedShape::ball(1.0)).unwrap();
        let at = |x: f64, touched| {
            let place = DVec3::new(x, -1.0, 0.0);
            let way = (-DVec3::X, DVec3::ZERO);
            on_a_plane(&ball, (place, place.normalize()), touched, way)
        };
        assert!(!at(0.0, false) && at(0.05, false) && at(0.9, false));
        assert!(!at(0.05, true) && at(0.2, true));
    }

    #[test]
    fn what_leans_over_can_push_only_if_it_touched() {
        let leaning = |sine: f64| [DVec3::new((1.0 - sine * sine).sqrt(), sine, 0.0), -DVec3::Y];
        assert!(can_push(leaning(0.05), DVec3::Y, false));
        assert!(!can_push(leaning(0.2), DVec3::Y, false));
        assert!(can_push(leaning(0.2), DVec3::Y, true));
        assert!(!can_push(leaning(0.6), DVec3::Y, true));
        assert!(can_push([DVec3::ZERO; 2], DVec3::Y, false));
    }
}
