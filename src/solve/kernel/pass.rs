//! The force pass over springs by rows: [`crate::solve::forces`] has the same as a scalar loop.

use super::Kernel;
use super::limits::Limited;
use super::sell::{LEAST_SQUARE, Range};
use super::vector::{Half, LANES, Pass, Reader, Slot, Vector, Wide, Width, Writer, run};
use crate::body::state::{Particle, State};
use crate::law::spring;
use crate::solve::forces::{Force, Happened, LimitEvent};
use crate::solve::springs::{Rows, SpringTable};

/// Writes the force of all springs, and of drag D \[N·s/m\], on every node. `None` where the scalar pass is to do it: it is
/// faster than four lanes, and some bodies have no table.
pub(crate) fn spring_forces(
    kernel: Kernel,
    table: &mut SpringTable<f32>,
    state: &mut State<f32>,
    forces: &mut [Force<f32>],
    events: &mut Vec<LimitEvent<f32>>,
    (commit, drag): (Option<f32>, f32),
) -> Option<Happened> {
    if Width::of(kernel) == Width::Portable {
        table.drop_rows();
        return None;
    }
    let old_events = events.len();
    table.make_rows(state);
    let Rows::Made(sell) = &mut table.rows else {
        return None;
    };
    let springs = Springs {
        out: sell.out.of_mut(forces)?,
        table: Table {
            firsts: &sell.firsts,
            far: sell.far.of(&state.particles)?,
            own: sell.own.of(&state.particles)?,
            which: &sell.which,
            stiffness: &sell.stiffness,
            damping: &sell.damping,
            rest: &sell.rest,
        },
        limited: sell.limits.as_mut().map(|limits| Limited {
            limits,
            table: &table.limits,
            rest: &mut state.rest,
            flow: &mut state.flow,
            events,
            commit,
            plastic: [0.0; LANES],
            fracture: 0.0,
        }),
        drag,
    };
    let happened = run(kernel, springs);
    // As the scalar pass finds them: by springs, and what flows and breaks at once in that order.
    events[old_events..].sort_unstable_by_key(|e| (e.spring, e.broke));
    table.cut_broken(state, &events[old_events..]);
    Some(happened)
}

/// What the pass reads and writes.
struct Springs<'a> {
    out: Writer<'a, Force<f32>>,
    table: Table<'a>,
    limited: Option<Limited<'a>>,
    drag: f32,
}

/// What the pass reads.
#[derive(Clone, Copy)]
pub(super) struct Table<'a> {
    firsts: &'a [u32],
    own: Reader<'a, Particle<f32>>,
    far: Reader<'a, Particle<f32>>,
    which: &'a [u32],
    pub stiffness: &'a [Wide],
    damping: &'a [Wide],
    /// Empty where springs have limits, which have them.
    rest: &'a [Wide],
}

impl Pass for Springs<'_> {
    type Output = Happened;

    #[inline(always)]
    fn run<V: Vector>(self) -> Happened {
        match (self.limited.is_some(), self.table.damping.is_empty()) {
            (false, true) => self.slices::<V, false, false>(),
            (false, false) => self.slices::<V, false, true>(),
            (true, true) => self.slices::<V, true, false>(),
            (true, false) => self.slices::<V, true, true>(),
        }
    }
}

impl Springs<'_> {
    #[inline(always)]
    fn slices<V: Vector, const LIMITED: bool, const DAMPED: bool>(self) -> Happened {
        let Self {
            mut out,
            table,
            mut limited,
            drag,
        } = self;
        for slice in 0..table.firsts.len() - 1 {
            for part in 0..LANES / V::LANES {
                let nodes = table.nodes::<V, DAMPED>(slice, part, drag);
                let sums = match &mut limited {
                    Some(limited) if LIMITED => {
                        limited.add_springs::<V, DAMPED>(&table, (slice, part), nodes)
                    }
                    _ => {
                        table
                            .add_springs::<V, false, DAMPED>((slice, part), nodes, table.rest, &[])
                            .0
                    }
                };
                let lanes = |[x, y, z]: [V; 3]| [x, y, z, V::ZERO];
                out.put(slice, part, Half::First, lanes(sums.elastic));
                out.put(slice, part, Half::Second, lanes(sums.damping));
            }
        }
        limited.map_or(Happened::default(), |l| l.happened())
    }
}

/// The nodes of a part of a slice, and what their springs sum to.
#[derive(Clone, Copy)]
pub(super) struct Nodes<V> {
    pub at: [V; 3],
    pub velocity: [V; 3],
    pub elastic: [V; 3],
    pub damping: [V; 3],
}

/// A spring of each lane as if it had no limits.
#[derive(Clone, Copy)]
pub(super) struct Trial<V> {
    /// From the row's node to the other.
    pub direction: [V; 3],
    pub length: V,
    pub elongation: V,
}

