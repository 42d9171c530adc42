//! Which deformables may meet in a rigid step, and their encounters in its substeps.
//!
//! Boxes around the bodies, grown by how far they can go, stand in a tree that is refitted from step to step, so that a
//! thousand bodies cost their neighbours and not their square.

use super::group::BodyKey;
use super::observer::Partner;
use super::reach::{Search, grown, travel};
use super::substep::{Group, Settings};
use super::{Deformable, DeformableHandle, DeformableWorld};
use crate::contact::encounter::Encounter;
use crate::contact::encounter::manners::{Manners, admit};
use crate::contact::encounter::outline::Outline;
use crate::contact::encounter::posed::Posed;
use crate::contact::encounter::rows::Bodies;
use crate::contact::encounter::search::Searched;
use crate::contact::site::Reach;
use crate::solve::rows::Rows;
use rapier3d::geometry::Aabb;
use rapier3d::parry::partitioning::{Bvh, BvhWorkspace};
use std::collections::BTreeMap;

/// Two of the deformables in reach of each other, by their places in the list, in ascending order.
pub(super) type Meeting = [usize; 2];

/// The share of the shortest edge that two bodies may close by in a substep \[1\]: a node that flew over whole faces in
/// one would be stopped by the wrong one.
const STRIDE: f64 = 0.5;

/// The most substeps that encounters ask for in a stretch. A body that explodes is soon faster than anything, and is to
/// be frozen, not to be followed.
const MOST: f64 = 256.0;

/// The boxes of all bodies that took part in the last step, by slot.
#[derive(Clone, Debug, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub(super) struct Meetings {
    tree: Bvh,
    slots: Vec<u32>,
}

/// A body's box before it is grown, and how fast it may become.
struct Swept {
    slot: u32,
    bounds: Aabb,
    speed: f64,
}

impl Meetings {
    /// Drops the boxes of bodies that are not among `swept`.
    fn keep(&mut self, swept: &[Swept]) {
        for &slot in &self.slots {
            if swept.binary_search_by_key(&slot, |s| s.slot).is_err() {
                self.tree.remove(slot);
            }
        }
        self.slots.clear();
        self.slots.extend(swept.iter().map(|s| s.slot));
    }

    /// Pairs whose boxes, grown by `reach`, overlap.
    fn overlaps(&mut self, swept: &[Swept], reach: impl Fn(&Swept) -> f64) -> Vec<Meeting> {
        let boxes = swept.iter().map(|s| grown(&s.bounds, reach(s)));
        let boxes: Vec<Aabb> = boxes.collect();
        for (s, grown) in swept.iter().zip(&boxes) {
            self.tree.insert_or_update_partially(*grown, s.slot, 0.0);
        }
        let mut workspace = BvhWorkspace::default();
        self.tree.refit(&mut workspace);
        self.tree.optimize_incremental(&mut workspace);
        let mut pairs = Vec::new();
        for (i, grown) in boxes.iter().enumerate() {
            let hits = self.tree.intersect_aabb(grown);
            let hits = hits.filter_map(|slot| swept.binary_search_by_key(&slot, |s| s.slot).ok());
            pairs.extend(hits.filter(|&j| j > i).map(|j| [i, j]));
        }
        pairs.sort_unstable();
        pairs
    }
}

impl DeformableWorld {
    /// The pairs of bodies that may touch in the coming step, and how fast each body may become by that \[m/s\].
    pub(super) fn find_meetings(
        &mut self,
        handles: &[DeformableHandle],
        search: &Search,
    ) -> (Vec<Meeting>, Vec<f64>) {
        let mut meetings = std::mem::take(&mut self.meetings);
        let found = self.search_meetings(&mut meetings, handles, search);
        self.meetings = meetings;
        found
    }

