//! Worlds saved in mid-run go on as if they had not been.

use crate::contact::embed::soft_ball;
use crate::fixtures::{bits, cube, floored};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario::Run;
use crumple::scenario::file::Scenario;
use crumple::world::SnapshotError;

/// Runs a scene for `before` steps, saves and restores it, and compares both for `after` steps.
fn goes_on(name: &str, before: usize, after: usize, renew: bool) {
    let scene = Scenario::embedded(name, &Default::default()).unwrap();
    let mut saved = scene.build().unwrap();
    for _ in 0..before {
        assert!(saved.step(), "{name} is over");
    }
    let bytes = saved.deformables.save(&saved.world).unwrap();
    let mut restored = scene.build().unwrap();
    (restored.deformables, restored.world) = DeformableWorld::load(&bytes).unwrap();
    restored.steps = saved.steps;
    let again = restored.deformables.save(&restored.world).unwrap();
    assert!(again == bytes, "{name}: saved again it is another");
    if renew {
        saved.world.physics_pipeline = PhysicsPipeline::new();
        saved.world.ccd_solver = CCDSolver::new();
    }
    let state = |run: &Run| (run.deformables.state_hash(), bits(&run.world));
    for step in 0..after {
        assert!(saved.step() && restored.step(), "{name} is over");
        assert!(
            state(&saved) == state(&restored),
            "{name}: differs {} steps after it was restored",
            step + 1
        );
        let works = |run: &Run| {
            let all = run.deformables.iter();
            all.map(|(_, b)| format!("{:?}", b.energies()))
                .collect::<Vec<_>>()
        };
        assert_eq!(works(&saved), works(&restored), "{name}");
    }
    let last = [&saved, &restored].map(|run| run.deformables.save(&run.world).unwrap());
    assert!(last[0] == last[1], "{name}: something else differs");
}

/// Springs that yield and break against a fixed wall, solids of tets, a heap of everything, joints, attachments, thin plates,
/// edges of a terrain.
#[test]
fn a_restored_scene_goes_on_bit_for_bit() {
    goes_on("wall", 8, 10, true);
    goes_on("pole", 8, 10, true);
    goes_on("pile", 60, 20, true);
    goes_on("rubber_drop", 25, 20, true);
    goes_on("gripper", 40, 20, true);
    goes_on("thin_plate", 1, 2, true);
    goes_on("tow_rope", 12, 12, true);
    goes_on("motor", 30, 30, true);
    goes_on("terrain", 60, 20, true);
}

/// A skin is finer than the mesh that carries it, and so are the features of what it touches: on so large a ball it needs none,
/// and the mesh would.
#[test]
fn a_skin_goes_on_bit_for_bit() {
    let mut world = PhysicsWorld::default();
    let below = RigidBodyBuilder::fixed().translation(Vector::Y * -5.0);
    let (_, ground) = world.insert(below, ColliderBuilder::ball(5.0));
    let mut set = DeformableWorld::new();
    let skinned = soft_ball().translation(Vector::new(0.05, 0.51, 0.0));
    let body = set.insert(skinned).unwrap();
    for _ in 0..30 {
        set.step(&mut world);
    }
    assert!(set.contact_force(body, ground).unwrap().y > 0.0);
    let bytes = set.save(&world).unwrap();
    let (mut restored, mut other) = DeformableWorld::load(&bytes).unwrap();
    for step in 1..=10 {
        set.step(&mut world);
        restored.step(&mut other);
        let same = set.state_hash() == restored.state_hash();
        assert!(same, "differs {step} steps after it was restored");
    }
    assert!(set.save(&world).unwrap() == restored.save(&other).unwrap());
}

