//! A flat sheet: a membrane of springs with a little resistance to folding.
//!
//! A plane of central springs with springs along the sides and both diagonals of every cell is isotropic with ν = ⅓ when
//! the sides have k = 3Et/4 and the diagonals k = 3Et/8 (t the thickness). As in the lattice, every cell brings its own
//! half of its four sides, so that a border needs no correction. Springs that skip one node keep the sheet from folding
//! at a node; they also pull in the plane, so what they add there is taken from the sides they run along, and the
//! membrane stays exact.

use crate::body::error::positive;
use crate::body::{BuildError, Net, Node, Spring};
use crate::math::{DVec3, Real, narrow};

/// The `bending_share` of [`sheet`] \[1\].
pub const BENDING_SHARE: Real = 0.1;

/// More nodes than this is a mistake \[1\].
const MAX_NODES: f64 = 50.0e6;
/// As for the lattice: the squared aspect at which the diagonals are softened to leave some stiffness to the sides.
const MAX_ASPECT: f64 = 2.85;

/// A sheet of `width` along x and `height` along z \[m\], centred on the origin in the plane y = 0, of `nx` by `ny` nodes
/// and a `thickness` \[m\], with [`BENDING_SHARE`]. Nodes are numbered with x fastest; the faces look to +y and both
/// sides count.
///
/// The membrane has exactly E·thickness and ν = ⅓ for cells whose sides differ by less than a factor 1.69; narrower cells
/// are softer in shear.
///
/// # Errors
/// [`BuildError::Value`] if a size is not positive and finite, there are fewer than two nodes along a side or more than
/// fifty million in all.
pub fn sheet(
    width: Real,
    height: Real,
    nx: usize,
    ny: usize,
    thickness: Real,
) -> Result<Net, BuildError> {
    sheet_with_bending(width, height, nx, ny, thickness, BENDING_SHARE)
}

/// A [`sheet`] whose skip-one springs carry `bending_share` of the stiffness along each line of nodes, from 0 (none) to
/// less than 1. The whole in the plane is the same for every share, also along borders.
///
/// Central springs in a flat sheet resist bending only at second order: a fold by an angle φ over nodes a apart shortens
/// the skip-one spring by a·φ²/4. That stops creases; it does not model a plate.
///
/// # Errors
/// Those of [`sheet`], and [`BuildError::Value`] for a share outside \[0, 1).
pub fn sheet_with_bending(
    width: Real,
    height: Real,
    nx: usize,
    ny: usize,
    thickness: Real,
    bending_share: Real,
) -> Result<Net, BuildError> {
    let sheet = Sheet::new([width, height, thickness], [nx, ny], bending_share)?;
    let nodes = sheet.places().map(|place| sheet.node(place)).collect();
    let mut net = Net::new(nodes, Vec::new());
    for place in sheet.places() {
        sheet.add_springs(place, &mut net.springs);
        net.faces
            .extend(sheet.triangles(place).into_iter().flatten());
    }
    Ok(net)
}

/// What a sheet is made of.
struct Sheet {
    /// Width and height \[m\].
    size: [f64; 2],
    thickness: f64,
    /// Nodes along both.
    count: [usize; 2],
    /// From node to node \[m\].
    step: [f64; 2],
    cell: Cell,
    share: f64,
}

impl Sheet {
    fn new(
        [width, height, thickness]: [Real; 3],
        [nx, ny]: [usize; 2],
        bending_share: Real,
    ) -> Result<Self, BuildError> {
        let [w, h, t] = [
            positive("the width of the sheet", width.into())?,
            positive("the height of the sheet", height.into())?,
            positive("the thickness of the sheet", thickness.into())?,
        ];
        let share = f64::from(bending_share);
        if !(0.0..1.0).contains(&share) {
            return Err(BuildError::Value {
                what: "the bending share of the sheet",
                value: share,
                must: "0 or more and less than 1",
            });
        }
        for (what, n) in [
            ("the number of nodes along the sheet's width", nx),
            ("the number of nodes along the sheet's height", ny),
        ] {
            if n < 2 {
                return Err(BuildError::Value {
                    what,
                    value: n as f64,
                    must: "at least 2",
                });
            }
        }
        let count = nx as f64 * ny as f64;
        if count > MAX_NODES {
            return Err(BuildError::Value {
                what: "the number of nodes of the sheet",
                value: count,
                must: "at most 50 million",
            });
        }
        let step = [w / (nx - 1) as f64, h / (ny - 1) as f64];
        Ok(Self {
            size: [w, h],
            thickness: t,
            count: [nx, ny],
            step,
            cell: Cell::new(step[0], step[1], t),
            share,
        })
    }

