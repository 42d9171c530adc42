//! A scene as a function of its seed.

use crumple::body::Net;
use crumple::prelude::*;
use crumple::rapier3d::parry::utils::Array2;
use crumple::rapier3d::prelude::*;
use std::fmt::Write;

/// Step of the world [s].
pub const DT: f64 = 1.0 / 60.0;
/// Half the side of the room between four half-spaces [m].
const ROOM: f32 = 1.2;

/// Rigid bodies, which the mover does not touch, and the mover: its work on rigid bodies can't be seen.
const RIGID: Group = Group::GROUP_3;
const MOVER: Group = Group::GROUP_2;

/// A scene, and its description.
pub struct Scenery {
    pub world: PhysicsWorld,
    pub deformables: DeformableWorld,
    pub ground: ColliderHandle,
    pub mover: (RigidBodyHandle, ColliderHandle),
    pub held_by_mover: Vec<AttachmentHandle>,
    pub about: String,
}

/// SplitMix64 (Steele, Lea & Flood 2014).
pub struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From `a` to `b`.
    fn range(&mut self, a: f32, b: f32) -> f32 {
        a + (b - a) * ((self.next() >> 40) as f32 / (1_u64 << 24) as f32)
    }

    /// From `a` to `b` on a logarithmic scale.
    fn decade(&mut self, a: f32, b: f32) -> f32 {
        self.range(a.ln(), b.ln()).exp()
    }

    /// Below `n`.
    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    fn turn(&mut self) -> Rotation {
        let axis = Vector::new(
            self.range(-1.0, 1.0),
            self.range(-1.0, 1.0),
            self.range(-1.0, 1.0),
        );
        Rotation::from_scaled_axis(axis)
    }
}

/// A ground of one of four kinds with slopes of at most 1 in 10, and whether it is solid.
fn ground(dice: &mut Dice, about: &mut String) -> (ColliderBuilder, bool) {
    let cells = 6;
    let kind = dice.below(4);
    let (name, ground) = match kind {
        0 => (
            "cuboid",
            ColliderBuilder::cuboid(3.0, 0.5, 3.0).translation(Vector::Y * -0.5),
        ),
        1 => (
            "half-space",
            ColliderBuilder::new(SharedShape::halfspace(Vector::Y)),
        ),
        2 => {
            let heights = (0..49).map(|_| dice.range(-0.03, 0.03)).collect();
            let heights = Array2::new(cells + 1, cells + 1, heights);
            (
                "height field",
                ColliderBuilder::heightfield(heights, Vector::new(6.0, 1.0, 6.0)),
            )
        }
        _ => {
            let n = cells as u32 + 1;
            let mut points = Vec::new();
            for i in 0..n * n {
                let (x, z) = ((i % n) as f32 - 3.0, (i / n) as f32 - 3.0);
                points.push(Vector::new(x, dice.range(-0.03, 0.03), z));
            }
            let corners = (0..n * n).filter(|i| i % n + 1 < n && i / n + 1 < n);
            let faces = corners.flat_map(|i| [[i, i + n, i + 1], [i + 1, i + n, i + n + 1]]);
            let mesh = ColliderBuilder::trimesh(points, faces.collect());
            ("mesh", mesh.expect("a grid is a mesh"))
        }
    };
    writeln!(about, "  ground: {name}").unwrap();
    (ground.friction(dice.range(0.3, 0.9)), kind < 2)
}

