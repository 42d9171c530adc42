//! Signed distance and outward normal of a point to a solid collider, in the collider's own frame.
//!
//! Everything is computed in `f64` from the shape's own numbers instead of parry's projections: a projection that lands on
//! the point itself has no direction, the `f32` direction of one that lands a micrometre away is noise that tilts a resting
//! box by tens of degrees, and parry's answers for thin hulls, round shapes and the inside of compounds are wrong. Here the
//! normal on a surface is that of the face, and continuous through it.
//!
//! A convex solid is a core grown by a radius: a ball is a grown point, a capsule a grown segment, and parry's round shapes
//! are its sharp ones grown. So there is one closed form per core, and every query is written once.

mod compound;
mod crossing;
mod edges;
mod exits;
mod hull;
mod line;
mod parts;
mod planes;
mod primitive;
mod quickhull;
mod rim;
#[cfg(test)]
mod tests;
mod voxels;
mod way;

use crate::body::Surface;
use crate::math::{DQuat, DVec3, wide};
use compound::Compound;
pub use crossing::{Crossing, StraightEdge};
use hull::Hull;
use quickhull::Outline;
use rapier3d::geometry::{Shape, TriMesh, TypedShape};
pub use rim::Rim;
use std::sync::Arc;
use voxels::Grid;

/// Most triangles of a mesh that may be a hull, and by what share of its volume the two may differ.
const MOST_TRIANGLES: usize = 128;
const AS_LARGE: f64 = 1e-5;

/// A collider shape with an inside. Cheap to clone: what is large is shared.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    core: Core,
    /// By how much the core is grown \[m\].
    radius: f64,
}

/// What a solid is before it is grown. Lengths in m.
#[derive(Clone, Debug, PartialEq)]
enum Core {
    /// The origin.
    Point,
    /// Between two points.
    Segment(DVec3, DVec3),
    /// Half extents.
    Cuboid(DVec3),
    /// Along y: half height and radius.
    Cylinder(f64, f64),
    /// Along y, the apex up: half height and radius of the base.
    Cone(f64, f64),
    /// Everything below a plane through 0 with this outward normal.
    HalfSpace(DVec3),
    /// A convex polyhedron.
    Hull(Arc<Hull>),
    /// Solids that act as one.
    Compound(Arc<Compound>),
    /// Filled cells of a grid.
    Voxels(Arc<Grid>),
}

/// The turns that map a solid onto itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Symmetry {
    /// None, or a few.
    None,
    /// All about an axis.
    Axis {
        /// A point of it \[m\].
        centre: DVec3,
        /// Its unit direction.
        along: DVec3,
    },
    /// All about a point \[m\].
    Point(DVec3),
}

impl Solid {
    /// The solid of a parry shape; `None` for surfaces, curves and custom shapes, for a compound with such a part, and for
    /// hulls and voxels that are not finite. Hulls, compounds and voxels are worked out here, so keep what you get.
    pub fn of(shape: &dyn Shape) -> Option<Self> {
        use TypedShape as T;
        let grown = |core: Core, radius: f32| Self {
            core,
            radius: f64::from(radius).max(0.0),
        };
        Some(match shape.as_typed_shape() {
            T::Ball(s) => grown(Core::Point, s.radius),
            T::Capsule(s) => grown(
                Core::Segment(wide(s.segment.a), wide(s.segment.b)),
                s.radius,
            ),
            T::Cuboid(s) => grown(Core::cuboid(s.half_extents), 0.0),
            T::RoundCuboid(s) => grown(Core::cuboid(s.inner_shape.half_extents), s.border_radius),
            T::Cylinder(s) => grown(Core::cylinder(s.half_height, s.radius), 0.0),
            T::RoundCylinder(s) => grown(
                Core::cylinder(s.inner_shape.half_height, s.inner_shape.radius),
                s.border_radius,
            ),
            T::Cone(s) => grown(Core::cone(s.half_height, s.radius), 0.0),
            T::RoundCone(s) => grown(
                Core::cone(s.inner_shape.half_height, s.inner_shape.radius),
                s.border_radius,
            ),
            T::HalfSpace(s) => grown(
                Core::HalfSpace(wide(s.normal).try_normalize().unwrap_or(DVec3::Y)),
                0.0,
            ),
            T::ConvexPolyhedron(s) => grown(Core::hull(s.points())?, 0.0),
            T::RoundConvexPolyhedron(s) => {
                grown(Core::hull(s.inner_shape.points())?, s.border_radius)
            }
            T::Compound(s) => grown(Core::Compound(Arc::new(Compound::of(s)?)), 0.0),
            T::Voxels(s) => grown(Core::Voxels(Arc::new(Grid::of(s)?)), 0.0),
            _ => return None,
        })
    }

