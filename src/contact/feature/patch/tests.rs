//! Feet on patches against their weights, distances and normals.

use super::*;

const TWISTED: [DVec3; 4] = [
    DVec3::new(0.0, 0.1, 0.0),
    DVec3::new(0.2, 0.0, 1.2),
    DVec3::new(1.1, 0.2, 0.9),
    DVec3::new(1.0, 0.0, 0.1),
];

#[test]
fn feet_are_where_the_weights_say() {
    let corners = TWISTED;
    for count in [3, 4] {
        let patch = Patch::new(corners[..count].iter().copied());
        let normal = patch.normal().unwrap();
        let mut inside = 0;
        for i in 0..400 {
            let p = DVec3::new(
                f64::from(i % 20) * 0.08 - 0.2,
                0.3,
                f64::from(i / 20) * 0.08 - 0.2,
            );
            let Some(foot) = patch.foot(p) else { continue };
            inside += 1;
            let weighed: DVec3 = corners.iter().zip(foot.weights).map(|(c, w)| *c * w).sum();
            assert!((weighed - foot.point).length() < 1e-9);
            // Straight below the point, along the normal of the middle.
            assert!((p - foot.point).cross(normal).length() < 1e-7, "{p}");
            assert!(foot.normal.dot(normal) > 0.9);
        }
        assert!(inside > 60, "{inside}");
    }
}

#[test]
fn a_ball_touches_along_the_normal() {
    let patch = Patch::new(TWISTED.into_iter());
    let mut inside = 0;
    for i in 0..400 {
        let [x, z] = [i % 20, i / 20].map(|k| 0.08 * f64::from(k) - 0.2);
        let Some(foot) = patch.foot(DVec3::new(x, 0.3, z)) else {
            continue;
        };
        inside += 1;
        for radius in [0.3, -0.3] {
            let ball = patch
                .foot_of_ball(foot.point + foot.normal * radius)
                .unwrap();
            assert!(ball.point.distance(foot.point) < 1e-7);
            assert!(ball.normal.distance(foot.normal) < 1e-7);
        }
    }
    assert!(inside > 60, "{inside}");
}

#[test]
fn no_foot_is_nearer_than_the_distance() {
    let corners = TWISTED;
    for count in [3, 4] {
        let patch = Patch::new(corners[..count].iter().copied());
        let mut feet = 0;
        for i in 0..1000 {
            let [x, y, z] = [i % 10, i / 10 % 10, i / 100].map(|k| 0.2 * f64::from(k) - 0.5);
            let p = DVec3::new(x, y, z);
            let apart = patch.apart(p);
            let corner = patch.corners().iter().map(|c| c.distance(p));
            assert!(apart <= corner.fold(f64::INFINITY, f64::min) + 1e-12);
            if let Some(foot) = patch.foot(p) {
                feet += 1;
                let far = foot.point.distance(p);
                assert!(apart <= far + 1e-12, "{apart} {far}");
                assert!(count == 4 || apart > far - 1e-12, "{apart} {far}");
            }
        }
        assert!(feet > 100, "{feet}");
    }
}

#[test]
fn a_foot_on_the_border_is_the_nearest_place_of_it() {
    let corners = [DVec3::ZERO, DVec3::Z, DVec3::new(1.0, 0.0, 1.0), DVec3::X];
    for count in [3, 4] {
        let patch = Patch::new(corners[..count].iter().copied());
        // Beside the side from the first corner to the second.
        let under = DVec3::new(-0.02, -0.03, 0.4);
        assert!(patch.foot(under).is_none());
        let foot = patch.foot_on_border(under).unwrap();
        assert!(foot.point.distance(DVec3::Z * 0.4) < 1e-12);
        assert!((foot.weights[0] - 0.6).abs() < 1e-12 && (foot.weights[1] - 0.4).abs() < 1e-12);
        let within = patch.foot_on_border(DVec3::new(0.04, 0.5, 0.6)).unwrap();
        assert!(within.point.distance(DVec3::Z * 0.6) < 1e-12);
        // Beyond a corner.
        let beyond = patch
            .foot_on_border(DVec3::new(-0.01, 0.05, -0.01))
            .unwrap();
        assert_eq!(beyond.point, DVec3::ZERO);
    }
}

#[test]
fn normals_are_those_of_feet() {
    let patch = Patch::new(TWISTED.into_iter());
    let n = patch.normal().unwrap();
    let mut feet = 0;
    for i in 0..400 {
        let [x, z] = [i % 20, i / 20].map(|k| 0.08 * f64::from(k) - 0.2);
        let p = DVec3::new(x, 0.3, z);
        for side in [n, -n] {
            let below = patch.normal_below(p, side, &mut [0.5; 2]);
            let foot = patch.foot(p);
            assert_eq!(below.is_some(), foot.is_some(), "{p}");
            if let (Some(below), Some(foot)) = (below, foot) {
                feet += 1;
                let of_foot = foot.normal * 1.0_f64.copysign(foot.normal.dot(side));
                assert!(below.distance(of_foot) < 1e-4, "{below} {of_foot}");
            }
        }
    }
    assert!(feet > 100, "{feet}");
}

#[test]
fn what_is_behind_a_patch_is_seen_through_it() {
    let corners = [DVec3::ZERO, DVec3::Z, DVec3::new(1.0, 0.0, 1.0), DVec3::X];
    let patch = Patch::new(corners.into_iter());
    let under = DVec3::new(0.9, -0.01, 0.5);
    assert!(patch.is_between(under, DVec3::new(0.9, 1.0, 0.5)));
    assert!(patch.is_between(under, DVec3::new(5.0, 1.0, 0.5)));
    // Past the border, on the same side, and from beside the patch.
    assert!(!patch.is_between(under, DVec3::new(50.0, 1.0, 0.5)));
    assert!(!patch.is_between(under, DVec3::new(0.9, -1.0, 0.5)));
    assert!(!patch.is_between(DVec3::new(1.1, -0.01, 0.5), DVec3::new(0.9, 1.0, 0.5)));
}

#[test]
fn patches_without_area_or_numbers_have_no_feet() {
    let line = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0, DVec3::X * 3.0];
    for count in [3, 4] {
        let patch = Patch::new(line[..count].iter().copied());
        assert!(patch.foot(DVec3::Y).is_none());
        assert!(patch.foot_on_border(DVec3::Y).is_none());
        let patch = Patch::new([DVec3::NAN; 4][..count].iter().copied());
        assert!(patch.foot(DVec3::Y).is_none());
        assert!(patch.foot_on_border(DVec3::Y).is_none());
    }
}