    fn search_meetings(
        &self,
        meetings: &mut Meetings,
        handles: &[DeformableHandle],
        search: &Search,
    ) -> (Vec<Meeting>, Vec<f64>) {
        let bodies: Vec<&Deformable> = handles.iter().filter_map(|h| self.get(*h)).collect();
        let mut swept: Vec<Swept> = handles
            .iter()
            .zip(&bodies)
            .map(|(handle, body)| swept(*handle, body, search))
            .collect();
        let speeds = |swept: &[Swept]| swept.iter().map(|s| s.speed).collect();
        if bodies.len() < 2 || bodies.len() != handles.len() {
            return (Vec::new(), speeds(&swept));
        }
        meetings.keep(&swept);
        let unit = search.parts.length_unit();
        loop {
            let mut pairs = meetings.overlaps(&swept, |s| travel(s.speed, search.dt, search.parts));
            pairs.retain(|&[i, j]| admit(bodies[i].surface(), bodies[j].surface()));
            // Who is hit may become as fast as what hits it.
            let mut faster = false;
            for &[i, j] in &pairs {
                let most = swept[i].speed.max(swept[j].speed);
                for k in [i, j] {
                    if (most - swept[k].speed) * search.dt > 0.02 * unit {
                        swept[k].speed = most;
                        swept[k].be_struck(search);
                        faster = true;
                    }
                }
            }
            if !faster {
                pairs.retain(|&[i, j]| self.may_meet(handles[i], handles[j]));
                return (pairs, speeds(&swept));
            }
        }
    }

    /// Puts encounters into groups: those of the last step, and new ones.
    pub(super) fn resume_encounters(
        &mut self,
        groups: &mut BTreeMap<usize, Group>,
        group_of: &[usize],
        reaches: &[DeformableHandle],
        meetings: &[Meeting],
    ) {
        let mut kept = std::mem::take(&mut self.encounters);
        for pair in meetings {
            let Some(group) = groups.get_mut(&group_of[pair[0]]) else {
                continue;
            };
            let keys = pair.map(|i| reaches[i].key());
            let places = keys.map(|k| group.members.binary_search_by_key(&k, |m| m.0.key()));
            let [Ok(a), Ok(b)] = places else {
                continue;
            };
            for i in [a, b] {
                let body = &mut group.members[i].1;
                if body.outline.is_none() {
                    body.outline = Some(Box::new(Outline::new(body.contact_blueprint())));
                    body.tear_outline();
                }
            }
            let bodies = [a, b].map(|i| &group.members[i].1);
            let (Some(first), Some(second)) = (&bodies[0].outline, &bodies[1].outline) else {
                continue;
            };
            let manners = Manners::new(bodies.map(|b| b.surface()), [first, second]);
            let moved = (
                bodies.map(|b| b.edits),
                bodies.iter().map(|b| b.shifted).sum(),
            );
            let [of_a, of_b] = [a, b].map(|i| Partner::Deformable(group.members[i].0));
            let pair = group.add_pair(a, of_b);
            group.add_pair(b, of_a);
            let members = [a as u32, b as u32];
            let mut encounter = match kept.remove(&(keys[0], keys[1])) {
                Some(mut e) => {
                    e.resume(members, pair, manners, moved);
                    e
                }
                None => Encounter::new(members, pair, manners),
            };
            encounter.attached = group.attached_nodes(members);
            group.encounters.push(encounter);
        }
        kept.retain(|&(a, _), _| self.is_asleep(DeformableHandle::of_key(a)));
        self.encounters = kept;
    }

    /// Takes the encounters out of a group and puts them by for the next step.
    pub(super) fn pause_encounters(&mut self, group: &mut Group) {
        for mut encounter in group.encounters.drain(..) {
            let bodies = encounter.members.map(|m| &group.members[m as usize]);
            encounter.pause(bodies.map(|b| b.1.edits));
            let keys: [BodyKey; 2] = bodies.map(|b| b.0.key());
            self.encounters.insert((keys[0], keys[1]), encounter);
        }
    }
}