    /// The columns and rows of its nodes, in their order.
    fn places(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let [nx, ny] = self.count;
        (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j]))
    }

    fn index(&self, i: usize, j: usize) -> u32 {
        (i + self.count[0] * j) as u32
    }

    /// On how many sides of a line of nodes along `axis`, `at` along the other, there are cells.
    fn sides(&self, axis: usize, at: usize) -> f64 {
        let n = self.count[1 - axis];
        if at == 0 || at == n - 1 { 1.0 } else { 2.0 }
    }

    fn node(&self, [i, j]: [usize; 2]) -> Node {
        let ([w, h], [a, b]) = (self.size, self.step);
        let at = DVec3::new(i as f64 * a - 0.5 * w, 0.0, j as f64 * b - 0.5 * h);
        let volume = 0.25 * a * b * self.thickness * self.sides(1, i) * self.sides(0, j);
        Node::of_volume(narrow(at), volume as Real)
    }

    /// Of the stiffness of a line of nodes along `axis`, what its segment from one to the next keeps: the skip-one springs
    /// over it, one at the ends and two elsewhere, take half the share each.
    fn kept(&self, axis: usize, at: usize) -> f64 {
        let over = usize::from(at > 0) + usize::from(at + 2 < self.count[axis]);
        1.0 - 0.5 * self.share * over as f64
    }

    /// Adds the springs from a node to those behind it.
    fn add_springs(&self, [i, j]: [usize; 2], springs: &mut Vec<Spring>) {
        let ([nx, ny], cell, skip) = (self.count, &self.cell, 0.5 * self.share);
        let (along_x, along_z) = (cell.x * self.sides(0, j), cell.z * self.sides(1, i));
        let here = self.index(i, j);
        let mut add = |is_there: bool, i: usize, j: usize, section: f64| {
            if is_there && section > 0.0 {
                let there = self.index(i, j);
                springs.push(Spring::of_section(here, there, section as Real));
            }
        };
        let (right, down) = (i + 1 < nx, j + 1 < ny);
        add(right, i + 1, j, along_x * self.kept(0, i));
        add(i + 2 < nx, i + 2, j, along_x * skip);
        add(down && i > 0, i.wrapping_sub(1), j + 1, cell.diagonal);
        add(down, i, j + 1, along_z * self.kept(1, j));
        add(down && right, i + 1, j + 1, cell.diagonal);
        add(j + 2 < ny, i, j + 2, along_z * skip);
    }

    /// The triangles of the cell behind a node, if there is one.
    fn triangles(&self, [i, j]: [usize; 2]) -> Option<[[u32; 3]; 2]> {
        let [nx, ny] = self.count;
        let is_there = i + 1 < nx && j + 1 < ny;
        is_there.then(|| {
            let [here, right] = [self.index(i, j), self.index(i + 1, j)];
            let [down, across] = [self.index(i, j + 1), self.index(i + 1, j + 1)];
            [[here, across, right], [here, down, across]]
        })
    }
}

/// Sections that one cell gives: half of a side along x, half of a side along z, a whole diagonal \[m²\].
struct Cell {
    x: f64,
    z: f64,
    diagonal: f64,
}

