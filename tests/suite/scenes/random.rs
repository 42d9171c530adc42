//! Random scenes of two to eight bodies of all kinds, and stacks of thin ones. A scene is a function of its seed; one that
//! fails is printed, and runs alone with `CRUMPLE_SEED=n cargo test --release --features cli random::one_seed -- --ignored
//! --nocapture`, a stack with `random::one_stack`.

mod build;

use build::{DT, Scenery, scene, stack};
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario::survey::{all_finite, depth_in, mechanical_energy};

/// How scenes are made of seeds, and how many steps they go on.
type Kind = (fn(u64) -> Scenery, usize);

/// Bodies of all kinds, for 10 s.
const BODIES: Kind = (scene, 600);
/// Thin ones on each other, under a rigid one, for 2.5 s.
const STACKS: Kind = (stack, 150);

/// A deformable all of whose nodes go on slower than this, step by step for a whole second, is at rest [m/s]. Positions
/// tell: within a substep some schemes leave a node in contact with the velocity that the next impulse will take.
const REST: f64 = 0.01;
/// How long that is, in steps.
const SECOND: usize = 60;

/// Adds up what the mover does to deformables, and sees on what they act.
struct Watch {
    mover: ColliderHandle,
    held: Vec<AttachmentHandle>,
    velocity: DVec3,
    /// By the mover [J].
    work: f64,
    /// What deformables act on in a step.
    pressed: Vec<ColliderHandle>,
    pulled: Vec<AttachmentHandle>,
}

impl Watch {
    fn over(s: &Scenery) -> Self {
        Self {
            mover: s.mover.1,
            held: s.held_by_mover.clone(),
            velocity: DVec3::ZERO,
            work: 0.0,
            pressed: Vec::new(),
            pulled: Vec::new(),
        }
    }

    /// The bodies that deformables have acted on in the last step, those that these touch or hang on, and so forth.
    fn concerned(&self, s: &Scenery) -> Vec<RigidBodyHandle> {
        let world = &s.world;
        let parent = |c: ColliderHandle| world.colliders.get(c)?.parent();
        let moves = |b: &RigidBodyHandle| world.bodies[*b].is_dynamic();
        let pulled = self
            .pulled
            .iter()
            .filter_map(|a| s.deformables.attachment(*a)?.body());
        let mut found: Vec<RigidBodyHandle> = Vec::new();
        let mut next: Vec<RigidBodyHandle> = self
            .pressed
            .iter()
            .filter_map(|c| parent(*c))
            .chain(pulled)
            .collect();
        while let Some(body) = next.pop() {
            if !moves(&body) || found.contains(&body) {
                continue;
            }
            found.push(body);
            for &collider in world.bodies[body].colliders() {
                let pairs = world.narrow_phase.contact_pairs_with(collider);
                let pairs = pairs.filter(|p| p.has_any_active_contact());
                next.extend(
                    pairs
                        .flat_map(|p| [p.collider1, p.collider2])
                        .filter_map(parent),
                );
            }
            let joints = world.impulse_joints.attached_joints(body);
            next.extend(joints.flat_map(|(one, other, ..)| [one, other]));
        }
        found
    }
}

impl Observer for Watch {
    fn substep(&mut self, s: &Substep) {
        let mut impulse = DVec3::ZERO;
        for c in s.contacts.iter().filter(|c| c.impulse != DVec3::ZERO) {
            if let Partner::Collider(collider) = c.partner {
                self.pressed.push(collider);
                if collider == self.mover {
                    impulse += c.impulse;
                }
            }
        }
        for a in s.attachments {
            self.pulled.push(a.attachment);
            if self.held.contains(&a.attachment) {
                impulse += a.impulse;
            }
        }
        self.work += impulse.dot(self.velocity);
    }
}

/// Kinetic energy and that of height over the lowest ground, of everything [J]: what energy is measured against.
fn at_stake(s: &Scenery) -> f64 {
    let soft = s.deformables.iter().map(|(_, b)| {
        let height = b.center_of_mass().y + 0.03;
        b.energies().kinetic + b.mass() * 9.81 * height
    });
    let rigid = s.world.bodies.iter().filter(|(_, b)| b.is_dynamic());
    let rigid = rigid.map(|(_, b)| {
        let height = f64::from(b.center_of_mass().y) + 0.03;
        f64::from(b.kinetic_energy()) + f64::from(b.mass()) * 9.81 * height
    });
    soft.sum::<f64>() + rigid.sum::<f64>()
}

