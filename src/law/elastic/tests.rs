use super::tensor::*;
use super::*;

const LAME: (f64, f64) = (1.0e6, 0.3);

fn off(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    let d = sub(a, b);
    contract(&d, &d).sqrt()
}

/// Moderate, strongly compressed, inverted, nearly flat.
fn gradients() -> Vec<Mat<f64>> {
    let base = [[1.2, 0.3, -0.4], [0.1, 0.8, 0.5], [-0.7, 0.2, 1.5]];
    let mut flat = base;
    flat[0] = flat[0].map(|x| 0.04 * x);
    let mut inverted = base;
    inverted[1] = inverted[1].map(|x| -0.6 * x);
    vec![
        unit(),
        base,
        scale(&base, 0.55),
        flat,
        inverted,
        scale(&base, 2.0),
    ]
}

/// ∂P/∂F as a 9×9 matrix of rows, entry F\[i\]\[j\] at 3i + j \[Pa\]; symmetric.
fn tangent<L: Elastic<f64>>(law: &L, f: &Mat<f64>) -> [[f64; 9]; 9] {
    let mut matrix = [[0.0; 9]; 9];
    for column in 0..9 {
        let mut d = zero();
        d[column / 3][column % 3] = 1.0;
        let change = law.differential(f, &d);
        for (row, entries) in matrix.iter_mut().enumerate() {
            entries[column] = change[row / 3][row % 3];
        }
    }
    matrix
}

fn turn() -> Mat<f64> {
    polar::rotation(&[[0.2, -1.3, 0.4], [0.9, 0.3, 0.7], [-0.5, 0.1, 0.8]])
}

fn check_law<L: Elastic<f64>>(name: &str, law: L) {
    let d = [[0.3, -0.1, 0.7], [0.2, 0.9, -0.3], [0.1, 0.4, -0.6]];
    let q = turn();
    assert!(law.energy(&unit()).abs() < 1e-9 * LAME.0, "{name}: at rest");
    assert!(
        off(&law.stress(&q), &zero()) < 1e-9 * LAME.0,
        "{name}: turned"
    );
    assert!(law.energy(&q).abs() < 1e-9 * LAME.0, "{name}: turned");
    for f in gradients() {
        let e = 1e-6;
        let (plus, minus) = (add_scaled(&f, e, &d), add_scaled(&f, -e, &d));
        let p = law.stress(&f);
        let size = contract(&p, &p).sqrt() + LAME.0;
        let slope = (law.energy(&plus) - law.energy(&minus)) / (2.0 * e);
        assert!(
            (slope - contract(&p, &d)).abs() < 1e-6 * size,
            "{name}: stress at {f:?}"
        );
        let slope = scale(&sub(&law.stress(&plus), &law.stress(&minus)), 0.5 / e);
        let change = law.differential(&f, &d);
        let size = contract(&change, &change).sqrt();
        assert!(
            off(&slope, &change) < 1e-6 * size,
            "{name}: tangent at {f:?}"
        );
        let matrix = tangent(&law, &f);
        for i in 0..9 {
            let row: f64 = (0..9).map(|j| matrix[i][j] * d[j / 3][j % 3]).sum();
            assert!((row - change[i / 3][i % 3]).abs() < 1e-9 * size, "{name}");
            for (j, column) in matrix.iter().enumerate() {
                assert!(
                    (matrix[i][j] - column[i]).abs() < 1e-9 * size,
                    "{name}: symmetry"
                );
            }
        }
        let bound = law.majorant(&f);
        for k in 0..200 {
            let d = from_fn(|i, j| (f64::from(k * 9 + 1) * (3 * i + j + 1) as f64 * 0.7).sin());
            let exact = contract(&law.differential(&f, &d), &d);
            let most = majorant::value(&bound, &d);
            assert!(
                exact <= most * (1.0 + 1e-9),
                "{name}: {exact} > {most} at {f:?}"
            );
        }
        // Objectivity: W(QF) = W(F), P(QF) = Q·P(F); isotropy: W(FQ) = W(F).
        let size = contract(&p, &p).sqrt() + LAME.0;
        assert!(
            off(&law.stress(&mul(&q, &f)), &mul(&q, &p)) < 1e-9 * size,
            "{name}"
        );
        assert!(
            (law.energy(&mul(&f, &q)) - law.energy(&f)).abs() < 1e-9 * size,
            "{name}"
        );
    }
}

#[test]
fn stresses_and_tangents_are_derivatives_and_turn_with_the_body() {
    let lame = Lame::new(LAME.0, LAME.1);
    check_law("corotational", Corotational(lame));
    check_law("neo-Hookean", NeoHookean(lame));
    check_law("stable neo-Hookean", StableNeoHookean::new(lame));
    check_law("St. Venant-Kirchhoff", StVenantKirchhoff(lame));
}

