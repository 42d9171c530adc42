//! A block let fall on every shape.

use super::{block, box_mesh, corners, flat_field, grid_mesh, voxel_floor};
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// A shape whose highest point is at y = 0, and how far a point is from it.
struct Case {
    name: &'static str,
    collider: ColliderBuilder,
    distance: fn(DVec3) -> f64,
    /// Whether a block can lie on it.
    flat: bool,
    thickness: f32,
}

/// Above the middle of a flat top of 1 m; beyond it nothing is asked.
fn above(p: DVec3) -> f64 {
    if p.x.abs() < 0.45 && p.z.abs() < 0.45 {
        p.y
    } else {
        f64::INFINITY
    }
}

fn on(name: &'static str, collider: ColliderBuilder, y: f32) -> Case {
    Case {
        name,
        collider: collider.translation(Vector::new(0.0, y, 0.0)),
        distance: above,
        flat: true,
        thickness: 0.0,
    }
}

/// Turned upside down.
fn base_up(case: Case) -> Case {
    Case {
        collider: case
            .collider
            .rotation(Vector::new(std::f32::consts::PI, 0.0, 0.0)),
        ..case
    }
}

/// Distance from the x axis between −a and a.
fn from_axis(p: DVec3, y: f64, a: f64) -> f64 {
    (p - DVec3::new(p.x.clamp(-a, a), y, 0.0)).length()
}

fn comb() -> ColliderBuilder {
    let mut points = Vec::new();
    for i in 0..41 {
        let z = -0.5 + 0.025 * i as f32;
        let x = if i % 2 == 0 { 0.5 } else { -0.5 };
        points.extend([Vector::new(-x, 0.0, z), Vector::new(x, 0.0, z)]);
    }
    ColliderBuilder::polyline(points, None)
}

fn cases() -> Vec<Case> {
    let half = Vector::splat(0.5);
    let (lo, hi) = (Vector::new(-0.5, -1.0, -0.5), Vector::new(0.5, 0.0, 0.5));
    let inner = corners(Vector::splat(-0.45), Vector::splat(0.45));
    let halves = [-0.25, 0.25].map(|x| {
        (
            Pose::from_translation(Vector::new(x, 0.0, 0.0)),
            SharedShape::cuboid(0.25, 0.5, 0.5),
        )
    });
    let mesh = |flags| grid_mesh((-0.5, -0.5), (1.0, 1.0), (7, 7), flags);
    let thin = |case: Case| Case {
        thickness: 0.05,
        ..case
    };
    vec![
        Case {
            distance: |p| (p + DVec3::Y * 0.5).length() - 0.5,
            flat: false,
            ..on("ball", ColliderBuilder::ball(0.5), -0.5)
        },
        Case {
            distance: |p| from_axis(p, -0.3, 0.5) - 0.3,
            flat: false,
            ..on("capsule", ColliderBuilder::capsule_x(0.5, 0.3), -0.3)
        },
        on("cuboid", ColliderBuilder::cuboid(0.5, 0.5, 0.5), -0.5),
        on("cylinder", ColliderBuilder::cylinder(0.5, 0.7), -0.5),
        base_up(on("cone", ColliderBuilder::cone(0.5, 0.7), -0.5)),
        on(
            "half-space",
            ColliderBuilder::new(SharedShape::halfspace(Vector::Y)),
            0.0,
        ),
        on(
            "hull",
            ColliderBuilder::convex_hull(&corners(-half, half)).unwrap(),
            -0.5,
        ),
        on(
            "round cuboid",
            ColliderBuilder::round_cuboid(0.45, 0.45, 0.45, 0.05),
            -0.5,
        ),
        on(
            "round cylinder",
            ColliderBuilder::round_cylinder(0.45, 0.7, 0.05),
            -0.5,
        ),
        base_up(on(
            "round cone",
            ColliderBuilder::round_cone(0.45, 0.7, 0.05),
            -0.5,
        )),
        on(
            "round hull",
            ColliderBuilder::round_convex_hull(&inner, 0.05).unwrap(),
            -0.5,
        ),
        on("compound", ColliderBuilder::compound(halves.to_vec()), -0.5),
        on("mesh", mesh(TriMeshFlags::empty()), 0.0),
        on(
            "mesh of fixed edges",
            mesh(TriMeshFlags::FIX_INTERNAL_EDGES),
            0.0,
        ),
        on("box mesh", box_mesh(lo, hi, TriMeshFlags::empty()), 0.0),
        on(
            "oriented mesh",
            box_mesh(lo, hi, TriMeshFlags::ORIENTED),
            0.0,
        ),
        on("height field", flat_field(1.0, 1.0, 0.125), 0.0),
        on("voxels", voxel_floor([-4, -4], [4, 4], 0.125), 0.0),
        on(
            "triangle",
            ColliderBuilder::triangle(
                Vector::new(-2.0, 0.0, -1.0),
                Vector::new(0.0, 0.0, 3.0),
                Vector::new(2.0, 0.0, -1.0),
            ),
            0.0,
        ),
        on(
            "round triangle",
            ColliderBuilder::round_triangle(
                Vector::new(-2.0, 0.0, -1.0),
                Vector::new(0.0, 0.0, 3.0),
                Vector::new(2.0, 0.0, -1.0),
                0.05,
            ),
            -0.05,
        ),
        Case {
            distance: |p| from_axis(p, 0.0, 0.5),
            flat: false,
            ..thin(on(
                "segment",
                ColliderBuilder::segment(-half * Vector::X, half * Vector::X),
                0.0,
            ))
        },
        Case {
            // A node hangs through between two lines by .025 − √(.025² − .0125²).
            distance: |p| above(p) + 0.00335,
            ..thin(on("polyline", comb(), 0.0))
        },
    ]
}

