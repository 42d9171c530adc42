//! What is kept of one deformable.
//!
//! Cheap things (momentum, centre of mass, bounds: a pass over the nodes) are sampled often; the energies cost a pass over
//! the springs and are sampled seldom. Impulses are summed every substep, because nothing else closes: the change of
//! momentum equals the sum of all impulses to round-off or a force is missing.

use super::channel::{Channel, Interface};
use super::history::Moments;
use super::larger;
use super::recorder::Sampling;
use crate::math::DVec3;
use crate::world::{Deformable, DeformableHandle, Energies, Substep};

/// Energies at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LedgerSample {
    /// When \[s\].
    pub time: f64,
    /// Energies and work so far \[J\].
    pub energies: Energies,
    /// |balance − first balance| over the largest [`Energies::scale`] so far \[1\].
    pub residual: f64,
}

/// How well impulses explain the change of momentum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Closure {
    /// Sum of contact impulses \[N·s\].
    pub contact: DVec3,
    /// Sum of attachment impulses \[N·s\].
    pub attachment: DVec3,
    /// Impulse of gravity \[N·s\].
    pub gravity: DVec3,
    /// Change of momentum \[N·s\].
    pub change: DVec3,
    /// Largest change of momentum so far \[N·s\].
    pub scale: f64,
}

impl Closure {
    /// |Σ impulses − Δp| over the largest |Δp| so far \[1\]. Node forces, force fields, drag, mass damping, pinned nodes
    /// and changes of mass or velocity by hand are not in the sum, so a body that has them does not close.
    pub fn error(&self) -> f64 {
        let defect = self.contact + self.attachment + self.gravity - self.change;
        defect.length() / self.scale.max(f64::MIN_POSITIVE)
    }
}

/// The recording of one deformable.
#[derive(Clone, Debug)]
pub struct BodyRecord {
    /// Which.
    pub deformable: DeformableHandle,
    /// Edges of its substeps \[s\]: one more than there are substeps.
    pub edges: Vec<f64>,
    /// Force channels in the order of first touch.
    pub channels: Vec<Channel>,
    /// Centre of mass.
    pub center: Moments,
    /// Momentum at the times of `center` \[N·s\].
    pub momenta: Vec<DVec3>,
    /// Lower and upper corner of the nodes at the times of `center` \[m\].
    pub bounds: Vec<[DVec3; 2]>,
    /// Energies.
    pub ledger: Vec<LedgerSample>,
    /// Impulses and momentum at the last sample of `center`.
    pub closure: Closure,
    /// Mass at the last sample of `center` \[kg\].
    pub mass: f64,
    start: DVec3,
    sums: [DVec3; 3],
    scale: f64,
    next: f64,
    next_ledger: f64,
}

impl BodyRecord {
    /// Begins at `time` with the body as it is.
    pub(super) fn new(deformable: DeformableHandle, body: &Deformable, time: f64) -> Self {
        let mut record = Self {
            deformable,
            edges: vec![time],
            channels: Vec::new(),
            center: Moments::default(),
            momenta: Vec::new(),
            bounds: Vec::new(),
            ledger: Vec::new(),
            closure: Closure::default(),
            mass: body.mass(),
            start: body.momentum() + body.momentum_lost_in_sleep(),
            sums: [DVec3::ZERO; 3],
            scale: 0.0,
            next: time,
            next_ledger: time,
        };
        record.sample(body, time);
        record.balance(body, time);
        record
    }

    /// Takes in a substep; says whether samples are due.
    pub(super) fn substep(&mut self, body: &Deformable, s: &Substep, sampling: &Sampling) -> bool {
        let last = self.edges.last().copied().unwrap_or(s.time);
        if s.time <= last {
            return false;
        }
        // The body was out of the simulation for a while: an interval without impulses.
        if s.time - s.h > last + 0.5 * s.h {
            self.edges.push(s.time - s.h);
        }
        let index = self.edges.len() - 1;
        self.edges.push(s.time);
        let own = self.deformable;
        // Asleep, a body bears what it bore on average, in balance or nearly so.
        let moving = if body.is_sleeping() { 0.0 } else { 1.0 };
        for pair in s.contacts.iter().filter(|p| p.deformable == own) {
            let interface = Interface::from(pair.partner);
            if pair.touching > 0 || pair.depth > 0.0 {
                let channel = self.channel(interface);
                channel.add(index, pair.impulse, s.time);
                channel.max_touching = channel.max_touching.max(pair.touching);
                if pair.depth > channel.max_depth {
                    (channel.max_depth, channel.depth_time) = (pair.depth, s.time);
                }
            }
            self.sums[0] += pair.impulse * moving;
        }
        for tie in s.attachments.iter().filter(|t| t.deformable == own) {
            self.channel(Interface::Attachment(tie.attachment))
                .add(index, tie.impulse, s.time);
            self.sums[1] += tie.impulse * moving;
        }
        self.sums[2] += body.gravity() * (self.mass * s.h * moving);
        let due = s.time >= self.next - 1.0e-9;
        if due {
            self.next = (self.next + sampling.history).max(s.time);
            self.sample(body, s.time);
        }
        if self.balances(s.time) {
            self.next_ledger = (self.next_ledger + sampling.energy).max(s.time);
            self.balance(body, s.time);
        }
        due
    }

    /// Whether energies are due at `time` s.
    pub(super) fn balances(&self, time: f64) -> bool {
        time >= self.next_ledger - 1.0e-9
    }

    fn channel(&mut self, interface: Interface) -> &mut Channel {
        let known = self.channels.iter().position(|c| c.interface == interface);
        let i = known.unwrap_or_else(|| {
            self.channels.push(Channel::new(interface));
            self.channels.len() - 1
        });
        &mut self.channels[i]
    }

    fn sample(&mut self, body: &Deformable, time: f64) {
        let momentum = body.momentum();
        self.mass = body.mass();
        self.center
            .push(time, body.center_of_mass(), momentum / self.mass);
        self.momenta.push(momentum);
        let (lo, hi) = body.bounds();
        self.bounds.push([lo, hi]);
        let change = momentum + body.momentum_lost_in_sleep() - self.start;
        self.closure = Closure {
            contact: self.sums[0],
            attachment: self.sums[1],
            gravity: self.sums[2],
            change,
            scale: self.closure.scale.max(change.length()),
        };
    }

    fn balance(&mut self, body: &Deformable, time: f64) {
        let energies = body.energies();
        self.scale = self.scale.max(energies.scale());
        let first = self
            .ledger
            .first()
            .map_or(energies.balance(), |s| s.energies.balance());
        self.ledger.push(LedgerSample {
            time,
            energies,
            residual: (energies.balance() - first).abs() / self.scale.max(f64::MIN_POSITIVE),
        });
    }

    /// Largest energy residual of any sample \[1\]. A body at rest has but the rounding of its springs to be measured
    /// against, so samples before it had a billionth of its largest energy don't count.
    pub fn max_residual(&self) -> f64 {
        let stirred = |s: &&LedgerSample| s.energies.scale() > 1.0e-9 * self.scale;
        let first = self.ledger.iter().position(|s| stirred(&s));
        let counted = self.ledger.iter().skip(first.unwrap_or(0));
        counted.map(|s| s.residual).fold(0.0, larger)
    }

    /// The channel of an interface, if it ever acted.
    pub fn find(&self, interface: Interface) -> Option<&Channel> {
        self.channels.iter().find(|c| c.interface == interface)
    }
}
