//! What is squeezed: small rigid bodies between two blocks or between a block and a sheet, and soft blocks by each other. Nothing
//! is pushed by what it does not touch, and nothing gets through.

use super::Random;
use crate::support::weightless;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape::{TetSplit, tet_box};

/// Name, collider, and the sharp points that no block may have in it.
fn shapes() -> [(&'static str, ColliderBuilder, Vec<Vector>); 6] {
    let corners = |half: Vector| super::corners(-half, half);
    let (cube, plate) = (Vector::new(0.08, 0.1, 0.07), Vector::new(0.15, 0.01, 0.1));
    let peaks = [
        [1.0, 1.0, 1.0],
        [-1.0, -1.0, 1.0],
        [-1.0, 1.0, -1.0],
        [1.0, -1.0, -1.0],
    ];
    let peaks = peaks.map(|p| Vector::from(p) * 0.08).to_vec();
    let sides = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let mesh =
        ColliderBuilder::trimesh_with_flags(peaks.clone(), sides, TriMeshFlags::ORIENTED).unwrap();
    let cuboid = |half: Vector| ColliderBuilder::cuboid(half.x, half.y, half.z);
    [
        ("cylinder", ColliderBuilder::cylinder(0.1, 0.08), vec![]),
        ("disc", ColliderBuilder::cylinder(0.03, 0.15), vec![]),
        (
            "cone",
            ColliderBuilder::cone(0.1, 0.1),
            vec![Vector::Y * 0.1],
        ),
        ("cube", cuboid(cube), corners(cube)),
        ("plate", cuboid(plate), corners(plate)),
        ("tetrahedron", mesh, peaks),
    ]
}

/// The deepest point of any row \[m\].
struct Deepest(f64);

impl Observer for Deepest {
    fn substep(&mut self, substep: &Substep) {
        let depths = substep.contacts.iter().map(|c| c.depth);
        self.0 = depths.fold(self.0, f64::max);
    }
}

/// A cube of 5.4 kg that hardly damps what it does.
fn block() -> DeformableBuilder {
    DeformableBuilder::new(lattice(Vector::splat(0.3), 0.1))
        .material(Material::elastic(2e5, 200.0).viscosity(300.0))
        .friction(0.5)
}

/// Two symptoms. Rows out of nothing, up to 5 cm deep: a rim that lifted off one face had its point under another; edges and
/// corners counted as just arrived since they slid fast. And corners up to 11 cm deep in a block for good: the faces that
/// they pressed bent round them, so that they seemed to have no business there any more.
#[test]
fn what_is_squeezed_is_not_pushed_by_what_it_does_not_touch() {
    for (name, shape, points) in shapes() {
        for seed in 0..36 {
            let mut random = Random(seed);
            let mut within = |lo: f64, hi: f64| random.within(lo, hi) as f32;
            let mut world = PhysicsWorld::default();
            world.insert(
                RigidBodyBuilder::fixed().translation(Vector::Y * -0.5),
                ColliderBuilder::cuboid(5.0, 0.5, 5.0),
            );
            let start = Vector::new(within(-0.25, 0.25), within(0.5, 0.55), within(-0.25, 0.25));
            let above = Vector::new(within(-0.2, 0.2), 1.0, within(-0.2, 0.2));
            let (tilt, turn) = (within(0.0, 0.4), within(0.0, 0.5));
            let (small, _) = world.insert(
                RigidBodyBuilder::dynamic()
                    .translation(start)
                    .rotation(random.direction() * tilt),
                shape.clone().friction(0.5).density(300.0),
            );
            let mut set = DeformableWorld::default();
            set.insert(block().translation(Vector::Y * 0.16)).unwrap();
            let turn = Rotation::from_scaled_axis(random.direction() * turn);
            set.insert(block().translation(above).rotation(turn))
                .unwrap();
            let (mut rows, mut corners) = (Deepest(0.0), 0.0_f32);
            for _ in 0..120 {
                set.step_with(&mut world, &(), &(), &mut rows);
                for point in &points {
                    let place = world.bodies[small].position() * *point;
                    let near = set.project_point(place, 0.2, false, DeformableFilter::new());
                    let inside = near.filter(|p| p.is_inside).map_or(0.0, |p| p.distance);
                    corners = corners.max(inside);
                }
            }
            let (rows, corners) = (1e3 * rows.0, 1e3 * corners);
            println!("{name} {seed}: rows {rows:.2} mm, corners {corners:.2} mm");
            assert!(rows < 8.0, "{name} {seed}: a row {rows} mm deep");
            assert!(corners < 3.0, "{name} {seed}: a corner {corners} mm deep");
        }
    }
}

/// A body dropped on a sheet that is held at its border, and a block on both, by seed.
fn on_sheet(
    seed: u64,
    shape: ColliderBuilder,
    thickness: f32,
) -> (PhysicsWorld, DeformableWorld, RigidBodyHandle) {
    let mut random = Random(seed);
    let mut within = |lo: f64, hi: f64| random.within(lo, hi) as f32;
    let start = Vector::new(within(-0.25, 0.25), within(0.2, 0.3), within(-0.25, 0.25));
    let tilt = random.direction() * random.within(0.0, 1.5) as f32;
    let cells = 5 + (10.0 * random.unit()) as usize;
    let mut within = |lo: f64, hi: f64| random.within(lo, hi) as f32;
    let above = Vector::new(within(-0.2, 0.2), 0.8, within(-0.2, 0.2));
    let turn = random.direction() * random.within(0.0, 0.5) as f32;
    let mut world = PhysicsWorld::default();
    let (body, _) = world.insert(
        RigidBodyBuilder::dynamic()
            .translation(start)
            .rotation(tilt),
        shape.friction(0.5).density(500.0),
    );
    let net = sheet(1.0, 1.0, cells, cells, 1e-3).unwrap().pin_border();
    let sheet = DeformableBuilder::new(net)
        .material(Material::elastic(5.0e6, 1000.0).viscosity(2.0e4))
        .friction(0.5)
        .thickness(thickness);
    let block = block()
        .translation(above)
        .rotation(Rotation::from_scaled_axis(turn));
    let mut set = DeformableWorld::default();
    set.insert(sheet).unwrap();
    set.insert(block).unwrap();
    (world, set, body)
}

/// Symptom: where a sheet hung over the rim of a body, the rim at its far side had rows up to 6 cm deep.
#[test]
fn what_hangs_over_a_rim_does_not_feel_the_far_one() {
    let cylinder = || ColliderBuilder::cylinder(0.1, 0.08);
    let rounded = || ColliderBuilder::round_cylinder(0.08, 0.06, 0.02);
    let cases = [10, 28, 38].map(|seed| (seed, cylinder()));
    for (seed, shape) in cases.into_iter().chain([(6, rounded())]) {
        let (mut world, mut set, _) = on_sheet(seed, shape, 0.0);
        let mut rows = Deepest(0.0);
        for _ in 0..180 {
            set.step_with(&mut world, &(), &(), &mut rows);
        }
        assert!(rows.0 < 4e-3, "{seed}: a row {} m deep", rows.0);
    }
}

/// Three symptoms, each up to 27 mm deep or through: a rim that came to a face from beside it, a little below, was taken for one
/// on the other side of the sheet; over a twisted face a rim was lower between the four points of it that were looked at; and
/// the side of a cylinder that lay along the ridge of a twisted face did not touch it.
#[test]
fn nothing_round_gets_into_a_sheet() {
    let cylinder = ColliderBuilder::cylinder(0.1, 0.08);
    let disc = ColliderBuilder::cylinder(0.03, 0.15);
    let cone = ColliderBuilder::cone(0.1, 0.1);
    let shapes = [
        (cylinder, [91, 263, 464, 540, 252]),
        (disc, [18, 50, 118, 162, 216]),
        (cone, [76, 140, 231, 142, 260]),
    ];
    for (shape, seeds) in shapes {
        for seed in seeds {
            let thickness = if seed % 2 == 0 { 0.0 } else { 0.01 };
            let (mut world, mut set, body) = on_sheet(seed, shape.clone(), thickness);
            let mut rows = Deepest(0.0);
            for step in 0..180 {
                set.step_with(&mut world, &(), &(), &mut rows);
                let Vector { x, y, z } = world.bodies[body].translation();
                let over = x.abs().max(z.abs()) < 0.45;
                assert!(!over || y > -0.3, "{seed}: through, in step {step}");
            }
            println!("{seed}: {:.2} mm", 1e3 * rows.0);
            assert!(rows.0 < 4e-3, "{seed}: a row {} m deep", rows.0);
        }
    }
}

/// Four symptoms, the first two of which let one sharp mesh of twenty fall through a sheet: a corner that slid to the next face had
/// no business on that one, as it leaned; an edge of a twisted quad took its face for the triangle at one of its ends; a
/// corner that came to a face from beside it, a little below, was taken for one on the other side; and an edge that lay along
/// the ridge of a twisted face did not touch it.
#[test]
fn a_sharp_mesh_does_not_cut_through_a_sheet() {
    for seed in [1, 6, 34, 40, 62, 66, 128, 135, 160, 184, 102, 112, 169, 170] {
        let [.., (_, tetrahedron, _)] = shapes();
        let thickness = if seed % 2 == 0 { 0.0 } else { 0.01 };
        let (mut world, mut set, body) = on_sheet(seed, tetrahedron, thickness);
        for step in 0..180 {
            set.step(&mut world);
            let Vector { x, y, z } = world.bodies[body].translation();
            let over = x.abs().max(z.abs()) < 0.45;
            assert!(!over || y > -0.3, "{seed}: through, in step {step}");
        }
    }
}

/// Symptom: rows up to 10 cm deep where soft blocks crumple. A surface that is folded over takes what is beside it for
/// inside it, and what slid round an edge was led back to the face it had left. What comes in one of their long substeps may be
/// some of it inside at first sight: 16 mm at most in 400 such blows.
#[test]
fn what_crumples_is_no_deeper_than_it_comes() {
    for seed in [133, 165, 182, 217, 270, 276, 278, 305, 362, 375] {
        let mut random = Random(seed);
        let mut world = PhysicsWorld {
            gravity: Vector::ZERO,
            ..PhysicsWorld::default()
        };
        let mut set = DeformableWorld::default();
        let way = random.direction();
        let speed = random.within(4.0, 6.0) as f32;
        for side in [-1.0, 1.0] {
            let beside = random.direction() * random.within(0.0, 0.15) as f32;
            let block = DeformableBuilder::new(lattice(Vector::splat(0.3), 0.1))
                .material(Material::elastic(8e4, 300.0).viscosity(4e2))
                .friction(0.5)
                .translation(way * (0.4 * side) + beside)
                .rotation(Rotation::from_scaled_axis(random.direction() * 3.0))
                .linvel(-way * (speed * side));
            set.insert(block).unwrap();
        }
        let mut rows = Deepest(0.0);
        for _ in 0..30 {
            set.step_with(&mut world, &(), &(), &mut rows);
        }
        println!("{seed}: rows {:.2} mm", 1e3 * rows.0);
        assert!(rows.0 < 0.02, "{seed}: a row {} m deep", rows.0);
    }
}

/// A sheet 1 cm thick between two balls, or a ball and a box, which can only rise and sink: what holds them apart, and what
/// moves nodes out gave in the last second \[J\].
fn pressed_sheet(lower: RigidBodyBuilder, upper: ColliderBuilder, aside: f32) -> (f32, f64) {
    let radius = 0.13;
    let mut world = PhysicsWorld::default();
    let ground = ColliderBuilder::cuboid(2.0, 0.1, 2.0);
    let below = RigidBodyBuilder::fixed().translation(-Vector::Y * (0.1 + radius));
    world.insert(below, ground);
    let guided = |body: RigidBodyBuilder| {
        let body = body.enabled_translations(false, true, false);
        body.lock_rotations()
    };
    let ball = ColliderBuilder::ball(radius).mass(4.6).friction(0.6);
    let (low, _) = world.insert(guided(lower), ball);
    let start = Vector::Y * (2.0 * radius + 0.06);
    let top = guided(RigidBodyBuilder::dynamic()).translation(start);
    let (top, _) = world.insert(top, upper.friction(0.6));
    let mut set = DeformableWorld::default();
    let sheet = DeformableBuilder::new(sheet(0.42, 0.42, 8, 8, 0.01))
        .material(Material::elastic(1e6, 400.0).viscosity(8e2))
        .thickness(0.01)
        .friction(0.6)
        .translation(Vector::new(aside, radius + 0.0052, 0.7 * aside));
    let sheet = set.insert(sheet).unwrap();
    (0..120).for_each(|_| set.step(&mut world));
    let before = set[sheet].energies().work.push_out;
    (0..60).for_each(|_| set.step(&mut world));
    let [low, top] = [low, top].map(|b| world.bodies[b].translation().y);
    let given = set[sheet].energies().work.push_out - before;
    (top - low - 2.0 * radius, given)
}

/// Symptom: what lies between two bodies was moved out of each of them into the other, for good and with 0.1 to 5 W, and nothing
/// moved the bodies: they sank into each other through a sheet at millimetres per second, a box of 46 kg until it touched the
/// ball.
#[test]
fn what_is_between_two_bodies_holds_them_apart() {
    let (fixed, free) = (RigidBodyBuilder::fixed, RigidBodyBuilder::dynamic);
    let ball = |mass| ColliderBuilder::ball(0.13).mass(mass);
    let cube = |mass| ColliderBuilder::cuboid(0.13, 0.13, 0.13).mass(mass);
    for (lower, upper, aside) in [
        (fixed(), ball(4.6), 0.03),
        (fixed(), ball(46.0), 0.03),
        (free(), ball(4.6), 0.03),
        (free(), ball(4.6), 0.0),
        (free(), ball(46.0), 0.03),
        (free(), cube(46.0), 0.03),
    ] {
        let what = format!(
            "{:?} under {:?}, {aside}",
            lower.body_type,
            upper.shape.shape_type()
        );
        let (gap, given) = pressed_sheet(lower, upper, aside);
        println!("{what}: {:.2} mm, {given:.4} J", 1e3 * gap);
        assert!((9e-3..10.5e-3).contains(&gap), "{what}: {gap} m");
        assert!(given < 0.1, "{what}: {given} J in a second");
    }
}

/// An inner edge of one block that bent by 1.5° met an edge of the other, which flattened it, was let go of for being flat, and had it
/// bend again: nodes trembled at 0.2 to 0.5 m/s, and 0.4 to 0.9 kW went into `push_out`.
#[test]
fn blocks_that_are_pressed_on_each_other_at_an_angle_lie_still() {
    let size = Vector::new(0.4, 0.2, 0.4);
    let mesh = tet_box(size, 0.1, TetSplit::Six).unwrap();
    let lattice = DeformableBuilder::new(lattice(size, 0.1))
        .material(Material::elastic(1e6, 300.0).viscosity(5e3));
    let tets = DeformableBuilder::tets(mesh, Solid::new(1e6, 0.3, 300.0).damping(0.0, 1e-3));
    for (name, block, by, angle) in [
        ("lattices", &lattice, 0.06, 0.6),
        ("lattices", &lattice, 0.12, 0.3),
        ("tets", &tets, 0.06, 0.3),
        ("tets", &tets, 0.06, 0.6),
    ] {
        let mut world = weightless(1.0 / 60.0);
        let plate = || ColliderBuilder::cuboid(1.0, 0.2, 1.0).friction(0.5);
        let below = RigidBodyBuilder::fixed().translation(Vector::NEG_Y * 0.6);
        world.insert(below, plate());
        let (above, _) = world.insert(
            RigidBodyBuilder::kinematic_position_based().translation(Vector::Y * 0.22),
            plate(),
        );
        let mut set = DeformableWorld::default();
        let all = [0.0, 1.0].map(|i| {
            let at = Vector::new(0.05 * i, -0.3 + 0.201 * i, 0.0);
            let turned = Rotation::from_rotation_y(angle * i);
            let block = block.clone().translation(at).rotation(turned);
            set.insert(block.friction(0.5).can_sleep(false)).unwrap()
        });
        let moved = |set: &DeformableWorld| -> f64 {
            let of = |block| set[block].energies().work.push_out;
            all.into_iter().map(of).sum()
        };
        let (mut before, mut fastest) = (0.0, 0.0_f32);
        for frame in 0..120 {
            let way = (by + 0.02) * (frame as f32 / 59.0).min(1.0);
            world.bodies[above].set_next_kinematic_translation(Vector::Y * (0.22 - way));
            set.step(&mut world);
            if frame == 89 {
                before = moved(&set);
            }
            if frame > 89 {
                let speeds = all.iter().flat_map(|block| set[*block].velocities());
                fastest = speeds.map(|v| v.length()).fold(fastest, f32::max);
            }
        }
        let power = (moved(&set) - before) / 0.5;
        assert!(
            fastest < 2e-3 && power < 2.0,
            "{name} pressed by {by} m at {angle}: {fastest} m/s, {power} W"
        );
    }
}
