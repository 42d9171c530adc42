//! Corners and edges of meshes, height fields, voxels and lines between the nodes of a body.

use crumple::prelude::*;
use crumple::rapier3d::parry::utils::Array2;
use crumple::rapier3d::prelude::*;

/// How high the obstacles stand \[m\], and where \[m\].
const PEAK: Vector = Vector::new(0.05, 0.15, 0.03);

/// A needle of four faces.
fn pyramid(flags: TriMeshFlags) -> ColliderBuilder {
    let v = Vector::new;
    let half = 0.04;
    let corners = vec![
        v(-half, -PEAK.y, -half),
        v(half, -PEAK.y, -half),
        v(half, -PEAK.y, half),
        v(-half, -PEAK.y, half),
        v(0.0, 0.0, 0.0),
    ];
    let faces = vec![
        [0, 4, 1],
        [1, 4, 2],
        [2, 4, 3],
        [3, 4, 0],
        [0, 1, 2],
        [0, 2, 3],
    ];
    ColliderBuilder::trimesh_with_flags(corners, faces, flags).unwrap()
}

/// A terrain of 5 cm cells with one vertex that stands out.
fn peak_of_a_field() -> ColliderBuilder {
    let n = 41;
    let mut heights = Array2::repeat(n, n, -PEAK.y);
    heights[(n / 2, n / 2)] = 0.0;
    ColliderBuilder::heightfield(heights, Vector::new(2.0, 1.0, 2.0))
}

fn column_of_voxels() -> ColliderBuilder {
    let cells: Vec<IVector> = (-5..0).map(|y| IVector::new(0, y, 0)).collect();
    ColliderBuilder::voxels(Vector::splat(0.03), &cells)
        .translation(Vector::new(-0.015, 0.0, -0.015))
}

/// A tent of wire.
fn wire() -> ColliderBuilder {
    let v = Vector::new;
    let corners = vec![
        v(-0.04, -PEAK.y, 0.01),
        Vector::ZERO,
        v(0.04, -PEAK.y, -0.01),
    ];
    ColliderBuilder::polyline(corners, None)
}

/// A roof whose ridge is shorter than a cell.
fn roof() -> ColliderBuilder {
    let v = Vector::new;
    let (half, low) = (0.05, -PEAK.y);
    let corners = vec![
        v(-0.03, 0.0, 0.0),
        v(0.03, 0.0, 0.0),
        v(-half, low, -half),
        v(half, low, -half),
        v(half, low, half),
        v(-half, low, half),
    ];
    let faces = vec![
        [0, 1, 3],
        [0, 3, 2],
        [1, 0, 5],
        [1, 5, 4],
        [0, 2, 5],
        [1, 4, 3],
    ];
    ColliderBuilder::trimesh(corners, faces).unwrap()
}

fn ground(world: &mut PhysicsWorld) {
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(5.0, 0.5, 5.0),
    );
}

/// A free sheet of 25 cm cells.
fn tarpaulin() -> DeformableBuilder {
    DeformableBuilder::new(sheet(1.0, 1.0, 4, 4, 1e-3).unwrap())
        .material(Material::elastic(5.0e6, 1000.0).viscosity(2.0e4))
}

/// A block of 25 cm cells; its lower side has a node every 25 cm.
fn cushion() -> DeformableBuilder {
    DeformableBuilder::new(lattice(Vector::new(1.0, 0.25, 1.0), 0.25))
        .material(Material::elastic(2.0e5, 100.0).viscosity(1.0e3))
}

/// How far the point `PEAK` is inside a body, or above a sheet \[m\].
fn through(deformables: &DeformableWorld) -> f64 {
    let filter = DeformableFilter::new;
    let nearest = deformables.project_point(PEAK, 2.0, false, filter());
    if let Some(inside) = nearest.filter(|n| n.is_inside) {
        return inside.distance.into();
    }
    let down = Ray::new(PEAK, Vector::NEG_Y);
    let below = deformables.cast_ray(&down, 2.0, false, filter());
    below.map_or(0.0, |hit| hit.time_of_impact.into())
}

/// Lets a body fall on a fixed obstacle whose highest point is `PEAK`. Returns how far that comes through at the worst \[m\].
fn fall(soft: DeformableBuilder, obstacle: ColliderBuilder, height: f32) -> f64 {
    let mut world = PhysicsWorld::default();
    ground(&mut world);
    world.insert(RigidBodyBuilder::fixed().translation(PEAK), obstacle);
    let mut deformables = DeformableWorld::default();
    deformables
        .insert(soft.translation(Vector::Y * (PEAK.y + height)))
        .unwrap();
    let mut worst = 0.0_f64;
    for _ in 0..240 {
        deformables.step(&mut world);
        worst = worst.max(through(&deformables));
    }
    worst
}

