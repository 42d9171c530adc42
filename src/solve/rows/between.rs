//! Contacts and joints of shadows alone.

use super::JointRow;
use super::rigid::{Answers, RigidRow, start_rigid};
use super::settled::Settled;
use crate::solve::shadow::Shadow;

/// Contacts and joints of shadows alone, for a rehearsal of a rigid step.
pub struct BetweenShadows {
    contacts: Vec<RigidRow>,
    joints: Vec<JointRow>,
    /// How many of the joints are not soft: the first of them.
    stiff: usize,
    answers: Answers,
}

impl BetweenShadows {
    pub(super) fn of(contacts: &[RigidRow], joints: &[JointRow], answers: &Answers) -> Self {
        let mut joints = joints.to_vec();
        joints.sort_by_key(JointRow::is_soft);
        Self {
            contacts: contacts.to_vec(),
            stiff: joints.partition_point(|joint| !joint.is_soft()),
            joints,
            answers: answers.clone(),
        }
    }

    /// Back to the start of the rigid step, where no row has given anything yet.
    pub fn restart(&mut self) {
        for row in &mut self.contacts {
            (row.normal_impulse, row.friction_impulse) = Default::default();
            row.gap = row.gap_at_start;
        }
        self.restart_joints();
    }

    /// Joints have given nothing yet.
    pub fn restart_joints(&mut self) {
        for row in &mut self.joints {
            row.restart();
        }
    }

    /// Solves a substep of h s in at most `passes` passes, until a pass changes no impulse by more than a share of
    /// `tolerance`.
    pub fn solve(&mut self, shadows: &mut [Shadow], limits: Limits) {
        let (h, ..) = limits;
        for row in &mut self.contacts {
            row.approach(shadows, h);
        }
        start_rigid(&mut self.contacts, shadows, &mut self.answers);
        solve_in_passes(&mut self.contacts, &mut self.joints, shadows, limits);
        for row in &mut self.contacts {
            row.end(shadows, h);
        }
        self.joints.iter_mut().for_each(|joint| joint.end(h));
    }

    /// The same of those joints alone that pass on an impulse at once: soft ones take their time.
    pub fn solve_joints(&mut self, shadows: &mut [Shadow], limits: Limits) {
        solve_in_passes(&mut [], &mut self.joints[..self.stiff], shadows, limits);
    }
}

/// Length of a substep \[s\], most passes, and the share by which a pass changes impulses that are settled.
type Limits = (f64, usize, f64);

/// Solves these rows in passes, one after the other.
fn solve_in_passes(
    contacts: &mut [RigidRow],
    joints: &mut [JointRow],
    shadows: &mut [Shadow],
    (h, passes, tolerance): Limits,
) {
    for row in &mut *joints {
        row.start(shadows, h);
    }
    let settled = Settled {
        tolerance,
        ..Settled::default()
    };
    for _ in 0..passes {
        let mut changed = false;
        for row in &mut *contacts {
            changed |= row.solve(shadows, settled);
        }
        for row in &mut *joints {
            changed |= row.solve(shadows, tolerance);
        }
        if !changed {
            break;
        }
    }
}
