//! Hanging cloth.

use crate::support::close;
use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape;

const STEPS: [f32; 3] = [1.0 / 60.0, 1.0 / 240.0, 1.0 / 1000.0];

/// The cloth after `time` s of hanging along +z with drag. `carried` are nodes of the top edge that are free to slide sideways
/// and carried by a force \[N\].
fn hang(net: Net, carried: &[(u32, f32)], (drag, time): (f32, f32), dt: f32) -> Deformable {
    let mut world = PhysicsWorld {
        gravity: Vector::new(0.0, 0.0, 9.81),
        ..PhysicsWorld::default()
    };
    world.integration_parameters.dt = dt;
    let mut deformables = DeformableWorld::default();
    let handle = deformables
        .insert(
            DeformableBuilder::new(net)
                .material(Material::elastic(1.0e5, 200.0))
                .drag(drag),
        )
        .unwrap();
    for &(node, force) in carried {
        deformables[handle].set_node_force(NodeId(node), Vector::new(0.0, 0.0, -force));
    }
    for _ in 0..(time / dt) as usize {
        deformables.step(&mut world);
    }
    deformables.remove(handle).unwrap()
}

/// How far a node of the lower edge, z = .5 m, has sunk \[m\].
fn sunk(body: &Deformable, node: u32) -> f64 {
    body.position(NodeId(node)).unwrap().z - 0.5
}

fn top(p: Vector) -> bool {
    p.z < -0.499
}

/// V24: threads only, E·h = 100 N/m and .2 kg/m²: every column of the cloth is a hanging chain, free to be as narrow as
/// it likes, so the tip sinks by ρgL²/(2Eh) whatever the mesh.
#[test]
fn v24_woven_cloth() {
    let n = 11;
    let a = 0.1;
    let border = |i: usize| if i == 0 || i == n - 1 { 0.5 } else { 1.0 };
    let mut net = Net::default();
    for j in 0..n {
        for i in 0..n {
            let at = Vector::new(a * i as f32 - 0.5, 0.0, a * j as f32 - 0.5);
            net.nodes
                .push(Node::new(at, 0.2 * a * a * border(i) * border(j)));
            let here = (i + n * j) as u32;
            if i + 1 < n {
                net.springs
                    .push(Spring::new(here, here + 1, 100.0 * border(j)));
            }
            if j + 1 < n {
                net.springs
                    .push(Spring::new(here, here + n as u32, 100.0 * border(i)));
            }
        }
    }
    let net = net.pin(top);
    for dt in STEPS {
        let body = hang(net.clone(), &[], (0.1, 1.5), dt);
        for column in [0, 5] {
            let tip = sunk(&body, (column + n * (n - 1)) as u32);
            close(
                &format!("tip of column {column} at dt = {dt} [m]"),
                tip,
                0.00981,
                0.005,
            );
        }
    }
}

/// V24: a strip of `shape::sheet` one cell wide whose top edge may contract. The exact answer of the mesh, by Newton's
/// method in f64 on the energy of its springs, is 9.76773 mm: at strains up to 2 % the diagonals are stiffer than linear.
#[test]
fn v24_strip_of_a_sheet() {
    let net = shape::sheet(0.1, 1.0, 2, 11, 1e-3).unwrap();
    let half = 0.5 * 0.02 * 9.81;
    let mut net = net;
    net.nodes[0].pinned = true;
    for dt in STEPS {
        // The left top corner is held, the right one carried; the little that is left of its swing is averaged out.
        let body = hang(net.clone(), &[(1, half)], (0.007, 4.0), dt);
        let at = |node| body.position(NodeId(node)).unwrap();
        let tip = 0.5 * (at(20).distance(at(0)) + at(21).distance(at(1))) - 1.0;
        close(
            &format!("mesh: tip at dt = {dt} [m]"),
            tip,
            0.009_767_73,
            0.001,
        );
        close(
            &format!("analytic: tip at dt = {dt} [m]"),
            tip,
            0.00981,
            0.005,
        );
    }
}

/// V24: a `shape::sheet` pinned along its whole top edge, which can't contract there; by the same computation the middle
/// of the lower edge sinks by 9.66306 mm and its corners by 9.08307 mm.
#[test]
fn v24_sheet_pinned_along_its_top() {
    let net = shape::sheet(1.0, 1.0, 11, 11, 1e-3).unwrap().pin(top);
    for dt in STEPS {
        let body = hang(net.clone(), &[], (0.1, 1.5), dt);
        let middle = sunk(&body, 115);
        close(
            &format!("middle at dt = {dt} [m]"),
            middle,
            0.009_663_06,
            0.001,
        );
        let corner = sunk(&body, 110);
        close(
            &format!("corner at dt = {dt} [m]"),
            corner,
            0.009_083_07,
            0.001,
        );
    }
}
