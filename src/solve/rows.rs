//! Rows: contacts and ties of one substep, solved together by sequential impulses.
//!
//! Contact and coupling only fill rows; this pass knows nodes, shadows and numbers. Impulses on single nodes are
//! accumulated from zero in every substep (a warm start would keep squeezed bodies awake for ever); rows that share nodes
//! start from their last impulses, or four passes would leave a light node in a heavy grip trembling. The order is fixed,
//! and reversed in every other pass, so that the bias of one order does not add up to a spin. Nodes appear once, however
//! many rows they have.

use super::shadow::Shadow;
use crate::law::row::{allowed_velocity, friction_impulse, normal_impulse, turning};
use crate::math::{DMat3, DVec3};

/// A node that has at least one row.
#[derive(Clone, Copy, Debug)]
pub struct RowNode {
    /// Index of the body within its group.
    pub body: u32,
    /// Index of the node within its body.
    pub node: u32,
    /// 1/m \[1/kg\].
    pub inv_mass: f64,
    /// Velocity, changed by the pass \[m/s\].
    pub v: DVec3,
    /// Velocity after the free part of the substep \[m/s\].
    pub free: DVec3,
    /// Velocity at the end of the last substep \[m/s\].
    pub before: DVec3,
}

/// A node's part in a row: the row sees the point Σ weight · node, and node k takes the impulse share · j.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    /// Index into the row nodes.
    pub node: u32,
    /// Weight in the point's velocity: barycentric for a point of a face, negative on the far side of a row between two
    /// deformables.
    pub weight: f64,
    /// The weight again, or 0 for a body that dominates the other side and takes nothing.
    pub share: f64,
}

/// Where the terms of a row stand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    first: u32,
    count: u32,
}

impl Terms {
    #[inline(always)]
    fn range(self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// A unilateral contact with friction, of a point with a shadow or of points of two deformables.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The nodes of the point.
    pub terms: Terms,
    /// Index into the shadows; 0 for a row between two deformables.
    pub shadow: u32,
    /// Which pair of deformable and partner the impulse is counted for.
    pub pair: u32,
    /// Whether it lies between two deformables.
    pub between: bool,
    /// From the collider, or the second deformable, to the outside.
    pub normal: DVec3,
    /// Signed depth, positive inside \[m\].
    pub depth: f64,
    /// From the shadow's centre of mass to the point \[m\].
    pub arm: DVec3,
    /// What the shadow takes of the impulse: 1, or 0 for a body that dominates the deformable.
    pub rigid_share: f64,
    /// Coulomb's μ.
    pub friction: f64,
    /// 0 for a rigid contact, 1/(h²k) of one with a stiffness of k N/m \[1/kg\].
    pub softness: f64,
    /// How far the point has slipped from where friction took hold of it \[m\].
    pub drift: DVec3,
    /// Normal impulse of earlier substeps that friction has not answered yet \[N·s\].
    pub carried: f64,
    /// Accumulated normal impulse \[N·s\].
    pub normal_impulse: f64,
    /// Accumulated friction impulse \[N·s\].
    pub friction_impulse: DVec3,
    /// Effective mass along the normal \[kg\]; set by the pass.
    pub mass: f64,
    /// How much faster the surface turns towards the point than it moves at the start of the substep \[m/s\]; set by the
    /// pass.
    pub turning: f64,
}

impl Row {
    /// Impulse on the point so far \[N·s\].
    pub fn impulse(&self) -> DVec3 {
        self.normal * self.normal_impulse + self.friction_impulse
    }

    /// The most that friction can do \[N·s\].
    pub fn friction_limit(&self) -> f64 {
        self.friction * (self.normal_impulse + self.carried)
    }

