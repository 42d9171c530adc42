//! Surfaces without thickness: meshes, height fields, triangles, polylines, as soups of facets.
//!
//! parry answers distances to them in `f32`, is never inside a plain mesh, and picks its side at random on the surface
//! itself. Here it only says which facets lie in a box; all geometry of a facet is done in `f64`.
//!
//! A thin surface has no inside, so a node must remember the side it is on. What it remembers is a *point* rather than a
//! normal: an anchor, the last place where it was known to be on the right side ([`Touches::anchor`]). If the straight
//! way from the anchor to the node crosses a facet, the node has been pushed through there, however far that is and
//! whichever facet is nearest now; if it does not, the node has gone round the border and is free. A remembered normal
//! cannot tell these two apart.

mod crossing;
mod edges;
mod facet;
mod gather;
mod inside;
mod near;
mod overhang;
mod search;
mod slide;
mod touch;

#[cfg(test)]
mod tests;

pub use edges::{Edge, EdgeKind, EdgeSearch};
pub use facet::Facet;
pub use gather::NodeFacets;
pub use inside::Exit;
pub use overhang::{Margins, Overhang, bearing};
pub use touch::{Touches, touches};

use crate::math::DVec3;
use edges::Edges;
use rapier3d::geometry::{Shape, SharedShape, TriMeshFlags, TypedShape};
use std::fmt;
use std::sync::Arc;

/// A surface shape seen as facets, in the shape's own frame.
#[derive(Clone)]
pub struct Soup {
    shape: SharedShape,
    radius: f64,
    oriented: bool,
    /// Of a mesh; other shapes find theirs when asked.
    edges: Option<Arc<Edges>>,
}

impl fmt::Debug for Soup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Soup")
            .field("shape", &self.shape.shape_type())
            .field("radius", &self.radius)
            .field("oriented", &self.oriented)
            .finish_non_exhaustive()
    }
}

impl PartialEq for Soup {
    /// Whether they are the same shape, or one of the same numbers.
    fn eq(&self, other: &Self) -> bool {
        use TypedShape as T;
        if Arc::ptr_eq(&self.shape.0, &other.shape.0) {
            return true;
        }
        match (self.shape.as_typed_shape(), other.shape.as_typed_shape()) {
            (T::TriMesh(a), T::TriMesh(b)) => {
                a.flags() == b.flags() && a.indices() == b.indices() && a.vertices() == b.vertices()
            }
            (T::HeightField(a), T::HeightField(b)) => {
                a.scale() == b.scale()
                    && (a.nrows(), a.ncols()) == (b.nrows(), b.ncols())
                    && a.heights().data() == b.heights().data()
                    && a.cells_statuses().data() == b.cells_statuses().data()
            }
            (T::Polyline(a), T::Polyline(b)) => {
                a.indices() == b.indices() && a.vertices() == b.vertices()
            }
            (T::Segment(a), T::Segment(b)) => a == b,
            (T::Triangle(a), T::Triangle(b)) => a == b,
            (T::RoundTriangle(a), T::RoundTriangle(b)) => {
                a.inner_shape == b.inner_shape && a.border_radius == b.border_radius
            }
            _ => false,
        }
    }
}

impl Soup {
    /// Whether a shape is of a kind that [`Soup::of`] takes.
    pub fn takes(shape: &dyn Shape) -> bool {
        use TypedShape as T;
        matches!(
            shape.as_typed_shape(),
            T::TriMesh(_)
                | T::HeightField(_)
                | T::Triangle(_)
                | T::RoundTriangle(_)
                | T::Segment(_)
                | T::Polyline(_)
        )
    }

    /// The soup of a mesh, height field, triangle, rounded triangle, segment or polyline; `None` for other shapes.
    ///
    /// Takes O(n log n) for a mesh of n triangles: keep it as long as the collider keeps its shape.
    pub fn of(shape: &SharedShape) -> Option<Self> {
        let mut soup = Self {
            shape: shape.clone(),
            radius: 0.0,
            oriented: false,
            edges: None,
        };
        match shape.as_typed_shape() {
            TypedShape::TriMesh(mesh) => {
                let edges = Edges::of(&soup, mesh.num_triangles() as u32);
                soup.oriented = mesh.flags().contains(TriMeshFlags::ORIENTED) && edges.closed;
                soup.edges = Some(Arc::new(edges));
            }
            TypedShape::RoundTriangle(s) => soup.radius = f64::from(s.border_radius).max(0.0),
            TypedShape::HeightField(_)
            | TypedShape::Triangle(_)
            | TypedShape::Segment(_)
            | TypedShape::Polyline(_) => {}
            _ => return None,
        }
        Some(soup)
    }

    /// Half the thickness the shape itself gives its facets, 0 unless it is a rounded one \[m\].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Whether the winding says what is inside: a mesh with parry's `ORIENTED` flag and without borders. An open mesh has
    /// no inside, flag or not.
    pub fn oriented(&self) -> bool {
        self.oriented
    }

    /// A facet by its id; `None` where there is none, or not a finite one.
    pub fn facet(&self, id: u32) -> Option<Facet> {
        let facet = match self.shape.as_typed_shape() {
            TypedShape::TriMesh(mesh) => {
                let corners = mesh.indices().get(id as usize)?;
                let corner = |i: u32| Some(mesh.vertices().get(i as usize)?.as_dvec3());
                Facet::Triangle([
                    corner(corners[0])?,
                    corner(corners[1])?,
                    corner(corners[2])?,
                ])
            }
            TypedShape::HeightField(field) => {
                let t = field.triangle_at_id(id)?;
                Facet::Triangle([t.a, t.b, t.c].map(|v| v.as_dvec3()))
            }
            TypedShape::Triangle(t) if id == 0 => {
                Facet::Triangle([t.a, t.b, t.c].map(|v| v.as_dvec3()))
            }
            TypedShape::RoundTriangle(s) if id == 0 => {
                let t = &s.inner_shape;
                Facet::Triangle([t.a, t.b, t.c].map(|v| v.as_dvec3()))
            }
            TypedShape::Segment(s) if id == 0 => Facet::Segment([s.a, s.b].map(|v| v.as_dvec3())),
            TypedShape::Polyline(line) => {
                let ends = line.indices().get(id as usize)?;
                let end = |i: u32| Some(line.vertices().get(i as usize)?.as_dvec3());
                Facet::Segment([end(ends[0])?, end(ends[1])?])
            }
            _ => return None,
        };
        facet
            .points()
            .iter()
            .all(|p| p.is_finite())
            .then_some(facet)
    }
}

/// Whether two boxes meet, borders included; never if anything is NaN.
fn meets(lo: DVec3, hi: DVec3, other_lo: DVec3, other_hi: DVec3) -> bool {
    lo.cmple(other_hi).all() && other_lo.cmple(hi).all()
}