/// A rigid shape of one of nine kinds. No mesh on a ground that is one, or a height field: Rapier has no contact between
/// them.
fn shape(dice: &mut Dice, on_solid: bool) -> (&'static str, ColliderBuilder) {
    let a = dice.range(0.08, 0.2);
    let b = dice.range(0.08, 0.2);
    let c = dice.range(0.08, 0.2);
    match dice.below(9) {
        0 => ("cuboid", ColliderBuilder::cuboid(a, b, c)),
        1 => ("ball", ColliderBuilder::ball(a)),
        2 => ("capsule", ColliderBuilder::capsule_x(a, 0.6 * b)),
        3 => ("cylinder", ColliderBuilder::cylinder(a, b)),
        4 => ("cone", ColliderBuilder::cone(a, b)),
        5 => ("round cuboid", ColliderBuilder::round_cuboid(a, b, c, 0.03)),
        6 => {
            let points: Vec<Vector> = (0..12)
                .map(|_| dice.turn() * Vector::new(a, b, c).normalize() * dice.range(0.15, 0.22))
                .collect();
            (
                "hull",
                ColliderBuilder::convex_hull(&points).expect("twelve points span a solid"),
            )
        }
        7 => {
            let parts = vec![
                (
                    Pose::from_translation(Vector::X * 0.12),
                    SharedShape::cuboid(0.12, 0.06, 0.06),
                ),
                (
                    Pose::from_translation(Vector::Y * 0.12),
                    SharedShape::cuboid(0.06, 0.12, 0.06),
                ),
            ];
            ("compound", ColliderBuilder::compound(parts))
        }
        _ if !on_solid => ("cuboid", ColliderBuilder::cuboid(a, b, c)),
        _ => {
            let (points, faces) = Cuboid::new(Vector::new(a, b, c)).to_trimesh();
            let flags = TriMeshFlags::FIX_INTERNAL_EDGES;
            let mesh = ColliderBuilder::trimesh_with_flags(points, faces, flags);
            ("mesh", mesh.expect("a box is a mesh"))
        }
    }
}

/// A deformable of one of three kinds, of any material and mostly the usual integrator.
fn soft(dice: &mut Dice, about: &mut String) -> DeformableBuilder {
    let (young, density) = (dice.decade(0.1e6, 3.0e6), dice.decade(100.0, 1000.0));
    let speed = (young / density).sqrt();
    // Between 5 % and 50 % of what is critical for a wave of the length of a cell.
    let viscosity = young * dice.range(0.05, 0.5) * 0.1 / speed;
    let mut material = Material::elastic(young, density).viscosity(viscosity);
    let plastic = dice.below(4) == 0;
    if plastic {
        material = material.yielding(0.05 * young, 0.2 * young);
    }
    let (name, net, thick) = match dice.below(3) {
        0 => {
            let size = Vector::new(
                dice.range(0.2, 0.4),
                dice.range(0.2, 0.4),
                dice.range(0.2, 0.4),
            );
            (format!("block {size:?}"), lattice(size, 0.12), 0.0)
        }
        1 => {
            let (w, h) = (dice.range(0.3, 0.45), dice.range(0.3, 0.45));
            (format!("sheet {w} x {h}"), sheet(w, h, 6, 6, 0.01), 0.01)
        }
        _ => {
            let half = dice.range(0.15, 0.25);
            let ends = (-Vector::X * half, Vector::X * half);
            (
                format!("rope {}", 2.0 * half),
                rope(ends.0, ends.1, 8, 4.0e-4),
                0.015,
            )
        }
    };
    let integrator = match dice.below(10) {
        0 => Integrator::VelocityVerlet,
        1 => Integrator::Midpoint,
        2 => Integrator::Rk4,
        _ => Integrator::SymplecticEuler,
    };
    writeln!(
        about,
        "  {name}: E {young:.3e} Pa, {density:.0} kg/m3, viscosity {viscosity:.3e}, plastic {plastic}, {}",
        integrator.name()
    )
    .unwrap();
    DeformableBuilder::new(net)
        .material(material)
        .integrator(integrator)
        .thickness(thick)
        .friction(dice.range(0.3, 0.9))
}

/// Walls and mover.
fn surroundings(world: &mut PhysicsWorld) -> (RigidBodyHandle, ColliderHandle) {
    for out in [Vector::X, -Vector::X, Vector::Z, -Vector::Z] {
        world.insert(
            RigidBodyBuilder::fixed().translation(-out * ROOM),
            ColliderBuilder::new(SharedShape::halfspace(out)),
        );
    }
    let groups = InteractionGroups::new(MOVER, Group::ALL, InteractionTestMode::And);
    world.insert(
        RigidBodyBuilder::kinematic_velocity_based().translation(Vector::Y * 0.1),
        ColliderBuilder::cuboid(0.3, 0.04, 0.3)
            .friction(0.6)
            .collision_groups(groups),
    )
}

