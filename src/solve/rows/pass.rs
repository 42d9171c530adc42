//! Gauss–Seidel passes over all rows of a group.

use super::bundle::Bundles;
use super::climb::Attempt;
use super::composite::Composites;
use super::contact::{LEVER, Response};
use super::layers::Layers;
use super::points::{self, Points};
use super::rigid::{Answers, start_rigid};
use super::settled::{Give, Settled};
use super::squeeze::{Held, Squeeze};
use super::stand::Heaps;
use super::worklist::Worklist;
use super::{JointRow, RigidRow, Row, Rows, Tie};
use crate::law::row::{allowed_velocity, chord, yielding};
use crate::math::{DMat3, DVec3};
use crate::solve::shadow::Shadow;

/// Passes over rows that hang together, per pass asked for.
const COUPLED: usize = 4;
/// The same while anything sinks in, as foam does under a heavy body on a light sheet. Few substeps of a heap need more than
/// [`COUPLED`].
const SINKING: usize = 64;
/// Visits of rows in all, or passes as above where that is more, while anything sinks in after a blow, which is over within a few substeps:
/// a cylinder of 24 kg that fell by 0.2 m on sheets and a rope of 0.1 kg was 6 mm in them without, and was lifted out again.
const STRUCK: usize = 1 << 21;
/// What counts as sinking in, per speed at which points are moved out. What is squeezed between two bodies is moved out of
/// both, and gives way to the softer one at a small part of that speed.
const SINKS: f64 = 0.03;
/// After the passes asked for, points of several nodes on rigid bodies are visited only in every so manieth one, as long as
/// nothing sinks in: they start warm, and what they leave they go on with in the next substep. Those of two deformables would
/// lose friction by it, and contacts of rigid bodies would not bear what is put on them.
const RESTS: usize = 4;

/// How often contacts and joints of shadows are visited in a pass where light ones bear a heavy deformable. Under a car of 876 kg, feet
/// of 5 kg on fixed joints ended every step 2.9 mm/s off with one visit, and 0.3, 0.4, 0.2 and 0.1 mm/s with two, four, eight and 16.
const SWEEPS: usize = 2;

impl Rows {
    /// Solves all rows in at most `passes` passes, or so many times as many where they need it, stopping once one changes
    /// nothing, and books the impulses to the shadows. `reversed` picks the order of the first pass.
    pub fn solve(&mut self, shadows: &mut [Shadow], h: f64, passes: usize, reversed: bool) {
        let squeezed = self.find_squeezed(shadows);
        let rows = self.contacts.len() + self.ties.len() + self.rigid.len() + self.joints.len();
        self.worklist.start(self.nodes.len(), shadows, rows);
        let negligible = if self.ties.is_empty() {
            self.negligible
        } else {
            self.negligible.of_shadows()
        };
        let points = Points {
            nodes: &mut self.nodes,
            terms: &self.terms,
            levers: &self.levers,
        };
        for row in &mut self.rigid {
            row.approach(shadows, h);
        }
        self.composites.start(&points, &mut self.ties, shadows);
        shadows.iter_mut().for_each(Shadow::take_late);
        self.fallen.clear();
        self.fallen.resize(shadows.len(), 0.0);
        let mut pass = Pass {
            points,
            contacts: &mut self.contacts,
            ties: &mut self.ties,
            rigid: &mut self.rigid,
            joints: &mut self.joints,
            shadows,
            squeeze: &self.squeeze,
            layers: &self.layers,
            held: &mut self.held,
            attempt: &mut self.attempt,
            bundles: &mut self.bundles,
            fallen: &mut self.fallen,
            composites: &mut self.composites,
            worklist: &mut self.worklist,
            answers: &mut self.answers,
            squeezed,
            h,
            sweeps: if self.bears { SWEEPS } else { 1 },
            rests: false,
            settled: Settled {
                tolerance: 0.0,
                negligible,
            },
        };
        pass.prepare();
        pass.prepare_lifts(self.push_out);
        pass.find_bundles();
        pass.follow_all();
        pass.start_shadows();
        pass.start_warm(&mut self.clusters);
        pass.spread_loads(&mut self.bearers, &mut self.tried);
        pass.pass_over_still();
        pass.converge(
            passes,
            self.blow,
            SINKS * self.push_out,
            reversed,
            &mut self.heaps,
        );
        pass.follow_all();
        pass.book();
        self.composites.end(shadows);
    }

