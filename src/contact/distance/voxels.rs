//! Filled cells of a grid. Each cell knows which of its 26 neighbours are filled, so a point near the surface is answered
//! from one look-up: outside by the nearest filled neighbour, inside by the nearest empty one. A face between two filled
//! cells is never a way out.

use super::primitive;
use super::way::{SELF, Way, bit, is_hidden, neighbours, order, place};
use crate::contact::soup::{Edge, EdgeKind, EdgeSearch, Facet};
use crate::contact::tree::{around, nearest};
use crate::math::{DVec3, wide};
use rapier3d::math::IVector;
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};
use rapier3d::parry::shape::Voxels;

/// Cells in cubes of 8³. Every cube with a filled cell in it or beside it is stored.
pub struct Grid {
    /// Edges of a cell \[m\].
    cell: DVec3,
    chunks: Vec<Chunk>,
    /// Index of the chunk with each key of the box `first`..`first + size`, +1; empty if the box would be too large.
    index: Vec<u32>,
    first: IVector,
    size: IVector,
    /// Chunks with filled cells, and a tree of them for points far from all.
    full: Vec<u32>,
    tree: Bvh,
    /// Of the filled cells \[m\].
    lo: DVec3,
    hi: DVec3,
}

#[derive(PartialEq)]
struct Chunk {
    key: IVector,
    /// Bit x + 3y + 9z (0 to 2 each) for the neighbour at −1, 0, 1; bit 13 is the cell itself.
    near: Box<[u32; 512]>,
}

/// Entries of the index above which chunks are searched for instead (16 MB).
const LARGEST_INDEX: i64 = 1 << 22;
/// Cells from the origin beyond which nothing is looked for, as they are numbered in 32 bits.
const MOST_CELLS: f64 = 1e9;
/// Rings of cells within which the nearest empty one is looked for.
const DEEPEST: i32 = 6;

impl PartialEq for Grid {
    fn eq(&self, other: &Self) -> bool {
        self.cell == other.cell && self.chunks == other.chunks
    }
}

impl std::fmt::Debug for Grid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Grid")
            .field("cell", &self.cell)
            .field("chunks", &self.chunks.len())
            .finish_non_exhaustive()
    }
}

impl Grid {
    /// From parry's; `None` for cells without a finite, positive size.
    pub fn of(voxels: &Voxels) -> Option<Self> {
        let cell = wide(voxels.voxel_size());
        if !(cell.is_finite() && cell.min_element() > 0.0) {
            return None;
        }
        let [low, high] = voxels.domain();
        let one = IVector::splat(1);
        // One cell more on each side: parry's bounds go through `f32` positions.
        let filled: Vec<IVector> = voxels
            .voxels_in_range(low - one, high + one)
            .filter(|v| !v.state.is_empty())
            .map(|v| v.grid_coords)
            .collect();
        let mut keys: Vec<IVector> = filled
            .iter()
            .flat_map(|&c| [-1, 1].map(|d| place(c + IVector::splat(d)).0))
            .collect();
        keys.sort_by_key(|&k| order(k));
        keys.dedup();
        // A cell on the edge of its chunk has neighbours in up to seven more.
        let mut all: Vec<IVector> = Vec::new();
        for &c in &filled {
            if ((c.x & 7) + 1) & 7 < 2 || ((c.y & 7) + 1) & 7 < 2 || ((c.z & 7) + 1) & 7 < 2 {
                all.extend(neighbours(1).map(|step| place(c + step).0));
            }
            if all.len() > 1 << 20 {
                all.sort_by_key(|&k| order(k));
                all.dedup();
            }
        }
        keys.append(&mut all);
        keys.sort_by_key(|&k| order(k));
        keys.dedup();
        let mut grid = Self {
            cell,
            chunks: keys
                .into_iter()
                .map(|key| Chunk {
                    key,
                    near: Box::new([0; 512]),
                })
                .collect(),
            index: Vec::new(),
            first: IVector::splat(0),
            size: IVector::splat(0),
            full: Vec::new(),
            tree: Bvh::new(),
            lo: DVec3::INFINITY,
            hi: DVec3::NEG_INFINITY,
        };
        grid.number();
        grid.fill(&filled);
        Some(grid)
    }

    /// Makes the index, where it is small enough.
    fn number(&mut self) {
        let Some(start) = self.chunks.first().map(|c| c.key) else {
            return;
        };
        let (mut low, mut high) = (start, start);
        for chunk in &self.chunks {
            (low, high) = (low.min(chunk.key), high.max(chunk.key));
        }
        (self.first, self.size) = (low, high - low + IVector::splat(1));
        let room = [self.size.x, self.size.y, self.size.z]
            .iter()
            .try_fold(1_i64, |all, &n| all.checked_mul(i64::from(n)));
        let Some(room) = room.filter(|&r| r <= LARGEST_INDEX) else {
            return;
        };
        self.index = vec![0; room as usize];
        for i in 0..self.chunks.len() {
            let at = self.entry(self.chunks[i].key);
            self.index[at] = i as u32 + 1;
        }
    }

