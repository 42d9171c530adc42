//! Hexahedral cells on a grid, turned into a net cell by cell.
//!
//! Every cell carries its own quarter of its twelve edges and its own half of its twelve face diagonals, so that a
//! single free cell already has the solid's E and ν = ¼ and a surface needs no correction: whatever set of cells is
//! occupied, its springs are the sums of its cells'. A spring *gathers* its sum from the two or four cells around it
//! instead of the cells scattering into a map, which needs no memory per spring, gives the same order on every run, and
//! leaves the springs sorted by their nodes for free.

use crate::body::{BuildError, Net, Node, Spring};
use crate::math::{DVec3, Real, narrow};

/// More nodes than this is a mistake in the units, not a body \[1\].
const MAX_NODES: f64 = 50.0e6;

/// What a spring of a cell is: an edge along axis 0, 1 or 2, or a diagonal of the face across axis 0, 1 or 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Edge(usize),
    Diagonal(usize),
}

/// The nine neighbours of a grid point that come after it in memory, in the order of memory.
const AFTER: [([i64; 3], Kind); 9] = [
    ([1, 0, 0], Kind::Edge(0)),
    ([-1, 1, 0], Kind::Diagonal(2)),
    ([0, 1, 0], Kind::Edge(1)),
    ([1, 1, 0], Kind::Diagonal(2)),
    ([0, -1, 1], Kind::Diagonal(0)),
    ([-1, 0, 1], Kind::Diagonal(1)),
    ([0, 0, 1], Kind::Edge(2)),
    ([1, 0, 1], Kind::Diagonal(1)),
    ([0, 1, 1], Kind::Diagonal(0)),
];

/// Which cells of a box of cells are solid. Cells and grid points are numbered with x fastest.
#[derive(Clone, Debug)]
pub(super) struct CellGrid {
    /// Cells along each axis.
    pub counts: [usize; 3],
    /// One per cell.
    pub occupied: Vec<bool>,
}

impl CellGrid {
    /// `counts` cells along each axis, all solid or all empty.
    ///
    /// # Errors
    /// [`BuildError::Value`] above fifty million grid points.
    pub fn new(counts: [f64; 3], solid: bool) -> Result<Self, BuildError> {
        let points: f64 = counts.iter().map(|n| n + 1.0).product();
        if points.is_nan() || points > MAX_NODES {
            return Err(BuildError::Value {
                what: "the number of nodes of the lattice",
                value: points,
                must: "at most 50 million; use larger cells",
            });
        }
        let counts = counts.map(|n| n as usize);
        Ok(Self {
            counts,
            occupied: vec![solid; counts.iter().product()],
        })
    }

    /// Index of the cell at `at`.
    pub fn cell(&self, at: [usize; 3]) -> usize {
        at[0] + self.counts[0] * (at[1] + self.counts[1] * at[2])
    }

    /// Index of the grid point at `at`.
    pub fn point(&self, at: [usize; 3]) -> usize {
        at[0] + (self.counts[0] + 1) * (at[1] + (self.counts[1] + 1) * at[2])
    }

    /// How many grid points there are.
    pub fn points(&self) -> usize {
        self.counts.iter().map(|n| n + 1).product()
    }

    /// Where cell `index` is.
    pub fn cell_at(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.counts;
        [index % nx, index / nx % ny, index / nx / ny]
    }

    /// The cell at `at` if it is on the grid and solid.
    pub fn solid(&self, at: [i64; 3]) -> Option<usize> {
        let mut inside = [0; 3];
        for axis in 0..3 {
            if at[axis] < 0 || at[axis] >= self.counts[axis] as i64 {
                return None;
            }
            inside[axis] = at[axis] as usize;
        }
        let cell = self.cell(inside);
        self.occupied[cell].then_some(cell)
    }

    /// The grid points of a cell; bit d of the place says whether the corner is the far one along axis d.
    pub fn corners(&self, at: [usize; 3]) -> [usize; 8] {
        std::array::from_fn(|c| self.point(corner(at, c)))
    }

    /// Where the corners of a cell are, given the place of every grid point.
    pub fn places(&self, cell: usize, places: &[DVec3]) -> [DVec3; 8] {
        self.corners(self.cell_at(cell)).map(|point| places[point])
    }

