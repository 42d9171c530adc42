//! What a surface and a rigid body may be besides the usual.

use super::{block, box_mesh, flat_field, grid_mesh, voxel_floor};
use crate::fixtures::bead;
use crate::support::{close, weightless};
use crumple::body::BuildError;
use crumple::math::{DVec3, wide};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// Momentum and angular momentum about the origin of a body and a bead.
fn momenta(world: &PhysicsWorld, body: RigidBodyHandle, bead: &Deformable) -> (DVec3, DVec3) {
    let b = &world.bodies[body];
    let p = wide(b.linvel()) * f64::from(b.mass());
    let com = wide(b.center_of_mass());
    let turn = glam_rotation(b);
    let props = b.mass_properties().local_mprops;
    let frame = turn * wide_rotation(props.principal_inertia_local_frame);
    let w = frame.inverse() * wide(b.angvel());
    let spin = frame * (wide(props.principal_inertia()) * w);
    (
        p + bead.momentum(),
        com.cross(p) + spin + bead.angular_momentum(DVec3::ZERO),
    )
}

fn wide_rotation(r: Rotation) -> crumple::math::DQuat {
    crumple::math::DQuat::from_xyzw(r.x.into(), r.y.into(), r.z.into(), r.w.into())
}

fn glam_rotation(b: &RigidBody) -> crumple::math::DQuat {
    wide_rotation(*b.rotation())
}

/// A bead of .5 kg at 5 m/s against a free body, off its centre.
fn hit(name: &str, body: RigidBodyBuilder, colliders: Vec<ColliderBuilder>) {
    let mut world = weightless(1.0 / 240.0);
    let body = world.insert_body(body);
    for collider in colliders {
        world.insert_collider(collider, Some(body));
    }
    world.bodies[body].recompute_mass_properties_from_colliders(&world.colliders);
    let mut deformables = DeformableWorld::default();
    let handle = deformables
        .insert(
            bead(0.5)
                .translation(Vector::new(0.4, 0.3, 0.1))
                .linvel(Vector::new(0.0, -5.0, 0.0)),
        )
        .unwrap();
    let (p0, l0) = momenta(&world, body, &deformables[handle]);
    for _ in 0..60 {
        deformables.step(&mut world);
    }
    let bead = &deformables[handle];
    let (p, l) = momenta(&world, body, bead);
    let off = (
        (p - p0).length() / p0.length(),
        (l - l0).length() / l0.length(),
    );
    println!(
        "{name}: momentum off by {:.1e}, angular momentum by {:.1e}",
        off.0, off.1
    );
    assert!(
        bead.linvel().y > -4.9,
        "{name}: went on at {}",
        bead.linvel()
    );
    assert!(
        world.bodies[body].angvel().length() > 0.1,
        "{name}: no spin"
    );
    assert!(
        off.0 < 1e-4 && off.1 < 1e-3,
        "{name}: momenta off by {off:?}"
    );
}

#[test]
fn free_bodies_of_all_kinds_are_hit() {
    let plate = || ColliderBuilder::cuboid(0.5, 0.1, 0.5).density(100.0);
    let dynamic = RigidBodyBuilder::dynamic;
    hit("plain", dynamic(), vec![plate()]);
    hit(
        "offset collider",
        dynamic().translation(Vector::new(0.5, 0.2, 0.0)),
        vec![plate().translation(Vector::new(-0.5, -0.2, 0.0))],
    );
    hit(
        "offset centre of mass",
        dynamic().additional_mass_properties(MassProperties::new(
            Vector::new(-0.3, 0.1, 0.2),
            10.0,
            Vector::splat(1.0),
        )),
        vec![plate()],
    );
    hit(
        "several colliders",
        dynamic(),
        vec![
            ColliderBuilder::cuboid(0.25, 0.1, 0.5)
                .density(100.0)
                .translation(Vector::new(0.25, 0.0, 0.0)),
            ColliderBuilder::ball(0.2)
                .density(100.0)
                .translation(Vector::new(-0.4, 0.0, 0.0)),
        ],
    );
    hit(
        "continuous collision",
        dynamic().ccd_enabled(true),
        vec![plate()],
    );
    hit(
        "mesh",
        dynamic().additional_mass_properties(MassProperties::new(
            Vector::ZERO,
            10.0,
            Vector::splat(1.0),
        )),
        vec![box_mesh(
            Vector::new(-0.5, -0.1, -0.5),
            Vector::new(0.5, 0.1, 0.5),
            TriMeshFlags::ORIENTED,
        )],
    );
}