/// Height of the centre of mass at 2 s.
fn drop_on(case: &Case) -> f64 {
    let mut world = PhysicsWorld::default();
    world.insert(
        RigidBodyBuilder::fixed(),
        case.collider.clone().friction(0.5),
    );
    let mut deformables = DeformableWorld::default();
    // A row of nodes above a single line.
    let z = 0.5 * case.thickness;
    let start = Vector::new(0.0, 0.25 + 0.5 * case.thickness, z);
    let handle = deformables
        .insert(block().thickness(case.thickness).translation(start))
        .unwrap();
    let half = f64::from(0.5 * case.thickness);
    let name = case.name;
    let first = deformables[handle].energies().balance();
    let (mut dissipated, mut depth, mut residual, mut drop) = (0.0, 0.0_f64, 0.0_f64, 0.0_f64);
    for _ in 0..120 {
        deformables.step(&mut world);
        let body = &deformables[handle];
        assert_eq!(deformables.report().unsupported, [], "{name}");
        let energies = body.energies();
        residual = residual.max((energies.balance() - first).abs() / energies.scale());
        let now = energies.work.contact_normal + energies.work.contact_friction;
        drop = drop.max(dissipated - now);
        dissipated = now;
        for i in 0..body.node_count() as u32 {
            let p = body.position(NodeId(i)).unwrap();
            depth = depth.max(half - (case.distance)(p));
        }
    }
    let body = &deformables[handle];
    println!(
        "{name}: height {:.6}, speed {:.1e}, depth {depth:.2e}, residual {residual:.1e}, drop {drop:.1e}",
        body.center_of_mass().y,
        body.linvel().length()
    );
    assert!(depth <= 1e-3, "{name}: a node was {depth} m deep");
    assert!(residual <= 0.01, "{name}: residual {residual}");
    assert!(drop <= 1e-6, "{name}: contact gave back {drop} J");
    if case.flat {
        let speed = body.linvel().length();
        assert!(speed < 1e-3, "{name}: still moves at {speed} m/s");
    }
    body.center_of_mass().y
}

#[test]
fn a_block_falls_on_every_shape() {
    let flat: Vec<_> = cases()
        .iter()
        .map(|case| (case, drop_on(case)).1)
        .zip(cases())
        .filter(|(_, case)| case.flat && case.thickness == 0.0)
        .collect();
    let cuboid = flat.iter().find(|(_, c)| c.name == "cuboid").unwrap().0;
    for (height, case) in &flat {
        let off = (height - cuboid).abs();
        assert!(
            off < 1e-4,
            "{}: rests at {height} m, on the cuboid at {cuboid} m",
            case.name
        );
    }
}
