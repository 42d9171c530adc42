//! Settings after build, borders, and what is attached to what.

use crate::fixtures::{bead, cube, pair};
use crumple::body::BuildError;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

#[test]
fn gravity_and_drag_may_change_in_flight() {
    let mut world = PhysicsWorld::default();
    let mut set = DeformableWorld::new();
    let body = set.insert(bead(2.0)).unwrap();
    assert_eq!((set[body].gravity_scale(), set[body].drag()), (1.0, 0.0));
    assert!(set[body].set_gravity_scale(-2.0));
    for _ in 0..60 {
        set.step(&mut world);
    }
    assert!((set[body].linvel().y - 19.62).abs() < 0.05);
    assert!(set[body].set_gravity_scale(0.0));
    set[body].set_drag(2.0).unwrap();
    assert_eq!((set[body].gravity_scale(), set[body].drag()), (0.0, 2.0));
    let start = set[body].linvel().y;
    for _ in 0..60 {
        set.step(&mut world);
    }
    // v = v₀·exp(−D·t/m).
    let ratio = set[body].linvel().y / start;
    assert!((ratio - (-1.0_f64).exp()).abs() < 0.01, "{ratio}");
    assert!(!set[body].set_gravity_scale(f32::NAN));
    assert!(set[body].set_drag(-1.0).is_err() && set[body].set_drag(f32::NAN).is_err());
    assert_eq!((set[body].gravity_scale(), set[body].drag()), (0.0, 2.0));
}

#[test]
fn schemes_and_substeps_may_change_and_the_balance_stays_closed() {
    let mut world = PhysicsWorld::default();
    let mut set = DeformableWorld::new();
    let body = set.insert(cube(0.6)).unwrap();
    assert!(set[body].set_velocities(Vector::X, Vector::splat(3.0)));
    let start = set[body].energies().balance();
    let schemes = [
        Integrator::VelocityVerlet,
        Integrator::Rk4,
        Integrator::Midpoint,
        Integrator::SymplecticEuler,
    ];
    for scheme in schemes {
        set[body].set_integrator(Some(scheme)).unwrap();
        assert_eq!(set[body].integrator(), scheme);
        for _ in 0..10 {
            set.step(&mut world);
        }
        let now = set[body].energies();
        assert!(
            (now.balance() - start).abs() < 2e-3 * now.scale(),
            "{scheme:?}: {now:?}"
        );
    }
    set[body].set_integrator(None).unwrap();
    assert_eq!(set[body].integrator(), set.params.integrator);
    set[body].set_substeps(Some(Substeps::Fixed(500))).unwrap();
    set.step(&mut world);
    assert_eq!(set[body].substeps(), Substeps::Fixed(500));
    assert!((set[body].substep_length() - 1.0 / 60.0 / 500.0).abs() < 1e-9);
    let refused = set[body].set_substeps(Some(Substeps::Fixed(1)));
    assert!(
        matches!(refused, Err(BuildError::Unstable { .. })),
        "{refused:?}"
    );
    let bad = Substeps::Auto {
        safety: f64::NAN,
        min_h: 0.0,
    };
    assert!(set[body].set_substeps(Some(bad)).is_err());
    assert_eq!(set[body].substeps(), Substeps::Fixed(500));

    // Explicit Euler is stable for no undamped spring.
    let mut net = pair();
    net.springs[0].damping = 0.0;
    let stiff = set.insert(DeformableBuilder::new(net)).unwrap();
    let work = set[stiff].energies();
    let refused = set[stiff].set_integrator(Some(Integrator::ExplicitEuler));
    assert!(
        matches!(refused, Err(BuildError::NeverStable { .. })),
        "{refused:?}"
    );
    assert_eq!(set[stiff].integrator(), set.params.integrator);
    assert_eq!(set[stiff].energies(), work);
}

#[test]
fn borders_are_the_hems_of_sheets() {
    let net = sheet(2.0, 1.0, 5, 4, 0.001).unwrap();
    let border = net.border_nodes();
    assert_eq!(border.len(), 14);
    for (node, place) in (0..).zip(&net.nodes) {
        let outer = place.position.x.abs() > 0.99 || place.position.z.abs() > 0.49;
        assert_eq!(border.contains(&NodeId(node)), outer, "{place:?}");
    }
    let drum = net.pin_border();
    let pinned = drum.nodes.iter().filter(|n| n.pinned).count();
    assert_eq!(pinned, 14);
    let block = lattice(Vector::ONE, 0.25).unwrap();
    assert!(block.border_nodes().is_empty());
    assert!(pair().border_nodes().is_empty());
    let two = pair().pin_nodes([NodeId(1), NodeId(7)]);
    assert_eq!(
        two.nodes.iter().map(|n| n.pinned).collect::<Vec<_>>(),
        [false, true]
    );
}

#[test]
fn attachments_can_be_listed() {
    let mut world = PhysicsWorld::default();
    let (rigid, _) = world.insert(RigidBodyBuilder::dynamic(), ColliderBuilder::ball(0.1));
    let mut set = DeformableWorld::new();
    let block = set.insert(cube(0.6)).unwrap();
    let first = set
        .attach(block, &[NodeId(3)], rigid, &world.bodies)
        .unwrap();
    let nodes = [NodeId(1), NodeId(2)];
    let second = set.attach(block, &nodes, rigid, &world.bodies).unwrap();
    let listed: Vec<_> = set.attachments().map(|(handle, _)| handle).collect();
    assert_eq!(listed, [first, second]);
    let attachment = set.attachment(second).unwrap();
    assert_eq!(
        (attachment.deformable, attachment.body().unwrap()),
        (block, rigid)
    );
    assert_eq!(attachment.nodes.to_vec(), [1, 2]);
    assert!(set.contains_attachment(first) && set.detach(first));
    assert!(!set.contains_attachment(first) && set.attachment(first).is_none());
    assert!(set.contains_attachment(second) && set.attachments().count() == 1);
    assert!(set.remove(block).is_some());
    assert_eq!(set.attachments().count(), 0);
}
