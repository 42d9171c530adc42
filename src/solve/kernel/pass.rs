//! The force pass over springs by rows: [`crate::solve::forces`] has the same as a scalar loop.

use super::limits::{Book, Limited, Outcome};
use super::mirror::Copied;
use super::sell::Sell;
use super::table::{End, Free, Rule, Table};
use super::trial::{Nodes, Reach};
use super::vector::{LANES, Pass, Runs, Vector, Width, Writer, put_four, run};
use super::{Kernel, SLICES};
use crate::body::state::State;
use crate::law::spring;
use crate::solve::forces::{Commit, Forces, Happened, Lanes, LimitEvent};
use crate::solve::springs::{Rows, SpringTable};
use crate::solve::threads::{BLOCK, Work, parts, share};

/// Makes the rows of a body that is going to be moved, where they are wanted.
pub(crate) fn make_rows(kernel: Kernel, table: &mut SpringTable<f32>, state: &State<f32>) {
    if Width::of(kernel) != Width::Portable {
        table.make_rows(state);
    }
}

/// Writes the force of all springs, and of drag D \[N·s/m\], on every node. `None` where the scalar pass is to do it: it is
/// faster than four lanes, and some bodies have no table.
pub(crate) fn spring_forces(
    kernel: Kernel,
    table: &mut SpringTable<f32>,
    state: &mut State<f32>,
    forces: &mut Forces<f32>,
    events: &mut Vec<LimitEvent<f32>>,
    (commit, drag): (Option<Commit<f32>>, f32),
) -> Option<Happened> {
    if Width::of(kernel) == Width::Portable {
        table.drop_rows(state);
        return None;
    }
    let old_events = events.len();
    table.make_rows(state);
    let Rows::Made(sell) = &mut table.rows else {
        return None;
    };
    let Sell {
        layout,
        limits,
        mirror,
        sums,
    } = &mut **sell;
    let parts = parts();
    let nodes = Table::of(layout, &state.particles)?;
    let touched = limits
        .as_ref()
        .is_some_and(|l| l.any_touched(&layout.regular));
    let velocities = nodes.is_damped() || touched;
    if layout.regular.contains(&true) {
        let copied = if velocities {
            Copied::Velocities
        } else {
            Copied::Nothing
        };
        share(mirror.copying(nodes, copied), parts, &|copying| {
            run(kernel, copying)
        });
    }
    let limited = limits.as_mut().map(|limits| {
        let book = if parts > 1 {
            sums.log.prepare(layout, &limits.telling.lanes);
            Book::Log(sums.log.part())
        } else {
            Book::Events(events)
        };
        Limited::new(limits.span(Width::of(kernel)), velocities, book, commit)
    });
    let springs = Springs {
        table: nodes,
        // There are places in columns for as many as there are.
        runs: layout.starts.of(&mirror.columns)?,
        mirrored: layout.mirrored.of(&mirror.columns)?,
        out: match nodes.keeps_order() {
            true => Out::Rows([&mut forces.elastic, &mut forces.damping]),
            false => Out::Places([
                Some(layout.out.of_mut(&mut forces.elastic)?),
                layout.out.of_mut(&mut forces.damping),
            ]),
        },
        limited,
        outcomes: &mut sums.outcomes,
        drag,
        first: 0,
    };
    share(springs, parts, &|springs| run(kernel, springs));
    let mut happened = Happened::default();
    for (block, outcome) in sums.outcomes.iter().enumerate() {
        happened.plastic += outcome.happened.plastic;
        happened.fracture += outcome.happened.fracture;
        if outcome.logged > 0 {
            let entries = sums.log.of_block(block, outcome.logged);
            entries.iter().for_each(|entry| entry.tell(events));
        }
    }
    // As the scalar pass finds them: by springs, and what flows and breaks at once in that order.
    events[old_events..].sort_unstable_by_key(|e| (e.spring, e.broke));
    table.cut_broken(state, &events[old_events..]);
    Some(happened)
}