#[test]
fn nothing_sharp_stands_through_a_coarse_body() {
    for (name, obstacle) in [
        ("mesh", pyramid(TriMeshFlags::empty())),
        ("oriented mesh", pyramid(TriMeshFlags::ORIENTED)),
        ("mended mesh", pyramid(TriMeshFlags::FIX_INTERNAL_EDGES)),
        ("field", peak_of_a_field()),
        ("voxels", column_of_voxels()),
        ("wire", wire()),
        ("roof", roof()),
    ] {
        // A face of four nodes is a curved patch in contact and two triangles in queries: over a needle, on cells of 25 cm,
        // a centimetre lies between them. Of 15.
        let worst = fall(tarpaulin(), obstacle.clone(), 0.3);
        assert!(worst < 0.015, "{name} stands {worst} m through a sheet");
        let worst = fall(cushion(), obstacle, 0.125 + 0.2);
        assert!(worst < 1e-3, "{name} stands {worst} m in a block");
    }
}

#[test]
fn a_needle_of_a_mesh_does_what_its_hull_does() {
    let v = Vector::new;
    let half = 0.04;
    let corners = [
        v(-half, -PEAK.y, -half),
        v(half, -PEAK.y, -half),
        v(half, -PEAK.y, half),
        v(-half, -PEAK.y, half),
        Vector::ZERO,
    ];
    let hull = ColliderBuilder::convex_hull(&corners).unwrap();
    let mesh = pyramid(TriMeshFlags::empty());
    let through = [hull, mesh].map(|obstacle| fall(tarpaulin(), obstacle, 0.3));
    assert!((through[0] - through[1]).abs() < 1e-4, "{through:?}");
}

/// Bars of 40 cm along z, their upper edge at the origin, of many pieces where that is possible.
fn bars() -> Vec<(&'static str, ColliderBuilder)> {
    let v = Vector::new;
    let along = |x: f32, y: f32| -> Vec<Vector> {
        let at = |i: u8| v(x, y, f32::from(i) * 0.05 - 0.2);
        (0..9).map(at).collect()
    };
    let top = along(0.0, 0.0);
    let strip = |a: u32, b: u32| -> Vec<[u32; 3]> {
        let cell = |i: u32| [[a + i, b + i, b + i + 1], [a + i, b + i + 1, a + i + 1]];
        (0..8).flat_map(cell).collect()
    };
    let fin = [top.clone(), along(0.0, -0.1)].concat();
    let roof = [top.clone(), along(-0.05, -0.1), along(0.05, -0.1)].concat();
    let roof_faces = [strip(0, 9), strip(18, 0)].concat();
    let cells: Vec<IVector> = (0..20).map(|z| IVector::new(0, -1, z - 10)).collect();
    let (first, last) = (top[0], top[8]);
    let part = |x: f32, y: f32, z: f32, half: Vector| {
        let shape = SharedShape::cuboid(half.x, half.y, half.z);
        (Pose::from_translation(v(x, y, z)), shape)
    };
    // Parts that abut, their seams along the bar and across it, on a base that they abut as well.
    let (split, quarter) = (v(0.0025, 0.05, 0.2), v(0.005, 0.05, 0.1));
    let base = part(0.0, -0.11, 0.0, v(0.03, 0.01, 0.2));
    let along = vec![
        part(-0.0025, -0.05, 0.0, split),
        part(0.0025, -0.05, 0.0, split),
        base.clone(),
    ];
    let across = vec![
        part(0.0, -0.05, -0.1, quarter),
        part(0.0, -0.05, 0.1, quarter),
        base,
    ];
    // Two slopes so gentle that they are almost one plane.
    let slope = |x: f32| {
        let points = [(0.0, 0.0), (x, -0.09 * x.abs()), (0.0, -0.1), (x, -0.1)];
        let points = points.map(|(x, y)| [v(x, y, -0.2), v(x, y, 0.2)]);
        let hull = SharedShape::convex_hull(points.as_flattened());
        (Pose::IDENTITY, hull.unwrap())
    };
    let gentle = vec![slope(-0.1), slope(0.1)];
    vec![
        ("wire", ColliderBuilder::polyline(top.clone(), None)),
        ("gentle compound", ColliderBuilder::compound(gentle)),
        ("compound along", ColliderBuilder::compound(along)),
        ("compound across", ColliderBuilder::compound(across)),
        ("segment", ColliderBuilder::segment(first, last)),
        (
            "triangle",
            ColliderBuilder::triangle(first, last, v(0.0, -0.2, 0.0)),
        ),
        (
            "round triangle",
            ColliderBuilder::round_triangle(first, last, v(0.0, -0.2, 0.0), 1e-3)
                .translation(Vector::NEG_Y * 1e-3),
        ),
        ("fin", ColliderBuilder::trimesh(fin, strip(0, 9)).unwrap()),
        ("roof", ColliderBuilder::trimesh(roof, roof_faces).unwrap()),
        (
            "voxels",
            ColliderBuilder::voxels(Vector::splat(0.02), &cells).translation(v(-0.01, 0.0, 0.0)),
        ),
    ]
}