impl Cell {
    /// A cell of sides `a` and `b` and thickness `t` \[m\].
    ///
    /// λ = μ = 3Et/8 in the plane: the diagonals give C₁₁₂₂ = μ, the sides what is missing to C₁₁₁₁ = 3μ.
    fn new(a: f64, b: f64, t: f64) -> Self {
        let whole = 3.0 * t / 8.0;
        let (a2, b2) = (a * a, b * b);
        let mu = whole * (MAX_ASPECT * a2.min(b2) / a2.max(b2)).min(1.0);
        let d2 = a2 + b2;
        let side = |a: f64, b: f64| 0.5 * (3.0 * whole * b / a - mu * a / b) * a;
        Self {
            x: side(a, b),
            z: side(b, a),
            diagonal: mu * d2 / (2.0 * a * b) * d2.sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::wide;

    const YOUNG: f64 = 1.0e6;

    fn pull(nx: usize, ny: usize, size: [Real; 2], share: Real) {
        let net = sheet_with_bending(size[0], size[1], nx, ny, 0.002, share).unwrap();
        net.check().unwrap();
        let strain = 1e-5;
        let e = DVec3::new(strain, 0.0, -strain / 3.0);
        let mut forces = vec![DVec3::ZERO; net.nodes.len()];
        let mut energy = 0.0;
        for s in &net.springs {
            let [p, q] = s.nodes.map(|n| n as usize);
            let d = wide(net.nodes[q].position) - wide(net.nodes[p].position);
            let k = YOUNG * f64::from(s.section) / d.length();
            let stretch = d.normalize().dot(d * e);
            energy += 0.5 * k * stretch * stretch;
            forces[p] += d.normalize() * k * stretch;
            forces[q] -= d.normalize() * k * stretch;
        }
        let area = f64::from(size[0]) * f64::from(size[1]);
        let uniaxial = 0.5 * YOUNG * 0.002 * strain * strain * area;
        assert!(
            (energy / uniaxial - 1.0).abs() < 1e-4,
            "{energy} {uniaxial}"
        );
        let axial = YOUNG * 0.002 * f64::from(size[1]) * strain;
        let mut ends = 0.0;
        for (node, f) in net.nodes.iter().zip(&forces) {
            // With ν = ⅓ no force is left but the pull at the two ends.
            assert!(f.z.abs() < 1e-4 * axial, "{f} at {}", node.position);
            if (node.position.x.abs() - 0.5 * size[0]).abs() > 1e-6 {
                assert!(f.x.abs() < 1e-4 * axial, "{f} at {}", node.position);
            } else {
                ends += f.x.abs();
            }
        }
        assert!((ends / axial / 2.0 - 1.0).abs() < 1e-4, "{ends} {axial}");
    }

    #[test]
    fn a_membrane_has_young_times_thickness_and_a_third() {
        for share in [0.0, 0.1, 0.5] {
            pull(6, 6, [1.0, 1.0], share);
            pull(9, 2, [0.8, 0.1], share);
            pull(5, 5, [1.0, 1.5], share);
        }
    }

    #[test]
    fn a_sheet_has_its_volume_and_faces_up() {
        let net = sheet(1.0, 2.0, 5, 9, 0.01).unwrap();
        assert_eq!(net.nodes.len(), 45);
        let volume: Real = net.nodes.iter().map(|n| n.volume).sum();
        assert!((volume / 0.02 - 1.0).abs() < 1e-5);
        for f in &net.faces {
            let [a, b, c] = f.map(|n| net.nodes[n as usize].position);
            assert!((b - a).cross(c - a).y > 0.0);
        }
    }

    #[test]
    fn narrow_cells_keep_positive_springs_and_bad_values_are_errors() {
        let net = sheet(1.0, 0.01, 3, 3, 0.01).unwrap();
        assert!(net.springs.iter().all(|s| s.section > 0.0));
        for bad in [
            sheet(Real::NAN, 1.0, 3, 3, 0.1),
            sheet(1.0, 1.0, 1, 3, 0.1),
            sheet(1.0, 1.0, 3, 3, -0.1),
            sheet(1.0, 1.0, usize::MAX, usize::MAX, 0.1),
            sheet_with_bending(1.0, 1.0, 3, 3, 0.1, 1.0),
            sheet_with_bending(1.0, 1.0, 3, 3, 0.1, Real::NAN),
        ] {
            assert!(matches!(bad, Err(BuildError::Value { .. })), "{bad:?}");
        }
    }
}
