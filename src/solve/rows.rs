//! Rows: contacts and ties of one substep, solved together by sequential impulses.
//!
//! Contact and coupling only fill rows; this pass knows nodes, shadows and numbers. Impulses are accumulated from zero in
//! every substep (a warm start would keep squeezed bodies awake for ever) in a fixed order, reversed in every other
//! pass, so that the bias of one order does not add up to a spin. Nodes appear once, however many rows they have.

use super::shadow::Shadow;
use crate::law::row::{allowed_velocity, friction_impulse, normal_impulse};
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

/// A unilateral contact with friction.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Index into the row nodes.
    pub node: u32,
    /// Index into the shadows.
    pub shadow: u32,
    /// Which body–collider pair the impulse is counted for.
    pub pair: u32,
    /// From the collider to the outside.
    pub normal: DVec3,
    /// Signed depth, positive inside \[m\].
    pub depth: f64,
    /// From the shadow's centre of mass to the node \[m\].
    pub arm: DVec3,
    /// Coulomb's μ.
    pub friction: f64,
    /// Accumulated normal impulse \[N·s\].
    pub normal_impulse: f64,
    /// Accumulated friction impulse \[N·s\].
    pub friction_impulse: DVec3,
    /// Effective mass along the normal \[kg\]; set by the pass.
    pub mass: f64,
}

/// A node held at a point of a shadow.
#[derive(Clone, Copy, Debug)]
pub struct Tie {
    /// Index into the row nodes.
    pub node: u32,
    /// Index into the shadows.
    pub shadow: u32,
    /// Which attachment the impulse is counted for.
    pub attachment: u32,
    /// From the shadow's centre of mass to the anchor \[m\].
    pub arm: DVec3,
    /// Node minus anchor \[m\].
    pub error: DVec3,
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
    /// Contacts, sorted by collider and node.
    pub contacts: Vec<Row>,
    /// Ties, sorted by attachment and node.
    pub ties: Vec<Tie>,
}

