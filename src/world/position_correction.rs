//! What is mended at position level: depth, creep, errors of ties.

use super::Deformable;
use super::substep::{Group, Members, Settings};
use super::work::node_work;
use crate::coupling::observe::Answer;
use crate::law::row::{pull_back, push_out};
use crate::math::{DMat3, DVec3};
use crate::solve::rows::{Row, RowNode, Rows, Term, Terms};

/// Nodes whose determinant of inertia is less than this, over the cube of Σ m·r² about their centre, count as lying on a line \[1\].
const ON_A_LINE: f64 = 1e-4;
/// Nodes that are no farther apart than this, per distance from the origin of the first one's body, are in one place: what is left is
/// rounding \[1\].
const IN_ONE_PLACE: f64 = 1e-7;

impl Group {
    /// Mends depth, creep of what sticks, and errors of ties at position level, on the nodes alone, which gives nothing any
    /// velocity. Ties are mended in full, and at a limited rate only while something moved from outside is on its way
    /// back. What that changes in stored energy is booked; the angular momentum that a moved node loses goes to the body
    /// it is moved out of, if nothing but contacts holds that, and between deformables to the nodes of the row. A body
    /// lighter than the node takes so much less of it: in truth it would be the one that is moved, and one of a gram
    /// would be set spinning by what a node of a kilogram has.
    pub fn push_out(&mut self, h: f64, s: &Settings) {
        let Self {
            rows,
            members,
            shadows,
            touched,
            attachments,
            mended,
            ..
        } = self;
        mended.clear();
        mended.resize(rows.nodes.len(), DVec3::ZERO);
        let mut mend = |members: &mut Members,
                        (rows, mended): (&Rows, &mut [DVec3]),
                        what: (Terms, u32, f64),
                        row: Option<usize>,
                        by: DVec3| {
            let (terms, shadow, taken) = what;
            let lost = displace(members, (rows, mended), (terms, row), by);
            if (shadow as usize)
                .checked_sub(1)
                .is_some_and(|i| touched[i].answer == Answer::Free || touched[i].answer.is_kept())
            {
                let alone = !rows.is_composite(shadow);
                let shadow = &mut shadows[shadow as usize];
                shadow.late_torque += lost * taken;
                // What holds nodes takes it with them in the next substep: a light body would turn by it alone, and its nodes be
                // moved all the farther.
                if alone {
                    shadow.take_late();
                }
            }
            lost
        };
        for i in 0..rows.contacts.len() {
            let row = &rows.contacts[i];
            let mut by = DVec3::ZERO;
            if row.depth > 0.0 && row.softness == 0.0 && row.lift.speed == 0.0 {
                let done = if row.between {
                    come_out(rows, row, mended)
                } else {
                    0.0
                };
                by += row.normal * push_out(row.depth - row.pinched - done, h, s.push_out);
            }
            if row.drift != DVec3::ZERO && row.sticks() {
                by -= row.drift * pull_back(h);
            }
            if by == DVec3::ZERO {
                continue;
            }
            let taken = row.response.mass_ratio(row.normal);
            let by = by * row.response.share;
            let what = (row.terms, row.shadow, taken);
            let lost = mend(members, (rows, mended), what, Some(i), by);
            if row.between {
                let terms = &rows.terms[row.terms.range()];
                turn(members, &mut rows.nodes, terms, lost, h);
            }
        }
        for tie in rows.ties.iter().filter(|t| t.softness == 0.0) {
            let length = tie.error.length();
            if length > 0.0 {
                let loose = attachments[tie.attachment as usize].bond.loose;
                let most = if loose { s.push_out * h } else { length };
                let by = -towards(tie.error, length.min(most));
                let what = (tie.terms, tie.shadow, 1.0);
                mend(members, (rows, mended), what, None, by);
            }
        }
    }
}