/// Draws a bar, its middle at `z` m, under a sheet that is held at its border, 3 cm above the border, and returns how far it came
/// through \[m\].
fn draw(bar: ColliderBuilder, z: f32) -> f64 {
    let mut world = PhysicsWorld::default();
    let start = Vector::new(-0.33, -0.05, z);
    let (body, _) = world.insert(
        RigidBodyBuilder::kinematic_velocity_based().translation(start),
        bar.friction(0.3),
    );
    let mut deformables = DeformableWorld::default();
    let net = sheet(1.0, 1.0, 10, 10, 1e-3).unwrap().pin_border();
    let cloth = DeformableBuilder::new(net)
        .material(Material::elastic(2.0e6, 1000.0).viscosity(5.0e3))
        .friction(0.3);
    deformables.insert(cloth).unwrap();
    let mut worst = 0.0_f64;
    for i in 0..160 {
        // Up, and then across.
        let up = if i < 20 { 0.24 } else { 0.0 };
        let across = if i < 20 { 0.0 } else { 0.3 };
        world.bodies[body].set_linvel(Vector::new(across, up, 0.0), true);
        deformables.step(&mut world);
        let at = world.bodies[body].translation();
        for k in 0..41 {
            let edge = at + Vector::Z * (f32::from(k as u8) * 0.01 - 0.2);
            let down = Ray::new(edge, Vector::NEG_Y);
            let below = deformables.cast_ray(&down, 1.0, false, DeformableFilter::new());
            worst = worst.max(below.map_or(0.0, |hit| hit.time_of_impact.into()));
        }
    }
    worst
}

#[test]
fn a_sheet_is_drawn_over_edges_of_all_kinds() {
    for (name, bar) in bars() {
        let worst = draw(bar, 0.013);
        assert!(worst < 4e-3, "{name} comes {worst} m through");
    }
    // Symptom: a blade came through by 20 cm. Cause: nodes beside it, a hair below its edge, were carried along with its side.
    let blade = || {
        let mut all = bars().into_iter();
        all.find(|(name, _)| *name == "triangle").unwrap().1
    };
    for z in [0.0, 0.005, 0.02, 0.04] {
        let worst = draw(blade(), z);
        assert!(worst < 4e-3, "a triangle at {z} m comes {worst} m through");
    }
}

/// A rope of 1 cm that is shot across the top edge of a triangle, or a line, and wraps round it. Symptom: a quarter slid through:
/// what came after a segment that lay on one flank took that for its side.
#[test]
fn a_rope_wraps_round_a_sharp_edge() {
    let v = Vector::new;
    let edges = [
        ColliderBuilder::triangle(v(0.0, 0.0, -1.0), v(0.0, 0.0, 1.0), v(0.0, -0.4, 0.0)),
        ColliderBuilder::polyline(vec![v(0.0, 0.0, -1.0), v(0.0, 0.0, 1.0)], None),
    ];
    for edge in edges {
        let mut wrapped = 0;
        for seed in 0..30 {
            let mut random = super::Random(seed * 7 + 3);
            let segments = [4, 9, 20][seed as usize % 3];
            let (shift, yaw) = (random.within(-0.15, 0.15), random.within(-0.3, 0.3));
            let mut world = crate::support::weightless(1.0 / 240.0);
            world.insert(RigidBodyBuilder::fixed(), edge.clone().friction(0.2));
            let rope = crumple::shape::rope(v(-0.5, 0.0, 0.0), v(0.5, 0.0, 0.0), segments, 1e-4);
            let rope = DeformableBuilder::new(rope)
                .material(Material::elastic(1e8, 1000.0).viscosity(1e4))
                .thickness(0.01)
                .translation(v(shift as f32, 0.15, 0.0))
                .rotation(Rotation::from_rotation_y(yaw as f32))
                .linvel(v(0.0, -5.0, 0.0));
            let mut deformables = DeformableWorld::default();
            let rope = deformables.insert(rope).unwrap();
            let mut bends = false;
            for _ in 0..30 {
                deformables.step(&mut world);
                let places: Vec<Vector> = deformables[rope].positions().collect();
                let over = places
                    .windows(2)
                    .filter(|p| (p[0].x <= 0.0) != (p[1].x <= 0.0));
                let heights: Vec<f32> = over
                    .map(|p| p[0].lerp(p[1], p[0].x / (p[0].x - p[1].x)).y)
                    .collect();
                // A rope that has swung off one flank crosses the plane nowhere, or thrice.
                let [height] = heights[..] else { break };
                assert!(height > -0.05, "{:?}, {seed}: {height} m", edge.shape);
                let ends = places[0].y.max(places[segments].y);
                bends |= ends < height - 0.2;
            }
            wrapped += u32::from(bends);
        }
        assert!(wrapped > 20, "{:?}: {wrapped} of 30", edge.shape);
    }
}