impl DeformableWorld {
    /// Where a body may be in the coming step.
    pub(super) fn swept_box(
        &self,
        handle: DeformableHandle,
        body: &Deformable,
        search: &Search,
    ) -> Aabb {
        let swept = swept(handle, body, search);
        let by = travel(swept.speed, search.dt, search.parts);
        grown(&swept.bounds, by)
    }
}

fn swept(handle: DeformableHandle, body: &Deformable, search: &Search) -> Swept {
    let mut speed = body.coming_speed(search.lead);
    if body.sleep.beside_rigid {
        speed = speed.max(search.fast.slow());
    }
    let spacing = body.outline.as_ref().map_or(0.0, |o| o.spacing);
    let spacing = if spacing.is_finite() { spacing } else { 0.0 };
    let mut swept = Swept {
        slot: handle.key().0,
        bounds: body.box_within(spacing.max(2.0 * body.half_thickness())),
        speed,
    };
    swept.be_struck(search);
    swept
}

impl Swept {
    /// It may become as fast as the rigid bodies that it meets.
    fn be_struck(&mut self, search: &Search) {
        let fast = search.fast_speed(&self.bounds, self.speed);
        self.speed = self.speed.max(fast);
    }
}

/// How many substeps of a stretch of `dt` s the encounters of a group want.
pub(super) fn substeps(group: &Group, dt: f64) -> usize {
    let wanted = group.encounters.iter().map(|e| {
        let [a, b] = e.members.map(|m| &group.members[m as usize].1);
        let spacing = |b: &Deformable| b.outline.as_ref().map_or(f64::INFINITY, |o| o.spacing);
        let stride = STRIDE * spacing(a).min(spacing(b));
        // By the speeds before rows, which are smooth: every change of the substep costs leapfrog some energy.
        let speed = |b: &Deformable| f64::from(b.solver.speed_squared).sqrt();
        let n = (dt * (speed(a) + speed(b)) / stride).ceil();
        n.min(MOST) as usize
    });
    wanted.max().unwrap_or(1)
}

