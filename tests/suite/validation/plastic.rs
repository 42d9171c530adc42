//! Plastic flow that takes its time.

use crate::support::{close, weightless};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// A rope of E = 100 MPa that yields at 1 MPa and hardens by 10 MPa, drawn by a twentieth within 2 s. However short the substeps, in
/// which it flows by less than the last digit of its length, p = (E·ε − σ)/(E + H), and the tension is A·(σ + H·p).
#[test]
fn slow_flow_is_that_of_the_law_in_any_substep() {
    const AREA: f64 = 1e-4;
    let material = Material::elastic(1e8, 1000.0).yielding(1e6, 1e7);
    for (springs, substeps) in [(1, 50), (1, 8000), (8, 2000)] {
        let mut world = weightless(1.0 / 60.0);
        let mut deformables = DeformableWorld::default();
        let rope = rope(Vector::ZERO, Vector::X, springs, AREA as f32);
        let body = DeformableBuilder::new(rope)
            .material(material.viscosity(3e4))
            .pin(|x| x.x < 1e-4 || x.x > 0.9999)
            .substeps(Substeps::Fixed(substeps));
        let handle = deformables.insert(body).unwrap();
        let frames = 120;
        for i in 1..=frames {
            let end = Vector::X * (1.0 + 0.05 * i as f32 / frames as f32);
            deformables[handle].set_kinematic_target(NodeId(springs as u32), end);
            deformables.step(&mut world);
        }
        let body = &deformables[handle];
        let p = (1e8 * 0.05 - 1e6) / (1e8 + 1e7);
        let name = format!("{springs} springs, {substeps} substeps");
        let tension = body.tension(SpringId(0)).unwrap();
        let law = AREA * (1e6 + 1e7 * p);
        close(&format!("tension [N], {name}"), tension, law, 1e-4);
        let energies = body.energies();
        let law = AREA * p * (1e6 + 0.5e7 * p);
        close(
            &format!("plastic work [J], {name}"),
            energies.work.plastic,
            law,
            1e-4,
        );
        let share = energies.balance() / energies.work.external;
        assert!(share.abs() < 1e-4, "balance of {share:e}, {name}");
    }
}
