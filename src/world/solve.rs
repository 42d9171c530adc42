//! Solving the rows of a substep, and again where their impulses change the forces within it.

use super::Deformable;
use super::substep::Group;

/// How often rows are solved at most where impulses are taken at the start of the substep: each time what is left shrinks
/// by half the substep over the damping time of a node, a half at worst.
const ROUNDS: usize = 8;
/// What may be left, in changes of velocity by the rows \[1\].
const SETTLED: f64 = 1e-4;

impl Group {
    /// Solves the rows and gives nodes their impulses. Where these are taken at the start of the substep, the body's forces
    /// change with them, and what rows asked for is not quite what comes out: the rest is solved for again.
    pub(super) fn solve_rows(&mut self, h: f64, passes: usize, reversed: bool) {
        self.read_free_velocities(h);
        let rounds = if self.solves_again() { ROUNDS } else { 1 };
        let Self {
            members,
            shadows,
            waiting,
            rows,
            ..
        } = self;
        let late = |body: &Deformable| body.integrator().takes_late_impulses();
        waiting.clear();
        if rounds > 1 {
            waiting.extend_from_slice(shadows);
        }
        for round in 1..=rounds {
            rows.solve(shadows, h, passes, reversed);
            for node in &rows.nodes {
                let body = &mut members[node.body as usize].1;
                if !late(body) && (round > 1 || node.v != node.free) {
                    body.take_impulse(node.node as usize, node.v - node.free, h);
                }
            }
            for (_, body) in members.iter_mut() {
                body.move_anew(h);
            }
            if round == rounds {
                break;
            }
            let (mut change, mut missed) = (0.0_f64, 0.0_f64);
            for node in &rows.nodes {
                let body = &members[node.body as usize].1;
                if !late(body) {
                    let got = body.free_velocity(node.node as usize, h);
                    change = change.max(node.v.distance_squared(node.free));
                    missed = missed.max(node.v.distance_squared(got));
                }
            }
            if missed <= SETTLED * SETTLED * change {
                break;
            }
            for node in &mut rows.nodes {
                let body = &members[node.body as usize].1;
                if !late(body) {
                    node.free += body.free_velocity(node.node as usize, h) - node.v;
                }
                node.v = node.free;
            }
            shadows.copy_from_slice(waiting);
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

    /// Whether any node takes its impulse at the start, and it can be told what that changes. Contacts alone of schemes by
    /// which a pressed node hops are not looked at again: their work must never be negative, and it would be.
    fn solves_again(&self) -> bool {
        let rows = &self.rows;
        let schemes = rows.nodes.iter();
        let mut early = schemes
            .map(|n| self.members[n.body as usize].1.integrator())
            .filter(|scheme| !scheme.takes_late_impulses())
            .peekable();
        early.peek().is_some()
            && (!rows.ties.is_empty() || early.all(|scheme| scheme.settles_rows()))
    }

    fn read_free_velocities(&mut self, h: f64) {
        for node in &mut self.rows.nodes {
            let body = &self.members[node.body as usize].1;
            node.free = body.free_velocity(node.node as usize, h);
            node.v = node.free;
        }
    }
}
