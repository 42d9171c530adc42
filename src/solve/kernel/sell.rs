//! The table of springs that the kernels read: sliced ELLPACK form, rows are nodes.
//!
//! A slice is sixteen rows, a slot one spring of each of them. What fills up short rows, and what has broken, is a spring from
//! a node to itself whose rest length is the least length there is: it has no direction and no tension.
//!
//! Where nodes are numbered as a lattice is, rows keep the order of nodes, and slots hold springs of one step, from each node to
//! the one so many behind it ([`super::regular`]). A lane without such a spring then reads a node that has nothing to do with it,
//! and has no stiffness.
//!
//! Constants lie in tables of distinct slots, so that a regular net streams hardly more than its indices. Rest
//! length and flow of springs that can flow lie in both copies of a spring, where the pass reads and writes them. The state
//! gets them once somebody may look at it ([`Sell::settle`]): to write it in every pass made one in which all springs flow
//! 1.4 times as long, for springs are not numbered as rows are. A state changed by other hands than the solver's wants a
//! new table.

use super::SLICES;
use super::limits::Outcome;
use super::log::Log;
use super::mirror::Mirror;
use super::order;
use super::palette::{Mixer, Palette};
use super::ranges::{Limits, Ranges, slack};
use super::regular;
use super::telling::Telling;
use super::vector::{LANES, Places, Starts, Wide};
use crate::body::adjacency::Adjacency;
use crate::body::state::State;
use crate::law::spring::LEAST_SQUARE;
use crate::solve::springs::{Limit, Link};
use std::collections::HashMap;

/// The length of a spring from a node to itself, as the pass finds it: \[m\].
pub fn least_length() -> f32 {
    (LEAST_SQUARE as f32).sqrt()
}

/// Springs of a body by rows.
#[derive(Clone, Debug)]
pub struct Sell {
    pub(super) layout: Layout,
    pub(super) limits: Option<Limits>,
    /// Empty where no slice is regular.
    pub(super) mirror: Mirror,
    pub(super) sums: Sums,
}

/// What a pass sums, and keeps until all threads are done.
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    /// Of each block of slices.
    pub outcomes: Vec<Outcome>,
    /// Empty before threads have shared the body.
    pub log: Log,
}

/// What does not change but by breaking.
#[derive(Clone, Debug)]
pub struct Layout {
    pub(super) nodes: usize,
    /// The first slot of each slice, and the end.
    pub(super) firsts: Vec<u32>,
    /// Per slice the node of each row. What fills up the last slice reads node 0, and writes behind the last.
    pub(super) own: Places,
    pub(super) out: Places,
    /// Per slot the node at the other end of each spring.
    pub(super) far: Places,
    /// Per slot of a regular slice where those begin in the mirror. Empty where no slice is regular.
    pub(super) starts: Starts,
    /// Per slice where its own nodes begin in the mirror. Empty where no slice is regular.
    pub(super) mirrored: Starts,
    /// Per slice whether it is regular. Empty where none is.
    pub(super) regular: Vec<bool>,
    /// Per slot which constants.
    pub(super) which: Vec<u32>,
    pub(super) stiffness: Vec<Wide>,
    /// Empty where nothing is damped.
    pub(super) damping: Vec<Wide>,
    /// Empty where there are limits, which have them by slot, but for regular slices.
    pub(super) rest: Vec<Wide>,
    /// The row of each node.
    pub(super) rows: Vec<u32>,
}

impl Layout {
    /// How many slices there are.
    #[inline(always)]
    pub fn slices(&self) -> usize {
        self.firsts.len() - 1
    }

    /// The slots of a slice.
    #[inline(always)]
    pub fn slots(&self, slice: usize) -> std::ops::Range<usize> {
        self.firsts[slice] as usize..self.firsts[slice + 1] as usize
    }
}

/// The springs, and how they are arranged.
struct Builder<'a> {
    links: &'a [Link<f32>],
    table: &'a [Limit<f32>],
    state: &'a State<f32>,
    adjacency: Adjacency,
    damped: bool,
    distinct: HashMap<[[u32; LANES]; 4], u32>,
    mixer: Mixer,
}

/// A slot: in every lane a spring and the node at its other end, if there is one.
type Ends = [Option<(u32, u32)>; LANES];

