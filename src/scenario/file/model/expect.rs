//! What must come out of a run.

use super::super::check::{DEFORMABLE, FINITE, NOT_NEGATIVE};
use super::super::decode::Decoder;
use super::super::schema::{choice, record};
use super::super::tree::Node;
use super::probe::{Axis, Channel};

record! {
    /// What must come out: a quantity, and bounds on it, or a value with a tolerance.
    pub struct Expectation {
        /// What it is about; the quantity itself if it is empty.
        name: String = String::new();
        /// The quantity.
        that: Quantity;
        /// It is at least this, in its unit.
        at_least: Option<f64> = None, FINITE;
        /// It is at most this, in its unit.
        at_most: Option<f64> = None, FINITE;
        /// It is this, to the tolerance of `within` or `within_share`.
        equals: Option<f64> = None, FINITE;
        /// Tolerance about `equals`, in its unit.
        within: Option<f64> = None, NOT_NEGATIVE;
        /// Tolerance about `equals`, as a share of it.
        within_share: Option<f64> = None, NOT_NEGATIVE;
        /// The span of time that a channel is looked at \[s\], which must end with the run at the latest; the whole run if it is
        /// left out.
        over: Option<[f64; 2]> = None, FINITE;
        /// The hash that `StateHash` must have, 16 hexadecimal digits.
        hash: Option<String> = None;
    }
    then bounded
}

fn bounded(e: &Expectation, node: &Node, d: &mut Decoder) -> Option<()> {
    let hash = matches!(e.that, Quantity::StateHash);
    let bounds = e.at_least.is_some() || e.at_most.is_some() || e.equals.is_some();
    let tolerance = e.within.is_some() || e.within_share.is_some();
    let complaint = if hash && (bounds || tolerance || e.hash.is_none()) {
        "StateHash goes with `hash: \"…\"` and nothing else"
    } else if e.hash.as_ref().is_some_and(|h| !is_hash(h)) {
        "a hash has 16 hexadecimal digits"
    } else if !hash && e.hash.is_some() {
        "`hash` goes with StateHash"
    } else if !hash && !bounds {
        "nothing is expected; give `at_least`, `at_most` or `equals`"
    } else if e.equals.is_some() != tolerance || (e.within.is_some() && e.within_share.is_some()) {
        "`equals` goes with one of `within` and `within_share`"
    } else if e.equals == Some(0.0) && e.within_share.is_some() {
        "a share of 0 is nothing; give `within`"
    } else if e.at_least.zip(e.at_most).is_some_and(|(lo, hi)| lo > hi) {
        "`at_least` is above `at_most`"
    } else if e.over.is_some_and(|[from, to]| from >= to) {
        "`over` must be (from, to) with from before to"
    } else if e.over.is_some_and(|[_, to]| to < 0.0) {
        "`over` must not end before the run begins"
    } else if e.over.is_some() && e.that.channel().is_none() {
        "`over` goes with quantities of a channel"
    } else {
        return Some(());
    };
    d.wrong(node.at, |_| complaint.into());
    None
}

fn is_hash(text: &str) -> bool {
    text.len() == 16 && text.bytes().all(|b| b.is_ascii_hexdigit())
}

choice! {
    /// A number that a run comes to.
    pub enum Quantity {
        /// Largest value of a channel.
        Peak(Channel);
        /// Smallest value of a channel.
        Lowest(Channel);
        /// Largest distance of a channel from 0.
        PeakSize(Channel);
        /// Mean of a channel over time.
        Mean(Channel);
        /// First value of a channel.
        First(Channel);
        /// Last value of a channel.
        Final(Channel);
        /// Last value of a channel minus its first.
        Change(Channel);
        /// Value of a channel at a time, straight between samples.
        At {
            /// The channel.
            channel: Channel;
            /// When \[s\].
            time: f64, NOT_NEGATIVE;
        };
        /// When a channel is largest \[s\].
        PeakTime(Channel);
        /// Integral of a channel over time, in its unit times s.
        Integral(Channel);
        /// Mean time from one rise through the mean to the next \[s\].
        Period(Channel);
        /// How much shorter a deformable gets along an axis, at the most \[m\].
        Crush {
            /// The deformable.
            of: String, DEFORMABLE;
            /// Along which axis.
            axis: Axis;
        };
        /// How much shorter a deformable is along an axis at the end \[m\].
        LastingCrush {
            /// The deformable.
            of: String, DEFORMABLE;
            /// Along which axis.
            axis: Axis;
        };
        /// Speed away over speed towards: minus the last velocity over the first.
        Rebound(Channel);
        /// Largest energy residual of any deformable, as a share of its energies.
        EnergyResidual;
        /// Largest error of Σ impulses = Δp of any deformable, as a share of Δp. Impulses are those of contacts, attachments and
        /// gravity; bodies with pinned nodes, drag, mass damping or forces of actuators do not close.
        MomentumClosure;
        /// Work of shadows that Rapier did otherwise, summed over its absolute values \[J\].
        CouplingDefect;
        /// Largest rise of the mechanical energy over its lowest so far, as a share of its range: 1 of what only rises.
        EnergyRise;
        /// Deepest that any node was in anything \[m\].
        DeepestPenetration;
        /// Nodes deeper than this in solids that they may touch, at the end \[m\].
        NodesThrough(f64, NOT_NEGATIVE);
        /// Springs that have begun to yield.
        Yielded;
        /// Springs that have broken.
        Broken;
        /// Attachments that have broken.
        AttachmentsBroken;
        /// Contacts of a deformable that began.
        ContactsBegun;
        /// From when on nothing was faster than this \[m/s\] until the end \[s\]; inf if that was never.
        RestTime(f64, NOT_NEGATIVE);
        /// Rigid bodies asleep at the end.
        Asleep;
        /// 1 if every position and velocity is finite, and every actuator was, 0 if not. A run in which one is not fails,
        /// unless the file expects something of this itself.
        Finite;
        /// Time that was simulated \[s\].
        Time;
        /// Bit for bit the state of all deformables; with `hash`.
        StateHash;
    }
}

impl Quantity {
    /// The channel it is of.
    pub fn channel(&self) -> Option<&Channel> {
        match self {
            Self::Peak(c)
            | Self::Lowest(c)
            | Self::PeakSize(c)
            | Self::Mean(c)
            | Self::First(c)
            | Self::Final(c)
            | Self::Change(c)
            | Self::PeakTime(c)
            | Self::Integral(c)
            | Self::Period(c)
            | Self::Rebound(c) => Some(c),
            Self::At { channel, .. } => Some(channel),
            _ => None,
        }
    }
}
