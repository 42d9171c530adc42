//! Solids of tets, through `DeformableWorld::step`: patch test, cantilever, elastica, uniaxial stretch.

use crate::support::{close, weightless};
use crumple::body::Tets;
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape::{TetSplit, tet_box, tet_box_of_cells};

/// V12: boundary nodes are put where a linear field has them, inner ones swing, are damped and find their places. Every tet
/// has the exact stress then.
#[test]
fn v12_patch_test_in_the_world() {
    let mut mesh = tet_box(Vector::splat(1.0), 0.5, TetSplit::Six).unwrap();
    mesh.nodes[13] += DVec3::new(0.11, -0.07, 0.09);
    for mesh in [mesh.clone(), mesh.quadratic()] {
        let solid = Solid::new(1.0e6, 0.25, 1000.0).damping(30.0, 1e-3);
        let mut deformables = DeformableWorld::default();
        let boundary = |x: Vector| x.abs().max_element() > 0.499;
        let body = DeformableBuilder::tets(mesh.clone(), solid).pin(boundary);
        let body = deformables.insert(body).unwrap();
        for (node, x) in (0..).zip(&mesh.nodes) {
            if boundary(x.as_vec3()) {
                let moved = *x + 0.5e-3 * (DVec3::splat(x.x + x.y + x.z) + *x);
                assert!(deformables[body].set_position(NodeId(node), moved.as_vec3()));
            }
        }
        let mut world = weightless(1.0 / 60.0);
        for _ in 0..60 {
            deformables.step(&mut world);
        }
        for stress in deformables[body].stresses() {
            for (i, row) in stress.cauchy.iter().enumerate() {
                for (j, found) in row.iter().enumerate() {
                    let expected = if i == j { 2000.0 } else { 400.0 };
                    close("stress [Pa]", found / 2000.0, expected / 2000.0, 1e-3);
                }
            }
        }
    }
}

/// The cantilever of V15, nodes `n` times as close as 9×3×3 along every axis.
fn beam(n: u32, quadratic: bool) -> TetMesh {
    let size = Vector::new(2.0, 0.2, 0.2);
    if quadratic {
        let mesh = tet_box_of_cells(size, [4 * n, n, n], TetSplit::Six);
        mesh.unwrap().quadratic()
    } else {
        tet_box_of_cells(size, [8 * n, 2 * n, 2 * n], TetSplit::Five).unwrap()
    }
}

/// A body clamped at its low x end, and the nodes of its other end.
fn cantilever(mesh: &TetMesh, solid: Solid) -> (DeformableWorld, DeformableHandle, Vec<NodeId>) {
    let ends = mesh.nodes.iter().fold((f64::MAX, f64::MIN), |(lo, hi), x| {
        (lo.min(x.x), hi.max(x.x))
    });
    let mut deformables = DeformableWorld::default();
    let clamped = ends.0 as f32 + 1e-4;
    let body = DeformableBuilder::tets(mesh.clone(), solid).pin(move |x| x.x < clamped);
    let body = deformables.insert(body).unwrap();
    let tip = (0..mesh.nodes.len()).filter(|&n| mesh.nodes[n].x > ends.1 - 1e-4);
    (deformables, body, tip.map(|n| NodeId(n as u32)).collect())
}

fn displacement(body: &Deformable, mesh: &TetMesh, nodes: &[NodeId]) -> DVec3 {
    let each = nodes
        .iter()
        .map(|n| body.position(*n).unwrap() - mesh.nodes[n.index()]);
    each.sum::<DVec3>() / nodes.len() as f64
}

/// Deflection of the tip at rest under the body's own weight.
fn rest_deflection(mesh: &TetMesh, equal_masses: bool, dt: f32) -> f64 {
    let solid = Solid::new(1.2e7, 0.0, 100.0).damping(35.0, 0.0);
    let (mut deformables, body, tip) = cantilever(mesh, solid);
    if equal_masses {
        for node in 0..mesh.nodes.len() as u32 {
            let mass = 8.0 / mesh.nodes.len() as f32;
            deformables[body].set_node_mass(NodeId(node), mass).unwrap();
        }
    }
    let mut world = PhysicsWorld::default();
    world.integration_parameters.dt = dt;
    for _ in 0..(1.2 / dt).round() as usize {
        deformables.step(&mut world);
    }
    displacement(&deformables[body], mesh, &tip).y
}

