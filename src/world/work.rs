//! The work of rows, and who got which impulse.

use super::Deformable;
use super::observer::NodeImpulse;
use super::substep::{Group, Members};
use crate::body::NodeId;
use crate::math::{DVec3, Vector};
use crate::solve::Integrator;
use crate::solve::forces::three;
use crate::solve::rows::{RowNode, Term};
use crate::solve::work::Work;

impl Group {
    /// Work of every row by the trapezoid rule over the displacements actually made. It is booked where the two sides meet:
    /// at the collider's velocity, or half-way between the points of two deformables.
    pub fn book_work(&mut self) {
        for row in &self.rows.contacts {
            let terms = self.rows.terms_of(row.terms);
            let shadow = &self.shadows[row.shadow as usize];
            let ends = Ends::of(&self.rows.nodes, terms);
            let meeting = if row.between {
                let levers = self.rows.levers_of(row).map(|l| (l, row.normal));
                0.5 * ends.mean_velocity(self, terms, levers)
            } else {
                0.5 * (shadow.velocity_before(row.arm) + shadow.velocity_at(row.arm))
            };
            let impulse = row.impulse();
            let along = row.normal * row.normal_impulse;
            for (term, part) in self.rows.parts(row, impulse) {
                let node = &self.rows.nodes[term.node as usize];
                let kick = HalfKick::noted(&self.kicks, term.node);
                let (mean, work) = node_work(&mut self.members, node, kick, part);
                work.contact_normal -= term.share * along.dot(mean - meeting);
                work.contact_friction -= term.share * row.friction_impulse.dot(mean - meeting);
                work.contact_friction -= (part - impulse * term.share).dot(mean);
                work.rigid += term.share * impulse.dot(meeting);
            }
            let pair = row.pair as usize;
            let pressed = row.normal_impulse > 0.0;
            // Two deformables are two pairs, the second with the impulse on the other one.
            for (i, sign) in [1.0, -1.0].into_iter().enumerate() {
                if i == 1 && !row.between {
                    break;
                }
                let of_this = |t: &&Term| ends.sign(t) == sign;
                let share: f64 = terms.iter().filter(of_this).map(|t| t.share).sum();
                let sums = &mut self.pairs[pair + i];
                sums.impulse += impulse * share;
                sums.depth = sums.depth.max(row.depth);
                sums.touching += u32::from(pressed);
                if pressed {
                    let point = ends.point(&self.members, terms, sign);
                    self.sums[pair + i].add_row(point, row.normal * sign, row.normal_impulse);
                }
            }
        }
    }

    /// Notes the half kicks before, of the nodes of rows.
    pub(super) fn note_kicks(&mut self) {
        self.kicks.clear();
        let mut schemes = self.members.iter().map(|(_, body)| body.integrator());
        if schemes.any(|scheme| scheme == Integrator::VelocityVerlet) {
            let of = |n: &RowNode| HalfKick::of(&self.members[n.body as usize].1, n);
            self.kicks.extend(self.rows.nodes.iter().map(of));
        }
    }

    /// What each node got of each row.
    pub fn list_node_impulses(&mut self, wanted: bool) {
        if !wanted {
            self.node_impulses = None;
            return;
        }
        let list = self.node_impulses.get_or_insert_default();
        list.clear();
        for row in &self.rows.contacts {
            let impulse = row.impulse();
            if impulse == DVec3::ZERO {
                continue;
            }
            let terms = self.rows.terms_of(row.terms);
            let ends = Ends::of(&self.rows.nodes, terms);
            list.extend(self.rows.parts(row, impulse).map(|(term, impulse)| {
                let node = &self.rows.nodes[term.node as usize];
                // The nodes of the other deformable belong to the second pair.
                let pair = row.pair as usize + usize::from(ends.sign(term) < 0.0);
                NodeImpulse {
                    deformable: self.members[node.body as usize].0,
                    node: NodeId(node.node),
                    partner: self.pairs[pair].partner,
                    impulse,
                }
            }));
        }
    }
}

/// The two points of a row between deformables, or the one of any other: the weights of the first body's nodes sum to 1, those
/// of the other's to −1. Single weights tell nothing: a point outside of the tet that carries it has some of either sign.
struct Ends<'a> {
    nodes: &'a [RowNode],
    first: u32,
}

impl<'a> Ends<'a> {
    fn of(nodes: &'a [RowNode], terms: &[Term]) -> Self {
        let body = |t: &Term| nodes[t.node as usize].body;
        let some = terms.first().map_or(0, body);
        let own = terms.iter().filter(|t| body(t) == some);
        let others = terms.iter().map(body).find(|b| *b != some);
        let is_first = own.map(|t| t.weight).sum::<f64>() > 0.0;
        let first = if is_first {
            some
        } else {
            others.unwrap_or(some)
        };
        Self { nodes, first }
    }

