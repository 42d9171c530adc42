//! The outline of a body: what of it can touch another deformable.
//!
//! Its elements are the faces of the net, then the springs that belong to no face and no solid (a rope), then nodes that
//! nothing holds. A body whose every edge is used by two faces in opposite directions is a solid: outside is where the
//! winding says, and only its surface counts. Everything else has two sides and needs a thickness.

use crate::body::{Blueprint, State, Topology};
use crate::math::{DVec3, Real, wide};
use rapier3d::geometry::Aabb;
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};
use std::collections::BTreeMap;

/// No face, no edge, no spring.
pub const NONE: u32 = u32::MAX;

/// What a thickness of zero means for a body with two sides, per shortest edge.
const OWN_THICKNESS: f64 = 0.1;

/// An edge of the outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Its nodes.
    pub nodes: [u32; 2],
    /// The faces at it.
    pub faces: [u32; 2],
    /// The spring it is, if it belongs to no face.
    pub spring: u32,
    /// Whether all faces at it are torn, and no spring is left.
    pub torn: bool,
}

impl Edge {
    /// Whether it belongs to no face.
    pub fn is_spring(&self) -> bool {
        self.spring != NONE
    }
}

/// What of a body can touch another deformable.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    /// Faces; then springs (a, b, b); then single nodes (a, a, a).
    pub elements: Vec<[u32; 3]>,
    /// How many of them are faces.
    pub faces: usize,
    /// Which faces of the blueprint they are.
    triangles: Vec<u32>,
    /// Which of them are torn; empty while none is.
    torn: Vec<bool>,
    /// Nodes that can touch, in ascending order.
    pub nodes: Vec<u32>,
    /// Edges of faces, and the springs of the elements.
    pub edges: Vec<Edge>,
    /// Per element its edges, from corner k to the next.
    pub edges_of: Vec<[u32; 3]>,
    /// Per edge the element that stands for it in the tree.
    pub owner: Vec<u32>,
    /// Faces around each node, node after node, and where each node's begin.
    around: Vec<u32>,
    first: Vec<u32>,
    /// Whether it bounds a solid.
    pub closed: bool,
    /// Shortest edge at rest \[m\]; infinite without edges.
    pub spacing: f64,
    tree: Bvh,
    /// Whether the tree is where the elements are.
    fitted: bool,
}

/// The shortest edge of a body's faces, or of its springs where it has none, at rest \[m\].
pub fn spacing(blueprint: &Blueprint) -> f64 {
    let at = |n: u32| wide(blueprint.nodes[n as usize].position);
    let faces = blueprint.faces.iter();
    let mut edges: Vec<[u32; 2]> = faces
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .collect();
    if edges.is_empty() {
        edges.extend(blueprint.springs.iter().map(|s| s.nodes));
    }
    let lengths = edges.iter().map(|&[a, b]| at(a).distance(at(b)));
    lengths.filter(|&l| l > 0.0).fold(f64::INFINITY, f64::min)
}

impl Outline {
    /// The outline of a body.
    pub fn new(blueprint: &Blueprint) -> Self {
        let count = blueprint.nodes.len();
        let mut outline = Self {
            spacing: spacing(blueprint),
            ..Self::default()
        };
        outline.add_faces(blueprint);
        let uses = outline.edges.iter().all(|e| !e.faces.contains(&NONE));
        outline.closed &= uses && outline.faces > 0;
        outline.index_faces(count);
        let mut held = vec![false; count];
        for element in &outline.elements {
            for &n in element {
                held[n as usize] = true;
            }
        }
        if !outline.closed {
            outline.add_springs(blueprint, &mut held);
            for n in (0..count as u32).filter(|&n| !held[n as usize]) {
                outline.elements.push([n; 3]);
                outline.edges_of.push([NONE; 3]);
            }
            held.fill(true);
        }
        outline.nodes = (0..count as u32).filter(|&n| held[n as usize]).collect();
        outline
    }

    /// Faces that name a node twice are none.
    fn add_faces(&mut self, blueprint: &Blueprint) {
        let mut known = BTreeMap::<[u32; 2], u32>::new();
        self.closed = true;
        let faces = (0..).zip(&blueprint.faces);
        for (triangle, &face) in faces.filter(|(_, [a, b, c])| a != b && b != c && c != a) {
            self.triangles.push(triangle);
            let index = self.elements.len() as u32;
            let mut own = [NONE; 3];
            for (k, own) in own.iter_mut().enumerate() {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                let next = self.edges.len() as u32;
                let id = *known.entry([a.min(b), a.max(b)]).or_insert(next);
                *own = id;
                if id == next {
                    self.edges.push(Edge {
                        nodes: [a, b],
                        faces: [index, NONE],
                        spring: NONE,
                        torn: false,
                    });
                    self.owner.push(index);
                    continue;
                }
                let edge = &mut self.edges[id as usize];
                // A third face at an edge, or a second that runs the same way: no solid.
                self.closed &= edge.faces[1] == NONE && edge.nodes == [b, a];
                if edge.faces[1] == NONE {
                    edge.faces[1] = index;
                }
            }
            self.elements.push(face);
            self.edges_of.push(own);
        }
        self.faces = self.elements.len();
    }

