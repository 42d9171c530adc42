//! A bounding volume tree over what a body shows: its faces, or its springs and nodes where it has none.
//!
//! The tree is parry's, in `f32` about the body's origin, with boxes rounded outwards. Costs are computed in `f64` and
//! handed to it as differences from the cost of the whole body, rounded so that nothing is cut off early: the answer is
//! that of a loop over all leaves in `f64`, ties going to the lowest index.
//!
//! Nodes that move leave the tree's layout as it is and only its boxes are fitted anew, until they overlap half as much
//! again as when it was built: a crumpling body keeps its neighbours, one that flies to pieces does not.

use crate::body::{Blueprint, State};
use crate::math::{DVec3, Real, Vector, narrow};
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy, BvhNode, TraversalAction};
use std::cell::Cell;
use std::sync::{Arc, OnceLock};

/// Growth of the boxes' area at which the tree is built anew.
const WORN: f64 = 1.5;

/// Smallest and largest corner \[m\].
pub(crate) type Bounds = (DVec3, DVec3);

/// The tree at one state of the body.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    bvh: Bvh,
    /// Whether the faces enclose a volume: every side is used as often along as against. Never so without faces.
    pub closed: bool,
    /// Per node of a body without faces, whether no unbroken spring holds it.
    pub alone: Vec<bool>,
    /// Area of all boxes over that of the whole when it was built.
    wear: f64,
}

/// The tree, its state of yesterday, and the bounds, each found when first asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cache {
    bounds: OnceLock<Bounds>,
    tree: OnceLock<Arc<Tree>>,
    last: Option<Arc<Tree>>,
}

impl Cache {
    /// To be called whenever a node has moved or a spring has broken.
    pub fn forget(&mut self) {
        self.bounds.take();
        if let Some(tree) = self.tree.take() {
            self.last = Some(tree);
        }
    }

    /// Bounds relative to the body's origin; those of nothing where a node is not finite.
    pub fn bounds(&self, state: &State<Real>) -> Bounds {
        *self.bounds.get_or_init(|| {
            let positions = || (0..state.particles.len()).map(|i| state.local(i));
            let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            if positions().all(|x| x.is_finite()) {
                positions().fold(start, |(lo, hi), x| (lo.min(x), hi.max(x)))
            } else {
                start
            }
        })
    }

    /// The tree of the body as it stands. Nodes must be finite.
    pub fn tree(&self, blueprint: &Blueprint, state: &State<Real>) -> &Tree {
        self.tree.get_or_init(|| {
            Arc::new(match &self.last {
                Some(last) => last.refitted(blueprint, state),
                None => Tree::new(blueprint, state),
            })
        })
    }
}

impl Tree {
    fn new(blueprint: &Blueprint, state: &State<Real>) -> Self {
        let mut tree = Self {
            bvh: build(blueprint, state),
            closed: is_closed(&blueprint.faces),
            alone: alone(blueprint, state),
            wear: 0.0,
        };
        tree.wear = tree.area();
        tree
    }

    fn refitted(&self, blueprint: &Blueprint, state: &State<Real>) -> Self {
        let mut tree = self.clone();
        for (i, aabb) in (0..).zip(boxes(blueprint, state)) {
            tree.bvh.insert_or_update_partially(aabb, i, 0.0);
        }
        tree.bvh.refit_without_opt();
        tree.alone = alone(blueprint, state);
        if tree.area() > WORN * tree.wear {
            tree.bvh = build(blueprint, state);
            tree.wear = tree.area();
        }
        tree
    }

    /// Area of all boxes over that of the whole: about how many of them a line through the body meets.
    fn area(&self) -> f64 {
        let area = |aabb: Aabb| {
            let [x, y, z] = (aabb.maxs - aabb.mins).as_dvec3().to_array();
            x * y + y * z + z * x
        };
        let mut sum = 0.0;
        self.bvh.traverse(|node| {
            sum += area(node.aabb());
            TraversalAction::Continue
        });
        sum / area(self.bvh.root_aabb()).max(f64::MIN_POSITIVE)
    }