/// V15 (a): the discrete answers, the same whatever the step is. (b): that of the recommended element is the beam's.
#[test]
fn v15_a_cantilever_at_rest() {
    for (mesh, equal, expected) in [
        (beam(1, false), true, -0.01475),
        (beam(1, false), false, -0.01424),
        (beam(2, false), true, -0.03102),
        (beam(1, true), false, -0.04876),
    ] {
        let found =
            [1.0 / 60.0, 1.0 / 240.0, 1.0 / 1000.0].map(|dt| rest_deflection(&mesh, equal, dt));
        let what = format!("{} nodes: tip {found:?}", mesh.nodes.len());
        for tip in found {
            close(&what, tip, expected, 5e-3);
            close(&what, tip, found[0], 1e-4);
        }
    }
    for n in [1, 2] {
        let tip = rest_deflection(&beam(n, true), false, 1.0 / 60.0);
        close("tip of quadratic tets", tip, -0.049442, 0.02);
    }
}

/// V15: let go from straight, the beam swings about its rest shape with its first frequency.
#[test]
fn v15_first_frequency() {
    let mesh = beam(1, true);
    let (mut deformables, body, tip) = cantilever(&mesh, Solid::new(1.2e7, 0.0, 100.0));
    let mut world = PhysicsWorld::default();
    world.integration_parameters.dt = 1e-3;
    let rest = -0.04876;
    let (mut last, mut crossings) = (0.0, Vec::new());
    for _ in 0..3000 {
        deformables.step(&mut world);
        let now = displacement(&deformables[body], &mesh, &tip).y - rest;
        if last > 0.0 && now <= 0.0 {
            crossings.push(deformables.time() - 1e-3 * now / (now - last));
        }
        last = now;
    }
    let (first, end) = (crossings[0], crossings[crossings.len() - 1]);
    let hertz = (crossings.len() - 1) as f64 / (end - first);
    close("first frequency [Hz]", hertz, 2.79796, 0.01);
    // The clamp takes up work, so the sum is that of the body alone.
    let energies = deformables[body].energies();
    let residual = energies.balance().abs() / energies.scale();
    assert!(residual < 0.01, "{residual}: {energies:?}");
}

/// V16: a slender beam under a dead load at its tip, turned by up to more than 70°.
#[test]
fn v16_elastica() {
    let (length, side) = (1.0, 0.04);
    let mesh = tet_box_of_cells(Vector::new(1.0, 0.04, 0.04), [25, 1, 1], TetSplit::Six);
    let mesh = mesh.unwrap().quadratic();
    let bending = 1.0e7 * side * side * side * side / 12.0;
    for (alpha, w, u) in [
        (1.0, 0.301721, 0.056433),
        (3.0, 0.603253, 0.254420),
        (10.0, 0.810609, 0.554996),
    ] {
        let solid = Solid::new(1.0e7, 0.0, 1000.0).damping(8.0, 0.0);
        let (mut deformables, body, tip) = cantilever(&mesh, solid);
        let load = alpha * bending / (length * length) / tip.len() as f64;
        for node in &tip {
            let force = Vector::new(0.0, -load as f32, 0.0);
            assert!(deformables[body].set_node_force(*node, force));
        }
        let mut world = weightless(1.0 / 60.0);
        for _ in 0..180 {
            deformables.step(&mut world);
        }
        let moved = displacement(&deformables[body], &mesh, &tip);
        close(&format!("w/L at α = {alpha}"), -moved.y, w, 0.02);
        close(&format!("u/L at α = {alpha}"), -moved.x, u, 0.02);
    }
}

/// Cubes of 1 m: of one cell and of 2³, of linear and of quadratic tets. Those of 2³ cells are their own mirror images.
fn cubes() -> [TetMesh; 4] {
    let of = |cell, split| tet_box(Vector::splat(1.0), cell, split).unwrap();
    let (one, eight) = (of(1.0, TetSplit::Six), of(0.5, TetSplit::Five));
    [
        one.clone(),
        one.quadratic(),
        eight.clone(),
        eight.quadratic(),
    ]
}

