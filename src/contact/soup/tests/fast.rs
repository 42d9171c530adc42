//! Fast nodes: none may get through, through faces, edges or corners, and none may be stopped by what is not there.

use super::*;

const H: f64 = 5.0e-4;

#[test]
fn no_fast_node_gets_into_a_box_mesh_or_out_of_it() {
    let half = DVec3::new(0.5, 0.3, 0.8);
    let mut random = Random(5);
    let mut met = 0;
    for flags in [
        TriMeshFlags::empty(),
        TriMeshFlags::ORIENTED,
        TriMeshFlags::FIX_INTERNAL_EDGES,
    ] {
        let soup = soup(&box_mesh(half, 3, flags));
        let inside = !soup.oriented();
        for k in 0..10_000 {
            // Half of them from inside where there is an inside to be in.
            let within = inside && k % 2 == 0;
            let p = half * random.vector() * if within { 0.95 } else { 1.0 };
            let mut p = p;
            if !within {
                let axis = k % 3;
                p[axis] = (half[axis] + 0.03 * random.next().abs() + 1e-3) * random.next().signum();
            }
            let speed = 52.5 + 47.5 * random.next();
            let mut probe = Probe::new(p, random.direction() * speed);
            for _ in 0..8 {
                let a = random.vector() * 2.0e4;
                probe.step(&soup, a, H);
                met += probe.touches.as_slice().len();
                let q = probe.p.abs() - half;
                let depth = if within {
                    q.max_element()
                } else {
                    -q.max_element()
                };
                assert!(depth < 1e-6, "{flags:?} {k}: {depth} from {p}");
            }
        }
    }
    assert!(met > 50_000, "{met} touches");
}

/// Height of the bumpy field over a place, by the two triangles of its cell.
fn field_height(field: &HeightField, p: DVec3) -> Option<f64> {
    let (i, j) = field.cell_at_point(Vector::new(p.x as f32, 0.0, p.z as f32))?;
    let (left, right) = field.triangles_at(i, j);
    [left?, right?].into_iter().find_map(|t| {
        let [a, b, c] = [t.a, t.b, t.c].map(|v| v.as_dvec3());
        let n = (b - a).cross(c - a);
        let y = a.y - (n.x * (p.x - a.x) + n.z * (p.z - a.z)) / n.y;
        let q = DVec3::new(p.x, y, p.z);
        let inside = |a: DVec3, b: DVec3| n.cross(b - a).dot(q - a) >= -1e-9;
        (inside(a, b) && inside(b, c) && inside(c, a)).then_some(y)
    })
}

#[test]
fn no_fast_node_gets_through_a_height_field() {
    let field = bumpy();
    let soup = soup(&SharedShape::new(field.clone()));
    let mut random = Random(9);
    let (mut met, mut checked) = (0, 0);
    for k in 0..10_000 {
        let mut p = random.vector() * 0.7;
        let Some(y) = field_height(&field, p) else {
            continue;
        };
        let side = if k % 2 == 0 { 1.0 } else { -1.0 };
        p.y = y + side * (1e-3 + 0.05 * random.next().abs());
        let speed = 52.5 + 47.5 * random.next();
        let mut probe = Probe::new(p, random.direction() * speed);
        for _ in 0..8 {
            let a = random.vector() * 2.0e4;
            probe.step(&soup, a, H);
            met += probe.touches.as_slice().len();
            if probe.p.x.abs().max(probe.p.z.abs()) > 0.95 {
                break;
            }
        }
        // Four passes over rows at blunt angles leave some depth, which must be known and mended.
        if probe.p.x.abs().max(probe.p.z.abs()) < 0.9 {
            probe.settle(&soup);
            if let Some(y) = field_height(&field, probe.p) {
                let height = side * (probe.p.y - y);
                assert!(height > -1e-6, "{k}: {height} from {p}");
                checked += 1;
            }
        }
    }
    assert!(
        met > 20_000 && checked > 8_000,
        "{met} touches, {checked} checked"
    );
}

#[test]
fn nodes_aimed_at_edges_and_corners_are_met() {
    let half = DVec3::new(0.5, 0.3, 0.8);
    let mut random = Random(17);
    let shapes = [
        box_mesh(half, 3, TriMeshFlags::empty()),
        box_mesh(half, 3, TriMeshFlags::ORIENTED),
        SharedShape::new(bumpy()),
    ];
    for shape in shapes {
        let soup = soup(&shape);
        for id in 0..200 {
            let Some(facet) = soup.facet(id) else {
                break;
            };
            let points = facet.points();
            for i in 0..3 {
                let (a, b) = (points[i], points[(i + 1) % 3]);
                for target in [a, a.midpoint(b), a.lerp(b, 0.123)] {
                    let front = (points[1] - points[0])
                        .cross(points[2] - points[0])
                        .normalize();
                    let from = target + front * 0.01 + random.vector() * 0.002;
                    // Beyond the target by as much again, exactly through it.
                    let mut probe = Probe::new(from, (target - from) * 2.0 / H);
                    probe.look(&soup, H);
                    let list = probe.touches.as_slice();
                    let ends = from + probe.v * H;
                    assert!(
                        list.iter().any(|t| (ends - from).dot(t.normal) < t.depth),
                        "facet {id} through {target} from {from}: {list:?}"
                    );
                    for touch in list {
                        // The target, which is the surface, is not forbidden.
                        assert!((target - from).dot(touch.normal) > touch.depth - 1e-7);
                    }
                }
            }
        }
    }
}