    fn add_springs(&mut self, blueprint: &Blueprint, held: &mut [bool]) {
        let in_face = held.to_vec();
        for (id, spring) in (0..).zip(&blueprint.springs) {
            let [a, b] = spring.nodes;
            // Springs between nodes of faces are what holds the sheet together.
            if in_face[a as usize] && in_face[b as usize] {
                continue;
            }
            (held[a as usize], held[b as usize]) = (true, true);
            let edge = self.edges.len() as u32;
            self.owner.push(self.elements.len() as u32);
            self.edges.push(Edge {
                nodes: [a, b],
                faces: [NONE; 2],
                spring: id,
                torn: false,
            });
            self.elements.push([a, b, b]);
            self.edges_of.push([edge, NONE, NONE]);
        }
    }

    fn index_faces(&mut self, count: usize) {
        self.first = vec![0; count + 1];
        let faces = &self.elements[..self.faces];
        for &n in faces.iter().flatten() {
            self.first[n as usize + 1] += 1;
        }
        for i in 0..count {
            self.first[i + 1] += self.first[i];
        }
        let mut next = self.first.clone();
        self.around = vec![0; 3 * self.faces];
        for (f, face) in (0..).zip(faces) {
            for &n in face {
                self.around[next[n as usize] as usize] = f;
                next[n as usize] += 1;
            }
        }
    }