/// Energy of a rigid body [J].
fn rigid_energy(body: &RigidBody) -> f64 {
    f64::from(body.kinetic_energy())
        + f64::from(body.mass()) * 9.81 * f64::from(body.center_of_mass().y)
}

/// How deep the node is below the ground, straight down [m].
fn below(ground: &Collider, at: Vector) -> f64 {
    let above = Vector::new(at.x, 5.0, at.z);
    let ray = Ray::new(above, -Vector::Y);
    let hit = ground.shape().cast_ray(ground.position(), &ray, 10.0, true);
    hit.map_or(0.0, |t| f64::from((5.0 - t) - at.y).max(0.0))
}

/// Deepest node of a deformable in any solid and below the ground, less the half thickness that it keeps [m].
fn deepest(s: &Scenery, body: &Deformable) -> (f64, String) {
    let half = 0.5 * f64::from(body.surface().thickness);
    let mut worst = (0.0, String::new());
    for (node, at) in body.positions().enumerate() {
        for (handle, collider) in s.world.colliders.iter() {
            let mut depth = depth_in(collider.shape(), collider.position(), at);
            if handle == s.ground {
                depth = depth.max(below(collider, at));
            }
            if depth - half > worst.0 {
                let kind = collider.shape().shape_type();
                worst = (depth - half, format!("node {node} in {kind:?}"));
            }
        }
    }
    worst
}

/// How fast the mover goes [m/s]: to and fro by .1 m with a period of 3 s, and at rest after 6 s.
fn mover_speed(time: f64) -> f64 {
    let omega = std::f64::consts::TAU / 3.0;
    if time < 6.0 {
        0.1 * omega * (omega * time).sin()
    } else {
        0.0
    }
}

/// Largest rise of a sum over its least value so far, and when.
struct Rise {
    least: f64,
    most: f64,
    at: f64,
}

impl Rise {
    fn feel(&mut self, value: f64, time: f64) {
        self.least = self.least.min(value);
        if value - self.least > self.most {
            (self.most, self.at) = (value - self.least, time);
        }
    }
}

/// Runs a seed; what is wrong with it, if anything is.
fn faults((scene, steps): Kind, seed: u64) -> Option<String> {
    let mut s = scene(seed);
    let mut watch = Watch::over(&s);
    let scale = at_stake(&s);
    // What Rapier's joints and contacts do to bodies in a step in which no deformable acts on them, nor on anything that
    // they touch or hang on, is not ours: their energy in such steps is left out, gain and loss alike.
    let mut apart = 0.0;
    let mut rise = Rise {
        least: f64::INFINITY,
        most: 0.0,
        at: 0.0,
    };
    let mut faults = Vec::new();
    let count = s.deformables.iter().count();
    let (mut quiet, mut deep) = (vec![0; count], vec![None; count]);
    let mut places: Vec<Vec<Vector>> = vec![Vec::new(); count];
    for step in 0..steps {
        let time = step as f64 * DT;
        let speed = mover_speed(time);
        watch.velocity = DVec3::X * speed;
        (watch.pressed, watch.pulled) = Default::default();
        s.world.bodies[s.mover.0].set_linvel(Vector::X * speed as f32, true);
        let moving = s.world.bodies.iter().filter(|(_, b)| b.is_dynamic());
        let before: Vec<_> = moving.map(|(h, b)| (h, rigid_energy(b))).collect();
        s.deformables.step_with(&mut s.world, &(), &(), &mut watch);
        if !all_finite(&s.world, &s.deformables) {
            faults.push(format!("not finite or frozen at {time:.3} s"));
            break;
        }
        let concerned = watch.concerned(&s);
        for (body, energy) in before.iter().filter(|(h, _)| !concerned.contains(h)) {
            apart += rigid_energy(&s.world.bodies[*body]) - energy;
        }
        let energy = mechanical_energy(&s.world, &s.deformables) - watch.work - apart;
        rise.feel(energy, time);
        for (i, (_, body)) in s.deformables.iter().enumerate() {
            let far = REST as f32 * DT as f32;
            let moves = places[i].len() != body.node_count()
                || body
                    .positions()
                    .zip(&places[i])
                    .any(|(x, y)| x.distance(*y) > far);
            quiet[i] = if moves { 0 } else { quiet[i] + 1 };
            places[i] = body.positions().collect();
            // After each second at rest, and at the end.
            if quiet[i] >= SECOND && (quiet[i] % SECOND == 0 || step + 1 == steps) {
                let (depth, whose) = deepest(&s, body);
                if depth > 1.0e-3 {
                    let depth = 1.0e3 * depth;
                    deep[i] = Some(format!(
                        "deformable {i} at rest at {time:.1} s and {depth:.1} mm deep: {whose}"
                    ));
                }
            }
        }
    }
    if rise.most > 0.01 * scale {
        let share = 100.0 * rise.most / scale;
        let (most, at) = (rise.most, rise.at);
        faults.push(format!(
            "energy rises by {most:.3} J, {share:.1} %, until {at:.2} s"
        ));
    }
    for (i, (_, body)) in s.deformables.iter().enumerate() {
        // What moves may be deeper for a moment, but not on the other side.
        let (depth, whose) = deepest(&s, body);
        if deep[i].is_none() && depth > 0.05 {
            let depth = 1.0e3 * depth;
            deep[i] = Some(format!("deformable {i} {depth:.1} mm deep: {whose}"));
        }
    }
    faults.extend(deep.into_iter().flatten());
    if std::env::var("CRUMPLE_SEED").is_ok() {
        let share = 100.0 * rise.most / scale;
        println!(
            "{}at rest for {quiet:?} steps, rise {share:.3} % of {scale:.1} J",
            s.about
        );
    }
    let about = &s.about;
    (!faults.is_empty()).then(|| format!("seed {seed}: {}\n{about}", faults.join("; ")))
}