/// What a scene file comes to: the hash of the state, every check and every probe, bit for bit. After so many steps Rapier's
/// pipeline is renewed, and both worlds are saved and restored if that is wanted.
fn outcome(name: &str, kernel: Kernel, renewed: u64, restored: bool) -> String {
    let scene = Scenario::embedded(name, &Default::default()).unwrap();
    let mut run = scene.start().unwrap();
    run.run.deformables.params.kernel = kernel;
    let mut steps = 0;
    while run.step() {
        steps += 1;
        if steps == renewed {
            let worlds = &mut run.run;
            worlds.world.physics_pipeline = PhysicsPipeline::new();
            worlds.world.ccd_solver = CCDSolver::new();
            if restored {
                let bytes = worlds.deformables.save(&worlds.world).unwrap();
                (worlds.deformables, worlds.world) = DeformableWorld::load(&bytes).unwrap();
            }
        }
    }
    assert!(steps > renewed, "{name} has {steps} steps");
    let outcome = run.outcome().unwrap();
    assert!(outcome.passed(), "{name}\n{outcome}");
    let checks = outcome.checks.iter();
    let checks: Vec<_> = checks.map(|c| (&c.name, c.measured.to_bits())).collect();
    let probes: Vec<Vec<u64>> = outcome
        .probes
        .iter()
        .map(|(_, series)| series.values.iter().map(|x| x.to_bits()).collect())
        .collect();
    format!("{} {checks:?} {probes:?}", outcome.state_hash)
}

/// The same file comes to the same, run again, with any kernel, and when it was saved and restored on the way.
#[test]
fn a_scene_file_comes_to_the_same_after_a_restore() {
    for (name, steps) in [
        ("weight", 20),
        ("tow_rope", 8),
        ("sliding_block", 50),
        ("yield_spring", 900),
        ("pulse", 15),
        ("motor", 300),
        ("drop", 30),
    ] {
        let usual = outcome(name, Kernel::default(), steps, false);
        assert!(
            usual == outcome(name, Kernel::default(), steps, false),
            "{name}: again"
        );
        assert!(
            usual == outcome(name, Kernel::default(), steps, true),
            "{name}: restored"
        );
        assert!(
            usual == outcome(name, Kernel::Portable, steps, true),
            "{name}: portable"
        );
    }
}

/// Rapier's workspaces hold nothing between steps: not even the pipeline has to be renewed.
#[test]
fn the_pipeline_need_not_be_renewed() {
    goes_on("pile", 90, 20, false);
    goes_on("drop", 40, 20, false);
}

/// A soft cube on a floor with a box on it, after some steps.
fn resting() -> (DeformableWorld, PhysicsWorld) {
    let (mut world, _) = floored(1.0 / 60.0);
    let above = RigidBodyBuilder::dynamic().translation(Vector::Y * 0.5);
    world.insert(above, ColliderBuilder::cuboid(0.1, 0.1, 0.1));
    let mut deformables = DeformableWorld::default();
    deformables
        .insert(cube(0.3).translation(Vector::Y * 0.15).user_data(7 << 90))
        .unwrap();
    for _ in 0..20 {
        deformables.step(&mut world);
    }
    (deformables, world)
}

#[test]
fn whatever_is_cut_or_changed_is_a_typed_error() {
    let (deformables, world) = resting();
    let whole = deformables.save(&world).unwrap();
    let alone = deformables.save_beside(&world.colliders).unwrap();
    assert!(whole.len() > 10_000 && alone.len() > 10_000);
    let load = |bytes: &[u8]| DeformableWorld::load(bytes).err();
    let beside =
        |bytes: &[u8]| DeformableWorld::load_beside(bytes, &world.bodies, &world.colliders).err();
    for length in (0..whole.len()).step_by(97) {
        let error = load(&whole[..length]).unwrap();
        let cut = matches!(error, SnapshotError::CutShort { found, .. } if found == length as u64);
        assert!(cut, "{length}: {error}");
    }
    for length in (0..alone.len()).step_by(97) {
        let error = beside(&alone[..length]).unwrap();
        assert!(matches!(error, SnapshotError::CutShort { .. }), "{error}");
    }
    for at in (0..whole.len()).step_by(97) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        assert!(load(&bytes).is_some(), "byte {at} is not missed");
    }
    let error = load(&[&whole[..], &[0]].concat()).unwrap();
    assert!(matches!(error, SnapshotError::TooLong { .. }), "{error}");
    assert_eq!(
        load(b"not a snapshot"),
        Some(SnapshotError::NoSnapshot { length: 14 })
    );
    assert_eq!(load(&alone), Some(SnapshotError::WithoutRapier));
    assert_eq!(beside(&whole), Some(SnapshotError::WithRapier));
}

