//! What is measured over time.

use super::super::check::{BODY, DEFORMABLE, FINITE, PARTNER, PROBE, RATE, RIGID};
use super::super::decode::Decoder;
use super::super::limits::USUAL_RATE;
use super::super::schema::{choice, record};
use super::super::tree::{Node, Value};
use super::deformable::Region;
use crate::record::Cfc;

record! {
    /// A channel that is written and can be named.
    pub struct Probe {
        /// Its name.
        name: String;
        /// What is measured.
        of: Channel;
        /// Factor on its values.
        scale: f64 = 1.0, FINITE;
        /// Samples per second \[Hz\]. Forces and accelerations are means over them, other values lie straight between those
        /// that were recorded. Without it the former have 10 kHz and the others come as they are recorded.
        rate: Option<f64> = None, RATE;
        /// The filter of SAE J211. What is not a force or an acceleration must be recorded often enough for it, by `history`,
        /// `energy` or `dt` of the world.
        cfc: Option<Class> = None;
    }
    then no_probe
}

impl Probe {
    /// How many samples it has over a run of this duration \[s\], if it does not come as it is recorded.
    pub(crate) fn samples(&self, duration: f64) -> f64 {
        let usual = if self.of.is_binned() { USUAL_RATE } else { 0.0 };
        self.rate.unwrap_or(usual) * duration
    }
}

impl Class {
    /// The filter.
    pub(crate) fn cfc(&self) -> Cfc {
        match self {
            Self::Cfc60 => Cfc::Cfc60,
            Self::Cfc180 => Cfc::Cfc180,
            Self::Cfc600 => Cfc::Cfc600,
            Self::Cfc1000 => Cfc::Cfc1000,
        }
    }
}

impl Channel {
    /// The unit of its values; `None` for what a probe measures, which may be scaled.
    pub fn unit(&self) -> Option<&'static str> {
        Some(match self {
            Self::Probe(_) => return None,
            Self::Force { .. } => "N",
            Self::Position { .. } | Self::Low { .. } | Self::High { .. } | Self::Extent { .. } => {
                "m"
            }
            Self::Velocity { .. } | Self::Fastest => "m/s",
            Self::Acceleration { .. } => "m/s²",
            Self::Spin { .. } => "rad/s",
            Self::Energy { .. } | Self::MechanicalEnergy => "J",
            Self::Stress { .. } => "Pa",
        })
    }

    /// Whether its values are means over bins of time, as those of forces are.
    pub(crate) fn is_binned(&self) -> bool {
        matches!(self, Self::Force { .. } | Self::Acceleration { .. })
    }

    /// The body whose nodes or tets a formula chooses, with the formula.
    pub(crate) fn region(&self) -> Option<(&str, &Region)> {
        match self {
            Self::Position { of, nodes, .. }
            | Self::Velocity { of, nodes, .. }
            | Self::Acceleration { of, nodes, .. } => nodes.as_ref().map(|r| (of.as_str(), r)),
            Self::Stress { of, at } => at.as_ref().map(|r| (of.as_str(), r)),
            _ => None,
        }
    }
}

fn no_probe(probe: &Probe, node: &Node, d: &mut Decoder) -> Option<()> {
    if !matches!(probe.of, Channel::Probe(_)) {
        return Some(());
    }
    d.wrong(node.at, |_| "a probe can't be another probe".into());
    None
}

choice! {
    /// A channel frequency class.
    pub enum Class {
        /// -3 dB at 100 Hz.
        Cfc60;
        /// -3 dB at 300 Hz.
        Cfc180;
        /// -3 dB at 1000 Hz.
        Cfc600;
        /// -3 dB at 1650 Hz.
        Cfc1000;
    }
}

choice! {
    /// An axis of the world.
    pub enum Axis {
        /// Forward.
        X;
        /// Up.
        Y;
        /// Sideways.
        Z;
    }
}

