//! A mass on one plastic spring.

use crate::support::{close, weightless};
use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// V36: elastic–perfectly plastic spring of 1 m.
#[test]
fn v36_elastic_plastic_car() {
    let net = Net::new(
        vec![
            Node::new(Vector::ZERO, 1500.0),
            Node::new(Vector::new(1.0, 0.0, 0.0), 1.0).pinned(),
        ],
        vec![Spring::new(0, 1, 5.0e6).yielding(294_300.0, 0.0)],
    );
    let mut world = weightless(1e-4);
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = 1e-4;
    let car = deformables
        .insert(
            DeformableBuilder::new(net)
                .linvel(Vector::new(15.6464, 0.0, 0.0))
                .substeps(Substeps::Fixed(20)),
        )
        .unwrap();
    let (mut crush, mut time_of_crush, mut plateau, mut rebound) = (0.0_f64, 0.0, 0.0_f64, None);
    for _ in 0..2000 {
        deformables.step(&mut world);
        let body = &deformables[car];
        let x = body.position(NodeId(0)).unwrap().x;
        let tension = body.tension(SpringId(0)).unwrap();
        plateau = plateau.max(-tension / 1500.0 / 9.81);
        if x > crush {
            (crush, time_of_crush) = (x, deformables.time());
        }
        if rebound.is_none() && x < crush && tension >= 0.0 {
            rebound = Some((-body.linvel_of(NodeId(0)).unwrap().x, x, body.energies()));
        }
    }
    let (rebound, set, energies) = rebound.expect("the car must come off");
    close("crush [m]", crush, 0.653308, 1e-3);
    close("permanent set [m]", set, 0.594448, 1e-3);
    close("rebound [m/s]", rebound, 3.398284, 1e-3);
    close("plastic work [J]", energies.work.plastic, 174_946.0, 1e-3);
    close("time of crush [s]", time_of_crush, 0.081636, 1e-3);
    close("plateau [g]", plateau, 20.0, 1e-3);
    let initial = 0.5 * 1500.0 * 15.6464_f64.powi(2);
    close("energy balance", energies.balance(), initial, 1e-3);
}