    /// The solid of a closed mesh whose winding tells its outside, if that is convex and has few triangles: their hull, whose corners
    /// and edges know of each other, and whose every query is a loop over all planes.
    pub fn of_convex_mesh(mesh: &TriMesh) -> Option<Self> {
        let (points, count) = (mesh.vertices().len(), mesh.indices().len());
        if count > MOST_TRIANGLES || points > 3 * count {
            return None;
        }
        let core = Core::hull(mesh.vertices())?;
        let Core::Hull(hull) = &core else {
            return None;
        };
        let surface = Surface::new(mesh.vertices().to_vec(), mesh.indices().to_vec());
        let (volume, whole) = (surface.volume(), hull.volume());
        // A hull holds its mesh, and is no larger only where it is that.
        (whole > 0.0 && (whole - volume).abs() < AS_LARGE * whole)
            .then_some(Self { core, radius: 0.0 })
    }

    /// Whether a shape is of a kind that [`Solid::of`] takes, without working anything out.
    pub fn takes(shape: &dyn Shape) -> bool {
        use TypedShape as T;
        match shape.as_typed_shape() {
            T::Compound(s) => s.shapes().iter().all(|(_, part)| Self::takes(&**part)),
            T::TriMesh(_)
            | T::HeightField(_)
            | T::Polyline(_)
            | T::Segment(_)
            | T::Triangle(_)
            | T::RoundTriangle(_)
            | T::Custom(_) => false,
            _ => true,
        }
    }

    /// Whether it has several parts.
    pub fn is_compound(&self) -> bool {
        matches!(self.core, Core::Compound(_))
    }

    /// Whether it may have hollows, where something can lie against several of its faces: compounds and voxels.
    pub fn is_hollow(&self) -> bool {
        matches!(self.core, Core::Compound(_) | Core::Voxels(_))
    }

    /// Whether there may be one within `reach` m of a point: where a compound has but one convex part, there is none.
    pub fn has_hollow_at(&self, p: DVec3, reach: f64) -> bool {
        match &self.core {
            Core::Compound(compound) => compound.has_hollow_at(p, reach),
            _ => self.is_hollow(),
        }
    }

    /// Signed distance (negative inside) \[m\] and outward unit normal at `p` \[m\]. Exact, but for compounds and voxels
    /// deep inside.
    #[inline]
    pub fn signed_distance(&self, p: DVec3) -> (f64, DVec3) {
        let (d, n) = match &self.core {
            Core::Point => primitive::direction(p, DVec3::Y),
            Core::Segment(a, b) => primitive::segment(p, *a, *b),
            Core::Cuboid(half) => primitive::cuboid(p, *half),
            Core::Cylinder(half_height, radius) => primitive::cylinder(p, *half_height, *radius),
            Core::Cone(half_height, radius) => primitive::cone(p, *half_height, *radius),
            Core::HalfSpace(normal) => (p.dot(*normal), *normal),
            Core::Hull(hull) => hull.signed_distance(p),
            Core::Compound(compound) => compound.signed_distance(p),
            Core::Voxels(grid) => grid.signed_distance(p),
        };
        (d - self.radius, n)
    }

    /// How deep `p` lies below the supporting plane with outward unit normal `n` \[m\], or below the surface of a compound in that
    /// direction; `None` where there is none: outside of a compound, for voxels, and a half-space in any direction but its own.
    pub fn depth_along(&self, p: DVec3, n: DVec3) -> Option<f64> {
        if let Core::HalfSpace(normal) = self.core {
            return (normal.dot(n) > 1.0 - 1e-9).then(|| -p.dot(normal));
        }
        if let Core::Compound(compound) = &self.core {
            return compound.depth_along(p, n);
        }
        Some((self.support(n)? - p).dot(n))
    }

    /// From `p` to the point that reaches farthest over it in a direction, which need not be a unit vector \[m\]; of voxels that of
    /// their box. `None` for half-spaces, which reach anywhere.
    pub fn farthest_over(&self, p: DVec3, n: DVec3) -> Option<DVec3> {
        let farthest = match &self.core {
            Core::Compound(_) => {
                let mut farthest = None;
                self.for_each_convex(&mut |offset, turn, part| {
                    let point = part.support(turn.inverse() * n);
                    let point = point.map(|point| offset + turn * point);
                    let farther = |a: DVec3, b: DVec3| if b.dot(n) > a.dot(n) { b } else { a };
                    farthest = match (farthest, point) {
                        (Some(a), Some(b)) => Some(farther(a, b)),
                        (a, b) => a.or(b),
                    };
                });
                farthest
            }
            Core::Voxels(grid) => {
                let (lo, hi) = grid.bounds();
                Some(DVec3::select(n.cmpgt(DVec3::ZERO), hi, lo))
            }
            _ => self.support(n),
        };
        farthest.map(|point| point - p)
    }