#[test]
fn a_concave_corner_holds_what_comes_at_100_m_s() {
    // V31: three sides of a box from inside, hit along all directions.
    let half = DVec3::splat(0.25);
    let soup = soup(&box_mesh(half, 2, TriMeshFlags::empty()));
    let mut random = Random(23);
    for k in 0..3_000 {
        let p = half - random.vector().abs() * 0.03 - 1e-4;
        let v = (DVec3::ONE + random.vector() * 0.99).normalize() * 100.0;
        let mut probe = Probe::new(p, v);
        for _ in 0..10 {
            probe.step(&soup, v * 1.0e4, H);
            let q = (probe.p - half).max_element();
            assert!(q < 1e-6, "{k}: {q} out from {p} at {v}");
        }
        // Driven by 1e6 m/s² for ten substeps it lies in the corner or on its way along a side.
        assert!(probe.touches.as_slice().len() >= 2, "{k}");
    }
}

#[test]
fn a_node_grazing_past_a_border_is_not_stopped() {
    let v = Vector::new;
    let plate = SharedShape::trimesh(
        vec![
            v(-1.0, 0.0, -1.0),
            v(0.0, 0.0, -1.0),
            v(0.0, 0.0, 1.0),
            v(-1.0, 0.0, 1.0),
        ],
        vec![[0, 2, 1], [0, 3, 2]],
    )
    .unwrap();
    let soup = soup(&plate);
    for from in [DVec3::new(-1e-3, 1e-3, 0.1), DVec3::new(1e-3, 1e-3, 0.1)] {
        for offset in [0.0, 5e-4] {
            let mut probe = Probe::new(from, DVec3::new(50.0, -10.0, 0.0));
            probe.offset = offset;
            let before = probe.v;
            for _ in 0..5 {
                probe.step(&soup, DVec3::ZERO, H);
            }
            assert_eq!(probe.v, before, "from {from}, offset {offset}");
            // And back underneath, where the border must not make it think it was pushed through.
            probe.v = DVec3::new(-50.0, 1.0, 0.0);
            for _ in 0..8 {
                probe.step(&soup, DVec3::ZERO, H);
            }
            assert!(probe.p.x < -0.05 && probe.p.y < 0.0, "{}", probe.p);
            assert_eq!(probe.v.y, 1.0);
        }
    }
    // The same motion starting farther in does meet the plate.
    let mut probe = Probe::new(DVec3::new(-0.02, 1e-3, 0.1), DVec3::new(50.0, -10.0, 0.0));
    probe.step(&soup, DVec3::ZERO, H);
    assert!((probe.p.y).abs() < 1e-9, "{}", probe.p);
}

#[test]
fn a_layer_is_met_as_a_surface() {
    // A node of 5 mm against the border of a plate, a segment and a polyline: stopped at that distance.
    let v = Vector::new;
    let shapes = [
        SharedShape::triangle(v(-1.0, 0.0, -1.0), v(0.0, 0.0, 0.0), v(-1.0, 0.0, 1.0)),
        SharedShape::segment(v(-1.0, 0.0, 0.0), v(0.0, 0.0, 0.0)),
        SharedShape::polyline(
            vec![v(-1.0, 0.0, 0.0), v(-0.3, 0.0, 0.0), v(0.0, 0.0, 0.0)],
            None,
        ),
    ];
    let mut random = Random(31);
    for shape in &shapes {
        let soup = soup(shape);
        for k in 0..2_000 {
            let target = DVec3::new(-0.5 + 0.5 * random.next(), 0.0, 0.0);
            let direction = random.direction();
            // Clear of the layer at the start, the plate's too.
            if direction.y.abs() < 0.3 {
                continue;
            }
            let from = target + direction * 0.02;
            let mut probe = Probe::new(from, (target - from) * 5.0 / H);
            probe.offset = 5e-3;
            for _ in 0..4 {
                probe.step(&soup, DVec3::ZERO, H);
                let near = probe.facets.near(0).nearest(probe.p);
                let distance = near.map_or(1.0, |n| n.distance);
                assert!(distance > 5e-3 - 1e-6, "{k}: {distance} from {from}");
            }
        }
    }
}