/// The rows of an encounter at the positions the substep starts from. Says by how much the two may close in it at most
/// \[m\].
pub(super) fn find_rows(
    encounter: &mut Encounter,
    members: &mut [(DeformableHandle, Box<Deformable>)],
    rows: &mut Rows,
    h: f64,
    s: &Settings,
) -> f64 {
    let places = encounter.members.map(|m| m as usize);
    let Ok([(_, a), (_, b)]) = members.get_disjoint_mut(places) else {
        return 0.0;
    };
    let (moved, closing) = (a.closed(b), h * a.closing(b));
    // Taken out for as long as the rest of the bodies is looked at.
    let [Some(mut of_a), Some(mut of_b)] = [&mut *a, &mut *b].map(|body| body.outline.take())
    else {
        return 0.0;
    };
    let slack = h * s.length_unit;
    let reach = Reach {
        h,
        touching: s.touching,
        slack,
        farthest: s.touching + slack + 2.0 * closing,
    };
    let (side_a, slots_a) = a.side(encounter.members[0]);
    let (side_b, slots_b) = b.side(encounter.members[1]);
    let searched = [(side_a.state, &mut *of_a), (side_b.state, &mut *of_b)];
    encounter.refresh(
        searched.map(|(state, outline)| Searched { state, outline }),
        moved,
        (closing, reach.farthest),
    );
    let origin = side_a.state.origin;
    let mut bodies = Bodies {
        posed: [
            Posed::new(&of_a, side_a.state, origin),
            Posed::new(&of_b, side_b.state, origin),
        ],
        carriers: [side_a.carrier, side_b.carrier],
        slots: [slots_a, slots_b],
    };
    encounter.add_rows(&mut bodies, rows, reach);
    (a.outline, b.outline) = (Some(of_a), Some(of_b));
    closing
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Material, NodeId};
    use crate::math::Vector;
    use crate::shape;
    use crate::world::{AttachTo, Attachment, DeformableBuilder, RapierParts};
    use rapier3d::dynamics::RigidBodyBuilder;
    use rapier3d::geometry::ColliderBuilder;
    use rapier3d::pipeline::PhysicsWorld;

    /// A row of blocks on a fixed floor, 0.3 m apart, after a first step; and a ball at a place and a velocity.
    fn row(ball: Vector, linvel: Vector) -> (PhysicsWorld, DeformableWorld) {
        let mut world = PhysicsWorld::default();
        let floor = RigidBodyBuilder::fixed().translation(Vector::Y * -1.0);
        world.insert(floor, ColliderBuilder::cuboid(100.0, 1.0, 100.0));
        let mut deformables = DeformableWorld::default();
        for i in 0..6 {
            let net = shape::lattice(Vector::splat(0.2), 0.1);
            let block = DeformableBuilder::new(net).material(Material::rubber());
            let at = Vector::new(0.5 * i as f32, 0.1, 0.0);
            deformables.insert(block.translation(at)).unwrap();
        }
        let body = RigidBodyBuilder::dynamic()
            .translation(ball)
            .gravity_scale(0.0)
            .linvel(linvel);
        world.insert(body, ColliderBuilder::ball(0.05));
        deformables.step(&mut world);
        (world, deformables)
    }

    fn meetings(ball: Vector, linvel: Vector) -> (Vec<Meeting>, Vec<f64>) {
        let (mut world, mut deformables) = row(ball, linvel);
        let parts = RapierParts::from(&mut world);
        let handles: Vec<_> = deformables.iter().map(|(handle, _)| handle).collect();
        let search = Search::new(
            &mut deformables.known,
            &deformables.attachments,
            &parts,
            1.0 / 60.0,
        );
        deformables.find_meetings(&handles, &search)
    }

    /// Symptom: everything met everything within metres, and took it into its group, while one body anywhere was fast.
    #[test]
    fn what_is_fast_far_off_makes_no_meetings() {
        for linvel in [Vector::Y * 400.0, Vector::X * -400.0] {
            let (pairs, speeds) = meetings(Vector::new(1000.0, 1000.0, 0.0), linvel);
            assert!(pairs.is_empty(), "{pairs:?}");
            assert!(speeds.iter().all(|v| *v < 1.0), "{speeds:?}");
        }
    }

    /// One that comes makes the first as fast as itself, and that one all the others, though none moves yet.
    #[test]
    fn what_is_fast_and_comes_makes_meetings_of_all_it_may_drive_together() {
        // 6.7 m in a step: it will be 5.2 m from the first when the step ends that is looked at.
        let (pairs, speeds) = meetings(Vector::new(-12.0, 0.1, 0.0), Vector::X * 400.0);
        let all: Vec<Meeting> = (0..6)
            .flat_map(|i| (i + 1..6).map(move |j| [i, j]))
            .collect();
        assert_eq!(pairs, all);
        assert!(speeds.iter().all(|v| *v > 399.0), "{speeds:?}");
    }

    /// A body without colliders that holds a block on a long arm is as fast for it as one that comes from as far.
    #[test]
    fn what_a_fast_body_holds_may_be_as_fast() {
        let far = Vector::new(0.0, 0.0, 500.0);
        let (mut world, mut deformables) = row(far, Vector::ZERO);
        let body = RigidBodyBuilder::kinematic_velocity_based()
            .translation(Vector::Y * 50.0)
            .linvel(Vector::X * 100.0);
        let body = world.insert_body(body);
        let handles: Vec<_> = deformables.iter().map(|(handle, _)| handle).collect();
        let pin = Attachment::pin([NodeId(0)]);
        deformables
            .attach(handles[0], pin, AttachTo::Body(body), &world.bodies)
            .unwrap();
        let parts = RapierParts::from(&mut world);
        let search = Search::new(
            &mut deformables.known,
            &deformables.attachments,
            &parts,
            1.0 / 60.0,
        );
        let (pairs, speeds) = deformables.find_meetings(&handles, &search);
        assert!(speeds[0] > 99.0, "{speeds:?}");
        assert!(pairs.contains(&[0, 1]), "{pairs:?}");
    }
}