    /// Finds what is squeezed between rows; `false` where there is too little for that.
    fn find_squeezed(&mut self, shadows: &[Shadow]) -> bool {
        if self.contacts.len() + self.ties.len() <= 1 {
            self.contacts.iter_mut().for_each(Row::cool);
            return false;
        }
        self.squeeze
            .find(self.nodes.len(), &self.contacts, &self.ties, &self.terms);
        let mut layers = std::mem::take(&mut self.layers);
        layers.find(self.seen(), shadows);
        self.layers = layers;
        self.held.clear();
        self.held.resize(self.contacts.len(), Held::default());
        let alone = |row: &&mut Row| self.squeeze.stands_alone(row, &self.terms);
        self.contacts.iter_mut().filter(alone).for_each(Row::cool);
        true
    }

    /// Ends a substep of h s: rigid contacts and joints go on from where their shadows take them.
    pub fn end(&mut self, shadows: &[Shadow], h: f64) {
        for row in &mut self.rigid {
            row.end(shadows, h);
        }
        self.joints.iter_mut().for_each(|joint| joint.end(h));
    }

    /// Ends a step of `dt` s of Rapier's: bodies get what its contacts can't bear.
    pub fn spare_contacts(&self, shadows: &mut [Shadow], dt: f64) {
        for row in &self.rigid {
            row.spare(shadows, dt);
        }
    }

    /// Warm starts of substeps that are from now on `ratio` times as long.
    pub fn change_substep(&mut self, ratio: f64) {
        for row in &mut self.rigid {
            row.scale(ratio);
        }
        for joint in &mut self.joints {
            joint.impulses *= ratio;
        }
    }
}

/// What a pass works on.
pub(super) struct Pass<'a> {
    pub points: Points<'a>,
    pub contacts: &'a mut [Row],
    pub ties: &'a mut [Tie],
    pub rigid: &'a mut [RigidRow],
    pub joints: &'a mut [JointRow],
    pub shadows: &'a mut [Shadow],
    pub squeeze: &'a Squeeze,
    pub layers: &'a Layers,
    pub held: &'a mut [Held],
    pub attempt: &'a mut Attempt,
    pub bundles: &'a mut Bundles,
    pub fallen: &'a mut [f64],
    pub composites: &'a mut Composites,
    pub worklist: &'a mut Worklist,
    answers: &'a mut Answers,
    /// Whether `squeeze` is of these rows.
    pub squeezed: bool,
    h: f64,
    /// How often contacts and joints of shadows are visited in a pass.
    sweeps: usize,
    /// Whether points of several nodes rest in this pass, see [`RESTS`].
    rests: bool,
    pub settled: Settled,
}

