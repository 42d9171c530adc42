//! Both preludes side by side: a name in both would be ambiguous, and rustc only warns of that unless told otherwise.

#![deny(ambiguous_glob_imports)]

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// Sees nothing, but is one.
struct Blind;

impl Observer for Blind {
    fn substep(&mut self, _: &Substep) {}

    fn event(&mut self, event: &SpringEvent) {
        assert!(matches!(
            event.kind,
            SpringEventKind::YieldBegan | SpringEventKind::Broke
        ));
    }

    fn touch_event(&mut self, event: &TouchEvent) {
        assert!(event.kind == TouchEventKind::Started);
        let contact: PairContact = event.contact;
        assert!(matches!(contact.partner, Partner::Collider(_)));
    }
}

#[test]
fn both_preludes_make_a_program() -> Result<(), BuildError> {
    let mut world = PhysicsWorld::default();
    let (floor, _) = world.insert(
        RigidBodyBuilder::fixed(),
        ColliderBuilder::cuboid(2.0, 0.1, 2.0),
    );
    let mut deformables = DeformableWorld::default();
    let params: &mut DeformableParameters = &mut deformables.params;
    params.integrator = Integrator::VelocityVerlet;
    params.substeps = Substeps::default();
    let net: Net = lattice(Vector::splat(0.2), 0.1)?;
    let spring: Spring = net.springs[0];
    let block: DeformableHandle = deformables.insert(
        DeformableBuilder::new(net)
            .material(Material::rubber())
            .translation(Vector::new(0.0, 0.3, 0.0)),
    )?;
    let bead = Node::new(Vector::ZERO, 1.0);
    deformables.insert(DeformableBuilder::new(Net::new(vec![bead], vec![])))?;
    let mut recorder = Recorder::new();
    recorder.begin(&deformables);
    let held: AttachmentHandle = deformables
        .attach(block, &[NodeId(0)], floor, &world.bodies)
        .expect("both exist");
    for f in [
        sheet(1.0, 1.0, 3, 3, 0.1),
        rope(Vector::X, Vector::Y, 2, 0.1),
    ] {
        f?.check()?;
    }
    assert!(filled(&Default::default(), 0.1).is_err());
    struct Open;
    impl DeformableHooks for Open {
        fn filter(&self, _: &PairContext) -> bool {
            true
        }
    }
    deformables.set_hooks(std::sync::Arc::new(Open));
    let none: &[NodeImpulse] = &[];
    assert!(none.is_empty());
    for _ in 0..3 {
        deformables.step_with(&mut world, &(), &(), &mut Blind);
    }
    deformables.before_step(&mut RapierParts::from(&mut world), &mut Blind);
    world.step();
    deformables.after_step(&mut RapierParts::from(&mut world));
    let ray = Ray::new(Vector::new(0.02, 5.0, 0.01), -Vector::Y);
    let filter = DeformableFilter::default();
    let hit: DeformableRayHit = deformables
        .cast_ray(&ray, 9.0, true, filter)
        .expect("below");
    let at: SurfacePoint = hit.at;
    assert!(matches!(at.feature, Feature::Face(_)));
    let near: Option<DeformableProjection> =
        deformables.project_point(hit.point, 1.0, true, filter);
    assert!(near.is_some());
    let ball = SharedShape::ball(0.1);
    let pose = Pose::from_translation(hit.point);
    let over: Vec<DeformableOverlap> = deformables.intersect_shape(&pose, &*ball, filter);
    assert_eq!(over.len(), 1);
    let first = deformables.cast_ray_with(&world.query_pipeline(), &ray, 9.0, true, filter);
    assert!(matches!(first, Some(RayHit::Deformable(_))));
    let body: &Deformable = &deformables[block];
    assert_eq!(body.blueprint().springs[0].nodes, spring.nodes);
    assert!(body.tension(SpringId(0)).is_some());
    assert!(deformables.attachment_force(held).is_some());
    Ok(())
}