/// V20: a cube of rubber between frictionless plates, squeezed to half its height. Its ends may slide, so quadratic tets
/// shear sideways in time, as a column buckles: by 11 mm where the mesh has no mirror planes, and from rounding, after another
/// second, where it has.
#[test]
fn v20_squeezed_between_plates() {
    for mesh in cubes() {
        let what = format!("{} tets of {} nodes", mesh.tets.len(), mesh.nodes.len());
        let solid = Solid::new(1.0e6, 0.3, 1000.0).law(SolidLaw::NeoHookean);
        let mut deformables = DeformableWorld::default();
        let cube = DeformableBuilder::tets(mesh, solid.damping(70.0, 1e-3)).friction(0.0);
        let cube = deformables.insert(cube).unwrap();
        let mut world = weightless(1.0 / 240.0);
        let [low, high] = [-1.0, 1.0].map(|side: f32| {
            let plate = RigidBodyBuilder::kinematic_position_based()
                .translation(Vector::new(side, 0.0, 0.0));
            world.insert(plate, ColliderBuilder::cuboid(0.5, 2.0, 2.0).friction(0.0))
        });
        let steps = 120;
        for step in 0..2 * steps {
            let closed = (step as f32 / steps as f32).min(1.0);
            for (side, (plate, _)) in [(-1.0, low), (1.0, high)] {
                let at = Vector::new(side * (1.0 - 0.25 * closed), 0.0, 0.0);
                world.bodies[plate].set_next_kinematic_translation(at);
            }
            deformables.step(&mut world);
        }
        let (lo, hi) = deformables[cube].bounds();
        let size = hi - lo;
        let force = deformables.contact_force(cube, high.1).unwrap().x;
        close(
            &format!("{what}, size {size}, P/E"),
            force / 1.0e6,
            -0.935352,
            1e-3,
        );
        close(&format!("{what}, side"), size.y, 1.210767, 1e-3);
        close(&format!("{what}, side"), size.z, 1.210767, 1e-3);
    }
}

/// What a uniform traction of `pull` Pa along x on the two ends gives each node \[N\]. On a linear face each corner has a
/// third of it, on a quadratic one each middle node, which are the corners of the last of its four triangles.
fn pull_ends(mesh: &TetMesh, pull: f64) -> Vec<f64> {
    let mut forces = vec![0.0; mesh.nodes.len()];
    let per_face = match mesh.tets {
        Tets::Linear(_) => 1,
        Tets::Quadratic(_) => 4,
    };
    let place = |n: u32| mesh.nodes[n as usize];
    for face in mesh.faces.chunks_exact(per_face) {
        let area =
            |[a, b, c]: &[u32; 3]| 0.5 * (place(*b) - place(*a)).cross(place(*c) - place(*a)).x;
        let end = |n: &u32| place(*n).x.abs() > 0.499;
        if !face.iter().flatten().all(end) {
            continue;
        }
        // Its x is positive where the face looks that way, 0 on a side.
        let area: f64 = face.iter().map(area).sum();
        for &node in &face[per_face - 1] {
            forces[node as usize] += pull * area / 3.0;
        }
    }
    forces
}

/// V20: a free cube pulled by dead loads on two faces takes up the stretch that belongs to them.
#[test]
fn v20_pulled_by_dead_loads() {
    for mesh in cubes() {
        let what = format!("{} tets of {} nodes", mesh.tets.len(), mesh.nodes.len());
        let solid = Solid::new(1.0e6, 0.3, 1000.0).law(SolidLaw::NeoHookean);
        let body = DeformableBuilder::tets(mesh.clone(), solid.damping(15.0, 1e-3));
        let mut deformables = DeformableWorld::default();
        let cube = deformables.insert(body).unwrap();
        for (node, force) in (0..).zip(pull_ends(&mesh, 0.378280e6)) {
            let force = Vector::new(force as f32, 0.0, 0.0);
            assert!(deformables[cube].set_node_force(NodeId(node), force));
        }
        let mut world = weightless(1.0 / 60.0);
        for _ in 0..120 {
            deformables.step(&mut world);
        }
        let (lo, hi) = deformables[cube].bounds();
        close(&format!("{what}, stretch"), hi.x - lo.x, 1.5, 1e-3);
        close(&format!("{what}, side"), hi.y - lo.y, 0.880175, 1e-3);
        close(&format!("{what}, side"), hi.z - lo.z, 0.880175, 1e-3);
    }
}