    /// Whether friction holds the point: it is pressed on, and not at the limit of its cone.
    pub fn sticks(&self) -> bool {
        self.normal_impulse > 0.0
            && self.friction_impulse.length() < self.friction_limit() * (1.0 - 1e-9)
    }
}

/// A point held at a point of a shadow, or of another deformable.
#[derive(Clone, Copy, Debug)]
pub struct Tie {
    /// The nodes of the point; of a tie between two deformables, those of the other one with negative weights.
    pub terms: Terms,
    /// Index into the shadows; 0 for a tie between two deformables.
    pub shadow: u32,
    /// Which attachment the impulse is counted for.
    pub attachment: u32,
    /// Whether it lies between two deformables.
    pub between: bool,
    /// From the shadow's centre of mass to the anchor \[m\].
    pub arm: DVec3,
    /// Point minus anchor \[m\].
    pub error: DVec3,
    /// Velocity relative to the anchor at the end of the last substep \[m/s\].
    pub before: DVec3,
    /// What the anchor's mean velocity over the substep differs from that at its start \[m/s\].
    pub chord: DVec3,
    /// Velocity the point must have relative to the anchor's \[m/s\].
    pub bias: DVec3,
    /// 0 for a rigid tie, that of [`link`](crate::law::row::link) for a link \[1/kg\].
    pub softness: f64,
    /// Accumulated impulse on the node \[N·s\].
    pub impulse: DVec3,
    /// Effective mass \[kg\]; set by the pass.
    pub mass: DMat3,
}

/// All rows of a group in a substep.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// Their nodes.
    pub nodes: Vec<RowNode>,
    /// Their terms, row after row.
    pub terms: Vec<Term>,
    /// Contacts, sorted by collider and node.
    pub contacts: Vec<Row>,
    /// Ties, sorted by attachment and node.
    pub ties: Vec<Tie>,
}

impl Rows {
    /// Forgets everything, keeping the memory.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.terms.clear();
        self.contacts.clear();
        self.ties.clear();
    }

    /// Adds the terms of a row: row nodes, weights, and what each takes of the impulse.
    pub fn add_terms(&mut self, terms: impl IntoIterator<Item = Term>) -> Terms {
        let first = self.terms.len();
        self.terms.extend(terms);
        self.terms_since(first)
    }

    /// The terms that have been added since there were `first`.
    pub fn terms_since(&self, first: usize) -> Terms {
        Terms {
            first: first as u32,
            count: (self.terms.len() - first) as u32,
        }
    }

    /// The terms of a row.
    #[inline(always)]
    pub fn terms_of(&self, terms: Terms) -> &[Term] {
        &self.terms[terms.range()]
    }

    /// Solves all rows in at most `passes` Gauss–Seidel passes, stopping once a pass changes nothing, and books the
    /// impulses to the shadows. `reversed` picks the order of the first pass.
    pub fn solve(&mut self, shadows: &mut [Shadow], h: f64, passes: usize, reversed: bool) {
        self.prepare(shadows, h);
        let Self {
            nodes,
            terms,
            contacts,
            ties,
        } = self;
        let mut points = Points {
            nodes,
            terms,
            tolerance: 0.0,
        };
        for row in contacts.iter().filter(|r| r.normal_impulse > 0.0) {
            let j = row.impulse();
            points.push(row.terms, j);
            shadows[row.shadow as usize].push(row.arm, -j * row.rigid_share);
        }
        for tie in ties.iter().filter(|t| t.impulse != DVec3::ZERO) {
            points.push(tie.terms, tie.impulse);
            shadows[tie.shadow as usize].push(tie.arm, -tie.impulse);
        }
        // Rows that share nodes take more passes when a blow finds them unprepared.
        let shared = contacts.iter().any(|row| row.terms.count > 1);
        let most = if shared { 4 * passes } else { passes };
        for pass in 0..most {
            points.tolerance = if pass < passes { 1e-9 } else { 1e-3 };
            let changed = if reversed == (pass % 2 == 0) {
                points.solve_contacts(contacts.iter_mut().rev(), shadows, h)
                    | points.solve_ties(ties.iter_mut().rev(), shadows)
            } else {
                points.solve_ties(ties.iter_mut(), shadows)
                    | points.solve_contacts(contacts.iter_mut(), shadows, h)
            };
            if !changed {
                break;
            }
        }
        for row in contacts {
            let shadow = &mut shadows[row.shadow as usize];
            book(shadow, row.arm, row.impulse() * row.rigid_share);
        }
        for tie in ties.iter().filter(|t| !t.between) {
            book(&mut shadows[tie.shadow as usize], tie.arm, tie.impulse);
        }
    }

    fn prepare(&mut self, shadows: &[Shadow], h: f64) {
        let Self {
            nodes,
            terms,
            contacts,
            ties,
        } = self;
        let points = Points {
            nodes,
            terms,
            tolerance: 0.0,
        };
        for row in contacts {
            let rigid = shadows[row.shadow as usize].response(row.arm, row.normal);
            let k = points.response(row.terms) + row.rigid_share * rigid + row.softness;
            row.mass = if k > 0.0 { 1.0 / k } else { 0.0 };
            let shadow = &shadows[row.shadow as usize];
            if shadow.w != DVec3::ZERO {
                let relative = points.velocity(row.terms) - shadow.velocity_at(row.arm);
                row.turning = turning(shadow.w, relative, row.arm, row.normal, h);
            }
        }
        for tie in ties {
            let own = points.response(tie.terms) + tie.softness;
            let k = DMat3::from_diagonal(DVec3::splat(own))
                + shadows[tie.shadow as usize].response_matrix(tie.arm);
            tie.mass = if k.determinant() > 0.0 {
                k.inverse()
            } else {
                DMat3::ZERO
            };
        }
    }
}

