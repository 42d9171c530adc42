//! The scene as plain data, one file per kind of thing.

pub mod actuator;
pub mod deformable;
pub mod expect;
pub mod joint;
pub mod material;
pub mod probe;
pub mod rigid;
pub mod shape;
pub mod soft_body;
pub mod world;

use super::check::{BODY, FINITE, Length};
use super::decode::{Check, Decoder};
use super::formula::Variables;
use super::schema::{Entry, record};
use super::tree::Node;
pub use actuator::{Act, Signal};
pub use deformable::{Alike, Attachment, Body, Deformable, Hold, Region, Set};
pub use expect::{Expectation, Quantity};
pub use joint::{Joint, JointKind, Motor};
pub use material::{AnyMaterial, Law, SolidMaterial, SpringMaterial};
pub use probe::{Axis, Channel, Class, Energy, Probe};
pub use rigid::{Collider, Groups, Rigid, RigidKind, Rule};
pub use shape::{Mesh, Shape};
pub use soft_body::SoftBody;
use std::collections::BTreeMap;
pub use world::{Scheme, Stop, Substepping, World};

record! {
    /// A scene: what is in it, what happens to it, what is measured, and what must come out.
    pub struct Scenario {
        /// What happens, in one line.
        about: String = String::new();
        /// Whether it takes so long that the ordinary tests leave it out.
        slow: bool = false;
        /// Numbers by name, for formulas; `--set name=value` changes one. A formula may name others.
        variables: Variables = Variables::new();
        /// Scenes whose things are put before those of this one, relative to this file. A value that stands in both is taken
        /// from here. Empty once the scene is loaded.
        include: Vec<String> = Vec::new();
        /// Materials by name, for deformables to share.
        materials: BTreeMap<String, AnyMaterial> = BTreeMap::new();
        /// Gravity, time, substeps.
        world: World = World::default();
        /// Rigid bodies with their colliders.
        rigid: Vec<Rigid> = Vec::new(), Length { from: 0, to: 20_000 };
        /// Joints between rigid bodies.
        joints: Vec<Joint> = Vec::new(), Length { from: 0, to: 20_000 };
        /// Deformable bodies.
        deformables: Vec<Deformable> = Vec::new(), Length { from: 0, to: 10_000 };
        /// Soft bodies of Rapier's own, to compare with.
        soft_bodies: Vec<SoftBody> = Vec::new(), Length { from: 0, to: 100 };
        /// What holds nodes of deformables to rigid bodies, to each other or to the world.
        attachments: Vec<Attachment> = Vec::new(), Length { from: 0, to: 10_000 };
        /// Nodes whose mean is followed.
        sets: Vec<Set> = Vec::new(), Length { from: 0, to: 1000 };
        /// Pairs of bodies that do not touch each other.
        no_contact: Vec<[String; 2]> = Vec::new(), PAIRS;
        /// Forces, motions and motors over time.
        actuators: Vec<Act> = Vec::new(), Length { from: 0, to: 10_000 };
        /// Channels that are written and can be named in expectations.
        probes: Vec<Probe> = Vec::new(), Length { from: 0, to: 1000 };
        /// What must come out.
        expect: Vec<Expectation> = Vec::new(), Length { from: 0, to: 1000 };
        /// From which direction pictures are taken, any length.
        view: [f64; 3] = [-0.05, 0.38, 1.0], FINITE;
        /// When pictures are taken \[s\], ascending, not after the end; at the beginning and the end if the list is empty.
        frames: Vec<f64> = Vec::new(), FRAMES;
    }
    then together
}

/// What only shows when all of a scene is known.
fn together(scene: &Scenario, node: &Node, d: &mut Decoder) -> Option<()> {
    super::limits::check(scene, node, d);
    super::whole::check(scene, node, d);
    (!d.failed()).then_some(())
}

/// Most pairs of bodies that do not touch, each of which is looked for at every contact.
const MOST_PAIRS: usize = 1000;

/// Times of pictures.
struct Frames;
const FRAMES: Frames = Frames;

impl Check<Vec<f64>> for Frames {
    fn complaint(&self, times: &Vec<f64>, d: &Decoder) -> Option<String> {
        let few = Length { from: 0, to: 1000 };
        few.complaint(times, d)
            .or_else(|| FINITE.complaint(times, d))
    }
}

/// Both names of every pair are those of bodies.
struct Pairs;
const PAIRS: Pairs = Pairs;

impl Check<Vec<[String; 2]>> for Pairs {
    fn complaint(&self, pairs: &Vec<[String; 2]>, d: &Decoder) -> Option<String> {
        let few = Length {
            from: 0,
            to: MOST_PAIRS,
        };
        let wrong = |pair: &[String; 2]| match pair {
            [a, b] if a == b => Some(format!("`{a}` does not touch itself anyway")),
            _ => BODY.complaint(pair, d),
        };
        few.complaint(pairs, d)
            .or_else(|| pairs.iter().find_map(wrong))
    }
}

/// Every key and variant with its default and what it means, from the whole to the parts.
pub fn reference() -> Vec<Entry> {
    [
        Scenario::KEYS,
        World::KEYS,
        Substepping::KEYS,
        Scheme::KEYS,
        Stop::KEYS,
        Rigid::KEYS,
        RigidKind::KEYS,
        Collider::KEYS,
        Shape::KEYS,
        shape::Placed::KEYS,
        Mesh::KEYS,
        Rule::KEYS,
        Groups::KEYS,
        Joint::KEYS,
        JointKind::KEYS,
        Motor::KEYS,
        Deformable::KEYS,
        Body::KEYS,
        deformable::NodeSpec::KEYS,
        deformable::SpringSpec::KEYS,
        deformable::Split::KEYS,
        Alike::KEYS,
        deformable::Part::KEYS,
        SpringMaterial::KEYS,
        SolidMaterial::KEYS,
        Law::KEYS,
        SoftBody::KEYS,
        Set::KEYS,
        Attachment::KEYS,
        Hold::KEYS,
        Act::KEYS,
        Probe::KEYS,
        Class::KEYS,
        Channel::KEYS,
        Axis::KEYS,
        Energy::KEYS,
        Expectation::KEYS,
        Quantity::KEYS,
    ]
    .concat()
}