impl Sell {
    /// The table of springs; `limits` is empty, or has a row for each spring. `None` for bodies too large for
    /// its indices.
    pub fn new(links: &[Link<f32>], limits: &[Limit<f32>], state: &State<f32>) -> Option<Self> {
        let nodes = state.particles.len();
        // Broken springs keep their slots, as do all that may break, so that a table made late has the order of one whose
        // springs broke under way.
        let whole = |&(i, link): &(usize, &Link<f32>)| {
            state.broken[i] || !limits.is_empty() || link.stiffness != 0.0 || link.damping != 0.0
        };
        let springs = links.iter().enumerate().filter(whole);
        let adjacency = Adjacency::new(nodes, springs.map(|(i, l)| (i as u32, [l.a, l.b])));
        let steps = regular::steps(&adjacency);
        let order = match &steps {
            Some(_) => (0..nodes as u32).collect(),
            None => order::rows(&adjacency),
        };
        let mut builder = Builder {
            links,
            table: limits,
            state,
            adjacency,
            damped: links.iter().any(|l| l.damping != 0.0),
            distinct: HashMap::new(),
            mixer: Mixer::default(),
        };
        let mut sell = Self {
            layout: Layout::empty(&order)?,
            limits: (!limits.is_empty()).then(|| Limits::none(limits)),
            mirror: Mirror::default(),
            sums: Sums::default(),
        };
        if let Some(steps) = &steps {
            let all = steps.iter().flatten().flatten();
            let farthest = all.map(|s| s.unsigned_abs()).max().unwrap_or(0);
            sell.mirror = Mirror::new(steps.len(), farthest as usize);
            sell.layout.starts = sell.mirror.starts()?;
            sell.layout.mirrored = sell.mirror.starts()?;
        }
        for (i, slice) in order.chunks(LANES).enumerate() {
            let steps = steps.as_ref().map(|s| s[i].as_deref());
            builder.push_slice(&mut sell, slice, steps);
        }
        let blocks = sell.layout.slices().div_ceil(SLICES);
        sell.sums.outcomes = vec![Outcome::default(); blocks];
        Some(sell)
    }

    /// Bytes of what a pass reads while nothing yields, and of all.
    pub(crate) fn bytes(&self) -> [usize; 2] {
        let wide = |table: &[Wide]| size_of_val(table);
        let l = &self.layout;
        let constants = wide(&l.stiffness) + wide(&l.damping) + wide(&l.rest);
        let mut hot = size_of_val(&l.which[..]) + l.starts.bytes() + l.mirrored.bytes() + constants;
        let mut rare = l.own.bytes() + l.out.bytes() + size_of_val(&l.rows[..]);
        let regular = !l.regular.is_empty();
        *(if regular { &mut rare } else { &mut hot }) += l.far.bytes();
        rare += self.mirror.columns.bytes() + self.sums.log.bytes();
        rare += size_of_val(&self.sums.outcomes[..]);
        if let Some(limits) = &self.limits {
            let by_slot = wide(&limits.rest) + size_of_val(&limits.ranges[..]);
            *(if regular { &mut rare } else { &mut hot }) += by_slot;
            hot += wide(&limits.slacks);
            rare += wide(&limits.flow) + limits.palette.bytes() + limits.telling.bytes();
        }
        [hot, hot + rare]
    }
}

impl Layout {
    fn empty(order: &[u32]) -> Option<Self> {
        let nodes = order.len();
        let mut rows = vec![0; nodes];
        for (row, &node) in order.iter().enumerate() {
            rows[node as usize] = row as u32;
        }
        Some(Self {
            nodes,
            firsts: vec![0],
            own: Places::new(nodes)?,
            out: Places::distinct(nodes + 1)?,
            far: Places::new(nodes)?,
            starts: Starts::default(),
            mirrored: Starts::default(),
            regular: Vec::new(),
            which: Vec::new(),
            stiffness: Vec::new(),
            damping: Vec::new(),
            rest: Vec::new(),
            rows,
        })
    }
}

