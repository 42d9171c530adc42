//! Frames that differ in length, as those of a game do.

use crate::fixtures::floored;
use crate::support::weightless;
use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape::{TetSplit, tet_box};

struct Dice(u32);

impl Dice {
    fn range(&mut self, least: f32, most: f32) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        least + (most - least) * (self.0 >> 8) as f32 / (1 << 24) as f32
    }
}

/// Two masses on a spring, a rope, a lattice and tets, none of them damped, each node thrown somewhere. Where substeps are as long
/// as is stable every change is a kick: 3,600 frames like the uneven ones here left the pair with 6e38 times its energy, the rope with
/// 8e7, the lattice with 200 times.
#[test]
fn uneven_frames_are_no_pump() {
    let pair = || {
        let ends = vec![Node::new(Vector::ZERO, 1.0), Node::new(Vector::X, 1.0)];
        DeformableBuilder::new(Net::new(ends, vec![Spring::new(0, 1, 2000.0)]))
    };
    let string = rope(Vector::ZERO, Vector::X, 10, 1e-4).unwrap();
    let block = lattice(Vector::splat(0.3), 0.1).unwrap();
    let mesh = tet_box(Vector::new(0.3, 0.1, 0.2), 0.1, TetSplit::Six).unwrap();
    let bodies = [
        ("pair", pair()),
        (
            "rope",
            DeformableBuilder::new(string).material(Material::elastic(1e6, 1000.0)),
        ),
        (
            "lattice",
            DeformableBuilder::new(block).material(Material::elastic(1e5, 300.0)),
        ),
        (
            "tets",
            DeformableBuilder::tets(mesh, Solid::new(1e5, 0.3, 1000.0)),
        ),
    ];
    for (what, body) in bodies {
        for [shortest, longest] in [[0.8 / 60.0, 1.2 / 60.0], [1.0 / 144.0, 1.0 / 30.0]] {
            let (mut world, mut dice) = (weightless(1.0 / 60.0), Dice(1));
            let mut set = DeformableWorld::default();
            let body = set.insert(body.clone()).unwrap();
            for node in (0..set[body].node_count() as u32).map(NodeId) {
                let mut throw = || dice.range(-0.4, 0.4);
                let v = Vector::new(throw(), throw(), throw());
                assert!(set.get_mut(body).unwrap().set_linvel_of(node, v));
            }
            set.step(&mut world);
            let start = set[body].energies();
            let all = start.kinetic + start.elastic;
            for frame in 0..1200 {
                world.integration_parameters.dt = dice.range(shortest, longest);
                set.step(&mut world);
                let made = set[body].energies().balance() - start.balance();
                assert!(made < 0.2 * all, "{what}: {made} of {all} J in {frame}");
            }
        }
    }
}

/// An undamped plate that swings after it has struck a floor, by which its stable substep changes all the time.
#[test]
fn a_plate_that_rings_gains_no_energy() {
    for speed in [4.0, 12.0] {
        let (mut world, _) = floored(1.0 / 60.0);
        let mesh = tet_box(Vector::new(0.3, 0.03, 0.2), 0.1, TetSplit::Six).unwrap();
        let solid = Solid::new(2e6, 0.45, 1000.0).law(SolidLaw::NeoHookean);
        let plate = DeformableBuilder::tets(mesh, solid)
            .rotation(Rotation::from_scaled_axis(Vector::Z * 0.3))
            .translation(Vector::Y * 0.13)
            .linvel(Vector::Y * -speed);
        let mut set = DeformableWorld::default();
        let plate = set.insert(plate).unwrap();
        let start = set[plate].energies();
        for frame in 0..60 {
            set.step(&mut world);
            assert!(!set[plate].is_frozen(), "{speed} m/s, frame {frame}");
            let off = (set[plate].energies().balance() - start.balance()) / start.kinetic;
            assert!(off.abs() < 0.08, "{speed} m/s: {off} in frame {frame}");
        }
    }
}