/// The reaction of an impulse `j` on a node, summed up for the hand-over.
fn book(shadow: &mut Shadow, arm: DVec3, j: DVec3) {
    shadow.impulse -= j;
    shadow.torque -= arm.cross(j);
}

/// The points that rows act on.
struct Points<'a> {
    nodes: &'a mut [RowNode],
    terms: &'a [Term],
    /// Relative change of an impulse below which it counts as settled.
    tolerance: f64,
}

impl Points<'_> {
    fn differs(&self, change: f64, total: f64) -> bool {
        change.abs() > self.tolerance * total.abs()
    }

    #[inline(always)]
    fn velocity(&self, terms: Terms) -> DVec3 {
        let mut v = DVec3::ZERO;
        for term in &self.terms[terms.range()] {
            v += self.nodes[term.node as usize].v * term.weight;
        }
        v
    }

    /// Inverse of the mass felt at a point \[1/kg\].
    #[inline(always)]
    fn response(&self, terms: Terms) -> f64 {
        let mut k = 0.0;
        for term in &self.terms[terms.range()] {
            k += term.weight * term.share * self.nodes[term.node as usize].inv_mass;
        }
        k
    }

    #[inline(always)]
    fn push(&mut self, terms: Terms, impulse: DVec3) {
        for term in &self.terms[terms.range()] {
            let node = &mut self.nodes[term.node as usize];
            node.v += impulse * (node.inv_mass * term.share);
        }
    }

    fn solve_contacts<'r>(
        &mut self,
        rows: impl Iterator<Item = &'r mut Row>,
        shadows: &mut [Shadow],
        h: f64,
    ) -> bool {
        let mut changed = false;
        for row in rows {
            let shadow = &mut shadows[row.shadow as usize];
            let relative = self.velocity(row.terms) - shadow.velocity_at(row.arm);
            let allowed = allowed_velocity(row.depth, h, row.softness) + row.turning;
            let speed = relative.dot(row.normal) + row.softness * row.normal_impulse;
            let jn = normal_impulse(row.normal_impulse, allowed, speed, row.mass);
            let along = row.normal * (jn - row.normal_impulse);
            changed |= self.differs(jn - row.normal_impulse, jn);
            row.normal_impulse = jn;
            self.push(row.terms, along);
            shadow.push(row.arm, -along * row.rigid_share);

            let limit = row.friction_limit();
            if limit > 0.0 || row.friction_impulse != DVec3::ZERO {
                let relative = self.velocity(row.terms) - shadow.velocity_at(row.arm);
                let slip = relative - row.normal * relative.dot(row.normal);
                let speed = slip.length();
                if speed > 0.0 {
                    let k = self.response(row.terms)
                        + row.rigid_share * shadow.response(row.arm, slip / speed);
                    let mass = if k > 0.0 { 1.0 / k } else { 0.0 };
                    let jt = friction_impulse(row.friction_impulse, slip, mass, limit);
                    let change = jt - row.friction_impulse;
                    changed |= self.differs(change.length(), jn);
                    row.friction_impulse = jt;
                    self.push(row.terms, change);
                    shadow.push(row.arm, -change * row.rigid_share);
                }
            }
        }
        changed
    }

    fn solve_ties<'r>(
        &mut self,
        ties: impl Iterator<Item = &'r mut Tie>,
        shadows: &mut [Shadow],
    ) -> bool {
        let mut changed = false;
        for tie in ties {
            let shadow = &mut shadows[tie.shadow as usize];
            let wanted = shadow.velocity_at(tie.arm) + tie.bias - tie.impulse * tie.softness;
            let change = tie.mass * (wanted - self.velocity(tie.terms));
            tie.impulse += change;
            changed |= self.differs(change.length(), tie.impulse.length());
            self.push(tie.terms, change);
            shadow.push(tie.arm, -change);
        }
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(v: DVec3) -> RowNode {
        RowNode {
            body: 0,
            node: 0,
            inv_mass: 1.0,
            v,
            free: v,
            before: v,
        }
    }

    fn rows(friction: f64, depth: f64, arm: DVec3, v: DVec3) -> Rows {
        let mut rows = Rows::default();
        rows.nodes.push(node(v));
        let terms = rows.add_terms([Term {
            node: 0,
            weight: 1.0,
            share: 1.0,
        }]);
        rows.contacts.push(Row {
            terms,
            shadow: 0,
            pair: 0,
            between: false,
            normal: DVec3::Y,
            depth,
            arm,
            rigid_share: 1.0,
            friction,
            softness: 0.0,
            drift: DVec3::ZERO,
            carried: 0.0,
            normal_impulse: 0.0,
            friction_impulse: DVec3::ZERO,
            mass: 0.0,
            turning: 0.0,
        });
        rows
    }

    #[test]
    fn a_node_lands_sticks_or_slides_and_may_close_its_gap() {
        for (friction, depth, expected) in [
            (0.0, 0.0, DVec3::new(1.0, 0.0, 0.0)),
            (0.3, 0.0, DVec3::new(0.4, 0.0, 0.0)),
            (0.9, 0.0, DVec3::ZERO),
            (0.0, -0.001, DVec3::new(1.0, -1.0, 0.0)),
        ] {
            let v = DVec3::new(1.0, -2.0, 0.0);
            let mut rows = rows(friction, depth, DVec3::ZERO, v);
            rows.solve(&mut [Shadow::FIXED], 1e-3, 4, false);
            assert!(
                (rows.nodes[0].v - expected).length() < 1e-12,
                "μ = {friction}, depth {depth}: {}",
                rows.nodes[0].v
            );
        }
    }

    #[test]
    fn a_collision_conserves_momentum() {
        let mut shadow = Shadow {
            inv_mass: DMat3::from_diagonal(DVec3::splat(0.5)),
            inv_inertia: DMat3::IDENTITY,
            v: DVec3::new(0.0, 0.3, 0.1),
            ..Shadow::FIXED
        };
        let before = DVec3::new(0.3, -2.0, 0.0) + shadow.v / 0.5;
        let v = DVec3::new(0.3, -2.0, 0.0);
        let mut rows = rows(0.5, 0.0, DVec3::new(0.4, 0.1, -0.2), v);
        rows.solve(std::slice::from_mut(&mut shadow), 1e-3, 4, true);
        let after = rows.nodes[0].v + shadow.v / 0.5;
        assert!((after - before).length() < 1e-12);
        assert!((shadow.impulse - (shadow.v - DVec3::new(0.0, 0.3, 0.1)) / 0.5).length() < 1e-12);
    }
}
