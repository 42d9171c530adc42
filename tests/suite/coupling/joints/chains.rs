//! Chains of rigid links with a block welded to their end, that is heavier than all of them.

use super::G;
use crate::coupling::{Mode, cuboid};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario::survey::mechanical_energy;

/// Length of a link [m].
const LINK: f32 = 0.3;

/// Lets a chain of links of such masses \[kg\], on hinges with limits if there are any, go horizontally with a block of 4 kg at its
/// end, and says by how much its energy rises at most, in that of the swing, and how far the block's nearest node gets in 2 s, in
/// lengths of the chain.
fn swing(masses: &[f32], limit: Option<f32>) -> (f64, f64) {
    let mut world = PhysicsWorld::default();
    let apart = InteractionGroups::none();
    let mut last = world.insert_body(RigidBodyBuilder::fixed());
    for (i, &mass) in masses.iter().enumerate() {
        let at = Vector::X * LINK * (i as f32 + 0.5);
        let link = RigidBodyBuilder::dynamic().translation(at).can_sleep(false);
        let shape = cuboid([0.1, 0.02, 0.02], mass).collision_groups(apart);
        let (link, _) = world.insert(link, shape);
        let half = Vector::X * 0.5 * LINK;
        let mut hinge = RevoluteJointBuilder::new(Vector::Z)
            .local_anchor1(if i == 0 { Vector::ZERO } else { half })
            .local_anchor2(-half);
        if let Some(limit) = limit {
            hinge = hinge.limits([-limit, limit]);
        }
        world.insert_impulse_joint(last, link, hinge);
        last = link;
    }
    let mut set = Mode::Shipped.deformables();
    let length = LINK * masses.len() as f32;
    let block = DeformableBuilder::new(lattice(Vector::splat(0.2), 0.1))
        .material(Material::elastic(1.0e6, 500.0).viscosity(1.0e3))
        .translation(Vector::X * (length + 0.05))
        .can_sleep(false);
    let block = set.insert(block).unwrap();
    let near = |n: &NodeId| set[block].position(*n).unwrap().x < f64::from(length) - 0.049;
    let nodes = (0..set[block].node_count() as u32).map(NodeId);
    let nodes: Vec<_> = nodes.filter(near).collect();
    let weld = Attachment::weld(nodes);
    set.attach(block, weld, last, &world.bodies).unwrap();
    let start = mechanical_energy(&world, &set);
    let (mut rise, mut far) = (0.0_f64, 0.0_f64);
    for _ in 0..120 {
        set.step(&mut world);
        rise = rise.max(mechanical_energy(&world, &set) - start);
        let nodes = set[block].positions();
        let nearest = nodes.map(|p| p.as_dvec3().length());
        far = far.max(nearest.fold(f64::INFINITY, f64::min));
    }
    let links: f32 = masses.iter().sum();
    let depth = G * f64::from((4.0 + links) * length);
    (rise / depth, far / f64::from(length))
}

/// Rapier's step answers limits of joints when they are passed, for the links alone: led by these, the block made 100 kJ of a swing
/// of 61 J, and 177 J of 36 J on links of 10 g without limits.
#[test]
fn a_heavy_block_on_a_light_chain_gains_nothing() {
    let cases = [
        (&[0.96; 3][..], Some(1.0), 2e-3),
        (&[0.96; 2], Some(1.0), 2e-3),
        (&[0.3; 3], Some(1.0), 2e-3),
        (&[0.03; 3], Some(0.3), 2e-3),
        (&[0.96; 3], None, 2e-3),
        (&[0.01; 3], None, 2e-3),
        (&[0.1, 5.7, 0.25], Some(1.0), 2e-3),
        // What swings past opens its joints by up to a centimetre, which takes up work and gives it back as they are closed.
        (&[1.2, 0.1, 1.7, 12.0], None, 2e-2),
    ];
    for (masses, limit, most) in cases {
        let (rise, far) = swing(masses, limit);
        let what = format!("links of {masses:?} kg, {limit:?}");
        assert!(rise < most, "{what}: {rise} of the swing");
        assert!((0.5..1.03).contains(&far), "{what}: {far} of its length");
    }
}
