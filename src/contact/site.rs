//! Where rows come from and go: the body, the collider's shadow, what is near enough, and the rows of the group.

use super::beside::Beside;
use super::target::Frame;
use crate::body::Binding;
use crate::body::state::State;
use crate::body::topology::Topology;
use crate::math::{DVec3, Real, Vector};
use crate::solve::forces::Forces;
use crate::solve::rows::{RowNode, Rows};
use crate::solve::shadow::Shadow;

/// How far a node may be from a surface and still get a row.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Substep \[s\].
    pub h: f64,
    /// Distance that counts as touching \[m\].
    pub touching: f64,
    /// What the fastest node and the target can do in a substep \[m\].
    pub farthest: f64,
    /// What forces can add to that within a substep \[m\].
    pub slack: f64,
}

impl Reach {
    /// The distance from which a point that moves at `speed` m/s can touch within the substep \[m\].
    pub fn at(&self, speed: f64) -> f64 {
        self.touching + 2.0 * self.h * speed + self.slack
    }

    /// How deep what lies on a surface may be and still count as lying on it \[m\].
    pub fn shallow(&self) -> f64 {
        (10.0 * self.touching).min(self.touching + self.slack)
    }

    /// How deep a point can have come within the last substep, which may have been longer, if it moves inwards at `speed` m/s \[m\].
    pub fn come(&self, speed: f64) -> f64 {
        self.touching + 1.5 * self.h * speed.max(0.0) + self.slack
    }
}

/// A body of the group in a substep, for contact.
#[derive(Clone, Copy)]
pub struct Side<'a> {
    /// Where the points are that can touch: nodes, or those of an embedded skin.
    pub state: &'a State<Real>,
    /// Their faces and edges.
    pub topology: &'a Topology,
    /// What carries them.
    pub carrier: Carrier<'a>,
    /// Forces within the body at its nodes, when they were last summed.
    pub(crate) forces: &'a Forces<Real>,
}

/// What carries the points of a surface: they are nodes, or weighted means of nodes.
#[derive(Clone, Copy)]
pub struct Carrier<'a> {
    /// Index of the body within the group.
    pub body: u32,
    /// Its nodes.
    pub nodes: &'a State<Real>,
    /// Which nodes carry each point, where the points are not nodes.
    pub bindings: Option<&'a [Binding]>,
}

impl Carrier<'_> {
    /// Adds the terms of a point of this weight, of whose impulse the body takes `share`, and their levers if it has one.
    pub fn add_terms(
        &self,
        point: u32,
        (weight, share, lever): (f64, f64, Option<DVec3>),
        slots: &mut [u32],
        rows: &mut Rows,
    ) {
        let mut add = |node: usize, part: f64| {
            let node = slot(self.body, node as u32, self.nodes, slots, rows);
            rows.add_term(node, weight * part, share);
            rows.levers.extend(lever.map(|lever| lever * part));
        };
        match self.bindings {
            None => add(point as usize, 1.0),
            Some(bindings) => {
                let parts = bindings[point as usize].parts();
                parts.for_each(|(node, part)| add(node, part));
            }
        }
    }
}

impl Side<'_> {
    /// What h s of the forces within the body that its nodes had last add to the velocity of a point \[m/s\]. Without gravity and the
    /// like: in a long substep these would draw what crosses a gap in a floor into it by more than it falls.
    pub fn gain(&self, point: u32, h: f64) -> DVec3 {
        let of = |node: usize| {
            let force = self.forces.at(node).sum();
            let inv_mass = f64::from(self.carrier.nodes.particles[node].inv_mass);
            h * inv_mass * Vector::from_array(force).as_dvec3()
        };
        match self.carrier.bindings {
            None => of(point as usize),
            Some(bindings) => {
                let parts = bindings[point as usize].parts();
                parts.map(|(node, part)| part * of(node)).sum()
            }
        }
    }

    /// The unit directions in a frame from a point of its surface along the edges there; none of a body without faces.
    pub fn around(&self, point: u32, frame: &Frame) -> impl Iterator<Item = DVec3> + use<'_> {
        let edges = self.topology.around.as_ref();
        let edges = edges.map_or(&[][..], |around| around.at(point));
        let torn = &self.topology.torn;
        let edges = edges.iter().filter(|(edge, _)| !torn.edge(*edge));
        let (frame, start) = (*frame, frame.to_local(self.state, point));
        let along = move |&(_, other): &(u32, u32)| frame.to_local(self.state, other) - start;
        edges.map(along).map(DVec3::normalize_or_zero)
    }

    /// The box around its points in a frame \[m\].
    pub fn bounds(&self, frame: &Frame) -> (DVec3, DVec3) {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let nodes = 0..self.state.particles.len() as u32;
        nodes
            .map(|node| frame.to_local(self.state, node))
            .fold(start, |(lo, hi), x| (lo.min(x), hi.max(x)))
    }
}

/// Where the rows of one body and one target come from, and where they go.
pub struct Site<'a> {
    /// The deformable.
    pub side: Side<'a>,
    /// The collider's body.
    pub shadow: &'a Shadow,
    /// Maps nodes to row nodes; `u32::MAX`: none yet.
    pub slots: &'a mut [u32],
    /// The rows of the group.
    pub rows: &'a mut Rows,
    /// What is near enough.
    pub reach: Reach,
    /// What else the body can touch.
    pub beside: Beside<'a>,
}

impl Site<'_> {
    /// How far what has this velocity goes in a substep relative to a point of the target in this frame, as both moved at the end of
    /// the last one, in the frame \[m\]: gravity and other forces that contacts will bear are not in it.
    pub fn way(&self, velocity: DVec3, frame: &Frame, point: DVec3) -> DVec3 {
        let arm = frame.axes * point + (frame.position - self.shadow.com);
        frame.axes.transpose() * (velocity - self.shadow.velocity_before(arm)) * self.reach.h
    }
}

/// The row node of node `i`, made if it has none yet.
pub fn slot(body: u32, i: u32, state: &State<Real>, slots: &mut [u32], rows: &mut Rows) -> u32 {
    let slot = &mut slots[i as usize];
    if *slot == u32::MAX {
        *slot = rows.nodes.len() as u32;
        let v = state.velocity(i as usize);
        rows.nodes.push(RowNode {
            body,
            node: i,
            inv_mass: state.particles[i as usize].inv_mass.into(),
            v,
            free: v,
            before: v,
        });
    }
    *slot
}