impl Pass<'_> {
    /// Passes over the rows until one changes nothing, `passes` at most, or so many times as many where rows hang together or
    /// something sinks in faster than `sinks` m/s. After a blow none of them is rested, and there are more, see [`STRUCK`]. Where shadows press on each other a pass can
    /// change little and be far from the end, see [`super::stand`].
    fn converge(
        &mut self,
        passes: usize,
        blow: bool,
        sinks: f64,
        reversed: bool,
        heaps: &mut Heaps,
    ) {
        let most = if blow {
            (SINKING * passes).max(STRUCK / self.contacts.len().max(1))
        } else if self.is_coupled() {
            SINKING * passes
        } else {
            passes
        };
        let (mut thorough, mut stood) = (blow, false);
        for n in 0..most {
            if n >= COUPLED * passes && n % passes == 0 {
                if !self.sinks(sinks) {
                    break;
                }
                if !self.rigid.is_empty() {
                    self.stand(heaps);
                }
            }
            self.settled.tolerance = if n < passes { 1e-9 } else { 1e-3 };
            let late = (passes..COUPLED * passes).contains(&n);
            self.rests = late && !thorough && n % RESTS != 0;
            if self.solve_all(reversed == (n % 2 == 0)) {
                stood = false;
                continue;
            }
            thorough = self.rests && self.sinks(sinks);
            if thorough {
                continue;
            }
            if stood || self.rigid.is_empty() || !self.sinks(sinks) {
                break;
            }
            self.stand(heaps);
            stood = true;
        }
    }

    /// One pass over all rows, forth or back; whether it changed anything.
    fn solve_all(&mut self, back: bool) -> bool {
        if back {
            self.solve_between_shadows(true)
                | self.solve_contacts((0..self.contacts.len()).rev())
                | self.solve_ties((0..self.ties.len()).rev())
        } else {
            self.solve_ties(0..self.ties.len())
                | self.solve_contacts(0..self.contacts.len())
                | self.solve_between_shadows(false)
        }
    }

    /// Contacts and joints of shadows with each other, forth or back, or to and fro; whether anything changed.
    fn solve_between_shadows(&mut self, back: bool) -> bool {
        let mut changed = false;
        for n in 0..self.sweeps {
            let again = if back == (n % 2 == 0) {
                self.solve_joints(true) | self.solve_rigid(true)
            } else {
                self.solve_rigid(false) | self.solve_joints(false)
            };
            changed |= again;
            if !again {
                break;
            }
        }
        changed
    }

    /// Whether rows share nodes, or shadows press on each other: these take more passes when a blow finds them unprepared.
    fn is_coupled(&self) -> bool {
        !self.rigid.is_empty()
            || !self.joints.is_empty()
            || self.contacts.iter().any(|row| row.terms.count > 1)
            || (0..self.contacts.len()).any(|i| self.is_squeezed(i))
    }

    fn prepare(&mut self) {
        for row in &mut *self.contacts {
            let shadow = &self.shadows[row.shadow as usize];
            let mut allowed = if row.softness > 0.0 {
                let own = self.points.velocity_before(row);
                let before = own - shadow.velocity_before(row.arm);
                yielding(row.depth, before.dot(row.normal), self.h)
            } else {
                allowed_velocity(row.depth, self.h)
            };
            let mut along = DVec3::ZERO;
            if shadow.w != DVec3::ZERO {
                let relative = self.points.velocity_of(row) - shadow.velocity_at(row.arm);
                allowed += row.turn.faster(relative, row.normal, self.h);
                along = row.along(chord(shadow.w, row.arm, self.h));
            }
            let own = self.points.response(row.terms);
            let rigid = if let Some(levers) = points::levers(self.points.levers, row) {
                self.points.lever_response(row, levers)
            } else if self.worklist.moves(row.shadow) {
                shadow.response_matrix(row.arm) * row.rigid_share
            } else {
                DMat3::ZERO
            };
            let give = self.points.give(row.terms);
            let least = give / LEVER;
            let throws =
                rigid == DMat3::ZERO && (shadow.v != DVec3::ZERO || shadow.w != DVec3::ZERO);
            let lever = if throws { (least - own).max(0.0) } else { 0.0 };
            row.response = Response {
                allowed,
                chord: along,
                own,
                rigid,
                mass: 0.0,
                softness: row.softness + lever,
                share: if least > own { own / least } else { 1.0 },
                give: match row.levers {
                    None => Give::of(give, &rigid),
                    Some(_) => Give::of(self.points.give_by_levers(row), &DMat3::ZERO),
                },
            };
            let resists = own + row.response.rigid_along(row.normal) + row.response.softness;
            row.response.mass = inverse(resists);
        }
        self.prepare_ties();
    }

    fn solve_rigid(&mut self, reversed: bool) -> bool {
        let first = self.contacts.len() + self.ties.len();
        let (shadows, settled) = (&mut *self.shadows, self.settled);
        self.worklist.pass(first, self.rigid, reversed, |row| {
            row.solve(shadows, settled)
        })
    }

    fn solve_joints(&mut self, reversed: bool) -> bool {
        let first = self.contacts.len() + self.ties.len() + self.rigid.len();
        let (shadows, tolerance) = (&mut *self.shadows, self.settled.tolerance);
        self.worklist.pass(first, self.joints, reversed, |row| {
            row.solve(shadows, tolerance)
        })
    }

    fn start_shadows(&mut self) {
        start_rigid(self.rigid, self.shadows, self.answers);
        for row in &mut *self.joints {
            row.start(self.shadows, self.h);
        }
    }

    fn solve_contacts(&mut self, order: impl Iterator<Item = usize>) -> bool {
        let mut changed = false;
        for i in order {
            let row = &self.contacts[i];
            let terms = self.points.terms_of(row.terms);
            if self.rests && terms.len() > 1 && !row.between {
                continue;
            }
            if !self.worklist.visit(i, terms, [row.shadow; 2]) {
                continue;
            }
            let felt = if self.is_squeezed(i) {
                self.solve_squeezed(i)
            } else {
                self.solve_row(i)
            };
            if felt {
                self.solve_bundle(i);
            }
            changed |= felt;
        }
        changed
    }

    pub(super) fn is_squeezed(&self, i: usize) -> bool {
        self.squeezed && self.squeeze.shares(i)
    }

    /// The reactions, summed up for the hand-over.
    fn book(&mut self) {
        let mut book = |shadow: u32, arm: DVec3, j: DVec3| {
            let shadow = &mut self.shadows[shadow as usize];
            shadow.impulse -= j;
            shadow.torque -= arm.cross(j);
        };
        for row in &*self.contacts {
            book(row.shadow, row.arm, row.impulse() * row.rigid_share);
        }
        for tie in self.ties.iter().filter(|t| !t.between) {
            book(tie.shadow, tie.arm, tie.impulse);
        }
    }
}

/// 1/k, or 0 for what does not give way at all.
pub(super) fn inverse(k: f64) -> f64 {
    if k > 0.0 { 1.0 / k } else { 0.0 }
}
