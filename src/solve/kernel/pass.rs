//! The force pass over springs by rows: [`crate::solve::forces`] has the same as a scalar loop.

use super::Kernel;
use super::limits::Limited;
use super::mirror::Mirror;
use super::sell::LEAST_SQUARE;
use super::table::{End, Free, Rule, Table};
use super::vector::{Half, LANES, Pass, Runs, Starts, Vector, Width, Writer, put, run};
use crate::body::state::State;
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
        out: sell.layout.out.of_mut(forces)?,
        table: Table::of(&sell.layout, &state.particles)?,
        mirror: &mut sell.mirror,
        starts: &sell.layout.starts,
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
    mirror: &'a mut Mirror,
    starts: &'a Starts,
    limited: Option<Limited<'a>>,
    drag: f32,
}

impl Pass for Springs<'_> {
    type Output = Happened;

    #[inline(always)]
    fn run<V: Vector>(self) -> Happened {
        match (self.limited.is_some(), self.table.is_damped()) {
            (false, false) => self.slices::<V, false, false>(),
            (false, true) => self.slices::<V, false, true>(),
            (true, false) => self.slices::<V, true, false>(),
            (true, true) => self.slices::<V, true, true>(),
        }
    }
}

impl Springs<'_> {
    #[inline(always)]
    fn slices<V: Vector, const LIMITED: bool, const DAMPED: bool>(self) -> Happened {
        let Self {
            mut out,
            table,
            mirror,
            starts,
            mut limited,
            drag,
        } = self;
        if !mirror.columns.is_empty() {
            mirror.fill::<V, DAMPED>(&table);
        }
        // There are places in columns for as many as there are.
        let Some(runs) = starts.of(&mirror.columns) else {
            return Happened::default();
        };
        for slice in 0..table.slices() {
            for part in 0..LANES / V::LANES {
                let nodes = Nodes::of::<DAMPED>(&table, slice, part, drag);
                let place = (slice, part);
                let sums = match &mut limited {
                    Some(limited) if LIMITED => {
                        limited.add_springs::<V, DAMPED>(&table, &runs, place, nodes)
                    }
                    _ => add_free_springs::<V, DAMPED>(&table, &runs, place, nodes),
                };
                let lanes = |[x, y, z]: [V; 3]| [x, y, z, V::ZERO];
                let columns = [lanes(sums.elastic), lanes(sums.damping)];
                match out.together(LANES * slice) {
                    Some(rows) if table.keeps_order() && slice < table.together().len() => {
                        put(rows, part, columns);
                    }
                    _ => {
                        out.put(slice, part, Half::First, columns[0]);
                        out.put(slice, part, Half::Second, columns[1]);
                    }
                }
            }
        }
        limited.map_or(Happened::default(), |l| l.happened())
    }
}

/// All springs of a part of a slice of a body whose springs have no limits.
#[inline(always)]
fn add_free_springs<V: Vector, const DAMPED: bool>(
    table: &Table,
    runs: &Runs,
    (slice, part): (usize, usize),
    nodes: Nodes<V>,
) -> Nodes<V> {
    let rule = Free(table.rests());
    if table.is_regular(slice) {
        let slots = table.regular_slots(slice, runs);
        add_springs::<V, _, _, DAMPED>(table, slots, part, nodes, &rule).0
    } else {
        add_springs::<V, _, _, DAMPED>(table, table.slots(slice), part, nodes, &rule).0
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
pub(super) fn difference<V: Vector>([x, y, z]: [V; 3], b: [V; 3]) -> [V; 3] {
    [x - b[0], y - b[1], z - b[2]]
}

impl<V: Vector> Trial<V> {
    #[inline(always)]
    pub fn new(at: [V; 3], far: &impl End<V>, part: usize, rest: V) -> Self {
        let d = difference(far.place(part), at);
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
    /// Those of a part of a slice, with the force of drag \[N·s/m\] on them.
    #[inline(always)]
    fn of<const DAMPED: bool>(table: &Table, slice: usize, part: usize, drag: f32) -> Self {
        let own = table.own(slice);
        let [x, y, z, _] = own.columns(part, Half::First);
        let mut nodes = Self {
            at: [x, y, z],
            velocity: [V::ZERO; 3],
            elastic: [V::ZERO; 3],
            damping: [V::ZERO; 3],
        };
        if DAMPED || drag > 0.0 {
            nodes.velocity = own.velocity(part);
        }
        if drag > 0.0 {
            let drag = V::of(drag.into());
            nodes.damping = nodes.velocity.map(|v| -(drag * v));
        }
        nodes
    }

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
    pub fn rate(&self, trial: &Trial<V>, far: &impl End<V>, part: usize) -> V {
        let velocity = difference(far.velocity(part), self.velocity);
        dot(velocity, trial.direction)
    }
}

/// All springs of as many nodes as there are lanes, as if none had a limit, and whether none can have reached one.
#[inline(always)]
pub(super) fn add_springs<V: Vector, E: End<V>, R: Rule<V>, const DAMPED: bool>(
    table: &Table,
    slots: impl Iterator<Item = (usize, E, usize)>,
    part: usize,
    mut nodes: Nodes<V>,
    rule: &R,
) -> (Nodes<V>, bool) {
    let mut within = V::ONE;
    for (slot, far, which) in slots {
        let rest = rule.rest(slot, which, part);
        let trial = Trial::new(nodes.at, &far, part, rest);
        let tension = spring::tension(table.stiffness(which, part), trial.elongation);
        within = rule.keep(within, trial.elongation, rest, (slot, which, part));
        nodes.pull(&trial, tension);
        if DAMPED {
            let rate = nodes.rate(&trial, &far, part);
            nodes.damp(&trial, rate, table.damping(which, part));
        }
    }
    (nodes, !R::LIMITED || within.all_above(V::ZERO))
}