/// λ tr ε I + 2μ ε for a small strain.
fn check_linear<L: Elastic<f64>>(name: &str, young: f64, poisson: f64, law: L) {
    let lame = Lame::<f64>::new(young, poisson);
    let e = [[3.0, 1.0, -2.0], [1.0, -1.0, 0.5], [-2.0, 0.5, 2.0]];
    let expected = add_scaled(&scale(&e, 2.0 * lame.mu), lame.lambda * trace(&e), &unit());
    let found = law.differential(&unit(), &e);
    assert!(
        off(&found, &expected) < 1e-9 * young,
        "{name} at ν = {poisson}"
    );
}

#[test]
fn all_laws_have_the_same_small_strains() {
    for poisson in [-0.9, -0.3, 0.0, 0.25, 0.4999] {
        let lame = Lame::new(1.0e6, poisson);
        check_linear("corotational", 1.0e6, poisson, Corotational(lame));
        check_linear("neo-Hookean", 1.0e6, poisson, NeoHookean(lame));
        check_linear(
            "stable neo-Hookean",
            1.0e6,
            poisson,
            StableNeoHookean::new(lame),
        );
        check_linear(
            "St. Venant-Kirchhoff",
            1.0e6,
            poisson,
            StVenantKirchhoff(lame),
        );
    }
}

/// V20: uniaxial stretch with free sides.
#[test]
fn v20_uniaxial_neo_hookean() {
    let law = NeoHookean(Lame::new(1.0e6, 0.3));
    for (stretch, side, stress) in [(0.5, 1.210767, -0.935352), (1.5, 0.880175, 0.378280)] {
        let (mut b, at) = (1.0, |b: f64| {
            law.stress(&[[stretch, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, b]])
        });
        for _ in 0..50 {
            let slope = (at(b + 1e-6)[1][1] - at(b - 1e-6)[1][1]) / 2e-6;
            b -= at(b)[1][1] / slope;
        }
        let found = at(b)[0][0] / 1.0e6;
        assert!(
            (b / side - 1.0).abs() < 1e-6,
            "λ = {stretch}: b = {b}, expected {side}"
        );
        assert!(
            (found / stress - 1.0).abs() < 1e-5,
            "λ = {stretch}: P/E = {found}, expected {stress}"
        );
    }
}

#[test]
fn inverted_elements_are_pushed_back_with_a_finite_force() {
    let lame = Lame::new(1.0e6, 0.3);
    let squeezed = |x: f64| [[x, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let laws: [&dyn Fn(f64) -> f64; 3] = [
        &|x| Corotational(lame).stress(&squeezed(x))[0][0],
        &|x| NeoHookean(lame).stress(&squeezed(x))[0][0],
        &|x| StableNeoHookean::new(lame).stress(&squeezed(x))[0][0],
    ];
    for (i, law) in laws.iter().enumerate() {
        for x in [-0.9, -0.5, -1e-3, 0.0, 1e-3, 0.1, 0.5] {
            let p = law(x);
            assert!(
                p.is_finite() && p < -1e4,
                "law {i}: P = {p} at a stretch of {x}"
            );
        }
    }
}

#[test]
fn damping_is_zero_in_rigid_motion_and_never_gives_energy() {
    let viscous = Viscous::<f64>::proportional(1e-3, Lame::new(1.0e6, -0.4));
    for f in gradients() {
        // Ḟ = [ω]ₓF.
        let spin = mul(&[[0.0, -3.0, 2.0], [3.0, 0.0, -1.0], [-2.0, 1.0, 0.0]], &f);
        assert!(off(&viscous.stress(&f, &spin), &zero()) < 1e-9);
        let rate = [[0.3, -0.1, 0.7], [0.2, 0.9, -0.3], [0.1, 0.4, -0.6]];
        assert!(contract(&viscous.stress(&f, &rate), &rate) > 0.0);
    }
    let rate = [[0.3, 0.1, 0.0], [0.1, -0.2, 0.4], [0.0, 0.4, 0.1]];
    let law = Corotational(Lame::new(1.0e6, -0.4));
    let expected = scale(&law.differential(&unit(), &rate), 1e-3);
    assert!(off(&viscous.stress(&unit(), &rate), &expected) < 1e-9);
}

/// At rest, however turned, the bound is met by a change of volume: 2μ + 3λ per ‖D‖².
#[test]
fn bounds_are_exact_at_rest() {
    let lame = Lame::new(1.0e6, 0.3);
    let q = turn();
    let most = |m: Majorant<f64>| majorant::value(&m, &q) / 3.0;
    let expected = 2.0 * lame.mu + 3.0 * lame.lambda;
    for (found, name) in [
        (most(Corotational(lame).majorant(&q)), "corotational"),
        (most(NeoHookean(lame).majorant(&q)), "neo-Hookean"),
        (
            most(StableNeoHookean::new(lame).majorant(&q)),
            "stable neo-Hookean",
        ),
        (
            most(StVenantKirchhoff(lame).majorant(&q)),
            "St. Venant-Kirchhoff",
        ),
    ] {
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{name}: {found} {expected}"
        );
    }
}