    fn node(&self, term: &Term) -> &RowNode {
        &self.nodes[term.node as usize]
    }

    fn sign(&self, term: &Term) -> f64 {
        if self.node(term).body == self.first {
            1.0
        } else {
            -1.0
        }
    }

    /// Where a row acts on its first body, or with a sign of −1 on its second \[m\].
    fn point(&self, members: &Members, terms: &[Term], sign: f64) -> DVec3 {
        let place = |t: &Term| {
            let node = self.node(t);
            let body = &members[node.body as usize].1;
            body.state.position(node.node as usize) * (t.weight * sign)
        };
        let own = terms.iter().filter(|t| self.sign(t) == sign);
        own.map(place).sum()
    }

    /// The sum of the mean velocities of its points, which levers along a normal carry on \[m/s\].
    fn mean_velocity(
        &self,
        group: &Group,
        terms: &[Term],
        levers: Option<(&[DVec3], DVec3)>,
    ) -> DVec3 {
        let velocity = |(k, t): (usize, &Term)| {
            let node = self.node(t);
            let body = &group.members[node.body as usize].1;
            let kick = HalfKick::noted(&group.kicks, t.node);
            let v = mean(body, node) + HalfKick::between(kick, body, node).all;
            let carried = levers.map_or(DVec3::ZERO, |(l, normal)| l[k] * normal.dot(v));
            (v * t.weight + carried) * self.sign(t)
        };
        terms.iter().enumerate().map(velocity).sum()
    }
}

/// Leapfrog velocities stand at half substeps: the trapezoid of the displacements before and after the impulse. The other
/// schemes know the velocity at the impulse itself, just before it and just after.
fn mean(body: &Deformable, node: &RowNode) -> DVec3 {
    if body.integrator().takes_late_impulses() {
        0.5 * (node.before + node.v)
    } else {
        node.before + 0.5 * (node.v - node.free)
    }
}

/// What half a kick of velocity Verlet does to a node \[m/s\].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HalfKick {
    all: DVec3,
    /// By damping alone.
    damped: DVec3,
}

impl HalfKick {
    /// The last one, or the first of the substep under way. There is none by other schemes, of what is pinned, and before
    /// the first substep.
    fn of(body: &Deformable, node: &RowNode) -> Option<Self> {
        let verlet = body.integrator() == Integrator::VelocityVerlet;
        if !verlet || node.inv_mass == 0.0 || body.solver.last_substep.is_none() {
            return None;
        }
        let (solver, i) = (&body.solver, node.node as usize);
        let by = 0.5 * body.h;
        let damping = Vector::from_array(three(solver.forces.at(i).damping)).as_dvec3();
        let force = solver.elastic_force(i) + solver.applied_force(i) + damping;
        Some(Self {
            all: (force * node.inv_mass + body.gravity()) * by,
            damped: damping * (node.inv_mass * by),
        })
    }

    /// The one before, of a row node, if any was noted.
    pub(super) fn noted(kicks: &[Option<Self>], node: u32) -> Option<Self> {
        *kicks.get(node as usize)?
    }

    /// By how much the mean of the displacements before and after an impulse is faster than that of the velocities just
    /// before and after it, in all and by damping \[m/s\]. The two differ where the half kicks before and after do.
    fn between(before: Option<Self>, body: &Deformable, node: &RowNode) -> Self {
        let kicks = before.zip(Self::of(body, node));
        kicks.map_or(Self::default(), |(before, after)| Self {
            all: 0.5 * (after.all - before.all),
            damped: 0.5 * (after.damped - before.damped),
        })
    }
}

/// The velocity whose product with an impulse on a node is its work, and where to book it. Whatever holds a pinned node
/// takes up the work of the impulse. `before` is the half kick before.
///
/// By velocity Verlet the balance is that of leapfrog, to which displacements count, and rows ask for displacements: by
/// these their work is never negative. What damping differs in beside the impulse is the dampers' work.
pub(super) fn node_work<'a>(
    members: &'a mut Members,
    node: &RowNode,
    before: Option<HalfKick>,
    impulse: DVec3,
) -> (DVec3, &'a mut Work) {
    let body = &mut members[node.body as usize].1;
    let between = HalfKick::between(before, body, node);
    let mean = mean(body, node) + between.all;
    let work = &mut body.solver.work;
    work.damping += impulse.dot(between.damped);
    if node.inv_mass == 0.0 {
        work.external -= impulse.dot(mean);
    }
    (mean, work)
}