    /// The solid cells that share the spring from grid point `at` to `at + step`.
    fn sharing(&self, at: [i64; 3], step: [i64; 3]) -> impl Iterator<Item = usize> + '_ {
        // Along an axis the spring moves on, its cells are those it spans; along the others, those on both sides.
        let low: [i64; 3] = std::array::from_fn(|d| {
            if step[d] == 0 {
                at[d] - 1
            } else {
                at[d] + step[d].min(0)
            }
        });
        let wide = step.map(|s| if s == 0 { 2 } else { 1 });
        (0..wide[2]).flat_map(move |k| {
            (0..wide[1]).flat_map(move |j| {
                (0..wide[0]).filter_map(move |i| self.solid([low[0] + i, low[1] + j, low[2] + k]))
            })
        })
    }

    /// The net of the solid cells, and the node of each grid point (`u32::MAX` where no solid cell touches it).
    ///
    /// `position` places a grid point \[m\], `share` is a cell's volume at one of its corners \[m³\] and `section` the
    /// section one cell gives a spring of a kind and a length \[m²\].
    pub fn net(
        &self,
        position: impl Fn([usize; 3]) -> DVec3,
        share: impl Fn(usize, usize) -> f64,
        section: impl Fn(usize, Kind, f64) -> f64,
    ) -> (Net, Vec<u32>) {
        let mut volume = vec![0.0_f64; self.points()];
        let mut used = vec![false; self.points()];
        let mut net = Net::default();
        for cell in 0..self.occupied.len() {
            if self.occupied[cell] {
                for (c, point) in self.corners(self.cell_at(cell)).into_iter().enumerate() {
                    volume[point] += share(cell, c);
                    used[point] = true;
                }
            }
        }
        let mut node_of = vec![u32::MAX; self.points()];
        self.each_point(|at, point| {
            if used[point] {
                node_of[point] = net.nodes.len() as u32;
                net.nodes
                    .push(Node::of_volume(narrow(position(at)), volume[point] as Real));
            }
        });
        self.each_point(|at, point| {
            if !used[point] {
                return;
            }
            let here = at.map(|v| v as i64);
            for (step, kind) in AFTER {
                if self.sharing(here, step).next().is_none() {
                    continue;
                }
                let there: [usize; 3] = std::array::from_fn(|d| (here[d] + step[d]) as usize);
                let length = position(at).distance(position(there));
                let sum: f64 = self
                    .sharing(here, step)
                    .map(|cell| section(cell, kind, length))
                    .sum();
                net.springs.push(Spring::of_section(
                    node_of[point],
                    node_of[self.point(there)],
                    sum as Real,
                ));
            }
        });
        for cell in 0..self.occupied.len() {
            if self.occupied[cell] {
                self.faces(cell, |quad| {
                    let [a, b, c, d] = quad.map(|point| node_of[point]);
                    net.faces.extend([[a, b, c], [a, c, d]]);
                });
            }
        }
        (net, node_of)
    }

    /// Calls `each` with the four grid points of every free face of a cell, counter-clockwise seen from outside.
    pub fn faces(&self, cell: usize, mut each: impl FnMut([usize; 4])) {
        let at = self.cell_at(cell);
        let corners = self.corners(at);
        for axis in 0..3 {
            let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
            for far in [0, 1] {
                let mut beyond = at.map(|v| v as i64);
                beyond[axis] += 2 * far as i64 - 1;
                if self.solid(beyond).is_none() {
                    let base = far << axis;
                    let quad = [base, base | u, base | u | v, base | v].map(|c| corners[c]);
                    each(if far == 1 {
                        quad
                    } else {
                        [quad[0], quad[3], quad[2], quad[1]]
                    });
                }
            }
        }
    }

    /// Calls `each` with the place and the index of every grid point, in memory order.
    pub fn each_point(&self, mut each: impl FnMut([usize; 3], usize)) {
        let [nx, ny, nz] = self.counts;
        let mut point = 0;
        for k in 0..=nz {
            for j in 0..=ny {
                for i in 0..=nx {
                    each([i, j, k], point);
                    point += 1;
                }
            }
        }
    }
}

/// The grid point at corner `c` of the cell at `at`.
pub(super) fn corner(at: [usize; 3], c: usize) -> [usize; 3] {
    std::array::from_fn(|d| at[d] + (c >> d & 1))
}