#[test]
fn locked_axes_do_not_give() {
    let mut world = weightless(1.0 / 240.0);
    let (body, _) = world.insert(
        RigidBodyBuilder::dynamic()
            .locked_axes(LockedAxes::TRANSLATION_LOCKED_Y | LockedAxes::ROTATION_LOCKED),
        ColliderBuilder::cuboid(0.5, 0.1, 0.5).friction(0.0),
    );
    let mut deformables = DeformableWorld::default();
    let handle = deformables
        .insert(
            bead(0.5)
                .friction(0.0)
                .translation(Vector::new(0.3, 0.3, 0.1))
                .linvel(Vector::new(0.0, -5.0, 0.0)),
        )
        .unwrap();
    for _ in 0..60 {
        deformables.step(&mut world);
    }
    let b = &world.bodies[body];
    assert!(b.linvel().length() < 1e-5 && b.angvel().length() < 1e-5);
    assert!(deformables[handle].linvel().length() < 1e-4);
}

/// Height of the centre of mass of a block after 2 s on a floor.
fn rest(builder: DeformableBuilder, floor: ColliderBuilder) -> f64 {
    let mut world = PhysicsWorld::default();
    world.insert_collider(floor, None);
    let mut deformables = DeformableWorld::default();
    let handle = deformables
        .insert(builder.translation(Vector::new(0.0, 0.25, 0.0)))
        .unwrap();
    for _ in 0..120 {
        deformables.step(&mut world);
    }
    deformables[handle].center_of_mass().y
}

fn slab() -> ColliderBuilder {
    ColliderBuilder::cuboid(2.0, 0.5, 2.0).translation(Vector::new(0.0, -0.5, 0.0))
}

#[test]
fn thickness_is_kept_from_solids_and_surfaces() {
    for (floor, name) in [
        (slab(), "cuboid"),
        (flat_field(4.0, 4.0, 0.3), "height field"),
    ] {
        let bare = rest(block(), floor.clone());
        let thick = rest(block().thickness(0.04), floor.clone());
        let skin = rest(block(), floor.contact_skin(0.02));
        assert!(
            (thick - bare - 0.02).abs() < 1e-4,
            "{name}: {thick} and {bare}"
        );
        assert!(
            (skin - bare - 0.02).abs() < 1e-4,
            "{name}: {skin} and {bare}"
        );
    }
}

/// What keeps more distance than anything comes nearer by in a step is looked for that much farther away: blocks fell into their own
/// skin until their nodes were within 5 cm, and trembled at 0.9 m/s. In the first step Rapier's BVH does not know the floor.
#[test]
fn great_thickness_is_kept_from_the_first() {
    for (thickness, skin) in [(0.24, 0.0), (0.0, 0.3), (0.24, 0.3)] {
        let net = lattice(Vector::new(2.0, 1.0, 2.0), 0.5);
        let lies = 0.5 * thickness + skin;
        let block = DeformableBuilder::new(net)
            .material(Material::elastic(1e7, 200.0).viscosity(2e4))
            .thickness(thickness)
            .translation(Vector::Y * (0.5 + lies + 1e-4));
        let mut world = PhysicsWorld::default();
        world.insert(RigidBodyBuilder::fixed(), slab().contact_skin(skin));
        let mut set = DeformableWorld::default();
        let body = set.insert(block).unwrap();
        let mut lowest = f32::INFINITY;
        for _ in 0..120 {
            set.step(&mut world);
            let heights = set[body].positions().map(|p| p.y - lies);
            lowest = heights.fold(lowest, f32::min);
        }
        let fastest = set[body].velocities().map(|v| v.length());
        let fastest = fastest.fold(0.0, f32::max);
        let moved = set[body].energies().work.push_out / (set[body].mass() * 9.81);
        assert!(
            lowest > -1e-5 && fastest < 1e-3 && moved < 1e-5,
            "{thickness} m thick, skin {skin} m: {lowest} m, {fastest} m/s, lifted by {moved} m"
        );
    }
}

/// A sheet 6 mm thick lies 3 mm above the floor.
#[test]
fn a_sheet_lies_at_half_its_thickness() {
    let net = sheet(0.4, 0.4, 5, 5, 0.006);
    let builder = DeformableBuilder::new(net)
        .material(Material::elastic(1.0e6, 500.0).viscosity(1.0e3))
        .total_mass(0.5)
        .thickness(0.006);
    for floor in [slab(), flat_field(4.0, 4.0, 0.3)] {
        let height = rest(builder.clone(), floor);
        assert!((height - 0.003).abs() < 1e-4, "lies at {height} m");
    }
}

