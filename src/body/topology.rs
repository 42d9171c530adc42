//! What of a body's surface can be touched besides its nodes: faces, their edges, and whether they close.

use super::Blueprint;
use super::adjacency::Adjacency;
use super::tears::Torn;
use crate::math::{DVec3, wide};
use std::collections::BTreeMap;

/// No node.
pub const NONE: u32 = u32::MAX;

/// A triangle or a quad, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// Three nodes.
    Triangle([u32; 3]),
    /// Four nodes.
    Quad([u32; 4]),
}

impl Face {
    /// Its nodes.
    pub fn nodes(&self) -> &[u32] {
        match self {
            Self::Triangle(nodes) => nodes,
            Self::Quad(nodes) => nodes,
        }
    }
}

/// The nodes of a face that are next to the first and to the second end of one of its edges.
pub type Wing = [u32; 2];

/// Faces and edges of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// Triangles over the nodes, and flat quads where two of them make one: a triangle of a quad would lean to its diagonal.
    pub faces: Vec<Face>,
    /// Per face of the blueprint which of these it is, or is half of.
    pub part_of: Vec<u32>,
    /// Each edge of a face once, in ascending order, but for the diagonals of flat quads: whatever lies across a diagonal lies
    /// across two sides. Of a body without faces, its springs.
    pub edges: Vec<[u32; 2]>,
    /// The faces to the left and to the right of each edge, seen from outside, by the next node from either end: of a triangle
    /// its third one, twice. [`NONE`] on a border, and between more than two faces or such as don't agree on an outside. None
    /// of a body without faces.
    pub wings: Vec<[Wing; 2]>,
    /// The edges at each node; none of a body without faces.
    pub around: Option<Adjacency>,
    /// Whether the faces enclose a volume: every edge belongs to two faces that agree on which side is outside. A surface
    /// that is open has no outside, and both sides count.
    pub closed: bool,
    /// Whether all faces that share an edge agree on which side is which, and no more than two do.
    pub oriented: bool,
    /// Mean length of the edges at rest \[m\].
    pub spacing: f64,
    /// What of it is torn: it is there for nobody any more.
    pub torn: Torn,
}

impl Topology {
    /// Whether a face of the blueprint is torn.
    pub fn is_torn(&self, face: u32) -> bool {
        self.torn.any() && self.torn.face(self.part_of[face as usize])
    }

    /// The topology of a blueprint.
    pub fn of(blueprint: &Blueprint) -> Self {
        let at = |node: u32| wide(blueprint.nodes[node as usize].position);
        let mut sides = BTreeMap::<[u32; 2], Vec<Side>>::new();
        for (face, &[a, b, c]) in blueprint.faces.iter().enumerate() {
            let normal = (at(b) - at(a)).cross(at(c) - at(a)).normalize_or_zero();
            for (from, to, opposite) in [(a, b, c), (b, c, a), (c, a, b)] {
                let others = [
                    at(opposite).distance(at(from)),
                    at(opposite).distance(at(to)),
                ];
                let side = Side {
                    face,
                    from,
                    opposite,
                    normal,
                    longest_other: others[0].max(others[1]),
                };
                sides
                    .entry([from.min(to), from.max(to)])
                    .or_default()
                    .push(side);
            }
        }
        let oriented = sides.values().all(|s| s.len() == 1 || closes(s));
        let closed = !sides.is_empty() && sides.values().all(|s| closes(s));
        let mut faces: Vec<Option<Face>> = blueprint
            .faces
            .iter()
            .map(|f| Some(Face::Triangle(*f)))
            .collect();
        let mut edges = Vec::with_capacity(sides.len());
        let mut halves: Vec<usize> = (0..faces.len()).collect();
        let mut at_edges = Vec::with_capacity(sides.len());
        // By triangle.
        let mut quads: Vec<Option<[u32; 4]>> = vec![None; faces.len()];
        for (&[a, b], sides) in &sides {
            match quad(at(a).distance(at(b)), [a, b], sides) {
                None => {
                    edges.push([a, b]);
                    at_edges.push(sides);
                }
                Some((first, second, nodes)) => {
                    faces[first] = Some(Face::Quad(nodes));
                    faces[second] = None;
                    halves[second] = first;
                    quads[first] = Some(nodes);
                    quads[second] = Some(nodes);
                }
            }
        }
        let wings = edges.iter().zip(at_edges);
        let wings = wings
            .map(|(e, sides)| wings_of(e[0], sides, &quads))
            .collect();
        if blueprint.faces.is_empty() {
            edges = blueprint.springs.iter().map(|s| s.nodes).collect();
        }
        let around = (!blueprint.faces.is_empty())
            .then(|| Adjacency::new(blueprint.nodes.len(), (0..).zip(edges.iter().copied())));
        let total: f64 = edges.iter().map(|&[a, b]| at(a).distance(at(b))).sum();
        let mut count = 0;
        let numbers: Vec<u32> = faces
            .iter()
            .map(|face| {
                count += u32::from(face.is_some());
                count.saturating_sub(1)
            })
            .collect();
        Self {
            part_of: halves.into_iter().map(|half| numbers[half]).collect(),
            faces: faces.into_iter().flatten().collect(),
            torn: Torn::default(),
            spacing: total / edges.len().max(1) as f64,
            edges,
            wings,
            around,
            closed,
            oriented,
        }
    }
}