impl Rows {
    /// Forgets everything, keeping the memory.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.contacts.clear();
        self.ties.clear();
    }

    /// Solves all rows in at most `passes` Gauss–Seidel passes, stopping once a pass changes nothing, and books the
    /// impulses to the shadows. `reversed` picks the order of the first pass.
    pub fn solve(&mut self, shadows: &mut [Shadow], h: f64, passes: usize, reversed: bool) {
        self.prepare(shadows);
        for pass in 0..passes {
            let changed = if reversed == (pass % 2 == 0) {
                let ties = self.ties.iter_mut().rev();
                solve_contacts(self.contacts.iter_mut().rev(), &mut self.nodes, shadows, h)
                    | solve_ties(ties, &mut self.nodes, shadows)
            } else {
                let ties = self.ties.iter_mut();
                solve_ties(ties, &mut self.nodes, shadows)
                    | solve_contacts(self.contacts.iter_mut(), &mut self.nodes, shadows, h)
            };
            if !changed {
                break;
            }
        }
        for row in &self.contacts {
            let j = row.normal * row.normal_impulse + row.friction_impulse;
            book(&mut shadows[row.shadow as usize], row.arm, j);
        }
        for tie in &self.ties {
            book(&mut shadows[tie.shadow as usize], tie.arm, tie.impulse);
        }
    }

    fn prepare(&mut self, shadows: &[Shadow]) {
        for row in &mut self.contacts {
            let k = self.nodes[row.node as usize].inv_mass
                + shadows[row.shadow as usize].response(row.arm, row.normal);
            row.mass = if k > 0.0 { 1.0 / k } else { 0.0 };
        }
        for tie in &mut self.ties {
            let w = self.nodes[tie.node as usize].inv_mass;
            let k = DMat3::from_diagonal(DVec3::splat(w))
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

/// Whether an impulse has changed by more than rounding.
fn differs(change: f64, total: f64) -> bool {
    change.abs() > 1e-9 * total.abs()
}

fn solve_contacts<'a>(
    rows: impl Iterator<Item = &'a mut Row>,
    nodes: &mut [RowNode],
    shadows: &mut [Shadow],
    h: f64,
) -> bool {
    let mut changed = false;
    for row in rows {
        let node = &mut nodes[row.node as usize];
        let shadow = &mut shadows[row.shadow as usize];
        let relative = node.v - shadow.velocity_at(row.arm);
        let speed = relative.dot(row.normal);
        let allowed = allowed_velocity(row.depth, h);
        let jn = normal_impulse(row.normal_impulse, allowed, speed, row.mass);
        let along = row.normal * (jn - row.normal_impulse);
        changed |= differs(jn - row.normal_impulse, jn);
        row.normal_impulse = jn;
        node.v += along * node.inv_mass;
        shadow.push(row.arm, -along);

        if row.friction > 0.0 && (jn > 0.0 || row.friction_impulse != DVec3::ZERO) {
            let relative = node.v - shadow.velocity_at(row.arm);
            let slip = relative - row.normal * relative.dot(row.normal);
            let speed = slip.length();
            if speed > 0.0 {
                let k = node.inv_mass + shadow.response(row.arm, slip / speed);
                let mass = if k > 0.0 { 1.0 / k } else { 0.0 };
                let jt = friction_impulse(row.friction_impulse, slip, mass, row.friction * jn);
                let change = jt - row.friction_impulse;
                changed |= differs(change.length(), jn);
                row.friction_impulse = jt;
                node.v += change * node.inv_mass;
                shadow.push(row.arm, -change);
            }
        }
    }
    changed
}

fn solve_ties<'a>(
    ties: impl Iterator<Item = &'a mut Tie>,
    nodes: &mut [RowNode],
    shadows: &mut [Shadow],
) -> bool {
    let mut changed = false;
    for tie in ties {
        let node = &mut nodes[tie.node as usize];
        let shadow = &mut shadows[tie.shadow as usize];
        let change = tie.mass * (shadow.velocity_at(tie.arm) - node.v);
        tie.impulse += change;
        changed |= differs(change.length(), tie.impulse.length());
        node.v += change * node.inv_mass;
        shadow.push(tie.arm, -change);
    }
    changed
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

    fn contact(friction: f64, depth: f64) -> Row {
        Row {
            node: 0,
            shadow: 0,
            pair: 0,
            normal: DVec3::Y,
            depth,
            arm: DVec3::ZERO,
            friction,
            normal_impulse: 0.0,
            friction_impulse: DVec3::ZERO,
            mass: 0.0,
        }
    }

    #[test]
    fn a_node_lands_sticks_or_slides_and_may_close_its_gap() {
        for (friction, depth, expected) in [
            (0.0, 0.0, DVec3::new(1.0, 0.0, 0.0)),
            (0.3, 0.0, DVec3::new(0.4, 0.0, 0.0)),
            (0.9, 0.0, DVec3::ZERO),
            (0.0, -0.001, DVec3::new(1.0, -1.0, 0.0)),
        ] {
            let mut rows = Rows::default();
            rows.nodes.push(node(DVec3::new(1.0, -2.0, 0.0)));
            rows.contacts.push(contact(friction, depth));
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
            inv_mass: DVec3::splat(0.5),
            inv_inertia: DMat3::IDENTITY,
            v: DVec3::new(0.0, 0.3, 0.1),
            ..Shadow::FIXED
        };
        let before = DVec3::new(0.3, -2.0, 0.0) + shadow.v / 0.5;
        let mut rows = Rows::default();
        rows.nodes.push(node(DVec3::new(0.3, -2.0, 0.0)));
        rows.contacts.push(Row {
            arm: DVec3::new(0.4, 0.1, -0.2),
            ..contact(0.5, 0.0)
        });
        rows.solve(std::slice::from_mut(&mut shadow), 1e-3, 4, true);
        let after = rows.nodes[0].v + shadow.v / 0.5;
        assert!((after - before).length() < 1e-12);
        assert!((shadow.impulse - (shadow.v - DVec3::new(0.0, 0.3, 0.1)) / 0.5).length() < 1e-12);
    }
}
