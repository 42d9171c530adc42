use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::world::Substep;
struct P(usize);
impl Observer for P { fn substep(&mut self, s:&Substep){ self.0+=1; if self.0%2000==0 || self.0<12 { let b=&s.deformables[0].1; println!("{} t {:.7} h {:.3e} x0 {:.7} v0 {:.6} x1 {:.7} v1 {:.6} j {:.4e}", self.0, s.time, s.h, b.position(NodeId(0)).unwrap().x,b.linvel_of(NodeId(0)).unwrap().x,b.position(NodeId(1)).unwrap().x,b.linvel_of(NodeId(1)).unwrap().x, s.contacts.iter().map(|c| c.impulse.x).sum::<f64>()); } } }
#[test] fn dbg(){
        let zeta=0.1f32; let damping = 2.0 * zeta * (1000.0_f32).sqrt();
        let net = Net::new(vec![Node::new(Vector::ZERO, 1e-3), Node::new(Vector::new(1.0, 0.0, 0.0), 1.0)],
            vec![Spring::new(0, 1, 1000.0).damping(damping)]);
        let mut world = PhysicsWorld{gravity: Vector::ZERO, ..PhysicsWorld::default()}; world.integration_parameters.dt=1e-3;
        world.insert(RigidBodyBuilder::fixed().translation(Vector::new(-1.0, 0.0, 0.0)), ColliderBuilder::cuboid(1.0, 1.0, 1.0));
        let mut d = DeformableWorld::default();
        d.insert(DeformableBuilder::new(net).translation(Vector::new(1e-4, 0.0, 0.0)).linvel(Vector::new(-1.0, 0.0, 0.0)).substeps(Substeps::Auto{safety:0.03,min_h:0.0})).unwrap();
        let mut p=P(0); for _ in 0..100 { d.step_with(&mut world, &(), &(), &mut p); }
}