/// What the pass reads and writes.
struct Springs<'a> {
    table: Table<'a>,
    runs: Runs<'a>,
    /// The nodes of slices in the mirror, which is up to date where a slice is regular.
    mirrored: Runs<'a>,
    out: Out<'a>,
    limited: Option<Limited<'a>>,
    /// Of its blocks, which begin with the `first`.
    outcomes: &'a mut [Outcome],
    first: usize,
    drag: f32,
}

/// Where the elastic and damping forces of rows go; these nowhere where there is no room for them.
enum Out<'a> {
    /// To rows in the order of slices, from those of the first block on.
    Rows([&'a mut [Lanes<f32>]; 2]),
    /// To nodes all over the body.
    Places([Option<Writer<'a, Lanes<f32>>>; 2]),
}

impl Work for Springs<'_> {
    fn blocks(&self) -> usize {
        let whole = matches!(&self.limited, Some(limited) if limited.is_whole());
        if whole { 1 } else { self.outcomes.len() }
    }

    fn cut(self, at: usize) -> [Self; 2] {
        let (outcomes, others) = self.outcomes.split_at_mut(at);
        let [out, rest] = self.out.cut(at);
        let slice = SLICES * (self.first + at);
        let slot = self.table.first_slot(slice);
        let limited = self.limited.map(|l| l.cut(at, (slice, slot)));
        let [limited, unlimited] = limited.map_or([None, None], |l| l);
        let part = |out, limited, outcomes, first| Self {
            table: self.table,
            runs: self.runs,
            mirrored: self.mirrored,
            out,
            limited,
            outcomes,
            first,
            drag: self.drag,
        };
        [
            part(out, limited, outcomes, self.first),
            part(rest, unlimited, others, self.first + at),
        ]
    }
}

impl<'a> Out<'a> {
    fn cut(self, at: usize) -> [Self; 2] {
        match self {
            Self::Rows(rows) => {
                let [[elastic, others], [damping, rest]] = rows.map(|rows| {
                    let (rows, rest) = rows.split_at_mut(rows.len().min(BLOCK * at));
                    [rows, rest]
                });
                [Self::Rows([elastic, damping]), Self::Rows([others, rest])]
            }
            Self::Places(places) => {
                let [elastic, damping] = places.map(|p| {
                    let both = p.map(|p| p.cut(SLICES * at));
                    both.map_or([None, None], |both| both.map(Some))
                });
                let ([elastic, others], [damping, rest]) = (elastic, damping);
                [
                    Self::Places([elastic, damping]),
                    Self::Places([others, rest]),
                ]
            }
        }
    }

    /// Writes to the rows of a part of a slice, which is the so many-th from the first block on.
    #[inline(always)]
    fn put<V: Vector>(&mut self, slice: usize, part: usize, columns: [[V; 4]; 2]) {
        match self {
            Self::Rows([elastic, damping]) => {
                put_rows(elastic, slice, part, columns[0]);
                if !damping.is_empty() {
                    put_rows(damping, slice, part, columns[1]);
                }
            }
            Self::Places(places) => {
                for (places, columns) in places.iter_mut().zip(columns) {
                    if let Some(places) = places {
                        places.put(slice, part, columns);
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn put_rows<V: Vector>(rows: &mut [Lanes<f32>], slice: usize, part: usize, columns: [V; 4]) {
    let rows = &mut rows[LANES * slice..];
    if let Some(rows) = rows.first_chunk_mut() {
        put_four(rows, part, columns);
    } else {
        // The last nodes of a body, which make no slice.
        let mut few = [Lanes::default(); LANES];
        put_four(&mut few, part, columns);
        let lanes = rows.iter_mut().zip(&few).skip(part * V::LANES);
        lanes.take(V::LANES).for_each(|(row, force)| *row = *force);
    }
}

impl Pass for Springs<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vector>(self) {
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
    fn slices<V: Vector, const LIMITED: bool, const DAMPED: bool>(self) {
        let Self {
            table,
            runs,
            mirrored,
            mut out,
            mut limited,
            outcomes,
            first,
            drag,
        } = self;
        for (b, outcome) in outcomes.iter_mut().enumerate() {
            if LIMITED && let Some(limited) = &mut limited {
                limited.begin(b);
            }
            let slices = SLICES * (first + b)..table.slices().min(SLICES * (first + b + 1));
            for slice in slices {
                let own = mirrored.slot(slice).filter(|_| table.is_regular(slice));
                for part in 0..LANES / V::LANES {
                    let mut nodes = match own {
                        Some(own) => Nodes::of::<DAMPED>(&own, part),
                        None => Nodes::of::<DAMPED>(&table.own(slice), part),
                    };
                    if drag > 0.0 {
                        nodes = nodes.dragged(&table.own(slice), part, drag);
                    }
                    let place = (slice, part);
                    let sums = match &mut limited {
                        Some(limited) if LIMITED => {
                            limited.add_springs::<V, DAMPED>(&table, &runs, place, nodes)
                        }
                        _ => add_free_springs::<V, DAMPED>(&table, &runs, place, nodes),
                    };
                    let lanes = |[x, y, z]: [V; 3]| [x, y, z, V::ZERO];
                    let columns = [lanes(sums.elastic), lanes(sums.damping)];
                    out.put(slice - SLICES * first, part, columns);
                }
            }
            if LIMITED && let Some(limited) = &limited {
                *outcome = limited.end(b);
            }
        }
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

/// All springs of as many nodes as there are lanes, as if none had a limit, and whether none can have reached one.
#[inline(always)]
pub(super) fn add_springs<V: Vector, E: End<V>, R: Rule<V>, const DAMPED: bool>(
    table: &Table,
    mut slots: impl Iterator<Item = (R::Slot, E, usize)>,
    part: usize,
    nodes: Nodes<V>,
    rule: &R,
) -> (Nodes<V>, bool) {
    let (at, within) = (nodes.at, V::EVERYWHERE);
    let mut sums = Sums { nodes, within };
    while let Some(one) = slots.next() {
        let reach = Reach::new(at, &one.1, part);
        if V::BY_TWOS
            && let Some(other) = slots.next()
        {
            let next = Reach::new(at, &other.1, part);
            sums.add::<_, _, DAMPED>(table, reach, one, part, rule);
            sums.add::<_, _, DAMPED>(table, next, other, part, rule);
        } else {
            sums.add::<_, _, DAMPED>(table, reach, one, part, rule);
        }
    }
    (sums.nodes, !R::LIMITED || V::is_everywhere(sums.within))
}

/// What the springs of a part of a slice sum to, and where none can have reached a limit.
struct Sums<V: Vector> {
    nodes: Nodes<V>,
    within: V::Mask,
}

impl<V: Vector> Sums<V> {
    /// Adds a slot that reaches so far.
    #[inline(always)]
    fn add<E: End<V>, R: Rule<V>, const DAMPED: bool>(
        &mut self,
        table: &Table,
        reach: Reach<V>,
        (slot, far, which): (R::Slot, E, usize),
        part: usize,
        rule: &R,
    ) {
        let rest = rule.rest(slot, (which, part));
        let stiffness = table.stiffness(which, part);
        let mut trial = reach.trial(rest);
        if R::ASKS_ALL {
            trial = trial.without_strays::<E>(stiffness);
        }
        let tension = spring::tension(stiffness, trial.elongation);
        self.within = rule.keep(self.within, trial.elongation, rest, slot, (which, part));
        self.nodes.pull(&trial, tension);
        if DAMPED {
            let rate = self.nodes.rate(&trial, &far, part);
            self.nodes.damp(&trial, rate, table.damping(which, part));
        }
    }
}
