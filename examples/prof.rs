use crumple::body::Blueprint;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::solve::Solver;
use std::time::Instant;
fn main() {
    let net = lattice(Vector::splat(1.0), 1.0 / 19.0).unwrap();
    for (name, m) in [
        ("elastic", Material::elastic(1e6, 100.0)),
        ("damped", Material::elastic(1e6, 100.0).viscosity(100.0)),
        ("plastic", Material::elastic(1e6, 100.0).yielding(1e4, 0.0)),
        (
            "all",
            Material::elastic(1e6, 100.0)
                .viscosity(100.0)
                .yielding(1e4, 0.0),
        ),
    ] {
        let b = Blueprint::resolve(net.clone(), |_| Some(m), None).unwrap();
        let mut st = b.rest_state();
        let mut s = Solver::new(&b.springs, &st);
        let t = Instant::now();
        let n = 400;
        for _ in 0..n {
            s.substep(&mut st, Integrator::SymplecticEuler, 1e-5);
        }
        let e = t.elapsed().as_secs_f64();
        println!(
            "{name} {} springs {:.1} us/substep {:.1} M/s",
            b.springs.len(),
            e / n as f64 * 1e6,
            b.springs.len() as f64 * n as f64 / e / 1e6
        );
        let t = Instant::now();
        for _ in 0..20 {
            std::hint::black_box(s.stable_step(&st, Integrator::SymplecticEuler));
        }
        println!("stable {:.1} us", t.elapsed().as_secs_f64() / 20.0 * 1e6);
    }
}
