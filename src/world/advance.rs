//! Groups are advanced through a rigid step: one after the other, or all at once where nobody looks at their substeps.
//!
//! Nothing that a group changes is seen by another until all are done, and what comes of them is taken in their order. So
//! results do not depend on threads.

use super::observer::Observer;
use super::report::{StepReport, note};
use super::substep::{Group, Settings};
use super::{Deformable, meet};
use crate::solve::threads;

/// What the groups of a rigid step have in common.
#[derive(Clone, Copy)]
pub(super) struct Advance {
    /// Simulated time at the start \[s\].
    pub time: f64,
    /// The order of rows at the start.
    pub parity: bool,
    /// Length of the rigid step \[s\], and of the step of the world that it is a part of.
    pub dt: f64,
    pub frame: f64,
    /// The stable substep is found anew at least this often \[s\].
    pub review_interval: f64,
    pub settings: Settings,
}

/// A group, and what came of it.
pub(super) struct Moving {
    pub group: Group,
    pub report: StepReport,
    /// Whether it took an odd number of substeps.
    pub odd: bool,
}

impl From<Group> for Moving {
    fn from(group: Group) -> Self {
        Self {
            group,
            report: StepReport::default(),
            odd: false,
        }
    }
}

impl Advance {
    /// Advances all groups. Threads are called once, and only for as much as is worth it.
    pub fn all(&self, groups: &mut [Moving], observer: &mut dyn Observer) {
        let apart = groups.len() > 1 && !observer.wants_substeps();
        let springs = groups.iter().map(|g| g.group.springs());
        let (sum, most) = springs.fold((0, 0), |(sum, most), n| (sum + n, n.max(most)));
        if apart && threads::is_worth_sharing(FEW_SUBSTEPS * sum) {
            let mut order: Vec<&mut Moving> = groups.iter_mut().collect();
            // The longest first, so that no thread is left with one at the end.
            order.sort_by_key(|g| std::cmp::Reverse(g.group.springs()));
            threads::each(order, |group| self.one(group, &mut ()));
            return;
        }
        let mut all = || groups.iter_mut().for_each(|g| self.one(g, observer));
        if threads::is_worth_sharing(most) {
            threads::within(all);
        } else {
            all();
        }
    }

    fn one(&self, moving: &mut Moving, observer: &mut dyn Observer) {
        let Moving { group, report, odd } = moving;
        let (mut time, mut parity) = (self.time, self.parity);
        let (mut left, mut last) = (self.dt, None);
        while left > 0.0 {
            // The stable substep changes as bodies crumple, so a long rigid step is looked at anew now and then, unless
            // what is left is a matter of a few substeps.
            let way = group.longest_way(self.dt, self.settings.near);
            let longest = group.longest_turn(self.dt).min(way);
            let spins = 2.0 * group.fastest_spin().max(SLOW);
            let turns = (left / longest).ceil() as usize;
            let (needed, stale) = group_substeps(group, report, left, self.frame);
            let needed = needed.max(turns);
            let reviews = (left / self.review_interval - 1e-6).ceil() as usize;
            let n = needed.div_ceil(reviews.min(needed / BETWEEN_REVIEWS).max(1));
            let h = left / needed as f64;
            let n = n.min((stale / h) as usize).max(1);
            match last {
                None => group.synchronise(h),
                Some(last) => group.change_substep(last, h),
            }
            last = Some(h);
            let speeds = group.speeds();
            let (mut made, mut strained) = (0, 0.0);
            while made < n && (made == 0 || group.fastest_spin() <= spins) && strained < STRAINED {
                time += h;
                parity = !parity;
                made += 1;
                if !group.substep(h, time, parity, &self.settings, observer) {
                    freeze(group, report);
                    return;
                }
                strained += h * group.rush(&speeds);
            }
            report.add_group(group, made);
            left = if made < needed {
                left - made as f64 * h
            } else {
                0.0
            };
        }
        group.write_back();
        // What rows did in the last substep, no integration pass has seen yet.
        if !group.freeze_non_finite() {
            freeze(group, report);
        }
        *odd = parity != self.parity;
    }
}

/// The fewest substeps between two looks at the stable one in a rigid step, if it has so many: a look takes as long as three of them.
const BETWEEN_REVIEWS: usize = 16;

/// How far, in spacings of its nodes, the fastest node of a body may have come beyond what it would have at twice the speed of the last
/// look before the next one: what a load that sets in at once does to the shape is not to be foreseen.
const STRAINED: f64 = 0.05;

/// A rigid step has hardly fewer substeps.
const FEW_SUBSTEPS: usize = 4;

/// By how much a rigid body may turn in a substep \[rad\]: what it touches moves straight on in that. One that is struck may
/// turn twice as far until substeps are shortened for it.
const TURN: f64 = 0.25;

/// What turns at less than this is looked at again only once it turns at twice this \[rad/s\].
const SLOW: f64 = 1.0;

/// How far past its row a corner or an edge of what strikes a sheet may come within a substep, per width of that: a face of length L that
/// is struck at v turns by v·h/L meanwhile, and moves by v·h. Without, of plates of 6 mm at 40 m/s a fifth went through.
const THIN: f64 = 0.5;

/// How far what flies past a body that turns may leave the straight line that its row takes it for within a substep, per width of that
/// body: one that slides at v over a blade that turns at ω leaves it by ω·v·h². Without, of single nodes shot at 5 to 100 m/s at a plate of
/// 2 mm that turned at 20 rad/s one in seven came through.
const SWING: f64 = 0.5;

