//! What shadows receive, against what nodes are given.

use super::*;
use crate::body::Material;
use crate::body::shape::lattice;
use crate::world::{DeformableBuilder, Substep};
use rapier3d::prelude::*;

#[derive(Default)]
struct Given(Vec<(ColliderHandle, DVec3)>);

impl Observer for Given {
    fn substep(&mut self, s: &Substep) {
        for n in s.node_impulses {
            if let Partner::Collider(c) = n.partner {
                self.0.push((c, n.impulse));
            }
        }
    }

    fn wants_node_impulses(&self) -> bool {
        true
    }
}

/// Tumbling bodies of two colliders each, with their centres of mass aside, two of them jointed, fall on a block: in
/// every Rapier step each shadow has received what the nodes were given, to the last bits.
#[test]
fn shadows_receive_what_nodes_are_given() {
    let mut world = PhysicsWorld::default();
    world.integration_parameters.dt = 1.0 / 240.0;
    let bodies = [-0.3, 0.0, 0.3].map(|x| {
        let at = RigidBodyBuilder::dynamic()
            .translation(Vector::new(x, 0.5, 0.05))
            .linvel(Vector::new(0.3, -4.0, 0.2))
            .angvel(Vector::new(3.0, -2.0, 6.0 + x));
        let cuboid = ColliderBuilder::cuboid(0.08, 0.1, 0.05).density(900.0);
        let (body, _) = world.insert(at, cuboid);
        let ball = ColliderBuilder::ball(0.07).translation(Vector::new(0.05, -0.1, 0.02));
        world.insert_collider(ball.density(300.0), Some(body));
        body
    });
    let joint = SphericalJointBuilder::new()
        .local_anchor1(Vector::X * 0.15)
        .local_anchor2(Vector::X * -0.15);
    world.insert_impulse_joint(bodies[0], bodies[1], joint);
    let mut set = DeformableWorld::new();
    let block = DeformableBuilder::new(lattice(Vector::new(1.0, 0.4, 0.4), 0.1))
        .material(Material::elastic(3.0e5, 300.0).viscosity(300.0));
    set.insert(block).expect("a sound block");
    let mut met = [0; 3];
    for _ in 0..120 {
        let mut given = Given::default();
        set.before_step(&mut RapierParts::from(&mut world), &mut given);
        for waiting in &set.waiting {
            let own =
                |c: &ColliderHandle| world.colliders[*c].parent() == Some(waiting.touched.body);
            let nodes = given.0.iter().filter(|(c, _)| own(c)).map(|(_, j)| *j);
            let size: f64 = nodes.clone().map(DVec3::length).sum();
            let error = (nodes.sum::<DVec3>() + waiting.end.impulse).length();
            assert!(error <= 1e-12 * size, "off by {error} of {size} N·s");
            let i = bodies.iter().position(|b| *b == waiting.touched.body);
            met[i.expect("one of them")] += u32::from(size > 0.0);
        }
        world.step();
        set.after_step(&mut RapierParts::from(&mut world));
    }
    assert!(met.iter().all(|n| *n > 3), "all must touch: {met:?}");
}
