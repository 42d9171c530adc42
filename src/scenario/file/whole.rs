//! What only the whole scene shows to be wrong: actions on bodies that can't take them, channels that bodies do not have,
//! keys that would be passed over.

use super::decode::Decoder;
use super::limits::USUAL_RATE;
use super::model::{Act, Body, Channel, Probe, Quantity, RigidKind, Scenario, Signal};
use super::tree::Node;
use std::collections::BTreeMap;

/// Complains of everything that does not fit together.
pub(super) fn check(scene: &Scenario, node: &Node, d: &mut Decoder) {
    let bodies = Bodies::of(scene);
    for (i, body) in scene.rigid.iter().enumerate() {
        for (j, collider) in body.colliders.iter().enumerate() {
            if let Some(what) = collider.shape.complaint() {
                let at = collider_of(node, i, j).at;
                let key = format!(".rigid[{i}].colliders[{j}].shape");
                d.within(key, |d| d.wrong(at, |_| what.into()));
            }
        }
    }
    let mut led = BTreeMap::new();
    for (i, act) in scene.actuators.iter().enumerate() {
        let complaint = bodies.cant_take(act).map(str::to_owned);
        if let Some(what) = complaint.or_else(|| twice(act, i, &bodies, &mut led)) {
            d.wrong_item(node, "actuators", i, what);
        }
    }
    for (i, probe) in scene.probes.iter().enumerate() {
        let complaint = bodies.have_not(&probe.of).map(str::to_owned);
        let complaint = complaint.or_else(|| too_seldom(scene, probe, &bodies));
        if let Some(what) = complaint {
            d.wrong_item(node, "probes", i, what);
        }
    }
    for (i, expected) in scene.expect.iter().enumerate() {
        let channel = expected.that.channel();
        if let Some(what) = channel.and_then(|c| bodies.have_not(c)) {
            d.wrong_item(node, "expect", i, what.into());
        }
        if matches!(expected.that, Quantity::MomentumClosure)
            && let Some(what) = bodies.not_closed(scene)
        {
            d.wrong_item(node, "expect", i, what);
        }
    }
    frames(scene, node, d);
    if scene.view.map(|x| x as f32) == [0.0; 3] {
        let at = node.get("view").unwrap_or(node).at;
        let what = "is no direction, it must point from the scene to the eye";
        d.within(".view", |d| d.wrong(at, |_| what.into()));
    }
}

/// What stands for a collider.
fn collider_of(scene: &Node, body: usize, collider: usize) -> &Node {
    let list = scene.get("rigid").and_then(Node::items).unwrap_or(&[]);
    let body = list.get(body).unwrap_or(scene);
    let list = body.get("colliders").and_then(Node::items).unwrap_or(&[]);
    list.get(collider).unwrap_or(body)
}

/// Pictures are taken one after the other.
fn frames(scene: &Scenario, node: &Node, d: &mut Decoder) {
    let at = node.get("frames").unwrap_or(node).at;
    let early = scene.frames.iter().find(|t| **t < 0.0);
    let back = scene.frames.windows(2).find(|t| t[1] < t[0]);
    let complaint = match (early, back) {
        (Some(t), _) => format!("{t} s is before the beginning"),
        (_, Some(t)) => format!("{} s stands after {} s, they must ascend", t[1], t[0]),
        _ => return,
    };
    d.within(".frames", |d| d.wrong(at, |_| complaint));
}

/// What two actions would do to the same thing, of which the later would win.
fn twice<'a>(
    act: &'a Act,
    i: usize,
    bodies: &Bodies,
    led: &mut BTreeMap<(&'a str, &'static str), usize>,
) -> Option<String> {
    let does: Vec<(&str, &'static str)> = match act {
        // Several may lead different nodes of a deformable.
        Act::Move { of, .. } if bodies.rigid.contains_key(of.as_str()) => vec![(of, "place")],
        Act::Drive {
            joint,
            position,
            velocity,
        } => [
            position.as_ref().map(|_| (joint.as_str(), "aim")),
            velocity.as_ref().map(|_| (joint.as_str(), "velocity")),
        ]
        .into_iter()
        .flatten()
        .collect(),
        _ => return None,
    };
    let before = does.iter().find_map(|key| Some((key.0, *led.get(key)?)));
    led.extend(does.iter().map(|key| (*key, i)));
    let (name, before) = before?;
    Some(format!("actuators[{before}] leads `{name}` already"))
}