impl Builder<'_> {
    /// `steps` is there for bodies with regular slices, and in it something for those slices.
    fn push_slice(&mut self, sell: &mut Sell, nodes: &[u32], steps: Option<Option<&[i32]>>) {
        let layout = &mut sell.layout;
        let slice = layout.slices();
        let node = |lane: usize, otherwise: usize| {
            let node = nodes.get(lane).map(|&n| n as usize);
            node.unwrap_or(otherwise) as u32
        };
        layout.own.push(std::array::from_fn(|l| node(l, 0)));
        layout
            .out
            .push(std::array::from_fn(|l| node(l, layout.nodes)));
        let whole = |&(spring, _): &(u32, u32)| !self.state.broken[spring as usize];
        // By its stiffness is a spring with limits told from none in a regular slice.
        let tells = |end: &(u32, u32)| {
            let stiffness = self.links[end.0 as usize].stiffness;
            whole(end) && (self.table.is_empty() || stiffness > 0.0)
        };
        let mut ends = nodes.iter().flat_map(|&n| self.adjacency.at(n));
        let steps = steps.map(|steps| steps.filter(|_| ends.all(tells)));
        match steps {
            Some(Some(steps)) => {
                for &step in steps {
                    let at = |lane: usize| {
                        let node = *nodes.get(lane)?;
                        let mut ends = self.adjacency.at(node).iter();
                        let other = (node as i32).wrapping_add(step) as u32;
                        ends.find(|(_, o)| *o == other).copied()
                    };
                    let ends = std::array::from_fn(at);
                    self.push_slot(sell, nodes, &ends, true);
                    sell.layout.starts.push(sell.mirror.start(slice, step));
                }
            }
            _ => {
                let longest = nodes.iter().map(|&n| self.adjacency.at(n).len()).max();
                for slot in 0..longest.unwrap_or(0) {
                    let end = |lane: usize| self.adjacency.at(*nodes.get(lane)?).get(slot).copied();
                    let at = |lane: usize| end(lane).filter(whole);
                    let ends = std::array::from_fn(at);
                    self.push_slot(sell, nodes, &ends, false);
                    if steps.is_some() {
                        sell.layout.starts.push(0);
                    }
                }
            }
        }
        let layout = &mut sell.layout;
        layout.firsts.push(layout.which.len() as u32);
        if let Some(steps) = steps {
            layout.mirrored.push(sell.mirror.start(slice, 0));
            layout.regular.push(steps.is_some());
        }
        if let Some(limits) = &mut sell.limits {
            let flows = |end: &(u32, u32)| self.state.flow[end.0 as usize] != 0.0;
            let untouched = !nodes.iter().flat_map(|&n| self.adjacency.at(n)).any(flows);
            // The first pass makes those busy that are not untouched.
            limits.busy.push([0; 4]);
            limits.untouched.push(untouched);
            limits.unsaved.push(false);
        }
    }

    fn push_slot(&mut self, sell: &mut Sell, nodes: &[u32], ends: &Ends, regular: bool) {
        let layout = &mut sell.layout;
        let own = |lane: usize| nodes.get(lane).copied().unwrap_or(0);
        let of = |value: fn(&Link<f32>) -> f32| {
            let each =
                ends.map(|e| e.map_or(0.0, |(spring, _)| value(&self.links[spring as usize])));
            Wide(each)
        };
        let rest =
            Wide(ends.map(|e| e.map_or(least_length(), |(s, _)| self.state.rest[s as usize])));
        let (stiffness, damping) = (of(|l| l.stiffness), of(|l| l.damping));
        layout.far.push(std::array::from_fn(|l| {
            ends[l].map_or(own(l), |(_, other)| other)
        }));
        // Rest lengths that can change are no constants, but for those of regular slices until something changes.
        let limited = sell.limits.is_some();
        let none = Wide([0.0; LANES]);
        let fixed = if regular || !limited { rest } else { none };
        let slacks = if limited { self.slacks(ends) } else { none };
        let known = if regular { slacks } else { none };
        let key = [stiffness, damping, fixed, known].map(|w| w.0.map(f32::to_bits));
        let next = layout.stiffness.len() as u32;
        let which = *self.distinct.entry(key).or_insert(next);
        let has_regular = !layout.regular.is_empty() || regular;
        if which == next {
            layout.stiffness.push(stiffness);
            if self.damped {
                layout.damping.push(damping);
            }
            if !limited || has_regular {
                layout.rest.resize(next as usize, none);
                layout.rest.push(fixed);
            }
        }
        layout.which.push(which);
        if let Some(limits) = &mut sell.limits {
            if which == next && has_regular {
                limits.slacks.resize(next as usize, none);
                limits.slacks.push(known);
            }
            let of = |end: Option<(u32, u32)>| Some(&self.table[end?.0 as usize]);
            limits.palette.push(&mut self.mixer, ends.map(of));
            limits.push_slot(ends, own, self.state, (rest, &slacks));
        }
    }

    /// The slack of the springs of a slot; without end where there is none.
    fn slacks(&self, ends: &Ends) -> Wide {
        Wide(ends.map(|e| {
            e.map_or(f32::INFINITY, |(spring, _)| {
                let i = spring as usize;
                slack(&self.table[i], self.links[i].stiffness, self.state.rest[i])
            })
        }))
    }
}

impl Limits {
    fn none(limits: &[Limit<f32>]) -> Self {
        Self {
            palette: Palette::of(limits),
            telling: Telling::default(),
            rest: Vec::new(),
            flow: Vec::new(),
            ranges: Vec::new(),
            slacks: Vec::new(),
            width: None,
            busy: Vec::new(),
            untouched: Vec::new(),
            unsaved: Vec::new(),
        }
    }

    fn push_slot(
        &mut self,
        ends: &Ends,
        own: impl Fn(usize) -> u32,
        state: &State<f32>,
        (rest, slacks): (Wide, &Wide),
    ) {
        let tells = |l: usize| ends[l].filter(|(_, other)| own(l) < *other);
        self.telling
            .push(std::array::from_fn(|l| tells(l).map(|(spring, _)| spring)));
        self.flow.push(Wide(
            ends.map(|e| e.map_or(0.0, |(s, _)| state.flow[s as usize])),
        ));
        self.rest.push(rest);
        self.ranges.push(Ranges::of_slacks(slacks));
    }
}
