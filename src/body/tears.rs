//! Faces that are torn.
//!
//! A face stands for the material between its corners. Springs hold these together; once so many of them have broken that a
//! corner hangs on the others by none any more, nothing is between them. A face whose corners no spring holds from the start,
//! as those of tets, can't be torn.

use super::adjacency::Adjacency;
use super::net::Spring;
use super::topology::{Face, NONE, Topology};

/// What of a [`Topology`] is torn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Torn {
    /// Per face and per edge; empty while no spring has broken.
    faces: Vec<bool>,
    edges: Vec<bool>,
}

impl Torn {
    /// Whether any spring has broken.
    pub fn any(&self) -> bool {
        !self.edges.is_empty()
    }

    /// Whether a face is.
    #[inline(always)]
    pub fn face(&self, face: u32) -> bool {
        self.faces.get(face as usize).is_some_and(|torn| *torn)
    }

    /// Whether an edge is: it belongs to torn faces only, and no spring is left between its nodes.
    #[inline(always)]
    pub fn edge(&self, edge: u32) -> bool {
        self.edges.get(edge as usize).is_some_and(|torn| *torn)
    }
}

/// What holds the faces of a body together. It is made when the first spring breaks.
#[derive(Clone, Debug)]
pub struct Seams {
    /// The springs at each node.
    springs: Adjacency,
    ends: Vec<[u32; 2]>,
    /// The faces at each node.
    faces: Vec<Vec<u32>>,
    /// Per face the parts that it was in when no spring had broken.
    parts: Vec<u8>,
}

impl Seams {
    /// Those of the faces of a body with these springs.
    pub fn new(topology: &Topology, springs: &[Spring], nodes: usize) -> Self {
        let ends: Vec<_> = springs.iter().map(|s| s.nodes).collect();
        let mut faces = vec![Vec::new(); nodes];
        for (f, face) in (0..).zip(&topology.faces) {
            for node in face.nodes() {
                faces[*node as usize].push(f);
            }
        }
        let mut seams = Self {
            springs: Adjacency::new(nodes, (0..).zip(ends.iter().copied())),
            ends,
            faces,
            parts: Vec::new(),
        };
        let whole = |face| seams.parts(face, &|_| true);
        seams.parts = topology.faces.iter().map(whole).collect();
        seams
    }

    /// Takes in that springs have broken; `broken` tells it of all springs.
    pub fn tear(&self, topology: &mut Topology, springs: &[u32], broken: &[bool]) {
        let holds = |spring: u32| !broken[spring as usize];
        topology.torn.faces.resize(topology.faces.len(), false);
        topology.torn.edges.resize(topology.edges.len(), false);
        for &spring in springs {
            let ends = self.ends[spring as usize];
            if topology.faces.is_empty() {
                // Its edges are its springs.
                topology.torn.edges[spring as usize] = true;
                continue;
            }
            for &f in &self.faces[ends[0] as usize] {
                let face = topology.faces[f as usize];
                let was_held = face.nodes().contains(&ends[1]) && !topology.torn.face(f);
                if was_held && self.parts(&face, &holds) > self.parts[f as usize] {
                    for side in topology.tear_face(f) {
                        self.tear_edge(topology, side, &holds);
                    }
                }
            }
            self.tear_edge(topology, ends, &holds);
        }
    }

    /// In how many parts the springs that hold leave the corners of a face.
    fn parts(&self, face: &Face, holds: &dyn Fn(u32) -> bool) -> u8 {
        let nodes = face.nodes();
        let mut part = [0, 1, 2, 3];
        let mut count = nodes.len() as u8;
        for (i, &node) in nodes.iter().enumerate() {
            let held = self.springs.at(node).iter();
            for &(_, other) in held.filter(|(spring, _)| holds(*spring)) {
                let Some(k) = nodes.iter().position(|n| *n == other) else {
                    continue;
                };
                let (from, to) = (part[k], part[i]);
                if from != to {
                    count -= 1;
                    part.iter_mut()
                        .filter(|p| **p == from)
                        .for_each(|p| *p = to);
                }
            }
        }
        count
    }