/// Turns the nodes of a row about the centre of their mass, all by one rotation, so that they have that much more angular
/// momentum, and books the work. None of those that are held, nor of those on a line or in one place, as nodes of blocks that lie
/// exactly on each other: they can't take it.
fn turn(members: &mut Members, nodes: &mut [RowNode], terms: &[Term], lost: DVec3, h: f64) {
    let of = |t: &Term| &nodes[t.node as usize];
    let is_held = |t: &Term| of(t).inv_mass == 0.0 || t.share != t.weight;
    if lost == DVec3::ZERO || terms.iter().any(is_held) {
        return;
    }
    let first = members[of(&terms[0]).body as usize].1.state.origin;
    let place = |members: &Members, node: &RowNode| {
        let state = &members[node.body as usize].1.state;
        state.local(node.node as usize) + (state.origin - first)
    };
    let (mut mass, mut center) = (0.0, DVec3::ZERO);
    for node in terms.iter().map(of) {
        let m = 1.0 / node.inv_mass;
        mass += m;
        center += place(members, node) * m;
    }
    center /= mass;
    // About the centre and not the origin, of which a difference of two large numbers would be left where nodes coincide.
    let mut square = DMat3::ZERO;
    for node in terms.iter().map(of) {
        let (m, x) = (1.0 / node.inv_mass, place(members, node) - center);
        square += DMat3::from_cols(x * x.x, x * x.y, x * x.z) * m;
    }
    let trace = square.x_axis.x + square.y_axis.y + square.z_axis.z;
    let inertia = DMat3::from_diagonal(DVec3::splat(trace)) - square;
    let are_apart = trace > mass * IN_ONE_PLACE.powi(2) * center.length_squared();
    let can_turn = are_apart && inertia.determinant() > ON_A_LINE * trace.powi(3);
    if !can_turn {
        return;
    }
    let spin = inertia.inverse() * lost;
    for term in terms {
        let node = &mut nodes[term.node as usize];
        let change = spin.cross(place(members, node) - center);
        let impulse = change / node.inv_mass;
        let body = &mut members[node.body as usize].1;
        if body.integrator().takes_late_impulses() {
            node.v += change;
            let (mean, work) = node_work(members, node, None, impulse);
            work.push_out -= impulse.dot(mean);
        } else {
            let mean = body.state.velocity(node.node as usize) + 0.5 * change;
            body.solver.work.push_out -= impulse.dot(mean);
        }
        let body = &mut members[node.body as usize].1;
        body.kick_at_end(node.node as usize, change, h);
    }
}

/// How far a row between two deformables has been moved out by what was done to its nodes for others in this substep \[m\]. Where the two
/// touch all over, a node has several rows: what one has moved the next is not to move again, and what the other side of a layer
/// has moved back is moved once more.
fn come_out(rows: &Rows, row: &Row, mended: &[DVec3]) -> f64 {
    let terms = rows.terms_of(row.terms).iter();
    let way: DVec3 = terms.map(|t| mended[t.node as usize] * t.weight).sum();
    way.dot(row.normal)
}

/// A vector of length `length` along `v`.
fn towards(v: DVec3, length: f64) -> DVec3 {
    v * (length / v.length())
}

impl Deformable {
    /// Changes the velocity of a node at the end of a substep of h s.
    fn kick_at_end(&mut self, node: usize, change: DVec3, h: f64) {
        if self.integrator().takes_late_impulses() {
            self.solver.kick(&mut self.state, node, change, h);
        } else {
            let v = self.state.velocity(node) + change;
            self.state.set_velocity(node, v);
        }
    }

    /// Elastic forces grow while nodes are moved against them: now that they are known at the places where these were
    /// moved to, the other half of the trapezoid is booked.
    pub(super) fn book_moved_out(&mut self) {
        for (node, by, before) in self.moved_out.drain(..) {
            let after = self.solver.elastic_force(node as usize);
            self.solver.work.push_out -= 0.5 * (after - before).dot(by);
        }
    }
}

/// Moves a point by moving its nodes as an impulse would, notes how far, books what that adds to the stored energy, and returns
/// what it takes from the angular momentum. A pinned node stays where it is put.
fn displace(
    members: &mut Members,
    (rows, mended): (&Rows, &mut [DVec3]),
    (terms, row): (Terms, Option<usize>),
    by: DVec3,
) -> DVec3 {
    let nodes = &rows.nodes;
    let answer = |t: &Term| t.share * nodes[t.node as usize].inv_mass;
    let is_free = |t: &Term| !row.is_some_and(|row| rows.is_blocked(row, t.node, by * t.share));
    let all = rows.terms_of(terms).iter();
    let all = all.filter(|t| answer(t) != 0.0);
    let free = all.clone().filter(|t| is_free(t)).count();
    // Where none is free, all share it.
    let are_some = 0 < free && free < all.clone().count();
    let moving = all.filter(|t| !are_some || is_free(t));
    let mut response = moving.clone().map(|t| t.weight * answer(t)).sum::<f64>();
    if are_some {
        // None of them goes farther than the point would: they may hardly move that.
        let each = moving.clone().map(|t| answer(t).abs());
        response = each.fold(response, f64::max);
    }
    let mut lost = DVec3::ZERO;
    if response <= 0.0 {
        return lost;
    }
    for term in moving {
        let node = &nodes[term.node as usize];
        let by = by * (answer(term) / response);
        let by = row.map_or(by, |row| rows.free_way(row, term.node, by));
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
        mended[term.node as usize] += by;
        body.state.displace(i, by.as_vec3().to_array());
        lost -= by.cross(body.state.velocity(i) * mass);
    }
    lost
}