choice! {
    /// Something that is measured over time. The name of a probe in quotes is that probe.
    pub enum Channel {
        /// A probe by its name.
        Probe(String, PROBE);
        /// Force of a rigid body's collider, a deformable or an attachment on deformables \[N\].
        Force {
            /// What exerts it: a body, a collider, an attachment.
            by: String, PARTNER;
            /// The deformable it acts on; all if it is left out.
            on: Option<String> = None, DEFORMABLE;
            /// Along which axis.
            axis: Axis;
        };
        /// Place of a body's centre of mass, or of the mean of some nodes \[m\].
        Position {
            /// The body.
            of: String, BODY;
            /// Which nodes of a deformable: a formula of x, y, z; all if it is left out.
            nodes: Option<Region> = None;
            /// Along which axis.
            axis: Axis;
        };
        /// Velocity of a body's centre of mass, or of the mean of some nodes \[m/s\].
        Velocity {
            /// The body.
            of: String, BODY;
            /// Which nodes of a deformable: a formula of x, y, z; all if it is left out.
            nodes: Option<Region> = None;
            /// Along which axis.
            axis: Axis;
        };
        /// Acceleration of a deformable's centre of mass, or of the mean of some nodes \[m/s²\].
        Acceleration {
            /// The deformable.
            of: String, DEFORMABLE;
            /// Which nodes: a formula of x, y, z; all if it is left out.
            nodes: Option<Region> = None;
            /// Along which axis.
            axis: Axis;
        };
        /// Angular velocity of a rigid body \[rad/s\].
        Spin {
            /// The body.
            of: String, RIGID;
            /// About which axis.
            axis: Axis;
        };
        /// Lowest coordinate of any node \[m\].
        Low {
            /// The deformable.
            of: String, DEFORMABLE;
            /// Along which axis.
            axis: Axis;
        };
        /// Highest coordinate of any node \[m\].
        High {
            /// The deformable.
            of: String, DEFORMABLE;
            /// Along which axis.
            axis: Axis;
        };
        /// Extent over all nodes \[m\].
        Extent {
            /// The deformable.
            of: String, DEFORMABLE;
            /// Along which axis.
            axis: Axis;
        };
        /// One term of a deformable's energies \[J\].
        Energy {
            /// The deformable.
            of: String, DEFORMABLE;
            /// Which.
            term: Energy;
        };
        /// Von Mises stress, mean by volume over some tets \[Pa\].
        Stress {
            /// The deformable.
            of: String, DEFORMABLE;
            /// Which tets, by their middles: a formula of x, y, z; all if it is left out.
            at: Option<Region> = None;
        };
        /// Kinetic, elastic and gravity energy of everything that moves freely \[J\].
        MechanicalEnergy;
        /// Speed of the fastest node or rigid body \[m/s\].
        Fastest;
    }
    otherwise probe_by_name
}

fn probe_by_name(node: &Node, d: &mut Decoder) -> Option<Option<Channel>> {
    let Value::Text(name) = &node.value else {
        return None;
    };
    // JSON writes the variants without fields as texts.
    if matches!(name.as_str(), "MechanicalEnergy" | "Fastest") {
        return None;
    }
    let wrong = super::super::decode::Check::complaint(&PROBE, name, d);
    Some(match wrong {
        None => Some(Channel::Probe(name.clone())),
        Some(what) => {
            d.wrong(node.at, |_| what);
            None
        }
    })
}

choice! {
    /// A term of a deformable's energies.
    pub enum Energy {
        /// Of its motion.
        Kinetic;
        /// Of its springs and tets.
        Elastic;
        /// Lost to flow.
        Plastic;
        /// Lost to damping.
        Damping;
        /// Lost to breaking.
        Fracture;
        /// Lost to contact along normals.
        ContactNormal;
        /// Lost to friction.
        ContactFriction;
        /// Of its weight, from where it began.
        Gravity;
        /// Work of forces from outside.
        External;
        /// Work received from rigid bodies.
        Rigid;
        /// Added by moving nodes out of solids.
        PushOut;
        /// What stays constant.
        Balance;
    }
}
