//! The books of what breaks.

use crate::fixtures::floored;
use crate::support::weightless;
use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

fn broken(body: &Deformable) -> usize {
    let springs = (0..body.spring_count() as u32).map(SpringId);
    springs.filter(|s| body.is_broken(*s) == Some(true)).count()
}

/// Two masses that fly apart until what joins them breaks. With one substep per frame it does at once, and nothing is lost.
#[test]
fn a_spring_that_breaks_takes_what_it_held() {
    for substeps in [1, 4, 16, 64] {
        let mut world = weightless(1.0 / 60.0);
        let ends = vec![Node::new(Vector::ZERO, 1.0), Node::new(Vector::X, 1.0)];
        let net = Net::new(ends, vec![Spring::new(0, 1, 1000.0).breaking(20.0)]);
        let pair = DeformableBuilder::new(net).substeps(Substeps::Fixed(substeps));
        let mut set = DeformableWorld::default();
        let pair = set.insert(pair).unwrap();
        let body = set.get_mut(pair).unwrap();
        for (node, v) in [(0, -2.5), (1, 2.5)] {
            assert!(body.set_linvel_of(NodeId(node), Vector::X * v));
        }
        let start = set[pair].energies();
        (0..10).for_each(|_| set.step(&mut world));
        let end = set[pair].energies();
        assert_eq!(broken(&set[pair]), 1);
        let off = end.balance() - start.balance();
        assert!(off.abs() < 1e-5 * start.kinetic, "{substeps}: {off} J");
        // With T = 20 N it holds 0.2 J.
        let lost = end.work.fracture;
        assert!(substeps < 64 || (lost - 0.2).abs() < 0.02, "{lost} J");
    }
}

/// A block of which most springs break, some of them plastic ones. In so hard a blow the default substep is good for a per cent,
/// whether anything breaks or not.
#[test]
fn the_books_of_a_block_that_bursts_close() {
    for (speed, yields) in [(5.0, false), (5.0, true), (10.0, false)] {
        let (mut world, _) = floored(1.0 / 60.0);
        let mut material = Material::elastic(1e6, 300.0).viscosity(200.0);
        material.strength = 2e4;
        if yields {
            (material.yield_tension, material.yield_compression) = (1.5e4, 1.5e4);
            material.hardening = 2e5;
        }
        let block = DeformableBuilder::new(lattice(Vector::splat(0.3), 0.06))
            .material(material)
            .rotation(Rotation::from_scaled_axis(Vector::new(0.5, 0.3, 0.2)))
            .translation(Vector::Y * 0.3)
            .linvel(Vector::Y * -speed);
        let mut set = DeformableWorld::default();
        let block = set.insert(block).unwrap();
        let start = set[block].energies();
        for _ in 0..30 {
            set.step(&mut world);
            let off = set[block].energies().balance() - start.balance();
            assert!(off.abs() < 0.015 * start.kinetic, "{speed} m/s: {off} J");
        }
        assert!(broken(&set[block]) > 100);
    }
}
