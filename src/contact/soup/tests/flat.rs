//! Edges between facets in one plane must not be felt.

use super::*;
use crate::math::DQuat;

/// A plate of 2 m in `n` by `n` squares, turned by `rot`.
fn plate(n: u32, rot: DQuat) -> SharedShape {
    let mut vertices = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            let at = |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
            vertices.push((rot * DVec3::new(at(i), 0.0, at(j))).as_vec3());
        }
    }
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j;
            let (b, c, d) = (a + n + 1, a + n + 2, a + 1);
            // Diagonals one way and the other.
            if (i + j) % 2 == 0 {
                triangles.extend([[a, c, b], [a, d, c]]);
            } else {
                triangles.extend([[a, d, b], [d, c, b]]);
            }
        }
    }
    SharedShape::trimesh(vertices, triangles).unwrap()
}

#[test]
fn sliding_over_a_tessellated_plane_is_smooth() {
    let field = HeightField::new(Array2::new(9, 9, vec![0.0; 81]), Vector::new(2.0, 1.0, 2.0));
    let shapes = [
        (plate(8, DQuat::IDENTITY), "plate"),
        (SharedShape::new(field), "field"),
    ];
    for (shape, name) in &shapes {
        let soup = soup(shape);
        for offset in [0.0, 2e-3] {
            for way in [
                DVec3::X,
                DVec3::Z,
                DVec3::new(1.0, 0.0, 1.0).normalize(),
                DVec3::new(0.6, 0.0, 0.8),
            ] {
                let mut probe = Probe::new(-way * 0.9 + DVec3::Y * offset, way * 7.0);
                probe.offset = offset;
                let mut felt = 0;
                for _ in 0..500 {
                    probe.step(&soup, DVec3::Y * -9.81, 5e-4);
                    for touch in probe.touches.as_slice() {
                        assert!(
                            touch.normal.distance(DVec3::Y) < 1e-6,
                            "{name} {}: {touch:?}",
                            probe.p
                        );
                        felt += 1;
                    }
                }
                assert!(felt >= 500, "{name}: {felt}");
                assert!((probe.v.dot(way) - 7.0).abs() < 1e-9, "{name}: {}", probe.v);
                assert!((probe.p.y - offset).abs() < 1e-6, "{name}: {}", probe.p);
            }
        }
    }
}

#[test]
fn a_turned_plane_is_as_flat_as_its_vertices() {
    let rot = DQuat::from_scaled_axis(DVec3::new(0.3, -0.7, 1.1));
    let soup = soup(&plate(8, rot));
    let up = rot * DVec3::Y;
    let way = rot * DVec3::new(0.6, 0.0, 0.8);
    let mut probe = Probe::new(way * -0.9 + up * 1e-4, way * 7.0);
    for _ in 0..500 {
        probe.step(&soup, up * -9.81, 5e-4);
        for touch in probe.touches.as_slice() {
            // Vertices are f32: 6e-8 m on facets of 0.25 m.
            assert!(touch.normal.distance(up) < 1e-6, "{}: {touch:?}", probe.p);
        }
    }
    assert!((probe.v.dot(way) - 7.0).abs() < 1e-5);
}