    /// The point farthest in a direction, which need not be a unit vector \[m\]; `None` for compounds, voxels and half-spaces.
    pub fn support(&self, direction: DVec3) -> Option<DVec3> {
        let sign = primitive::signs(direction);
        let rim = |radius: f64| primitive::radial(direction).1 * radius;
        let core = match &self.core {
            Core::Point => DVec3::ZERO,
            Core::Segment(a, b) if (*b - *a).dot(direction) > 0.0 => *b,
            Core::Segment(a, _) => *a,
            Core::Cuboid(half) => *half * sign,
            Core::Cylinder(half_height, radius) => rim(*radius) + DVec3::Y * (half_height * sign.y),
            Core::Cone(half_height, radius) => {
                let (apex, base) = (
                    DVec3::Y * *half_height,
                    rim(*radius) - DVec3::Y * *half_height,
                );
                if (base - apex).dot(direction) > 0.0 {
                    base
                } else {
                    apex
                }
            }
            Core::Hull(hull) => hull.support(direction),
            Core::HalfSpace(_) | Core::Compound(_) | Core::Voxels(_) => return None,
        };
        Some(core + primitive::direction(direction, DVec3::Y).1 * self.radius)
    }

    /// Lower and upper corner of its box \[m\]; infinite for a half-space.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        match &self.core {
            Core::Compound(compound) => compound.bounds(),
            Core::Voxels(grid) => grid.bounds(),
            _ => {
                let far = |axis: DVec3| self.support(axis).map_or(f64::INFINITY, |p| p.dot(axis));
                (
                    -DVec3::new(far(DVec3::NEG_X), far(DVec3::NEG_Y), far(DVec3::NEG_Z)),
                    DVec3::new(far(DVec3::X), far(DVec3::Y), far(DVec3::Z)),
                )
            }
        }
    }

    /// Smallest extent \[m\]: 0.002 for a 2 mm plate, the smallest over the parts of a compound, a cell for voxels,
    /// infinite for a half-space.
    pub fn width(&self) -> f64 {
        let core = match &self.core {
            Core::Point | Core::Segment(..) => 0.0,
            Core::Cuboid(half) => 2.0 * half.min_element(),
            Core::Cylinder(half_height, radius) => 2.0 * half_height.min(*radius),
            Core::Cone(half_height, radius) => {
                // Upright, or lying on its mantle.
                let height = 2.0 * half_height;
                let slant = height.hypot(*radius).max(f64::MIN_POSITIVE);
                height.min(2.0 * radius * height / slant)
            }
            Core::HalfSpace(_) => f64::INFINITY,
            Core::Hull(hull) => hull.width(),
            Core::Compound(compound) => compound.width(),
            Core::Voxels(grid) => grid.cell().min_element(),
        };
        core + 2.0 * self.radius
    }

    /// Radius of its roundest edges \[m\]: what the core was grown by, 0 for sharp ones.
    pub fn edge_radius(&self) -> f64 {
        self.radius
    }

    /// The turns that map it onto itself.
    pub fn symmetry(&self) -> Symmetry {
        match &self.core {
            Core::Point => Symmetry::Point(DVec3::ZERO),
            Core::Segment(a, b) => match (*b - *a).try_normalize() {
                Some(along) => Symmetry::Axis {
                    centre: 0.5 * (*a + *b),
                    along,
                },
                None => Symmetry::Point(*a),
            },
            Core::Cylinder(..) | Core::Cone(..) => Symmetry::Axis {
                centre: DVec3::ZERO,
                along: DVec3::Y,
            },
            Core::Cuboid(_)
            | Core::HalfSpace(_)
            | Core::Hull(_)
            | Core::Compound(_)
            | Core::Voxels(_) => Symmetry::None,
        }
    }

    /// Itself, or the parts of a compound with their positions \[m\] and rotations in its frame. Voxels have none: their
    /// cells are too many and act together.
    pub fn for_each_convex(&self, f: &mut dyn FnMut(DVec3, DQuat, &Self)) {
        match &self.core {
            Core::Compound(compound) => compound.for_each_convex(f),
            Core::Voxels(_) => {}
            _ => f(DVec3::ZERO, DQuat::IDENTITY, self),
        }
    }
}

impl Core {
    fn cuboid(half: rapier3d::math::Vector) -> Self {
        Self::Cuboid(wide(half).max(DVec3::ZERO))
    }

    fn cylinder(half_height: f32, radius: f32) -> Self {
        Self::Cylinder(f64::from(half_height).max(0.0), f64::from(radius).max(0.0))
    }

    fn cone(half_height: f32, radius: f32) -> Self {
        Self::Cone(f64::from(half_height).max(0.0), f64::from(radius).max(0.0))
    }

    /// A hull without any extent is a point, one with a single extent a segment.
    fn hull(points: &[rapier3d::math::Vector]) -> Option<Self> {
        let points: Vec<DVec3> = points.iter().map(|&p| wide(p)).collect();
        Some(match quickhull::outline(&points)? {
            Outline::Segment(a, b) => Self::Segment(a, b),
            Outline::Faces(faces) => Self::Hull(Arc::new(Hull::new(&points, &faces))),
        })
    }
}