/// An edge as one of its triangles has it.
struct Side {
    face: usize,
    /// Where the edge begins, going round the triangle.
    from: u32,
    /// The triangle's third node.
    opposite: u32,
    normal: DVec3,
    /// The longer one of the triangle's other edges \[m\].
    longest_other: f64,
}

/// The faces to the left and to the right of an edge from node `a`; of each triangle the quad that it is part of is given.
fn wings_of(a: u32, sides: &[Side], quads: &[Option<[u32; 4]>]) -> [Wing; 2] {
    const NEITHER: Wing = [NONE; 2];
    let wing = |s: &Side| {
        let quad = quads[s.face].and_then(|nodes| {
            let k = nodes.iter().position(|&node| node == s.from)?;
            Some([nodes[(k + 3) % 4], nodes[(k + 2) % 4]])
        });
        let [from, to] = quad.unwrap_or([s.opposite; 2]);
        if s.from == a { [from, to] } else { [to, from] }
    };
    match sides {
        [only] if only.from == a => [wing(only), NEITHER],
        [only] => [NEITHER, wing(only)],
        [first, second] if first.from == a && second.from != a => [wing(first), wing(second)],
        [first, second] if second.from == a && first.from != a => [wing(second), wing(first)],
        _ => [NEITHER; 2],
    }
}

/// Whether two triangles that agree on which side is outside share an edge.
fn closes(sides: &[Side]) -> bool {
    matches!(sides, [a, b] if a.from != b.from)
}

/// The quad whose diagonal an edge is, and its two triangles: they lie in one plane, and the edge is by far the longest of
/// both, so that no triangle is part of two quads.
fn quad(length: f64, [a, b]: [u32; 2], sides: &[Side]) -> Option<(usize, usize, [u32; 4])> {
    let [first, second] = sides else {
        return None;
    };
    let flat = first.normal.dot(second.normal) > 1.0 - 1e-6;
    let longest = length > 1.1 * first.longest_other && length > 1.1 * second.longest_other;
    let to = if first.from == a { b } else { a };
    let nodes = [first.from, second.opposite, to, first.opposite];
    (flat && longest && closes(sides)).then_some((first.face, second.face, nodes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Material;
    use crate::math::Vector;
    use crate::shape;

    fn topology(net: crate::body::Net) -> Topology {
        let material = Some(Material::rubber());
        Topology::of(&Blueprint::resolve(net, |_| material, None).unwrap())
    }

    #[test]
    fn a_block_is_closed_and_a_sheet_is_open() {
        let block = topology(shape::lattice(Vector::ONE, 0.5).unwrap());
        assert!(block.closed);
        assert_eq!(block.edges.len(), block.wings.len());
        let net = shape::lattice(Vector::ONE, 0.5).unwrap();
        let at = |i: u32| wide(net.nodes[i as usize].position);
        for (&[a, b], &[left, right]) in block.edges.iter().zip(&block.wings) {
            // The faces are squares.
            for k in 0..2 {
                let along = at(b) - at(a);
                let outward = along.cross(at(left[k]) - at(right[k]));
                assert!(outward.dot(at(a) + at(b)) > 0.0);
                assert_eq!((at(left[k]) - at([a, b][k])).dot(along), 0.0);
            }
        }
        // Euler: V − E + F = 2.
        assert_eq!(block.faces.len(), 24);
        assert_eq!(26 + 24, 2 + block.edges.len());
        assert!(block.faces.iter().all(|f| f.nodes().len() == 4));
        let rope = topology(shape::rope(Vector::ZERO, Vector::X, 4, 1e-4).unwrap());
        assert!(!rope.closed && rope.faces.is_empty());
        assert_eq!(rope.edges.len(), 4);
        assert!((rope.spacing - 0.25).abs() < 1e-6);
    }
    #[test]
    fn faces_of_a_sheet_agree_on_its_sides_unless_one_is_turned_over() {
        let mut net = shape::sheet(1.0, 1.0, 4, 4, 1e-3).unwrap();
        let sheet = topology(net.clone());
        assert!(sheet.oriented && !sheet.closed);
        net.faces[4].swap(0, 1);
        assert!(!topology(net).oriented);
    }
}
