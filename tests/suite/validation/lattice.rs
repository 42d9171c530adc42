//! The lattice in a true equilibrium.

use crate::support::{close, weightless};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape;

/// V11: uniaxial tension by end forces, relaxed to rest.
#[test]
fn v11_tension_of_a_lattice() {
    for (size, cells) in [
        (Vector::new(0.3, 0.1, 0.1), 1),
        (Vector::new(0.6, 0.2, 0.2), 2),
        (Vector::new(0.8, 0.4, 0.4), 4),
    ] {
        let (young, strain) = (1.0e6, 3e-4);
        let net = shape::lattice(size, 0.1).unwrap();
        let mut world = weightless(1.0 / 60.0);
        let mut deformables = DeformableWorld::default();
        let handle = deformables
            .insert(
                DeformableBuilder::new(net.clone())
                    .material(Material::elastic(young, 1000.0))
                    .drag(100.0),
            )
            .unwrap();
        let on = |x: f32, half: f32| (x.abs() - 0.5 * half).abs() < 1e-4;
        for (i, node) in net.nodes.iter().enumerate() {
            let p = node.position;
            if on(p.x, size.x) {
                let share = if on(p.y, size.y) { 0.5 } else { 1.0 }
                    * if on(p.z, size.z) { 0.5 } else { 1.0 };
                let force = share * young * strain * 0.01 * p.x.signum();
                deformables[handle].set_node_force(NodeId(i as u32), Vector::new(force, 0.0, 0.0));
            }
        }
        for _ in 0..120 {
            deformables.step(&mut world);
        }
        let body = &deformables[handle];
        let fastest = body.velocities().map(|v| v.length()).fold(0.0, f32::max);
        // What is left is the rounding of f32: 1e-7 of .1 m at the lattice's frequencies.
        assert!(fastest < 1e-4, "still moving at {fastest} m/s");
        // Mean strain along an axis, from the displacements of its two ends.
        let mean = |axis: usize| {
            let (mut sum, mut count) = (0.0, 0.0);
            for (i, node) in net.nodes.iter().enumerate() {
                if on(node.position[axis], size[axis]) {
                    let moved = body.position(NodeId(i as u32)).unwrap()[axis]
                        - f64::from(node.position[axis]);
                    sum += moved * f64::from(node.position[axis].signum());
                    count += 1.0;
                }
            }
            2.0 * sum / count / f64::from(size[axis])
        };
        let (along, y, z) = (mean(0), mean(1), mean(2));
        let measured = f64::from(strain * young) / along;
        let poisson = -0.5 * (y + z) / along;
        close(
            &format!("E on {cells}×{cells} cells"),
            measured,
            young.into(),
            2e-3,
        );
        close(&format!("ν on {cells}×{cells} cells"), poisson, 0.25, 2e-3);
    }
}