    /// The faces around a node that are not torn.
    pub fn around(&self, node: u32) -> impl Iterator<Item = u32> + '_ {
        let i = node as usize;
        let all = &self.around[self.first[i] as usize..self.first[i + 1] as usize];
        all.iter().copied().filter(|face| !self.is_torn(*face))
    }

    /// What a surface of `thickness` m comes to: 0 stands for nothing on a solid, and for a tenth of the shortest edge on
    /// what has two sides.
    pub fn thickness(&self, thickness: Real) -> f64 {
        if thickness != 0.0 || self.closed || self.spacing.is_infinite() {
            thickness.into()
        } else {
            OWN_THICKNESS * self.spacing
        }
    }

    /// Takes over what is torn of the faces that it was made of.
    pub fn tear(&mut self, topology: &Topology) {
        self.torn.resize(self.faces, false);
        for (f, &triangle) in self.triangles.iter().enumerate() {
            if self.torn[f] || !topology.is_torn(triangle) {
                continue;
            }
            self.torn[f] = true;
            for edge in self.edges_of[f] {
                let faces = &mut self.edges[edge as usize].faces;
                let own = faces.iter_mut().filter(|face| **face == f as u32);
                own.for_each(|face| *face = NONE);
            }
        }
        let bare = |edge: &&mut Edge| !edge.is_spring() && edge.faces == [NONE; 2];
        for edge in self.edges.iter_mut().filter(bare) {
            let [a, b] = edge.nodes;
            let known = topology.edges.binary_search(&[a.min(b), a.max(b)]);
            // The diagonals of quads are no edges of theirs.
            edge.torn = known.map_or(true, |i| topology.torn.edge(i as u32));
        }
    }

    /// Whether an element is a spring that has broken, or a face that is torn.
    pub fn is_gone(&self, element: u32, state: &State<Real>) -> bool {
        if (element as usize) < self.faces {
            return self.is_torn(element);
        }
        let edge = self.edges_of[element as usize][0];
        edge != NONE && self.is_broken(edge, state)
    }

    /// Whether a face is torn.
    #[inline(always)]
    pub fn is_torn(&self, face: u32) -> bool {
        self.torn.get(face as usize).is_some_and(|torn| *torn)
    }

    /// Whether an edge is a spring that has broken, or one of faces that are torn.
    pub fn is_broken(&self, edge: u32, state: &State<Real>) -> bool {
        let Edge { spring, torn, .. } = self.edges[edge as usize];
        torn || spring != NONE && state.broken[spring as usize]
    }

    /// Whether two elements have a node in common.
    pub fn are_neighbours(&self, a: u32, b: u32) -> bool {
        let (a, b) = (self.elements[a as usize], self.elements[b as usize]);
        a.iter().any(|n| b.contains(n))
    }

    /// The body has moved: its tree is to be brought up to date before it is looked at.
    pub fn loosen(&mut self) {
        self.fitted = false;
    }

    /// Brings the tree to where the elements are, in the body's own frame, if it is not yet.
    pub fn refit(&mut self, state: &State<Real>) {
        if std::mem::replace(&mut self.fitted, true) {
            return;
        }
        let bounds = |e: &[u32; 3]| {
            let [a, b, c] = e.map(|n| state.local(n as usize).as_vec3());
            Aabb::new(a.min(b).min(c), a.max(b).max(c))
        };
        if self.tree.is_empty() {
            let leaves: Vec<Aabb> = self.elements.iter().map(bounds).collect();
            self.tree = Bvh::from_leaves(BvhBuildStrategy::default(), &leaves);
            return;
        }
        for (i, element) in (0..).zip(&self.elements) {
            self.tree
                .insert_or_update_partially(bounds(element), i, 0.0);
        }
        self.tree.refit_without_opt();
    }

    /// Calls `found` for the elements whose boxes come within `radius` m of the box from `lo` to `hi` in the body's own
    /// frame, in any order.
    pub fn near(&self, lo: DVec3, hi: DVec3, radius: f64, mut found: impl FnMut(u32)) {
        // Boxes are of f32.
        let radius = radius + 1e-6 * lo.abs().max(hi.abs()).max_element();
        let query = Aabb::new((lo - radius).as_vec3(), (hi + radius).as_vec3());
        for leaf in self.tree.intersect_aabb(&query) {
            found(leaf);
        }
    }

    /// Whether a point in the body's own frame is within `radius` m of the box around the whole body.
    pub fn may_hold(&self, x: DVec3, radius: f64) -> bool {
        let root = self.tree.root_aabb();
        let radius = radius + 1e-6 * x.abs().max_element();
        (x + radius).cmpge(root.mins.as_dvec3()).all()
            && (x - radius).cmple(root.maxs.as_dvec3()).all()
    }

    /// The corners of the box around the whole body in its own frame \[m\].
    pub fn bounds(&self) -> [DVec3; 2] {
        let root = self.tree.root_aabb();
        [root.mins.as_dvec3(), root.maxs.as_dvec3()]
    }

    /// Half the diagonal of the box around the whole body \[m\], when the tree was last brought up to date.
    pub fn extent(&self) -> f64 {
        f64::from(self.tree.root_aabb().half_extents().length())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Net, Node, Spring};
    use crate::math::Vector;
    use crate::shape;

    fn outline(net: Net) -> Outline {
        Outline::new(
            &Blueprint::resolve(net, |_| Some(crate::body::Material::rubber()), None).unwrap(),
        )
    }

    #[test]
    fn boxes_are_solids_and_their_inside_does_not_count() {
        let o = outline(shape::lattice(Vector::splat(0.4), 0.1).unwrap());
        assert!(o.closed);
        assert_eq!((o.nodes.len(), o.faces), (98, 192));
        assert_eq!(o.edges.len(), 192 * 3 / 2);
        assert_eq!(o.thickness(0.0), 0.0);
        let total: usize = (0..125).map(|n| o.around(n).count()).sum();
        assert_eq!(total, 3 * 192);
    }

    #[test]
    fn sheets_and_ropes_have_two_sides() {
        let o = outline(shape::sheet(1.0, 1.0, 5, 5, 0.001).unwrap());
        assert!(!o.closed);
        assert_eq!(o.elements.len(), o.faces);
        assert!((o.thickness(0.0) - 0.025).abs() < 1e-7);
        let o = outline(shape::rope(Vector::ZERO, Vector::X, 4, 1e-4).unwrap());
        assert!(!o.closed && o.faces == 0);
        assert_eq!((o.elements.len(), o.edges.len(), o.nodes.len()), (4, 4, 5));
    }

    #[test]
    fn a_surface_turned_inside_out_in_part_is_no_solid() {
        let mut net = shape::lattice(Vector::splat(0.4), 0.1).unwrap();
        net.faces[7].swap(0, 1);
        assert!(!outline(net).closed);
    }

    #[test]
    fn loose_nodes_and_flat_faces_are_points() {
        let nodes = (0..4)
            .map(|i| Node::new(Vector::X * i as Real, 1.0))
            .collect();
        let mut net = Net::new(nodes, vec![Spring::new(0, 1, 1.0)]);
        net.faces.push([2, 2, 3]);
        let o = outline(net);
        assert_eq!(o.elements, [[0, 1, 1], [2, 2, 2], [3, 3, 3]]);
    }
}
