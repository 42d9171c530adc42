//! Rigid bodies and their colliders, with Rapier's own defaults.

use super::super::check::{DEFORMABLE, FINITE, Length, NOT_NEGATIVE, POINT, POSITIVE, WIDTH};
use super::super::decode::Decoder;
use super::super::schema::{choice, record};
use super::super::tree::Node;
use super::shape::Shape;

record! {
    /// A rigid body.
    pub struct Rigid {
        /// Its name.
        name: String;
        /// What moves it.
        kind: RigidKind = RigidKind::Dynamic;
        /// A deformable in whose own frame the place and the turn are meant, as that is put into the world.
        frame: Option<String> = None, DEFORMABLE;
        /// Where it is \[m\].
        translation: [f64; 3] = [0.0; 3], POINT;
        /// How it is turned: an axis, as long as the angle \[rad\].
        rotation: [f64; 3] = [0.0; 3], FINITE;
        /// Velocity of its origin \[m/s\].
        linvel: [f64; 3] = [0.0; 3], FINITE;
        /// Angular velocity \[rad/s\].
        angvel: [f64; 3] = [0.0; 3], FINITE;
        /// Factor on gravity.
        gravity_scale: f64 = 1.0, FINITE;
        /// Mass beside that of its colliders \[kg\].
        additional_mass: f64 = 0.0, NOT_NEGATIVE;
        /// Damping of its velocity \[1/s\].
        linear_damping: f64 = 0.0, NOT_NEGATIVE;
        /// Damping of its turning \[1/s\].
        angular_damping: f64 = 0.0, NOT_NEGATIVE;
        /// Whether it may fall asleep.
        can_sleep: bool = true;
        /// Whether Rapier looks for what it passes through in one step.
        ccd: bool = false;
        /// Its dominance group.
        dominance: i8 = 0;
        /// Whether it can't turn.
        lock_rotations: bool = false;
        /// What it is made of.
        colliders: Vec<Collider> = Vec::new(), Length { from: 0, to: 1000 };
    }
    then half_spaces
}

/// Rapier has no forces on what has no end, and panics where it meets voxels.
fn half_spaces(body: &Rigid, node: &Node, d: &mut Decoder) -> Option<()> {
    let endless = |shape: &Shape| matches!(shape, Shape::HalfSpace { .. });
    let any = |c: &Collider| match &c.shape {
        Shape::Compound(parts) => parts.iter().any(|p| endless(&p.shape)),
        shape => endless(shape),
    };
    if body.kind == RigidKind::Dynamic && body.colliders.iter().any(any) {
        d.wrong(node.at, |_| {
            "forces move no half-space; give the body `kind: Fixed`, KinematicPosition or KinematicVelocity"
                .into()
        });
        return None;
    }
    Some(())
}

choice! {
    /// What moves a rigid body.
    pub enum RigidKind {
        /// Nothing.
        Fixed;
        /// Forces.
        Dynamic;
        /// Actuators lead it to places.
        KinematicPosition;
        /// Actuators or its first velocity lead it.
        KinematicVelocity;
    }
}

record! {
    /// A collider of a rigid body.
    pub struct Collider {
        /// Its name where forces are measured; that of the body for its first one if it is empty.
        name: String = String::new();
        /// Its shape.
        shape: Shape;
        /// Where it is on the body \[m\].
        translation: [f64; 3] = [0.0; 3], POINT;
        /// How it is turned on the body: an axis, as long as the angle \[rad\].
        rotation: [f64; 3] = [0.0; 3], FINITE;
        /// Its mass \[kg\]; by its density if it is left out.
        mass: Option<f64> = None, POSITIVE;
        /// Density \[kg/m³\]; the default is Rapier's.
        density: f64 = 1.0, NOT_NEGATIVE;
        /// Coulomb's μ.
        friction: f64 = 0.5, NOT_NEGATIVE;
        /// How μ combines with that of what it touches.
        friction_rule: Rule = Rule::Average;
        /// Restitution between rigid bodies.
        restitution: f64 = 0.0, NOT_NEGATIVE;
        /// How restitution combines.
        restitution_rule: Rule = Rule::Average;
        /// Whether it only notices.
        sensor: bool = false;
        /// Which things it meets.
        groups: Groups = Groups::all();
        /// Which things it pushes.
        solver_groups: Groups = Groups::all();
        /// Distance that rigid bodies keep from it \[m\].
        contact_skin: f64 = 0.0, WIDTH;
    }
}

choice! {
    /// How coefficients of two surfaces combine; the later one in this list wins.
    pub enum Rule {
        /// Their mean.
        Average;
        /// The smaller.
        Min;
        /// Their product.
        Multiply;
        /// The larger.
        Max;
        /// Their sum, at most 1.
        ClampedSum;
    }
}

record! {
    /// Collision groups: two things meet if each is in a group that the other looks for.
    pub struct Groups {
        /// The groups it is in, from 1 to 32; all if the list is empty.
        member: Vec<u32> = Vec::new();
        /// The groups it looks for; all if the list is empty.
        with: Vec<u32> = Vec::new();
        /// The groups it does not look for.
        not_with: Vec<u32> = Vec::new();
    }
    then groups
}

impl Groups {
    /// In every group and looking for all.
    pub const fn all() -> Self {
        Self {
            member: Vec::new(),
            with: Vec::new(),
            not_with: Vec::new(),
        }
    }
}

fn groups(groups: &Groups, node: &Node, d: &mut Decoder) -> Option<()> {
    let all = [&groups.member, &groups.with, &groups.not_with];
    match all.into_iter().flatten().find(|g| !(1..=32).contains(*g)) {
        None => Some(()),
        Some(g) => {
            d.wrong(node.at, |_| format!("the group {g} must be from 1 to 32"));
            None
        }
    }
}