#[inline(always)]
pub(super) fn dot<V: Vector>(a: [V; 3], b: [V; 3]) -> V {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn difference<V: Vector>([x, y, z, _]: [V; 4], b: [V; 3]) -> [V; 3] {
    [x - b[0], y - b[1], z - b[2]]
}

impl<V: Vector> Trial<V> {
    #[inline(always)]
    pub fn new(at: [V; 3], far: &Slot<'_, Particle<f32>>, part: usize, rest: V) -> Self {
        let d = difference(far.columns(part, Half::First), at);
        let length = dot(d, d).at_least(LEAST_SQUARE).sqrt();
        let inverse = V::ONE / length;
        Self {
            direction: [d[0] * inverse, d[1] * inverse, d[2] * inverse],
            length,
            elongation: length - rest,
        }
    }
}

impl<V: Vector> Nodes<V> {
    /// Adds springs of this tension \[N\].
    #[inline(always)]
    pub fn pull(&mut self, trial: &Trial<V>, tension: V) {
        for k in 0..3 {
            self.elastic[k] += trial.direction[k] * tension;
        }
    }

    /// Adds what damps them.
    #[inline(always)]
    pub fn damp(&mut self, trial: &Trial<V>, rate: V, viscosity: V) {
        let tension = spring::damping(viscosity, rate);
        for k in 0..3 {
            self.damping[k] += trial.direction[k] * tension;
        }
    }

    /// Rate of elongation \[m/s\].
    #[inline(always)]
    pub fn rate(&self, trial: &Trial<V>, far: &Slot<'_, Particle<f32>>, part: usize) -> V {
        let velocity = difference(far.columns(part, Half::Second), self.velocity);
        dot(velocity, trial.direction)
    }
}

impl<'a> Table<'a> {
    #[inline(always)]
    fn nodes<V: Vector, const DAMPED: bool>(
        &self,
        slice: usize,
        part: usize,
        drag: f32,
    ) -> Nodes<V> {
        let own = self.own.slot(slice);
        let [x, y, z, _] = own.columns(part, Half::First);
        let mut nodes = Nodes {
            at: [x, y, z],
            velocity: [V::ZERO; 3],
            elastic: [V::ZERO; 3],
            damping: [V::ZERO; 3],
        };
        if DAMPED || drag > 0.0 {
            let [x, y, z, _] = own.columns(part, Half::Second);
            nodes.velocity = [x, y, z];
        }
        if drag > 0.0 {
            let drag = V::of(drag.into());
            nodes.damping = nodes.velocity.map(|v| -(drag * v));
        }
        nodes
    }

    /// The place of a slice's own nodes.
    #[inline(always)]
    pub fn own(&self, slice: usize) -> Slot<'a, Particle<f32>> {
        self.own.slot(slice)
    }

    /// The slots of a slice, each with its other ends and its constants.
    #[inline(always)]
    pub fn slots(
        &self,
        slice: usize,
    ) -> impl Iterator<Item = (usize, Slot<'a, Particle<f32>>, usize)> {
        let slots = self.firsts[slice] as usize..self.firsts[slice + 1] as usize;
        let each = self
            .far
            .slots(slots.clone())
            .zip(&self.which[slots.clone()]);
        slots
            .zip(each)
            .map(|(slot, (far, &which))| (slot, far, which as usize))
    }

    /// Stiffness of a slot \[N/m\].
    #[inline(always)]
    pub fn stiffness<V: Vector>(&self, which: usize, part: usize) -> V {
        V::load(&self.stiffness[which], part)
    }

    /// Viscosity of a slot \[N·s/m\].
    #[inline(always)]
    pub fn damping<V: Vector>(&self, which: usize, part: usize) -> V {
        V::load(&self.damping[which], part)
    }

    /// All springs of as many nodes as there are lanes, as if none had a limit, and whether none can have reached one.
    #[inline(always)]
    pub fn add_springs<V: Vector, const LIMITED: bool, const DAMPED: bool>(
        &self,
        (slice, part): (usize, usize),
        mut nodes: Nodes<V>,
        rest: &[Wide],
        ranges: &[Range],
    ) -> (Nodes<V>, bool) {
        let mut within = V::ONE;
        for (slot, far, which) in self.slots(slice) {
            let rest = V::load(&rest[if LIMITED { slot } else { which }], part);
            let trial = Trial::new(nodes.at, &far, part, rest);
            let tension = spring::tension(self.stiffness(which, part), trial.elongation);
            if LIMITED {
                within = ranges[slot].keep(within, trial.elongation, rest);
            }
            nodes.pull(&trial, tension);
            if DAMPED {
                let rate = nodes.rate(&trial, &far, part);
                nodes.damp(&trial, rate, self.damping(which, part));
            }
        }
        (nodes, !LIMITED || within.all_above(V::ZERO))
    }
}
