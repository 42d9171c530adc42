use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
fn main() {
    let mut world = PhysicsWorld::default();
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(10.0, 0.5, 10.0),
    );
    let mut d = DeformableWorld::default();
    let young = 1e6f32;
    let h = d
        .insert(
            DeformableBuilder::new(lattice(Vector::splat(1.0), 1.0 / 9.0))
                .material(
                    Material::elastic(young, 1.0).viscosity(0.1 * young / (young / 100.0).sqrt()),
                )
                .total_mass(100.0)
                .translation(Vector::new(0.0, 1.5, 0.0)),
        )
        .unwrap();
    let t = std::time::Instant::now();
    let mut sub = 0;
    for _ in 0..1200 {
        d.step(&mut world);
        sub += d.report().substeps[0].1;
    }
    println!(
        "{} us/substep, {} substeps/frame springs {} rigid {}",
        t.elapsed().as_secs_f64() * 1e6 / sub as f64,
        sub / 1200,
        d[h].spring_count(),
        d.report().rigid_steps
    );
}