/// A filter needs samples, and how often a channel is recorded is known.
fn too_seldom(scene: &Scenario, probe: &Probe, bodies: &Bodies) -> Option<String> {
    let class = probe.cfc.as_ref()?;
    let world = &scene.world;
    let rigid = |of: &str| bodies.rigid.contains_key(of);
    let interval = match &probe.of {
        of if of.is_binned() => 1.0 / probe.rate.unwrap_or(USUAL_RATE),
        Channel::MechanicalEnergy | Channel::Fastest | Channel::Spin { .. } => world.dt,
        Channel::Position { of, .. } | Channel::Velocity { of, .. } if rigid(of) => world.dt,
        Channel::Energy { .. } => world.energy,
        _ => world.history,
    };
    class
        .cfc()
        .coefficients(interval)
        .err()
        .map(|e| e.to_string())
}

/// Who can take what.
struct Bodies<'a> {
    rigid: BTreeMap<&'a str, &'a RigidKind>,
    /// Deformables, and whether nodes of theirs may be pinned and whether they have tets.
    soft: BTreeMap<&'a str, (bool, bool)>,
    /// Joints with motors.
    motors: Vec<&'a str>,
}

impl<'a> Bodies<'a> {
    fn of(scene: &'a Scenario) -> Self {
        let rigid = scene.rigid.iter().map(|r| (r.name.as_str(), &r.kind));
        let soft = scene.deformables.iter().map(|body| {
            let held = match &body.body {
                Body::Net { nodes, .. } => nodes.iter().any(|n| n.pinned),
                _ => false,
            };
            let pinned = held || body.pin.is_some();
            (body.name.as_str(), (pinned, body.body.has_tets()))
        });
        let motors = scene.joints.iter().filter(|j| j.motor.is_some());
        Self {
            rigid: rigid.collect(),
            soft: soft.collect(),
            motors: motors.map(|j| j.name.as_str()).collect(),
        }
    }

    /// Why the impulses that are recorded do not sum up to the change of momentum, if they can't.
    fn not_closed(&self, scene: &Scenario) -> Option<String> {
        let pinned = self.soft.iter().find(|(_, (pinned, _))| *pinned);
        let dragged = scene.deformables.iter().find(|body| {
            let solid = body.solid.as_ref().map_or(0.0, |s| s.0.mass_damping);
            body.drag > 0.0 || solid > 0.0
        });
        let mut acts = scene.actuators.iter();
        let pushed = acts.find_map(|act| match act {
            Act::Force { on, .. } => self.soft.get_key_value(on.as_str()),
            _ => None,
        });
        let (name, why) = match (pinned, dragged, pushed) {
            (Some((name, _)), ..) => (*name, "has pinned nodes"),
            (_, Some(body), _) => (body.name.as_str(), "has drag or mass damping"),
            (.., Some((name, _))) => (*name, "has a force of an actuator"),
            _ => return None,
        };
        let what = "contacts, attachments and gravity alone are summed";
        Some(format!("`{name}` {why}: {what}"))
    }

    /// Why what an action is about can't take it.
    fn cant_take(&self, act: &Act) -> Option<&'static str> {
        match act {
            Act::Force {
                on, nodes, torque, ..
            } => match self.rigid.get(on.as_str()) {
                Some(RigidKind::Dynamic) if nodes.is_none() => None,
                Some(_) => Some("forces act on dynamic rigid bodies, as a whole"),
                None if *torque != Signal::none() => Some("torques act on rigid bodies only"),
                None => None,
            },
            Act::Move {
                of, nodes, turn, ..
            } => match (self.rigid.get(of.as_str()), self.soft.get(of.as_str())) {
                (Some(RigidKind::KinematicPosition), _) if nodes.is_none() => None,
                (Some(_), _) => {
                    Some("only bodies of kind KinematicPosition can be led, as a whole")
                }
                (None, _) if *turn != Signal::none() => Some("only rigid bodies can be turned"),
                (None, Some((false, _))) => {
                    Some("only pinned nodes can be led, and none is pinned there")
                }
                _ => None,
            },
            Act::Drive { joint, .. } => {
                let known = self.motors.contains(&joint.as_str());
                (!known).then_some("only a joint with a motor can be driven")
            }
        }
    }

    /// Why a body has no such channel.
    fn have_not(&self, channel: &Channel) -> Option<&'static str> {
        if let Some((of, _)) = channel.region()
            && self.rigid.contains_key(of)
        {
            return Some("only a deformable has nodes");
        }
        match channel {
            Channel::Stress { of, .. } => match self.soft.get(of.as_str()) {
                Some((_, false)) => Some("only a body of tets has stresses"),
                _ => None,
            },
            _ => None,
        }
    }
}
