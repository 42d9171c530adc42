//! Which side a node is on, and that it remembers.

use super::*;

#[test]
fn a_node_pushed_through_is_brought_back_to_its_side() {
    let half = DVec3::new(0.5, 0.3, 0.8);
    let mut random = Random(41);
    for (shape, name) in [
        (box_mesh(half, 3, TriMeshFlags::empty()), "plain"),
        (box_mesh(half, 3, TriMeshFlags::ORIENTED), "oriented"),
        (box_mesh(half, 3, TriMeshFlags::FIX_INTERNAL_EDGES), "fixed"),
    ] {
        let soup = soup(&shape);
        for from_inside in [false, true] {
            if from_inside && soup.oriented() {
                continue;
            }
            let out = if from_inside { -1.0 } else { 1.0 };
            for _ in 0..1_000 {
                let mut p = half * random.vector() * 0.9;
                p.y = half.y + out * 1e-3;
                let mut probe = Probe::new(p, DVec3::ZERO);
                assert!(probe.look(&soup, 1e-3) < 0.0);
                // Squeezed 3 mm through in one go, then kept there and moved about.
                probe.p.y = half.y - out * 3e-3;
                for _ in 0..20 {
                    probe.p += DVec3::new(random.next(), 0.0, random.next()) * 2e-3;
                    probe.p = probe.p.clamp(
                        half * -0.95,
                        DVec3::new(half.x, 1.0, half.z) * 0.95 + DVec3::Y,
                    );
                    let depth = probe.look(&soup, 1e-3);
                    let touch = probe.touches.as_slice()[0];
                    assert!((depth - 3e-3).abs() < 1e-6, "{name}: {depth}");
                    assert!(
                        (touch.normal - DVec3::Y * out).length() < 1e-6,
                        "{name}: {touch:?}"
                    );
                }
                probe.settle(&soup);
                assert!(((probe.p.y - half.y) * out) > -1e-6);
            }
        }
    }
}

#[test]
fn a_thin_box_is_not_squeezed_through() {
    // 2 mm thick, pushed 1.5 mm in and then 3 mm right through it: still back the way it came.
    for flags in [TriMeshFlags::empty(), TriMeshFlags::ORIENTED] {
        let soup = soup(&box_mesh(DVec3::new(0.5, 1e-3, 0.5), 3, flags));
        for deep in [1.5e-3, 3.0e-3] {
            let mut probe = Probe::new(DVec3::new(0.11, 2e-3, 0.07), DVec3::ZERO);
            probe.look(&soup, 1e-3);
            probe.p.y = 1e-3 - deep;
            let depth = probe.look(&soup, 1e-3);
            assert!((depth - deep).abs() < 1e-6, "{flags:?}: {depth}");
            assert_eq!(probe.touches.as_slice()[0].normal, DVec3::Y);
        }
    }
}

#[test]
fn a_corner_pushed_through_on_all_sides_knows_them_all() {
    let half = DVec3::splat(0.25);
    let soup = soup(&box_mesh(half, 2, TriMeshFlags::empty()));
    let mut probe = Probe::new(half - 1e-3, DVec3::ZERO);
    probe.look(&soup, 1e-3);
    probe.p = half + DVec3::new(1e-3, 2e-3, 3e-3);
    probe.look(&soup, 1e-3);
    let mut sum = DVec3::ZERO;
    for touch in probe.touches.as_slice() {
        sum += touch.normal * touch.depth;
    }
    assert!(
        sum.distance(DVec3::new(-1e-3, -2e-3, -3e-3)) < 1e-6,
        "{:?}",
        probe.touches
    );
    probe.settle(&soup);
    assert!((probe.p - half).max_element() < 1e-6, "{}", probe.p);
}

#[test]
fn round_the_border_and_back_is_free() {
    let v = Vector::new;
    let triangle = SharedShape::triangle(v(-1.0, 0.0, -1.0), v(-1.0, 0.0, 1.0), v(0.0, 0.0, 0.0));
    let soup = soup(&triangle);
    let mut probe = Probe::new(DVec3::new(-0.002, 0.002, 0.0), DVec3::ZERO);
    for k in 0..=100 {
        let angle = std::f64::consts::PI * (0.75 - 1.5 * f64::from(k) / 100.0);
        let direction = DVec3::new(angle.cos(), angle.sin(), 0.0);
        probe.p = direction * 3e-3;
        let depth = probe.look(&soup, 1e-3);
        assert!(depth <= 0.0, "{k}: {depth}");
    }
    assert_eq!(probe.touches.as_slice()[0].normal, -DVec3::Y);
}

#[test]
fn on_the_surface_the_front_counts() {
    let half = DVec3::new(0.5, 0.25, 0.75);
    let soup = soup(&box_mesh(half, 2, TriMeshFlags::empty()));
    for (p, n) in [
        (DVec3::new(0.1, 0.25, 0.2), DVec3::Y),
        // On a seam, on an edge, on a corner.
        (DVec3::new(0.0, 0.25, 0.0), DVec3::Y),
        (
            DVec3::new(0.5, 0.25, 0.1),
            DVec3::new(1.0, 1.0, 0.0).normalize(),
        ),
        (half, DVec3::ONE.normalize()),
    ] {
        let mut probe = Probe::new(p, DVec3::ZERO);
        let depth = probe.look(&soup, 1e-3);
        let touch = probe.touches.as_slice()[0];
        assert!(depth.abs() < 1e-9, "{p}: {depth}");
        assert!(touch.normal.distance(n) < 1e-6, "{p}: {touch:?}");
        // Rounding either way does not change that.
        for noise in [-1e-13, 1e-13, -1e-10, 1e-10] {
            probe.p = p + n * noise;
            probe.look(&soup, 1e-3);
            let touch = probe.touches.as_slice()[0];
            assert!(touch.normal.dot(n) > 0.5, "{p} {noise}: {touch:?}");
            assert!((touch.depth + noise).abs() < 1e-9);
        }
    }
}

#[test]
fn resting_on_a_ridge_and_in_a_valley() {
    let v = Vector::new;
    for sign in [1.0_f32, -1.0] {
        let y = -0.5 * sign;
        let shape = SharedShape::trimesh(
            vec![
                v(-1.0, y, -1.0),
                v(0.0, 0.0, -1.0),
                v(1.0, y, -1.0),
                v(-1.0, y, 1.0),
                v(0.0, 0.0, 1.0),
                v(1.0, y, 1.0),
            ],
            vec![[0, 3, 1], [1, 3, 4], [1, 4, 2], [2, 4, 5]],
        )
        .unwrap();
        let soup = soup(&shape);
        let mut probe = Probe::new(DVec3::new(0.0, 1e-3, 0.1), DVec3::ZERO);
        // Into the valley from its side.
        probe.p.x = if sign < 0.0 { 0.05 } else { 0.0 };
        probe.p.y += 0.5 * probe.p.x;
        for _ in 0..4000 {
            probe.step(&soup, DVec3::Y * -9.81, 5e-4);
            if probe.p.x.abs() > 0.9 {
                break;
            }
            let gap = probe.p.y + 0.5 * f64::from(sign) * probe.p.x.abs();
            assert!(gap > -1e-6, "{sign}: {gap} at {}", probe.p);
        }
        if sign < 0.0 {
            assert!(probe.p.x.abs() < 1e-4, "{} moving at {}", probe.p, probe.v);
        }
    }
}