    /// Tears the edge between two nodes, if there is one and neither a face nor a spring is left at it.
    fn tear_edge(&self, topology: &mut Topology, [a, b]: [u32; 2], holds: &dyn Fn(u32) -> bool) {
        let Ok(edge) = topology.edges.binary_search(&[a.min(b), a.max(b)]) else {
            return;
        };
        let joins = |&(spring, other): &(u32, u32)| other == b && holds(spring);
        let is_left = |f: &u32| {
            let face = &topology.faces[*f as usize];
            face.nodes().contains(&b) && !topology.torn.face(*f)
        };
        let is_held = self.springs.at(a).iter().any(joins);
        if !is_held && !self.faces[a as usize].iter().any(is_left) {
            topology.torn.edges[edge] = true;
        }
    }
}

impl Topology {
    /// Takes a face away from its edges; its sides.
    fn tear_face(&mut self, f: u32) -> Vec<[u32; 2]> {
        self.torn.faces[f as usize] = true;
        let face = self.faces[f as usize];
        let nodes = face.nodes();
        let next = nodes.iter().cycle().skip(1);
        let sides: Vec<_> = nodes.iter().zip(next).map(|(&a, &b)| [a, b]).collect();
        for [a, b] in &sides {
            let Ok(edge) = self.edges.binary_search(&[*a.min(b), *a.max(b)]) else {
                continue;
            };
            let of_face = |wing: &&mut [u32; 2]| wing.iter().all(|node| nodes.contains(node));
            let mut wings = self.wings[edge].iter_mut();
            if let Some(wing) = wings.find(of_face) {
                *wing = [NONE; 2];
            }
        }
        sides
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Blueprint, Material};
    use crate::math::Vector;
    use crate::shape;

    /// Two quads side by side: nodes 0 to 2 below, 3 to 5 above, or of two triangles each.
    fn strip(bent: bool) -> (Topology, Seams, Vec<[u32; 2]>) {
        let mut net = shape::sheet(2.0, 1.0, 3, 2, 1e-3).unwrap();
        if bent {
            net.nodes[0].position += Vector::Y * 0.2;
            net.nodes[5].position += Vector::Y * 0.2;
        }
        let material = Some(Material::rubber());
        let blueprint = Blueprint::resolve(net, |_| material, None).unwrap();
        let topology = Topology::of(&blueprint);
        let seams = Seams::new(&topology, &blueprint.springs, 6);
        let ends = blueprint.springs.iter().map(|s| s.nodes).collect();
        (topology, seams, ends)
    }

    /// Breaks the springs that hold certain nodes and others.
    fn part(topology: &mut Topology, seams: &Seams, ends: &[[u32; 2]], nodes: &[u32]) {
        let parts = |[a, b]: &[u32; 2]| nodes.contains(a) != nodes.contains(b);
        let broken: Vec<bool> = ends.iter().map(parts).collect();
        let springs = (0..).zip(&broken).filter(|(_, b)| **b);
        let springs: Vec<u32> = springs.map(|(i, _)| i).collect();
        seams.tear(topology, &springs, &broken);
    }

    #[test]
    fn a_face_is_torn_once_a_corner_hangs_on_no_other() {
        for bent in [false, true] {
            let (whole, seams, ends) = strip(bent);
            assert_eq!(whole.faces.len(), if bent { 4 } else { 2 });
            let mut topology = whole.clone();
            part(&mut topology, &seams, &ends, &[0, 3]);
            for (f, face) in (0..).zip(&whole.faces) {
                let is_left = face.nodes().iter().any(|n| [0, 3].contains(n));
                assert_eq!(topology.torn.face(f), is_left, "{face:?}");
            }
            // Between the halves there is no edge any more, and the one on the seam is a border.
            for (e, edge) in (0..).zip(&whole.edges) {
                let parted = [0, 3].contains(&edge[0]) != [0, 3].contains(&edge[1]);
                assert_eq!(topology.torn.edge(e), parted, "{edge:?}");
            }
            let seam = whole.edges.binary_search(&[1, 4]).unwrap();
            let open = |t: &Topology| t.wings[seam].iter().filter(|w| w.contains(&NONE)).count();
            assert_eq!([open(&whole), open(&topology)], [0, 1]);
        }
    }

    #[test]
    fn one_spring_less_tears_nothing() {
        let (whole, seams, ends) = strip(false);
        for spring in 0..ends.len() as u32 {
            let mut topology = whole.clone();
            let broken: Vec<bool> = (0..ends.len() as u32).map(|i| i == spring).collect();
            seams.tear(&mut topology, &[spring], &broken);
            assert!((0..2).all(|f| !topology.torn.face(f)));
            assert!((0..whole.edges.len() as u32).all(|e| !topology.torn.edge(e)));
        }
    }
}
