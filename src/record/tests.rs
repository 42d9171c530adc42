//! The channel filters against the numbers of the standard and the closed form of their gain.

use super::*;
use approx::assert_abs_diff_eq;
use std::f64::consts::PI;

const DT: f64 = 1.0e-4;

#[test]
fn coefficients_are_those_of_the_standard() {
    let c = Cfc::Cfc60.coefficients(DT).unwrap();
    for (value, expected) in [
        (c.a0, 0.001452367),
        (c.b1, 1.889343224),
        (c.b2, -0.895152694),
    ] {
        assert_abs_diff_eq!(value, expected, epsilon = 1.0e-9);
    }
    let c = Cfc::Cfc1000.coefficients(DT).unwrap();
    for (value, expected) in [
        (c.a0, 0.219231417),
        (c.b1, 0.311896545),
        (c.b2, -0.188822214),
    ] {
        assert_abs_diff_eq!(value, expected, epsilon = 1.0e-9);
    }
    for class in Cfc::ALL {
        let c = class.coefficients(1.0e-5).unwrap();
        assert_abs_diff_eq!(
            (c.a0 + c.a1 + c.a2) / (1.0 - c.b1 - c.b2),
            1.0,
            epsilon = 1.0e-9
        );
    }
}

/// Amplitude in the middle of a long filtered sine, by projection on sine and cosine over whole periods.
fn gain(class: Cfc, hertz: f64) -> f64 {
    let n = 40_000;
    let phase = |i: usize| 2.0 * PI * hertz * i as f64 * DT;
    let x: Vec<f64> = (0..n).map(|i| phase(i).sin()).collect();
    let y = class.filter(DT, &x).unwrap();
    let whole = ((20_000.0 * DT * hertz).floor() / (hertz * DT)).round() as usize;
    let (mut s, mut c) = (0.0, 0.0);
    for (i, y) in y.iter().enumerate().skip(10_000).take(whole) {
        s += y * phase(i).sin();
        c += y * phase(i).cos();
    }
    assert!(c.abs() < 1.0e-3 * s.abs(), "{c} of {s} is out of phase");
    2.0 * s / whole as f64
}

#[test]
fn three_decibels_are_lost_at_the_cutoff() {
    assert_abs_diff_eq!(gain(Cfc::Cfc60, 100.02), 0.5_f64.sqrt(), epsilon = 2.0e-4);
    let half = PI * 60.0 * 2.0775 * DT;
    for hertz in [10.0, 60.0, 250.0, 1000.0] {
        let expected = 1.0 / (1.0 + ((PI * hertz * DT).tan() / half.tan()).powi(4));
        assert_abs_diff_eq!(gain(Cfc::Cfc60, hertz), expected, epsilon = 1.0e-6);
    }
}

#[test]
fn a_constant_stays_and_a_ramp_keeps_its_ends() {
    for n in [1, 2, 3, 10, 1000] {
        for class in Cfc::ALL {
            for y in class.filter(DT, &vec![3.5e5; n]).unwrap() {
                assert_abs_diff_eq!(y, 3.5e5, epsilon = 1.0e-6);
            }
        }
    }
    let ramp: Vec<f64> = (0..2000).map(|i| f64::from(i) * DT).collect();
    let y = Cfc::Cfc60.filter(DT, &ramp).unwrap();
    assert_abs_diff_eq!(y[0], 0.0, epsilon = 1.0e-6);
    assert_abs_diff_eq!(y[1999], ramp[1999], epsilon = 1.0e-6);
}

#[test]
fn a_symmetric_pulse_stays_symmetric() {
    let x: Vec<f64> = (0..2001)
        .map(|i| f64::max(0.0, 1.0 - (f64::from(i) - 1000.0).abs() / 60.0))
        .collect();
    for class in Cfc::ALL {
        let y = class.filter(DT, &x).unwrap();
        for i in 0..1000 {
            assert_abs_diff_eq!(y[i], y[2000 - i], epsilon = 1.0e-10);
        }
    }
}

#[test]
fn what_is_wrong_is_named() {
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            Cfc::Cfc60.filter(dt, &[]),
            Err(FilterError::Step { .. })
        ));
    }
    assert!(matches!(
        Cfc::Cfc60.filter(2.0e-3, &[]),
        Err(FilterError::Rate { class: 60, .. })
    ));
    assert!(Cfc::Cfc60.coefficients(1.0 / 600.0).is_ok());
    let error = Cfc::Cfc60.filter(DT, &[0.0, 1.0, f64::NAN]).unwrap_err();
    assert!(
        matches!(error, FilterError::Sample { index: 2, .. }),
        "{error}"
    );
    assert_eq!(Cfc::Cfc60.filter(DT, &[]).unwrap(), Vec::<f64>::new());
}