fn all_of(kind: Kind, seeds: impl IntoIterator<Item = u64>) {
    let (mut count, mut failed) = (0, Vec::new());
    for seed in seeds {
        count += 1;
        failed.extend(faults(kind, seed));
    }
    let n = failed.len();
    assert!(
        failed.is_empty(),
        "{n} of {count} seeds fail:\n{}",
        failed.join("\n")
    );
}

#[test]
fn seeds_0_to_9() {
    all_of(BODIES, 0..10);
}

#[test]
fn seeds_10_to_19() {
    all_of(BODIES, 10..20);
}

#[test]
fn seeds_20_to_29() {
    all_of(BODIES, 20..30);
}

#[test]
fn seeds_30_to_39() {
    all_of(BODIES, 30..40);
}

#[test]
fn seeds_40_to_49() {
    all_of(BODIES, 40..50);
}

/// Light bodies that hold nodes by long levers, alone and jointed to heavy ones, bodies that strike a mesh with themselves
/// and with what they hold, and a body on a mesh that tears at a node which it holds while it is jointed.
#[test]
fn bodies_that_hold_nodes() {
    all_of(BODIES, [56, 137, 176, 238, 297, 441, 822, 896, 921]);
}

/// Light bodies that strike the ground, which turns them, with nodes at the end of long levers: they were given 1 to 6 % of the energy.
#[test]
fn bodies_that_strike_the_ground_with_long_levers() {
    all_of(BODIES, [1112, 1832, 1866, 2075, 2229]);
}

/// Light nodes in the grip of heavy bodies, and a block that has been crumpled inside out.
#[test]
fn nodes_that_are_squeezed() {
    all_of(BODIES, [563, 707, 763, 773, 879]);
}

/// Blocks by RK4, crushed and pushed out again.
#[test]
fn blocks_by_rk4() {
    all_of(BODIES, [263, 356, 450]);
}

#[test]
#[ignore = "long: many minutes"]
fn a_thousand_seeds() {
    all_of(BODIES, 0..1000);
}

#[test]
fn stacks_0_to_9() {
    all_of(STACKS, 0..10);
}

/// Three of these gained 5 to 50 times what they had: what hardly bore a point was thrown to move it.
#[test]
fn stacks_10_to_19() {
    all_of(STACKS, 10..20);
}

/// They gained 1.1 to 2.6 %: a blow drove what lay on them millimetres in, which was lifted out again.
#[test]
fn stacks_that_are_struck() {
    all_of(STACKS, [66, 174, 257, 269]);
}

#[test]
#[ignore = "long: many minutes"]
fn five_hundred_stacks() {
    all_of(STACKS, 0..500);
}

#[test]
#[ignore = "runs the seed in CRUMPLE_SEED, or 0"]
fn one_seed() {
    all_of(BODIES, [seed_asked_for()]);
}

#[test]
#[ignore = "runs the seed in CRUMPLE_SEED, or 0"]
fn one_stack() {
    all_of(STACKS, [seed_asked_for()]);
}

fn seed_asked_for() -> u64 {
    let seed = std::env::var("CRUMPLE_SEED").unwrap_or("0".into());
    seed.parse().expect("CRUMPLE_SEED is a number")
}
