//! The table of springs that the kernels read: sliced ELLPACK, rows are nodes.
//!
//! A slice is sixteen rows, a slot one spring of each of them. What fills up short rows, and what has broken, is a spring from
//! a node to itself whose rest length is the least length there is: it has no direction and no tension.
//!
//! Constants lie in tables of distinct slots, so that a regular net streams hardly more than its indices. Rest
//! length and flow of springs that can flow lie in both copies of a spring, where the pass reads and writes them; the
//! copy at the first node writes the state as well, in the same pass, so that whoever reads the state finds it as it is. Keeping
//! them in the state alone would cost two scattered reads per spring and substep; keeping them in the table alone, a
//! synchronisation before every look from outside. A state changed by other hands than the solver's wants a new table.

use super::order::Adjacency;
use super::vector::{Half, LANES, Places, Vector, Wide};
use crate::body::state::State;
use crate::solve::springs::{Limit, Link};
use std::collections::HashMap;

/// The least l² that counts \[m²\].
pub const LEAST_SQUARE: f32 = 1e-30;

/// Springs of a body by rows.
#[derive(Clone, Debug)]
pub struct Sell {
    pub(super) nodes: usize,
    /// The first slot of each slice, and the end.
    pub(super) firsts: Vec<u32>,
    /// Per slice the node of each row. What fills up the last slice reads node 0, and writes behind the last.
    pub(super) own: Places,
    pub(super) out: Places,
    /// Per slot the node at the other end of each spring.
    pub(super) far: Places,
    /// Per slot which constants.
    pub(super) which: Vec<u32>,
    pub(super) stiffness: Vec<Wide>,
    /// Empty where nothing is damped.
    pub(super) damping: Vec<Wide>,
    /// Empty where there are limits, which have them by slot.
    pub(super) rest: Vec<Wide>,
    pub(super) limits: Option<Limits>,
    /// The row of each node.
    rows: Vec<u32>,
}

/// What springs that yield or break have besides, per slot.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Which spring; one behind the last for none.
    pub springs: Places,
    /// Rest length and accumulated flow \[m\].
    pub rest: Vec<Wide>,
    pub flow: Vec<Wide>,
    pub ranges: Vec<Range>,
    /// Per part of a slice whether a spring was out of its range in the last pass.
    pub busy: Vec<[bool; 4]>,
}

/// No spring of a slot flows or breaks while its elongation over its rest length lies between these two; NaN where they are not
/// known.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    least: f32,
    most: f32,
}

impl Range {
    const UNKNOWN: Self = Self {
        least: f32::NAN,
        most: f32::NAN,
    };

    /// What was `within`, or 0 for elongations out of range.
    #[inline(always)]
    pub fn keep<V: Vector>(&self, within: V, elongation: V, rest: V) -> V {
        let [least, most] = [self.least, self.most].map(|x| V::of(x.into()) * rest);
        let within = V::above(most, elongation, within, V::ZERO);
        V::above(elongation, least, within, V::ZERO)
    }

    #[inline(always)]
    pub fn forget(&mut self) {
        *self = Self::UNKNOWN;
    }

    #[inline(always)]
    pub fn is_known(&self) -> bool {
        !self.most.is_nan()
    }
}

impl Limits {
    /// Finds the range of a slot, which lies within what the law allows by more than the law is rounded.
    #[inline(always)]
    pub fn find_range<V: Vector>(&mut self, slot: usize, table: &[Limit<f32>], stiffness: &Wide) {
        let Some(rows) = self.springs.of(table) else {
            return;
        };
        let [mut most, mut least] = [V::of(f64::INFINITY), V::of(f64::NEG_INFINITY)];
        let mut shortest = V::of(f64::INFINITY);
        for part in 0..LANES / V::LANES {
            let limits = rows.slot(slot);
            let [tension, compression, hardening, _] = limits.columns::<V>(part, Half::First);
            let [break_force, break_length, ..] = limits.columns::<V>(part, Half::Second);
            let k = V::load(stiffness, part);
            let rest = V::load(&self.rest[slot], part);
            let grown = hardening * V::load(&self.flow[slot], part);
            // A quotient 0/0 is of a spring without stiffness, which has no limit; `min` and `max` drop it.
            let longest = ((tension + grown).min(break_force) / k).min(break_length - rest);
            most = (longest / rest).min(most);
            least = (-(compression + grown) / k / rest).max(least);
            shortest = shortest.min(rest);
        }
        let (mut range, mut positive) = ([f32::NEG_INFINITY, f32::INFINITY], true);
        for l in 0..V::LANES {
            range[0] = range[0].max(least.lane(l) as f32);
            range[1] = range[1].min(most.lane(l) as f32);
            positive &= shortest.lane(l) > 0.0;
        }
        let margin = |x: f32| {
            if x.is_finite() {
                1e-5 * x.abs() + 1e-6
            } else {
                0.0
            }
        };
        if positive {
            self.ranges[slot] = Range {
                least: range[0] + margin(range[0]),
                most: range[1] - margin(range[1]),
            };
        }
    }
}

/// The length of a spring from a node to itself, as the pass finds it.
fn least_length() -> f32 {
    LEAST_SQUARE.sqrt()
}

