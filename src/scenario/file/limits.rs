//! What a scene may ask for in all: told of with its place when the scene is known, before memory or time is spent on it.
//!
//! Each limit is about a gigabyte, or ten seconds of building. What only shows once a mesh is read or a body is built is
//! limited there, in [`build`](super::build).

use super::decode::Decoder;
use super::model::{Act, Channel, Deformable, Mesh, RigidKind, Scenario, Substepping};
use super::tree::Node;
use std::collections::BTreeMap;

/// Most nodes of all deformables and soft bodies.
pub(crate) const NODES: f64 = 1.0e6;
/// Most substeps of one deformable: its record has an entry for each.
pub(crate) const SUBSTEPS: f64 = 1.0e8;
/// Most samples of all probes, of all histories, of all paths.
const SAMPLES: f64 = 2.0e7;
/// Most colliders of all rigid bodies.
const COLLIDERS: f64 = 1.0e5;
/// Most points of all shapes.
const POINTS: f64 = 2.0e6;
/// Most nodes of all pictures.
const PICTURED: f64 = 5.0e7;
/// Most evaluations of the formulas that choose nodes.
const CHOICES: f64 = 2.0e7;
/// Samples per second of a channel that no probe is about \[Hz\].
pub(crate) const USUAL_RATE: f64 = 10_000.0;

/// A limit on what all things of a kind come to together.
struct Budget {
    what: &'static str,
    most: f64,
    sum: f64,
}

impl Budget {
    fn new(what: &'static str, most: f64) -> Self {
        Self {
            what,
            most,
            sum: 0.0,
        }
    }

    /// Takes `amount`; complains once, of the first that is too much.
    fn take(&mut self, amount: f64) -> Option<String> {
        let before = self.sum;
        self.sum += amount;
        let Self { what, most, sum } = self;
        (*sum > *most && before <= *most).then(|| {
            format!("with this there are {sum:.0} {what} in all, at most {most} are possible")
        })
    }
}

/// Complains of everything that is too much in all.
pub(super) fn check(scene: &Scenario, node: &Node, d: &mut Decoder) {
    let nodes = nodes(scene, node, d);
    substeps(scene, node, d);
    samples(scene, node, d);
    shapes(scene, node, d);
    choices(scene, &nodes, node, d);
    let pictured = scene.frames.len() as f64 * nodes.values().sum::<f64>();
    if let Some(what) = Budget::new("nodes on pictures", PICTURED).take(pictured) {
        let at = node.get("frames").unwrap_or(node).at;
        d.within(".frames", |d| d.wrong(at, |_| what));
    }
}

/// Nodes of each deformable, as far as they are known.
fn nodes<'a>(scene: &'a Scenario, node: &Node, d: &mut Decoder) -> BTreeMap<&'a str, f64> {
    let mut budget = Budget::new("nodes", NODES);
    let mut of = BTreeMap::new();
    for (i, body) in scene.deformables.iter().enumerate() {
        let count = body.body.nodes().unwrap_or(0.0);
        of.insert(body.name.as_str(), count);
        if let Some(what) = budget.take(count) {
            d.wrong_item(node, "deformables", i, what);
        }
    }
    for (i, body) in scene.soft_bodies.iter().enumerate() {
        if let Some(what) = budget.take(body.particles()) {
            d.wrong_item(node, "soft_bodies", i, what);
        }
    }
    of
}

fn substeps(scene: &Scenario, node: &Node, d: &mut Decoder) {
    let steps = scene.world.duration / scene.world.dt;
    let complaint = |substeps: &Substepping| match substeps {
        Substepping::Fixed(n) | Substepping::Unchecked(n) => {
            Budget::new("substeps", SUBSTEPS).take(steps * *n as f64)
        }
        Substepping::Auto { .. } => None,
    };
    if let Some(what) = complaint(&scene.world.substeps) {
        let at = node.get("world").unwrap_or(node).at;
        d.within(".world", |d| d.wrong(at, |_| what));
    }
    for (i, body) in scene.deformables.iter().enumerate() {
        if let Some(what) = body.substeps.as_ref().and_then(complaint) {
            d.wrong_item(node, "deformables", i, what);
        }
    }
}