/// 16 nodes of 5.4 kg on contacts of 2 kN/m, on floors of every make: where a node lies on a seam, or on many facets, its contact is
/// no stiffer.
#[test]
fn compliant_contacts_sink_as_springs_do() {
    let hard = |k: Option<f32>| {
        let body = DeformableBuilder::new(lattice(Vector::splat(0.3), 0.1))
            .material(Material::elastic(2.0e6, 200.0).viscosity(2.0e4))
            .drag(2.0);
        k.map_or(body.clone(), |k| body.contact_stiffness(k))
    };
    let (lo, hi) = (Vector::new(-2.0, -1.0, -2.0), Vector::new(2.0, 0.0, 2.0));
    let half = |x: f32| {
        let half = SharedShape::cuboid(1.0, 0.5, 2.0);
        (Pose::from_translation(Vector::new(x, -0.5, 0.0)), half)
    };
    let tile = |i: i32| {
        let (x, z) = (0.1 * (i % 4) as f32 - 0.15, 0.1 * (i / 4) as f32 - 0.15);
        let tile = SharedShape::cuboid(0.05, 0.5, 0.05);
        (Pose::from_translation(Vector::new(x, -0.5, z)), tile)
    };
    let floors = [
        slab(),
        ColliderBuilder::compound((0..16).map(tile).collect()),
        ColliderBuilder::compound(vec![half(-1.0), half(1.0)]),
        ColliderBuilder::new(SharedShape::halfspace(Vector::Y)),
        flat_field(4.0, 4.0, 0.3),
        flat_field(4.0, 4.0, 0.1),
        box_mesh(lo, hi, TriMeshFlags::empty()),
        box_mesh(lo, hi, TriMeshFlags::ORIENTED),
        box_mesh(lo, hi, TriMeshFlags::FIX_INTERNAL_EDGES),
        grid_mesh((-1.0, -1.0), (2.0, 2.0), (20, 20), TriMeshFlags::empty()),
        voxel_floor([-20, -20], [20, 20], 0.1),
    ];
    for floor in floors {
        let mut bodies = [hard(None), hard(Some(2000.0))].into_iter();
        let mass = hard(None).build().unwrap().mass();
        let mut height = || rest(bodies.next().unwrap(), floor.clone());
        let sunk = height() - height();
        let what = format!("depth on {:?} [m]", floor.shape.shape_type());
        close(&what, sunk, mass * 9.81 / (16.0 * 2000.0), 0.01);
    }
}

#[test]
fn solver_groups_decide_who_pushes() {
    let (a, b) = (Group::GROUP_1, Group::GROUP_2);
    let groups = |of, with| InteractionGroups::new(of, with, InteractionTestMode::And);
    let on = |floor| {
        rest(
            block().solver_groups(groups(a, a)),
            slab().solver_groups(floor),
        )
    };
    assert!(on(groups(a, a)) > 0.14);
    assert!(on(groups(b, b)) < -5.0);
}

/// A bead and a plate of the same mass that meet: the dominant one goes on as if alone.
#[test]
fn dominance_is_as_in_rapier() {
    for (group, (of_bead, of_plate)) in [(1, (-5.0, -5.0)), (0, (-2.5, -2.5)), (-1, (0.0, 0.0))] {
        let mut world = weightless(1.0 / 240.0);
        let (body, _) = world.insert(
            RigidBodyBuilder::dynamic(),
            ColliderBuilder::cuboid(0.5, 0.1, 0.5)
                .density(0.0)
                .mass(1.0),
        );
        let mut deformables = DeformableWorld::default();
        let handle = deformables
            .insert(
                bead(1.0)
                    .dominance_group(group)
                    .translation(Vector::new(0.0, 0.3, 0.0))
                    .linvel(Vector::new(0.0, -5.0, 0.0)),
            )
            .unwrap();
        for _ in 0..48 {
            deformables.step(&mut world);
        }
        let v = (
            deformables[handle].linvel().y,
            f64::from(world.bodies[body].linvel().y),
        );
        assert!(
            (v.0 - of_bead).abs() < 1e-3 && (v.1 - of_plate).abs() < 1e-3,
            "group {group}: {v:?}"
        );
    }
}

#[test]
fn values_that_cannot_be_are_refused() {
    let refused = |builder: DeformableBuilder| {
        assert!(matches!(builder.build(), Err(BuildError::Value { .. })));
    };
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        refused(block().thickness(bad));
        refused(block().contact_stiffness(bad));
    }
    refused(block().contact_stiffness(0.0));
}

/// Values set past the builder that cannot be count as none.
#[test]
fn values_that_cannot_be_do_nothing() {
    let bare = rest(block(), slab());
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        let mut world = PhysicsWorld::default();
        world.insert_collider(slab(), None);
        let mut deformables = DeformableWorld::default();
        let handle = deformables
            .insert(block().translation(Vector::new(0.0, 0.25, 0.0)))
            .unwrap();
        let surface = deformables[handle].surface_mut();
        (surface.thickness, surface.stiffness) = (bad, Some(bad));
        for _ in 0..120 {
            deformables.step(&mut world);
        }
        let height = deformables[handle].center_of_mass().y;
        assert!((height - bare).abs() < 1e-9, "{bad}: {height} and {bare}");
    }
}