    /// The leaf of least cost below or at `limit`. `node` is a lower bound of the costs in a box (infinite: none), `leaf`
    /// the cost of one; `base` is a lower bound for the whole body.
    pub fn least<T: Copy>(
        &self,
        limit: f64,
        base: f64,
        node: impl Fn(Bounds) -> f64,
        leaf: impl Fn(u32) -> Option<(f64, T)>,
    ) -> Option<(u32, f64, T)> {
        let best = Cell::new(None::<(u32, f64, T)>);
        self.bvh.find_best(
            above(limit - base),
            |n: &BvhNode, _| match node(corners(n)) {
                cost if cost.is_finite() => ((cost - base) as f32).next_down(),
                _ => f32::MAX,
            },
            |index, _| {
                let (cost, what) = leaf(index)?;
                let better = best
                    .get()
                    .is_none_or(|(i, least, _)| (cost, index) < (least, i));
                if cost > limit || !better {
                    return None;
                }
                best.set(Some((index, cost, what)));
                Some(above(cost - base))
            },
        );
        best.get()
    }

    /// The leaves in boxes that satisfy `admits`.
    pub fn leaves(&self, admits: impl Fn(Bounds) -> bool) -> impl Iterator<Item = u32> {
        self.bvh.leaves(move |node: &BvhNode| admits(corners(node)))
    }
}

/// The next `f32` above.
fn above(x: f64) -> f32 {
    (x as f32).next_up().min(f32::MAX)
}

fn corners(node: &BvhNode) -> Bounds {
    (node.mins().as_dvec3(), node.maxs().as_dvec3())
}

fn build(blueprint: &Blueprint, state: &State<Real>) -> Bvh {
    let leaves: Vec<Aabb> = boxes(blueprint, state).collect();
    Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves)
}

/// The box of every leaf: of each face, or of each spring and then each node.
fn boxes(blueprint: &Blueprint, state: &State<Real>) -> impl Iterator<Item = Aabb> {
    let faces = blueprint.faces.iter().map(|f| f.as_slice());
    let springs = blueprint.springs.iter().map(|s| s.nodes.as_slice());
    let lines = blueprint.faces.is_empty();
    let springs = springs.take(if lines { usize::MAX } else { 0 });
    let nodes = if lines { state.particles.len() } else { 0 };
    let around = |nodes: &[u32]| {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (lo, hi) = nodes.iter().fold(start, |(lo, hi), n| {
            let x = state.local(*n as usize);
            (lo.min(x), hi.max(x))
        });
        let outwards =
            |v: DVec3, step: fn(f32) -> f32| Vector::from_array(narrow(v).to_array().map(step));
        Aabb::new(outwards(lo, f32::next_down), outwards(hi, f32::next_up))
    };
    faces
        .chain(springs)
        .map(around)
        .chain((0..nodes as u32).map(move |n| around(&[n])))
}

/// Whether each side is used as often along as against.
fn is_closed(faces: &[[u32; 3]]) -> bool {
    let mut sides: Vec<(u32, u32, i32)> = faces
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .map(|(a, b)| (a.min(b), a.max(b), if a < b { 1 } else { -1 }))
        .collect();
    sides.sort_unstable();
    !sides.is_empty()
        && sides
            .chunk_by(|s, t| (s.0, s.1) == (t.0, t.1))
            .all(|uses| uses.iter().map(|u| u.2).sum::<i32>() == 0)
}

/// Which nodes no unbroken spring holds; nothing for a body with faces.
fn alone(blueprint: &Blueprint, state: &State<Real>) -> Vec<bool> {
    if !blueprint.faces.is_empty() {
        return Vec::new();
    }
    let mut alone = vec![true; state.particles.len()];
    for (spring, _) in blueprint
        .springs
        .iter()
        .zip(&state.broken)
        .filter(|(_, broken)| !**broken)
    {
        for node in spring.nodes {
            alone[node as usize] = false;
        }
    }
    alone
}