/// Both worlds, for steps of [`DT`].
fn empty() -> (PhysicsWorld, DeformableWorld) {
    let mut world = PhysicsWorld::default();
    world.integration_parameters.dt = DT as f32;
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = DT;
    (world, deformables)
}

/// The scene of a seed.
pub fn scene(seed: u64) -> Scenery {
    let mut dice = Dice(seed);
    let mut about = String::new();
    let (mut world, mut deformables) = empty();
    let (floor, on_solid) = ground(&mut dice, &mut about);
    let (_, ground) = world.insert(RigidBodyBuilder::fixed(), floor);
    let mover = surroundings(&mut world);
    let groups = InteractionGroups::new(RIGID, Group::ALL & !MOVER, InteractionTestMode::And);
    let (mut hard, mut yielding): (Vec<RigidBodyHandle>, Vec<DeformableHandle>) = (vec![], vec![]);
    for i in 0..2 + dice.below(7) {
        // One above the other and beside each other, in cells that no body is larger than.
        let (column, layer) = (i % 4, i / 4);
        let x = (column % 2) as f32 * 0.8 - 0.4 + dice.range(-0.05, 0.05);
        let z = (column / 2) as f32 * 0.8 - 0.4 + dice.range(-0.05, 0.05);
        let at = Vector::new(x, 0.6 + 0.8 * layer as f32, z);
        let (turn, speed) = (
            dice.turn(),
            Vector::new(
                dice.range(-1.0, 1.0),
                dice.range(-2.0, 0.0),
                dice.range(-1.0, 1.0),
            ),
        );
        // The first is deformable; of the others, every second.
        if i == 0 || dice.below(2) == 0 {
            let builder = soft(&mut dice, &mut about);
            let builder = builder.translation(at).rotation(turn).linvel(speed);
            yielding.push(deformables.insert(builder).expect("a sound body"));
        } else {
            let (name, collider) = shape(&mut dice, on_solid);
            let density = dice.decade(100.0, 2000.0);
            writeln!(about, "  rigid {name}: {density:.0} kg/m3 at {at:?}").unwrap();
            let body = RigidBodyBuilder::dynamic()
                .pose(Pose::from_parts(at, turn))
                .linvel(speed)
                .angular_damping(0.5);
            let collider = collider.density(density).friction(dice.range(0.3, 0.9));
            hard.push(world.insert(body, collider.collision_groups(groups)).0);
        }
    }
    if hard.len() >= 2 && dice.below(2) == 0 {
        let between = world.bodies[hard[1]].translation() - world.bodies[hard[0]].translation();
        let local = |h: RigidBodyHandle, v: Vector| world.bodies[h].rotation().inverse() * v;
        let (one, two) = (
            local(hard[0], 0.5 * between),
            local(hard[1], -0.5 * between),
        );
        let joint = SphericalJointBuilder::new()
            .local_anchor1(one)
            .local_anchor2(two);
        world.impulse_joints.insert(hard[0], hard[1], joint, true);
        writeln!(about, "  joint between the first two rigid bodies").unwrap();
    }
    let mut held_by_mover = Vec::new();
    let (kind, first) = (dice.below(6), yielding[0]);
    let target = match kind {
        0 => Some(AttachTo::World),
        1 => hard.first().map(|h| AttachTo::Body(*h)),
        2 => Some(AttachTo::Body(mover.0)),
        _ => None,
    };
    if let Some(target) = target {
        let hold = Attachment::pin([NodeId(0)]);
        let held = deformables
            .attach(first, hold, target, &world.bodies)
            .expect("sound");
        writeln!(
            about,
            "  node 0 of the first deformable pinned to {target:?}"
        )
        .unwrap();
        if kind == 2 {
            held_by_mover.push(held);
        }
    }
    Scenery {
        world,
        deformables,
        ground,
        mover,
        held_by_mover,
        about,
    }
}

