//! What is mended at position level: depth, creep, errors of ties.

use super::Deformable;
use super::substep::{Group, Members, Settings};
use crate::coupling::observe::Answer;
use crate::law::row::{pull_back, push_out};
use crate::math::DVec3;
use crate::solve::rows::{RowNode, Term, Terms};

impl Group {
    /// Mends depth, creep of what sticks, and errors of ties at position level, on the nodes alone, which gives nothing any
    /// velocity. Ties are mended in full, and at a limited rate only while something moved from outside is on its way
    /// back. What that changes in stored energy is booked; the angular momentum that a moved node loses goes to the body
    /// it is moved out of, if nothing but contacts holds that.
    pub fn push_out(&mut self, h: f64, s: &Settings) {
        let Self {
            rows,
            members,
            shadows,
            touched,
            attachments,
            ..
        } = self;
        let mut mend = |terms: Terms, shadow: u32, by: DVec3| {
            let lost = displace(members, &rows.nodes, rows.terms_of(terms), by);
            if (shadow as usize)
                .checked_sub(1)
                .is_some_and(|i| matches!(touched[i].answer, Answer::Free | Answer::Constrained))
            {
                let alone = !rows.is_composite(shadow);
                let shadow = &mut shadows[shadow as usize];
                shadow.late_torque += lost;
                // What holds nodes takes it with them in the next substep: a light body would turn by it alone, and its nodes be
                // moved all the farther.
                if alone {
                    shadow.take_late();
                }
            }
        };
        for row in &rows.contacts {
            let mut by = DVec3::ZERO;
            if row.depth > 0.0 && row.softness == 0.0 && row.lift.speed == 0.0 {
                by += row.normal * push_out(row.depth, h, s.push_out);
            }
            if row.drift != DVec3::ZERO && row.sticks() {
                by -= row.drift * pull_back(h);
            }
            if by != DVec3::ZERO {
                mend(row.terms, row.shadow, by);
            }
        }
        for tie in rows.ties.iter().filter(|t| t.softness == 0.0) {
            let length = tie.error.length();
            if length > 0.0 {
                let loose = attachments[tie.attachment as usize].bond.loose;
                let most = if loose { s.push_out * h } else { length };
                mend(tie.terms, tie.shadow, -towards(tie.error, length.min(most)));
            }
        }
    }
}

/// A vector of length `length` along `v`.
fn towards(v: DVec3, length: f64) -> DVec3 {
    v * (length / v.length())
}

impl Deformable {
    /// Elastic forces grow while nodes are moved against them: now that they are known at the places where these were
    /// moved to, the other half of the trapezoid is booked.
    pub(super) fn book_moved_out(&mut self) {
        for (node, by, before) in self.moved_out.drain(..) {
            let after = self.solver.elastic_force(node as usize);
            self.solver.work.push_out -= 0.5 * (after - before).dot(by);
        }
    }
}

/// Moves a point by moving its nodes as an impulse would, books what that adds to the stored energy, and returns what it
/// takes from the angular momentum. A pinned node stays where it is put.
fn displace(members: &mut Members, nodes: &[RowNode], terms: &[Term], by: DVec3) -> DVec3 {
    let response: f64 = terms
        .iter()
        .map(|t| t.weight * t.share * nodes[t.node as usize].inv_mass)
        .sum();
    let mut lost = DVec3::ZERO;
    if response <= 0.0 {
        return lost;
    }
    for term in terms {
        let node = &nodes[term.node as usize];
        let by = by * (term.share * node.inv_mass / response);
        if by == DVec3::ZERO {
            continue;
        }
        let body = &mut members[node.body as usize].1;
        let i = node.node as usize;
        let mass = f64::from(body.blueprint.nodes[i].mass);
        let elastic = body.solver.elastic_force(i);
        body.solver.work.push_out -= (elastic + body.gravity() * mass).dot(by);
        if body.integrator().takes_late_impulses() {
            body.moved_out.push((node.node, by, elastic));
        }
        body.state.displace(i, by.as_vec3().to_array());
        lost -= by.cross(body.state.velocity(i) * mass);
    }
    lost
}
