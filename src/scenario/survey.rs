//! What can be said of any world at any moment: its energy, how fast things move, and how deep nodes are in solids.

use super::{Figures, Run};
use crate::math::narrow;
use crate::record::larger;
use crate::world::{Deformable, DeformableWorld};
use rapier3d::geometry::Collider;
use rapier3d::math::Pose;
use rapier3d::parry::shape::{Shape, ShapeType};
use rapier3d::pipeline::PhysicsWorld;

/// Kinetic, elastic and gravity energy of all deformables and dynamic rigid bodies \[J\], heights from y = 0 for rigid
/// bodies and from where they were inserted for deformables.
pub fn mechanical_energy(world: &PhysicsWorld, deformables: &DeformableWorld) -> f64 {
    let soft = deformables.iter().map(|(_, b)| {
        let e = b.energies();
        e.kinetic + e.elastic + e.gravity
    });
    let moving = world.bodies.iter().filter(|(_, b)| b.is_dynamic());
    let rigid = moving.map(|(_, b)| {
        let weight = world.gravity * b.mass() * b.gravity_scale();
        f64::from(b.kinetic_energy()) - f64::from(weight.dot(b.center_of_mass()))
    });
    soft.sum::<f64>() + rigid.sum::<f64>()
}

/// Speed of the fastest node of any deformable \[m/s\].
pub fn fastest_node(deformables: &DeformableWorld) -> f64 {
    let nodes = deformables.iter().flat_map(|(_, b)| b.velocities());
    nodes.map(|v| f64::from(v.length())).fold(0.0, larger)
}

/// Speed of the fastest dynamic rigid body, the mean over its volume of turning included \[m/s\]: √(2·kinetic energy/m).
pub fn fastest_rigid(world: &PhysicsWorld) -> f64 {
    let moving = world.bodies.iter().filter(|(_, b)| b.is_dynamic());
    moving
        .map(|(_, b)| f64::from((2.0 * b.kinetic_energy() / b.mass().max(1.0e-9)).sqrt()))
        .fold(0.0, larger)
}

/// How deep a node at `point` is in a solid \[m\]: 0 outside, and in shapes without an inside.
pub fn depth_in(shape: &dyn Shape, pose: &Pose, point: rapier3d::math::Vector) -> f64 {
    if let Some(compound) = shape.as_compound() {
        let parts = compound.shapes().iter();
        let depths = parts.map(|(p, part)| depth_in(&**part, &(*pose * *p), point));
        return depths.fold(0.0, f64::max);
    }
    let hollow = matches!(
        shape.shape_type(),
        ShapeType::TriMesh | ShapeType::HeightField | ShapeType::Polyline | ShapeType::Triangle
    );
    if hollow {
        return 0.0;
    }
    let projection = shape.project_point(pose, point, false);
    match projection.is_inside {
        true => f64::from(projection.point.distance(point)),
        false => 0.0,
    }
}

/// How deep the nodes of a deformable are in a collider's solid \[m\].
fn depths<'a>(body: &'a Deformable, collider: &'a Collider) -> impl Iterator<Item = f64> + 'a {
    let pose = collider.position();
    let points = body.positions();
    points.map(move |p| depth_in(collider.shape(), pose, p))
}

/// How many nodes are farther than `allowed` m in any solid that they may touch now.
pub fn nodes_through(world: &PhysicsWorld, deformables: &DeformableWorld, allowed: f64) -> usize {
    let count = |(soft, body)| {
        let solids = world.colliders.iter();
        let solids = solids.filter(|(solid, _)| deformables.may_touch(soft, *solid, world));
        let inside = solids.map(|(_, c)| depths(body, c).filter(|d| *d > allowed).count());
        inside.sum::<usize>()
    };
    deformables.iter().map(count).sum()
}

/// Lowest node of any deformable \[m\].
pub fn lowest_node(deformables: &DeformableWorld) -> f64 {
    let nodes = deformables
        .iter()
        .flat_map(|(_, b)| b.positions())
        .map(|p| f64::from(p.y));
    nodes.fold(f64::INFINITY, f64::min)
}

/// Whether all positions and velocities are finite and no deformable is frozen.
pub fn all_finite(world: &PhysicsWorld, deformables: &DeformableWorld) -> bool {
    let soft = deformables.iter().all(|(_, b)| {
        let finite = b.positions().chain(b.velocities()).all(|v| v.is_finite());
        finite && !b.is_frozen() && narrow(b.center_of_mass()).is_finite()
    });
    let mut rigid = world.bodies.iter();
    soft && rigid.all(|(_, b)| {
        let pose = b.position();
        pose.translation.is_finite() && pose.rotation.is_finite() && b.linvel().is_finite()
    })
}

/// Largest rise of a series over its lowest value so far, over its range \[1\]: 0 of what only falls or stays, 1 of what
/// only rises.
pub fn largest_rise(series: &[f64]) -> f64 {
    let (mut least, mut most, mut rise) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
    for &e in series {
        least = least.min(e);
        most = most.max(e);
        rise = larger(rise, e - least);
    }
    match most > least {
        true => rise / (most - least),
        false => rise,
    }
}

/// The figures of any scene.
pub(super) fn figures(run: &Run, f: &mut Figures) {
    let through = nodes_through(&run.world, &run.deformables, 5.0e-3);
    f.add("nodes_through", "nodes inside solids", through as f64, "");
    let depth = run.recorder.max_depth();
    f.add("max_penetration_m", "deepest node", depth, "m");
    f.add("finite", "everything finite", f64::from(run.is_sound()), "");
    let soft = fastest_node(&run.deformables);
    f.add("soft_jitter_mps", "fastest node", soft, "m/s");
    let rigid = fastest_rigid(&run.world);
    f.add("rigid_jitter_mps", "fastest rigid body", rigid, "m/s");
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::math::Vector;
    use rapier3d::parry::shape::{Ball, Cuboid, SharedShape};

    #[test]
    fn depth_is_the_way_out() {
        let pose = Pose::from_translation(Vector::X);
        let cuboid = Cuboid::new(Vector::splat(0.5));
        for (x, depth) in [(1.4, 0.1), (1.0, 0.5), (0.4, 0.0)] {
            let d = depth_in(&cuboid, &pose, Vector::X * x);
            assert!((d - depth).abs() < 1e-6, "{x}: {d}");
        }
        let parts = vec![(pose, SharedShape::new(Ball::new(0.25)))];
        let compound = SharedShape::compound(parts);
        let d = depth_in(&*compound, &pose, Vector::X * 1.8);
        assert!((d - 0.05).abs() < 1e-6, "{d}");
    }

    #[test]
    fn a_rise_is_over_the_lowest_so_far() {
        assert_eq!(largest_rise(&[4.0, 2.0, 0.0]), 0.0);
        assert_eq!(largest_rise(&[4.0, 1.0, 2.0, 0.0]), 0.25);
        assert_eq!(largest_rise(&[0.0, 1.0, 3.0]), 1.0);
        assert_eq!(largest_rise(&[2.0, 2.0]), 0.0);
        assert_eq!(largest_rise(&[]), 0.0);
        assert!(largest_rise(&[1.0, f64::NAN, 0.0]).is_nan());
    }
}
