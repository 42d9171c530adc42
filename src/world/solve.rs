//! Solving the rows of a substep, and again where their impulses change the forces within it.

use super::Deformable;
use super::substep::Group;

/// How often rows are solved where impulses are taken at the start of the substep: each time what is left shrinks by
/// half the substep over the damping time of a node, a half at worst.
const ROUNDS: usize = 4;

impl Group {
    /// Solves the rows and gives nodes their impulses. Where these are taken at the start of the substep, the body's forces
    /// change with them, and what rows asked for is not quite what comes out: the rest is solved for again.
    pub(super) fn solve_rows(&mut self, h: f64, passes: usize, reversed: bool) {
        self.read_free_velocities(h);
        let Self {
            members,
            shadows,
            waiting,
            rows,
            ..
        } = self;
        let late = |body: &Deformable| body.integrator().takes_late_impulses();
        // Contacts alone are not looked at again: their work must never be negative, and it would be.
        let tied = !rows.ties.is_empty();
        let early = tied
            && rows
                .nodes
                .iter()
                .any(|n| !late(&members[n.body as usize].1));
        let rounds = if early { ROUNDS } else { 1 };
        waiting.clear();
        if early {
            waiting.extend_from_slice(shadows);
        }
        for round in 0..rounds {
            if round > 0 {
                shadows.copy_from_slice(waiting);
            }
            rows.solve(shadows, h, passes, reversed);
            for node in &rows.nodes {
                let body = &mut members[node.body as usize].1;
                if !late(body) && (round > 0 || node.v != node.free) {
                    body.take_impulse(node.node as usize, node.v - node.free, h);
                }
            }
            for (_, body) in members.iter_mut() {
                body.move_anew(h);
            }
            for node in &mut rows.nodes {
                let body = &members[node.body as usize].1;
                if round + 1 < rounds && !late(body) {
                    let got = body.free_velocity(node.node as usize, h);
                    let change = node.v - node.free;
                    (node.free, node.v) = (got - change, got - change);
                } else if round + 1 < rounds {
                    node.v = node.free;
                }
            }
        }
        rows.end(shadows, h);
        for node in &rows.nodes {
            let body = &mut members[node.body as usize].1;
            body.slots[node.node as usize] = u32::MAX;
            if late(body) && node.v != node.free {
                body.take_impulse(node.node as usize, node.v - node.free, h);
            }
        }
    }

    fn read_free_velocities(&mut self, h: f64) {
        for node in &mut self.rows.nodes {
            let body = &self.members[node.body as usize].1;
            node.free = body.free_velocity(node.node as usize, h);
            node.v = node.free;
        }
    }
}