fn samples(scene: &Scenario, node: &Node, d: &mut Decoder) {
    let world = &scene.world;
    let (history, energy) = (
        world.duration / world.history,
        world.duration / world.energy,
    );
    let mut histories = Budget::new("samples of history and energy", SAMPLES);
    for i in 0..scene.deformables.len() {
        if let Some(what) = histories.take(history + energy) {
            d.wrong_item(node, "deformables", i, what);
        }
    }
    for i in 0..scene.sets.len() {
        if let Some(what) = histories.take(history) {
            d.wrong_item(node, "sets", i, what);
        }
    }
    let mut paths = Budget::new("samples of paths", SAMPLES);
    for (i, body) in scene.rigid.iter().enumerate() {
        let moves = body.kind != RigidKind::Fixed;
        let what = moves.then(|| paths.take(world.duration / world.dt));
        if let Some(what) = what.flatten() {
            d.wrong_item(node, "rigid", i, what);
        }
    }
    let mut budget = Budget::new("samples of channels", SAMPLES);
    for (i, probe) in scene.probes.iter().enumerate() {
        let what = budget.take(probe.samples(world.duration));
        let followed = probe.of.region().and_then(|_| histories.take(history));
        if let Some(what) = what.or(followed) {
            d.wrong_item(node, "probes", i, what);
        }
    }
    for (i, expected) in scene.expect.iter().enumerate() {
        let channel = expected.that.channel();
        let binned = channel.is_some_and(Channel::is_binned);
        let what = binned
            .then(|| budget.take(USUAL_RATE * world.duration))
            .flatten();
        let followed = channel.and_then(Channel::region);
        let followed = followed.and_then(|_| histories.take(history));
        if let Some(what) = what.or(followed) {
            d.wrong_item(node, "expect", i, what);
        }
    }
}

fn shapes(scene: &Scenario, node: &Node, d: &mut Decoder) {
    let mut colliders = Budget::new("colliders", COLLIDERS);
    let mut points = Budget::new("points of shapes", POINTS);
    for (i, body) in scene.rigid.iter().enumerate() {
        let what = colliders.take(body.colliders.len() as f64);
        let sum = body.colliders.iter().map(|c| c.shape.points()).sum();
        for what in [what, points.take(sum)].into_iter().flatten() {
            d.wrong_item(node, "rigid", i, what);
        }
    }
    for (i, body) in scene.deformables.iter().enumerate() {
        let sum = body.embed.as_ref().map_or(0.0, Mesh::points);
        if let Some(what) = points.take(sum) {
            d.wrong_item(node, "deformables", i, what);
        }
    }
}

/// A formula that chooses nodes is evaluated at each node of its body.
fn choices(scene: &Scenario, nodes: &BTreeMap<&str, f64>, node: &Node, d: &mut Decoder) {
    let mut budget = Budget::new("evaluations of formulas that choose nodes", CHOICES);
    let of = |name: &str| nodes.get(name).copied().unwrap_or(0.0);
    let mut take = |list: &str, i: usize, amount: f64| {
        if let Some(what) = budget.take(amount) {
            d.wrong_item(node, list, i, what);
        }
    };
    for (i, body) in scene.deformables.iter().enumerate() {
        take("deformables", i, of(&body.name) * formulas(body) as f64);
    }
    for (i, held) in scene.attachments.iter().enumerate() {
        take("attachments", i, of(&held.of));
    }
    for (i, set) in scene.sets.iter().enumerate() {
        take("sets", i, of(&set.of));
    }
    for (i, act) in scene.actuators.iter().enumerate() {
        if let Act::Force { on: name, .. } | Act::Move { of: name, .. } = act {
            take("actuators", i, of(name));
        }
    }
    for (i, probe) in scene.probes.iter().enumerate() {
        take(
            "probes",
            i,
            probe.of.region().map_or(0.0, |(name, _)| of(name)),
        );
    }
    for (i, expected) in scene.expect.iter().enumerate() {
        let region = expected.that.channel().and_then(Channel::region);
        take("expect", i, region.map_or(0.0, |(name, _)| of(name)));
    }
}

fn formulas(body: &Deformable) -> usize {
    body.parts.len() + usize::from(body.pin.is_some())
}
