//! Landings: rigid bodies that come down on rigid ground, or on each other, through deformables.
//!
//! What lies squeezed on the ground bears the blow of what lands on it, and the rigid contact behind it has nothing to do. Given that
//! blow as a force over the step, or a part of it, the body would come to the ground in Rapier's step all the same, be stopped there
//! once more, and thrown back by the rest. So it gets all of it at the start of the step, before it is there, and is put where its
//! shadow has landed, with all that hangs on it by joints.

use super::group::{BodyKey, Waiting};
use super::substep::Group;
use crate::coupling::handover;
use crate::coupling::observe::Answer;
use crate::math::{DVec3, Disjoint};
use rapier3d::dynamics::RigidBodySet;
use std::collections::BTreeMap;

/// By which share of what they were given bodies may be faster than their shadows, or slower, and have landed as those have:
/// Rapier's velocities are ahead by half an iteration of gravity.
const LANDED: f64 = 0.1;

/// Bodies that hang together by joints, at the end of a step.
#[derive(Clone, Copy, Default)]
struct Arrival {
    /// The sum of the normals of contacts to which any of them came, out of what is there.
    out: DVec3,
    /// What contacts gave them \[N·s\].
    borne: DVec3,
    /// What deformables gave them \[N·s\].
    given: DVec3,
    /// Whether Rapier answers impulses on all of them.
    answers: bool,
}

impl Arrival {
    /// Whether it was deformables that stopped them, and did not press them on.
    fn lands(&self) -> bool {
        self.answers && self.given.dot(self.out) > 0.0 && self.given.dot(self.borne) >= 0.0
    }
}

impl Group {
    /// Lets go of bodies that could have pressed on others and did not come to them: they are as free as any. What has come
    /// nearer by more than `far` m in the step, of `dt` s, lands, with all that hangs on it by joints, if deformables stopped it.
    pub fn release(&mut self, far: f64, dt: f64) {
        let mut held = vec![false; self.shadows.len()];
        let mut sets = Disjoint::new(self.shadows.len());
        for [a, b] in self.rows.joints.iter().map(|j| j.joint.shadows) {
            held[a as usize] = true;
            held[b as usize] = true;
            if self.moves(a) && self.moves(b) {
                sets.join(a, b);
            }
        }
        let mut arrivals = vec![Arrival::default(); self.shadows.len()];
        for row in &self.rows.rigid {
            let came = row.arrives(&self.shadows, far, dt);
            for (shadow, sign) in row.shadows.into_iter().zip([-1.0, 1.0]) {
                held[shadow as usize] |= row.pressed > 0.0 || came;
                let arrival = &mut arrivals[sets.of(shadow) as usize];
                arrival.borne += row.normal * (sign * row.pressed);
                if came {
                    arrival.out += row.normal * sign;
                }
            }
        }
        for (touched, held) in self.touched.iter_mut().zip(&held[1..]) {
            if touched.answer == Answer::Constrained && !held {
                touched.answer = Answer::Free;
            }
        }
        self.note_landings(&mut sets, &mut arrivals);
    }

    fn note_landings(&mut self, sets: &mut Disjoint, arrivals: &mut [Arrival]) {
        arrivals.iter_mut().for_each(|a| a.answers = true);
        for (i, touched) in (1..).zip(&self.touched) {
            let arrival = &mut arrivals[sets.of(i) as usize];
            arrival.given += self.shadows[i as usize].given().0;
            arrival.answers &= touched.answer == Answer::Constrained;
        }
        for i in 1..self.shadows.len() as u32 {
            let set = sets.of(i) as usize;
            let key = self.touched[set - 1].body.into_raw_parts();
            self.touched[i as usize - 1].lands = arrivals[set].lands().then_some(key);
        }
    }

    /// Whether a shadow is that of a body that answers.
    fn moves(&self, shadow: u32) -> bool {
        let touched = (shadow as usize).checked_sub(1).map(|i| &self.touched[i]);
        touched.is_some_and(|t| t.answer != Answer::None)
    }
}

/// Puts bodies where their shadows have landed, all that hang together or none, if they are as fast as these.
pub(super) fn land(bodies: &mut RigidBodySet, waiting: &mut [Waiting]) {
    let mut sets: BTreeMap<BodyKey, (f64, f64)> = BTreeMap::new();
    for w in &*waiting {
        if let (Some(set), Some(body)) = (w.touched.lands, bodies.get(w.touched.body)) {
            let (off, given) = handover::off_shadow(body, &w.pending, &w.end);
            let sums = sets.entry(set).or_default();
            *sums = (sums.0 + off, sums.1 + given);
        }
    }
    for w in waiting {
        let Some(&(off, given)) = w.touched.lands.and_then(|set| sets.get(&set)) else {
            continue;
        };
        w.put = off <= LANDED * LANDED * given;
        if w.put
            && let Some(body) = bodies.get_mut(w.touched.body)
        {
            handover::put_at(body, &w.end);
        }
    }
}