/// The most substeps of a rigid step that what turns or is thin asks for: some bodies are so small that none is short enough.
const MOST: f64 = 256.0;

/// A tet takes about as long as so many springs.
const TET: usize = 15;

impl Group {
    /// The longest substep in which nothing that it may touch turns too far, in a rigid step of `dt` s \[s\].
    fn longest_turn(&self, dt: f64) -> f64 {
        (TURN / self.fastest_spin()).max(dt / MOST)
    }

    /// How fast the rigid body turns that turns fastest \[rad/s\].
    fn fastest_spin(&self) -> f64 {
        let spins = self.shadows.iter().map(|shadow| shadow.w.length());
        spins.fold(0.0, f64::max)
    }

    /// The longest substep in a rigid step of `dt` s in which no face of a sheet turns so far, as a rigid body strikes it, that this comes
    /// past it, see [`THIN`], and nothing that turns comes past what it strikes, see [`SWING`] \[s\]. Wider than `near` m counts as that,
    /// so that nothing is deeper inside; so does what has no width, and remembers on which side a node was.
    fn longest_way(&self, dt: f64, near: f64) -> f64 {
        let mut longest = f64::INFINITY;
        for (m, (_, body)) in self.members.iter().enumerate() {
            let topology = body.contact_topology();
            let is_sheet = !topology.closed && !topology.faces.is_empty();
            let mut own = None;
            for c in &self.candidates[m] {
                let shadow = &self.shadows[c.target.shadow as usize];
                let width = c.target.form.width().map(|w| w + 2.0 * c.target.skin);
                let folds = is_sheet && width.is_some_and(f64::is_finite);
                let spin = shadow.w.length();
                if !folds && spin == 0.0 {
                    continue;
                }
                let own = own.get_or_insert_with(|| body.gross_motion());
                let closing = own.closing(shadow);
                if folds && let Some(width) = width {
                    let way = (THIN * width * topology.spacing).sqrt();
                    longest = longest.min(way / (own.most + closing));
                }
                if spin > 0.0 {
                    let width = width.filter(|w| *w > 0.0).unwrap_or(near).min(near);
                    // No farther from its centre than it is large.
                    let there = (shadow.v - own.mean).length() + spin * c.target.extent;
                    let past = own.most + closing.min(there);
                    longest = longest.min((SWING * width / (spin * past)).sqrt());
                }
            }
        }
        longest.max(dt / MOST)
    }

    /// The speeds of the fastest nodes of the members \[m/s\].
    fn speeds(&self) -> Vec<f64> {
        let members = self.members.iter();
        members.map(|(_, body)| body.solver.top_speed()).collect()
    }

    /// By how much any of them has become faster than twice what it was, in spacings of its nodes \[1/s\].
    fn rush(&self, before: &[f64]) -> f64 {
        let now = self.members.iter().zip(before);
        let faster = now.map(|((_, body), before)| {
            let spacing = body.contact_topology().spacing;
            // Of nodes that nothing joins no shape changes.
            if spacing > 0.0 {
                (body.solver.top_speed() - 2.0 * before) / spacing
            } else {
                0.0
            }
        });
        faster.fold(0.0, f64::max)
    }

    /// How fast a member of tets and what is in its reach may close \[m/s\]; with nothing there, how fast its own nodes do. 0 for
    /// what has no tets.
    fn closing(&self, member: usize) -> f64 {
        let body = &self.members[member].1;
        if body.solid().is_none() {
            return 0.0;
        }
        let own = body.gross_motion();
        let rigid = self.candidates[member].iter();
        let rigid = rigid.map(|c| own.closing(&self.shadows[c.target.shadow as usize]));
        let soft = self.encounters.iter().filter_map(|e| {
            let [a, b] = e.members.map(|m| m as usize);
            let pair = [(a, b), (b, a)].into_iter().find(|pair| pair.0 == member);
            let other = self.members[pair?.1].1.gross_motion();
            Some((other.mean - own.mean).length() + other.most)
        });
        own.most + rigid.chain(soft).fold(0.0, f64::max)
    }

    /// How many springs take as long as a substep of it.
    fn springs(&self) -> usize {
        let of = |body: &Deformable| {
            body.spring_count() + TET * body.tet_count() + threads::NODE * body.node_count()
        };
        self.members.iter().map(|(_, body)| of(body)).sum()
    }
}

/// How many substeps of `dt` s a group needs, in a `frame` of the world, and after what time that is to be asked again \[s\].
fn group_substeps(group: &mut Group, report: &mut StepReport, dt: f64, frame: f64) -> (usize, f64) {
    let (mut most, mut stale) = (meet::substeps(group, dt).max(1), f64::INFINITY);
    for m in 0..group.members.len() {
        let closing = group.closing(m);
        let (handle, body) = &mut group.members[m];
        let (n, unstable, stale_after) = body.review(dt, frame, closing);
        (most, stale) = (most.max(n), stale.min(stale_after));
        if unstable {
            note(&mut report.unstable, *handle);
        }
    }
    (most, stale)
}

/// Reports the frozen bodies of a group and puts the others back to the start of the rigid step: what they got from a
/// body that was no longer finite is worthless.
fn freeze(group: &mut Group, report: &mut StepReport) {
    for (handle, body) in &mut group.members {
        if body.frozen {
            note(&mut report.frozen, *handle);
        } else {
            body.go_back();
        }
        body.slots.fill(u32::MAX);
    }
    group.forget_contacts();
    for (touched, shadow) in group.touched.iter().zip(&mut group.shadows[1..]) {
        *shadow = touched.start;
    }
    for attachment in &mut group.attachments {
        attachment.go_back();
    }
}