#[test]
fn another_version_or_layout_is_a_typed_error() {
    let (deformables, world) = resting();
    let bytes = deformables.save(&world).unwrap();
    let version = env!("CARGO_PKG_VERSION");
    let place = bytes
        .windows(version.len())
        .position(|w| w == version.as_bytes());
    let place = place.unwrap();
    let mut other = bytes.clone();
    other[place] = b'9';
    match DeformableWorld::load(&other).err() {
        Some(SnapshotError::Version { found, expected }) => {
            assert_eq!((found.as_bytes()[0], expected), (b'9', version));
        }
        error => panic!("{error:?}"),
    }
    let mut other = bytes.clone();
    other[place + version.len()] ^= 1;
    let error = DeformableWorld::load(&other).err().unwrap();
    assert!(matches!(error, SnapshotError::Layout { .. }), "{error}");
}

#[test]
fn between_the_halves_of_a_step_nothing_can_be_saved() {
    let (mut deformables, mut world) = resting();
    deformables.before_step(&mut RapierParts::from(&mut world), &mut ());
    assert_eq!(deformables.save(&world).err(), Some(SnapshotError::MidStep));
    world.step();
    deformables.after_step(&mut RapierParts::from(&mut world));
    assert!(deformables.save(&world).is_ok());
}

/// Tables are made anew, so what one kernel saved goes on with another.
#[test]
fn another_kernel_goes_on_with_the_same_bits() {
    let scene = Scenario::embedded("wall", &Default::default()).unwrap();
    let mut run = scene.build().unwrap();
    run.deformables.params.kernel = Kernel::Avx2;
    for _ in 0..10 {
        run.step();
    }
    let bytes = run.deformables.save(&run.world).unwrap();
    let states = [Kernel::Portable, Kernel::Auto].map(|kernel| {
        let (mut deformables, mut world) = DeformableWorld::load(&bytes).unwrap();
        deformables.params.kernel = kernel;
        for _ in 0..3 {
            deformables.step(&mut world);
        }
        deformables.state_hash()
    });
    assert_eq!(states[0], states[1]);
}

/// Rapier's sets restored by their owner, the deformables beside them.
#[test]
fn deformables_go_on_beside_sets_that_others_keep() {
    let (mut deformables, mut world) = resting();
    let bytes = deformables.save_beside(&world.colliders).unwrap();
    let both = deformables.save(&world).unwrap();
    let (_, mut restored) = DeformableWorld::load(&both).unwrap();
    let mut again =
        DeformableWorld::load_beside(&bytes, &restored.bodies, &restored.colliders).unwrap();
    for _ in 0..30 {
        deformables.step(&mut world);
        again.step(&mut restored);
    }
    assert_eq!(again.state_hash(), deformables.state_hash());
    assert_eq!(again.iter().next().unwrap().1.user_data, 7 << 90);
    assert_eq!(bits(&restored), bits(&world));
    // Without the colliders that were there, contacts are forgotten.
    let (mut empty, _) = floored(1.0 / 60.0);
    empty.bodies = Default::default();
    empty.colliders = Default::default();
    let mut falling =
        DeformableWorld::load_beside(&bytes, &empty.bodies, &empty.colliders).unwrap();
    for _ in 0..60 {
        falling.step(&mut empty);
    }
    let (_, body) = falling.iter().next().unwrap();
    assert!(body.center_of_mass().y < -2.0);
}

/// A body by itself is data too: one that was crushed can be put into another world.
#[test]
fn a_crushed_body_is_kept_as_text() {
    let scene = Scenario::embedded("yield_spring", &Default::default()).unwrap();
    let mut run = scene.build().unwrap();
    while run.step() {}
    let (_, body) = run.deformables.iter().next().unwrap();
    let text = ron::to_string(body).unwrap();
    let again: Deformable = ron::from_str(&text).unwrap();
    assert_eq!(again.state_hash(), body.state_hash());
    assert_eq!(
        again.plastic_strain(SpringId(0)),
        body.plastic_strain(SpringId(0))
    );
    assert!(again.plastic_strain(SpringId(0)).unwrap() > 0.0);
    let fewer = text.replacen("broken:[", "broken:[true,", 1);
    let error = ron::from_str::<Deformable>(&fewer).unwrap_err();
    assert!(error.to_string().contains("springs"), "{error}");
    DeformableWorld::default().insert(again).unwrap();
}