impl Sell {
    /// The table of springs; `limits` is empty, or has one row more than there are springs. `None` for bodies too large for
    /// its indices.
    pub fn new(links: &[Link<f32>], limits: &[Limit<f32>], state: &State<f32>) -> Option<Self> {
        let nodes = state.particles.len();
        // Broken springs keep their slots, so that a table made late has the order of one whose springs broke under way.
        let whole = |&(i, link): &(usize, &Link<f32>)| {
            state.broken[i] || link.stiffness != 0.0 || link.damping != 0.0
        };
        let springs = links.iter().enumerate().filter(whole);
        let adjacency = Adjacency::new(nodes, springs.map(|(i, l)| (i as u32, [l.a, l.b])));
        let order = adjacency.rows();
        let mut rows = vec![0; nodes];
        for (row, &node) in order.iter().enumerate() {
            rows[node as usize] = row as u32;
        }
        let damped = links.iter().any(|l| l.damping != 0.0);
        let mut sell = Self {
            nodes,
            firsts: vec![0],
            own: Places::new(nodes)?,
            out: Places::new(nodes + 1)?,
            far: Places::new(nodes)?,
            which: Vec::new(),
            stiffness: Vec::new(),
            damping: Vec::new(),
            rest: Vec::new(),
            limits: if limits.is_empty() {
                None
            } else {
                Some(Limits {
                    springs: Places::new(limits.len())?,
                    rest: Vec::new(),
                    flow: Vec::new(),
                    ranges: Vec::new(),
                    busy: Vec::new(),
                })
            },
            rows,
        };
        let mut distinct = HashMap::new();
        for slice in order.chunks(LANES) {
            sell.push_slice(slice, &adjacency, (links, state), damped, &mut distinct);
        }
        Some(sell)
    }

    fn push_slice(
        &mut self,
        nodes: &[u32],
        adjacency: &Adjacency,
        (links, state): (&[Link<f32>], &State<f32>),
        damped: bool,
        distinct: &mut HashMap<[[u32; LANES]; 3], u32>,
    ) {
        let node = |lane: usize, otherwise: usize| {
            let node = nodes.get(lane).map(|&n| n as usize);
            node.unwrap_or(otherwise) as u32
        };
        self.own.push(std::array::from_fn(|l| node(l, 0)));
        self.out.push(std::array::from_fn(|l| node(l, self.nodes)));
        let longest = nodes.iter().map(|&n| adjacency.at(n).len()).max();
        for slot in 0..longest.unwrap_or(0) {
            let end = |lane: usize| {
                let end = adjacency.at(*nodes.get(lane)?).get(slot).copied();
                end.filter(|(spring, _)| !state.broken[*spring as usize])
            };
            let of = |value: fn(&Link<f32>) -> f32| {
                Wide(std::array::from_fn(|l| {
                    end(l).map_or(0.0, |(spring, _)| value(&links[spring as usize]))
                }))
            };
            let rest = Wide(std::array::from_fn(|l| {
                end(l).map_or(least_length(), |(spring, _)| state.rest[spring as usize])
            }));
            let (stiffness, damping) = (of(|l| l.stiffness), of(|l| l.damping));
            self.far.push(std::array::from_fn(|l| {
                end(l).map_or(node(l, 0), |(_, other)| other)
            }));
            // Rest lengths that can change are no constants.
            let fixed = if self.limits.is_some() {
                Wide([0.0; LANES])
            } else {
                rest
            };
            let key = [stiffness, damping, fixed].map(|w| w.0.map(f32::to_bits));
            let next = self.stiffness.len() as u32;
            let which = *distinct.entry(key).or_insert(next);
            if which == next {
                self.stiffness.push(stiffness);
                if damped {
                    self.damping.push(damping);
                }
                if self.limits.is_none() {
                    self.rest.push(rest);
                }
            }
            self.which.push(which);
            if let Some(limits) = &mut self.limits {
                let spring = |l| end(l).map_or(links.len() as u32, |(spring, _)| spring);
                let flow = |l| end(l).map_or(0.0, |(spring, _)| state.flow[spring as usize]);
                limits.springs.push(std::array::from_fn(spring));
                limits.flow.push(Wide(std::array::from_fn(flow)));
                limits.rest.push(rest);
                limits.ranges.push(Range::UNKNOWN);
            }
        }
        self.firsts.push(self.which.len() as u32);
        if let Some(limits) = &mut self.limits {
            limits.busy.push([true; 4]);
        }
    }

    /// Takes all force from a spring that has limits.
    pub(crate) fn cut(&mut self, spring: usize, link: &Link<f32>, table: &[Limit<f32>]) {
        for node in [link.a, link.b] {
            let row = self.rows[node as usize] as usize;
            let (slice, lane) = (row / LANES, row % LANES);
            for slot in self.firsts[slice] as usize..self.firsts[slice + 1] as usize {
                let Some(limits) = &mut self.limits else {
                    return;
                };
                if limits.springs.row(slot, lane) == spring {
                    limits.springs.set(slot, lane, table.len() - 1);
                    limits.flow[slot].0[lane] = 0.0;
                    self.far.set(slot, lane, node as usize);
                    limits.rest[slot].0[lane] = least_length();
                    limits.ranges[slot].forget();
                    limits.busy[slice] = [true; 4];
                    break;
                }
            }
        }
    }

    /// Bytes of what a pass reads while nothing yields, and of all.
    pub(crate) fn bytes(&self) -> [usize; 2] {
        let wide = |table: &[Wide]| size_of_val(table);
        let constants = wide(&self.stiffness) + wide(&self.damping) + wide(&self.rest);
        let mut hot = self.far.bytes() + size_of_val(&self.which[..]) + constants;
        let mut rare = self.own.bytes() + self.out.bytes() + size_of_val(&self.rows[..]);
        if let Some(limits) = &self.limits {
            hot += wide(&limits.rest) + size_of_val(&limits.ranges[..]);
            rare += wide(&limits.flow) + limits.springs.bytes();
        }
        [hot, hot + rare]
    }
}
