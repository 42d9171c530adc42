//! Ropes on the seams of floors that are put together from pieces which share no vertices: nothing falls in between.

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// Two squares of 1 m that meet at x = 0, the left one first.
fn squares() -> [Vec<Vector>; 2] {
    let v = Vector::new;
    let square = |x: f32| {
        vec![
            v(x, 0.0, -0.5),
            v(x + 1.0, 0.0, -0.5),
            v(x + 1.0, 0.0, 0.5),
            v(x, 0.0, 0.5),
        ]
    };
    [square(-1.0), square(0.0)]
}

/// Floors by name.
fn floors() -> Vec<(&'static str, Vec<ColliderBuilder>)> {
    let mesh = |points, faces| ColliderBuilder::trimesh(points, faces).unwrap();
    let faces = vec![[0, 2, 1], [0, 3, 2]];
    let two = squares().map(|square| mesh(square, faces.clone()));
    let [left, right] = squares();
    let triangles = [&left, &right]
        .into_iter()
        .flat_map(|s| [(s[0], s[2], s[1]), (s[0], s[3], s[2])])
        .map(|(a, b, c)| ColliderBuilder::triangle(a, b, c));
    let unshared = [left.clone(), right.clone()].concat();
    let middle = vec![Vector::ZERO, (right[1] + right[2]) / 2.0];
    let t_junction = [unshared.clone(), middle].concat();
    let halves = vec![[4, 9, 5], [4, 8, 9], [8, 6, 9], [8, 7, 6]];
    let both = [faces.clone(), vec![[4, 6, 5], [4, 7, 6]]].concat();
    vec![
        ("two meshes", two.to_vec()),
        ("triangles", triangles.collect()),
        ("unshared vertices", vec![mesh(unshared, both)]),
        (
            "a junction",
            vec![mesh(t_junction, [faces, halves].concat())],
        ),
    ]
}

/// Ropes of 40 cm by name, from one end to the other, above the seam.
fn ropes() -> Vec<(&'static str, Vector, Vector)> {
    let v = Vector::new;
    vec![
        ("along", v(0.0, 0.1, -0.2), v(0.0, 0.1, 0.2)),
        ("nearly along", v(-5e-5, 0.1, -0.2), v(8e-5, 0.1, 0.2)),
        ("aslant", v(-0.003, 0.1, -0.2), v(0.003, 0.1, 0.2)),
        ("across", v(-0.2, 0.1, 0.0), v(0.2, 0.1, 0.0)),
        ("upright", v(0.0, 0.1, 0.1), v(0.0, 0.5, 0.1)),
        ("upright beside it", v(6e-5, 0.1, 0.0), v(6e-5, 0.5, 0.0)),
        ("steep", v(0.0, 0.1, 0.1), v(0.1, 0.4, 0.1)),
    ]
}

#[test]
fn ropes_lie_on_seams() {
    for (floor, colliders) in floors() {
        for (name, from, to) in ropes() {
            let mut world = PhysicsWorld::default();
            for collider in &colliders {
                world.insert(RigidBodyBuilder::fixed(), collider.clone());
            }
            let mut deformables = DeformableWorld::default();
            let net = rope(from, to, 8, 1.0e-4).unwrap();
            let material = Material::elastic(1.0e6, 1000.0).viscosity(2.0e3);
            let rope = DeformableBuilder::new(net).material(material);
            let rope = deformables.insert(rope).unwrap();
            for _ in 0..90 {
                deformables.step(&mut world);
                let lowest = deformables[rope].bounds().0.y;
                assert!(lowest > -1e-3, "{name} on {floor}: at {lowest} m");
            }
        }
    }
}