    fn entry(&self, key: IVector) -> usize {
        let k = key - self.first;
        ((k.z * self.size.y + k.y) * self.size.x + k.x) as usize
    }

    fn fill(&mut self, filled: &[IVector]) {
        let mut full: Vec<u32> = Vec::new();
        for &c in filled {
            let low = c.as_dvec3() * self.cell;
            self.lo = self.lo.min(low);
            self.hi = self.hi.max(low + self.cell);
            full.extend(self.chunk(place(c).0).map(|i| i as u32));
            for step in neighbours(1) {
                let (key, at) = place(c + step);
                if let Some(i) = self.chunk(key) {
                    self.chunks[i].near[at] |= bit(-step);
                }
            }
        }
        full.sort_unstable();
        full.dedup();
        let boxes: Vec<(usize, Aabb)> = full
            .iter()
            .enumerate()
            .map(|(k, &i)| {
                let low = (self.chunks[i as usize].key * 8).as_dvec3() * self.cell;
                (k, around(low, low + self.cell * 8.0))
            })
            .collect();
        self.full = full;
        self.tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes);
    }

    #[inline]
    fn chunk(&self, key: IVector) -> Option<usize> {
        if self.index.is_empty() {
            return self
                .chunks
                .binary_search_by_key(&order(key), |c| order(c.key))
                .ok();
        }
        let last = self.first + self.size;
        if key.cmplt(self.first).any() || key.cmpge(last).any() {
            return None;
        }
        (self.index[self.entry(key)] as usize).checked_sub(1)
    }

    /// The neighbours of a cell.
    #[inline]
    fn near(&self, cell: IVector) -> u32 {
        let (key, at) = place(cell);
        self.chunk(key).map_or(0, |i| self.chunks[i].near[at])
    }

    #[inline]
    fn is_filled(&self, cell: IVector) -> bool {
        self.near(cell) & SELF != 0
    }

    /// Edges of a cell \[m\].
    pub fn cell(&self) -> DVec3 {
        self.cell
    }

    /// The box of all filled cells.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        (self.lo, self.hi)
    }

    /// Puts into `out` the edges of the surface that stand out and meet a box.
    pub fn edges_in(&self, (lo, hi): (DVec3, DVec3), search: &mut EdgeSearch, out: &mut Vec<Edge>) {
        out.clear();
        // All cells round an edge in the box.
        let cell = |p: DVec3| (p / self.cell).floor().as_ivec3();
        let one = IVector::splat(1);
        let first = cell(lo.max(self.lo)) - one;
        let last = cell(hi.min(self.hi)) + one;
        let grown = around(lo - self.cell, hi + self.cell);
        let cells = self.tree.intersect_aabb(&grown).flat_map(|k| {
            let key = self.chunks[self.full[k as usize] as usize].key * 8;
            let (low, high) = (first.max(key), last.min(key + IVector::splat(7)));
            (low.z..=high.z).flat_map(move |z| {
                let rows = low.y..=high.y;
                rows.flat_map(move |y| (low.x..=high.x).map(move |x| IVector::new(x, y, z)))
            })
        });
        let facets = cells.flat_map(|c| self.facets(c));
        let stands_out = |edge: &Edge| edge.kind != EdgeKind::Valley;
        search.find(facets, (lo, hi), stands_out, out);
    }

    /// Two triangles for each free side of a filled cell, seen from outside, and their numbers, which begin again after 60
    /// million cells.
    fn facets(&self, cell: IVector) -> impl Iterator<Item = (u32, Facet)> {
        let near = self.near(cell);
        let place = (cell - self.first * 8).as_uvec3();
        let size = self.size.as_uvec3() * 8;
        let number = place.z.wrapping_mul(size.y).wrapping_add(place.y);
        let number = number.wrapping_mul(size.x).wrapping_add(place.x);
        let corner = cell.as_dvec3();
        let width = self.cell;
        let sides = if is_hidden(near) { 0..0 } else { 0..6_usize };
        sides.flat_map(move |side| {
            let (axis, up) = (side / 2, side % 2);
            let unit = |axis: usize| DVec3::AXES[axis % 3];
            let mut step = IVector::splat(0);
            step[axis] = 2 * up as i32 - 1;
            let free = near & bit(step) == 0;
            let base = corner + unit(axis) * up as f64;
            let (u, v) = (unit(axis + 1 + (1 - up)), unit(axis + 2 - (1 - up)));
            let quad = [base, base + u, base + u + v, base + v].map(|p| p * width);
            let first = number.wrapping_mul(12).wrapping_add(2 * side as u32);
            let [a, b, c, d] = quad;
            let triangles = [
                (first, Facet::Triangle([a, b, c])),
                (first.wrapping_add(1), Facet::Triangle([a, c, d])),
            ];
            triangles.into_iter().filter(move |_| free)
        })
    }

    /// Signed distance and normal.
    #[inline]
    pub fn signed_distance(&self, p: DVec3) -> (f64, DVec3) {
        let scaled = p / self.cell;
        // Cells are numbered in 32 bits; what lies beyond is outside, and no number is nowhere.
        if !scaled.abs().cmplt(DVec3::splat(MOST_CELLS)).all() {
            return (p.length(), primitive::direction(p, DVec3::Y).1);
        }
        let cell = scaled.floor().as_ivec3();
        let near = self.near(cell);
        let inside = near & SELF != 0;
        // Distances to the lower and upper faces of the cell.
        let low = p - cell.as_dvec3() * self.cell;
        let high = self.cell - low;
        let wanted = if inside { !near } else { near } & ((1 << 27) - 1) & !SELF;
        let mut best = Way::none();
        if wanted != 0 {
            best.try_neighbours(wanted, low, high);
        }
        // Nothing two cells away is nearer than this.
        let next = (low.min(high) + self.cell).min_element();
        if best.square > next * next {
            if inside {
                self.deep(cell, low, high, &mut best);
            } else {
                self.far(p, cell, &mut best);
            }
        }
        let distance = best.square.sqrt();
        if inside {
            (-distance, best.normal(1.0))
        } else {
            (distance, best.normal(-1.0))
        }
    }

    /// The nearest empty cell beyond the neighbours; below that, the shortest way along an axis.
    fn deep(&self, cell: IVector, low: DVec3, high: DVec3, best: &mut Way) {
        for ring in 2..=DEEPEST {
            let reach = (low.min(high) + self.cell * f64::from(ring - 1)).min_element();
            if best.square <= reach * reach {
                return;
            }
            for step in neighbours(ring) {
                if step.abs().max_element() == ring && !self.is_filled(cell + step) {
                    best.try_cell(step, low, high, self.cell);
                }
            }
        }
        for axis in [IVector::X, IVector::Y, IVector::Z] {
            for way in [axis, -axis] {
                let mut step = way * (DEEPEST + 1);
                while self.is_filled(cell + step) {
                    step += way;
                }
                best.try_cell(step, low, high, self.cell);
            }
        }
    }

    /// The nearest filled cell, from the tree.
    fn far(&self, p: DVec3, cell: IVector, best: &mut Way) {
        // `f32` only orders the search: it may overlook what is nearer by less than its rounding.
        let away = |leaf: usize| self.nearest_in(leaf, p, cell).square.sqrt();
        let found = nearest(&self.tree, p, away);
        if let Some((leaf, _)) = found {
            let way = self.nearest_in(leaf, p, cell);
            if way.square < best.square {
                *best = way;
            }
        }
    }

    fn nearest_in(&self, leaf: usize, p: DVec3, from: IVector) -> Way {
        let Some(chunk) = self
            .full
            .get(leaf)
            .and_then(|&i| self.chunks.get(i as usize))
        else {
            return Way::none();
        };
        let low = p - from.as_dvec3() * self.cell;
        let mut best = Way::none();
        for (i, near) in chunk.near.iter().enumerate() {
            if near & SELF != 0 {
                let i = i as i32;
                let cell = chunk.key * 8 + IVector::new(i & 7, i >> 3 & 7, i >> 6);
                best.try_cell(cell - from, low, self.cell - low, self.cell);
            }
        }
        best
    }

    /// The first filled cell on the way, from one grid plane to the next.
    pub fn cast(&self, a: DVec3, b: DVec3) -> Option<(f64, DVec3)> {
        let (start, path) = (a / self.cell, (b - a) / self.cell);
        let (low, high) = (self.lo / self.cell, self.hi / self.cell);
        // Only the part within the box of all cells.
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for i in 0..3 {
            if path[i] != 0.0 {
                let (s, t) = (
                    (low[i] - start[i]) / path[i],
                    (high[i] - start[i]) / path[i],
                );
                (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
            } else if !(low[i] <= start[i] && start[i] <= high[i]) {
                return None;
            }
        }
        let few = DVec3::splat(MOST_CELLS);
        let countable = start.abs().cmplt(few).all() && path.abs().cmplt(few).all();
        if from > to || !countable {
            return None;
        }
        // Start a little before the box, so that its own faces are crossed like any other.
        let from = (from - 1e-9).max(0.0);
        let begin = start + path * from;
        let mut cell = begin.floor();
        for i in 0..3 {
            // From a plane upwards the cell below is the one just left.
            if path[i] > 0.0 && begin[i] == cell[i] {
                cell[i] -= 1.0;
            }
        }
        if self.is_filled(cell.as_ivec3()) {
            return None;
        }
        let steps = 3 + (path.abs() * (to - from)).element_sum().ceil() as usize;
        for _ in 0..steps + 3 {
            let mut axis = 0;
            let mut first = f64::INFINITY;
            for i in 0..3 {
                if path[i] != 0.0 {
                    let plane = cell[i] + f64::from(u8::from(path[i] > 0.0));
                    let t = (plane - start[i]) / path[i];
                    if t < first {
                        (first, axis) = (t, i);
                    }
                }
            }
            if first > 1.0 {
                return None;
            }
            let side = path[axis].signum();
            cell[axis] += side;
            if self.is_filled(cell.as_ivec3()) {
                return Some((first.max(0.0), -DVec3::AXES[axis] * side));
            }
        }
        None
    }
}