/// Two to four thin bodies close over each other, and a rigid one over all, that fall on a floor: a scene as a function of its seed.
pub fn stack(seed: u64) -> Scenery {
    let mut dice = Dice(seed);
    let mut about = String::new();
    let (mut world, mut deformables) = empty();
    let floor = ColliderBuilder::cuboid(3.0, 0.5, 3.0).translation(Vector::Y * -0.5);
    let friction = dice.range(0.0, 0.9);
    let (_, ground) = world.insert(RigidBodyBuilder::fixed(), floor.friction(friction));
    let far = RigidBodyBuilder::kinematic_velocity_based().translation(Vector::Y * -5.0);
    let mover = world.insert(far, ColliderBuilder::ball(0.1));
    let mut y = 0.0;
    for _ in 0..2 + dice.below(3) {
        let (net, spacing, name) = thin(&mut dice);
        let thickness = [0.0, 0.002, 0.01][dice.below(3)];
        // What has no thickness keeps a tenth of its spacing from others.
        let keeps = if thickness > 0.0 {
            thickness
        } else {
            0.1 * spacing
        };
        y += keeps + dice.range(0.002, 0.02);
        // Node over node, or a little beside.
        let aside = [0.0, dice.decade(1e-4, 0.1)][dice.below(2)];
        let yaw = [0.0, dice.range(-1.0, 1.0)][dice.below(2)];
        let at = Vector::new(aside, y, 0.7 * aside);
        let (young, density) = (dice.decade(0.3e6, 3.0e6), dice.decade(200.0, 1000.0));
        let viscosity = young * dice.range(0.05, 0.5) * spacing / (young / density).sqrt();
        writeln!(
            about,
            "  {name}, {thickness} m thick, at {at:?}, turned by {yaw}: E {young:.3e} Pa, {density:.0} kg/m3, viscosity {viscosity:.3e}"
        )
        .unwrap();
        let body = DeformableBuilder::new(net)
            .material(Material::elastic(young, density).viscosity(viscosity))
            .thickness(thickness)
            .friction(friction)
            .translation(at)
            .rotation(Rotation::from_rotation_y(yaw));
        deformables.insert(body).expect("a sound body");
        y += keeps;
    }
    let (name, collider) = shape(&mut dice, true);
    let mass = dice.decade(0.05, 50.0);
    let at = Vector::new(dice.range(-0.1, 0.1), y + 0.25, dice.range(-0.1, 0.1));
    let turn = if dice.below(2) == 0 {
        dice.turn()
    } else {
        Rotation::IDENTITY
    };
    writeln!(
        about,
        "  rigid {name} of {mass} kg at {at:?}, friction {friction}"
    )
    .unwrap();
    let body = RigidBodyBuilder::dynamic().pose(Pose::from_parts(at, turn));
    let body = body.angular_damping(0.5);
    world.insert(body, collider.mass(mass).friction(friction));
    Scenery {
        world,
        deformables,
        ground,
        mover,
        held_by_mover: Vec::new(),
        about,
    }
}

/// A sheet or a rope, and its spacing \[m\].
fn thin(dice: &mut Dice) -> (Net, f32, String) {
    let size = dice.range(0.3, 0.6);
    let cells = 2 + dice.below(6);
    let spacing = size / cells as f32;
    if dice.below(3) == 0 {
        let half = 0.5 * size * Vector::X;
        let net = rope(-half, half, cells, 1e-4).expect("sound");
        (net, spacing, format!("rope of {size} m, {cells} links"))
    } else {
        let nodes = cells + 1;
        let net = sheet(size, size, nodes, nodes, 0.004).expect("sound");
        (net, spacing, format!("sheet of {size} m, {cells} cells"))
    }
}
