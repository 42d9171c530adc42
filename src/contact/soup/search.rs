//! Which facets lie in a box.

use super::{Soup, meets};
use crate::contact::tree::around;
use crate::math::DVec3;
use rapier3d::geometry::{HeightField, TypedShape};
use rapier3d::parry::partitioning::Bvh;
use std::ops::Range;

impl Soup {
    /// Puts into `out`, in ascending order, the ids of the facets whose boxes meet the one from `lo` to `hi` \[m\].
    pub fn facets_in(&self, lo: DVec3, hi: DVec3, out: &mut Vec<u32>) {
        out.clear();
        // NaN compares false.
        if !lo.cmple(hi).all() {
            return;
        }
        match self.shape.as_typed_shape() {
            TypedShape::TriMesh(mesh) => leaves(mesh.bvh(), lo, hi, out),
            TypedShape::Polyline(line) => leaves(line.bvh(), lo, hi, out),
            TypedShape::HeightField(field) => cells(field, lo, hi, out),
            _ => out.push(0),
        }
        out.retain(|&id| {
            self.facet(id).is_some_and(|facet| {
                let (facet_lo, facet_hi) = facet.bounds();
                meets(lo, hi, facet_lo, facet_hi)
            })
        });
    }
}

/// The leaves of parry's tree that meet a box, sorted.
fn leaves(bvh: &Bvh, lo: DVec3, hi: DVec3, out: &mut Vec<u32>) {
    out.extend(bvh.intersect_aabb(&around(lo, hi)));
    out.sort_unstable();
}

/// The triangles of the cells under a box. parry's own walk over them is not used: it makes their corners by another
/// formula than `triangle_at_id`, and the last bits decide whether neighbours have a gap.
fn cells(field: &HeightField, lo: DVec3, hi: DVec3, out: &mut Vec<u32>) {
    let scale = field.scale().as_dvec3();
    let rows = range(lo.z, hi.z, scale.z, field.nrows());
    let columns = range(lo.x, hi.x, scale.x, field.ncols());
    let half = (field.nrows() * field.ncols()) as u32;
    // parry numbers the left triangles of all cells first, column by column.
    for first in [0, half] {
        for column in columns.clone() {
            let start = first + (column * field.nrows()) as u32;
            out.extend(rows.clone().map(|row| start + row as u32));
        }
    }
}

/// The cells along one side of a height field that an interval covers.
fn range(lo: f64, hi: f64, scale: f64, count: usize) -> Range<usize> {
    let n = count as f64;
    let (a, b) = ((lo / scale + 0.5) * n, (hi / scale + 0.5) * n);
    if a.is_nan() || b.is_nan() {
        return 0..count;
    }
    // parry's coordinates are f32.
    let slack = 1.0e-6 * (n + 1.0);
    let start = (a.min(b) - slack).floor().clamp(0.0, n) as usize;
    let end = (a.max(b) + slack).ceil().clamp(0.0, n) as usize;
    start..end.max(start)
}
