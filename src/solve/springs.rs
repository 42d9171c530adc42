//! The springs as the force pass reads them. Private to this floor: vector kernels may reorder and pad it at will.

use crate::body::net::Spring;
use crate::body::state::State;
use crate::law::plastic::{self, Yield};
use crate::math::{Real, Scalar};
use crate::solve::forces::LimitEvent;
use crate::solve::kernel::{Sell, of_f32_mut};
use std::sync::OnceLock;

/// The elastic and viscous part of a spring.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Link<S> {
    pub a: u32,
    pub b: u32,
    pub stiffness: S,
    pub damping: S,
}

/// Where a spring flows and breaks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limit<S> {
    pub yields: Yield<S>,
    /// Tension at which it breaks \[N\].
    pub break_force: S,
    /// Length at which it breaks \[m\].
    pub break_length: S,
}

/// All springs of a body.
#[derive(Clone, Debug, Default)]
pub(crate) struct SpringTable<S> {
    pub links: Vec<Link<S>>,
    /// Empty when no spring of the body yields or breaks.
    pub limits: Vec<Limit<S>>,
    /// Whether any spring is damped.
    pub damped: bool,
    /// The nodes between two springs, with either of them. What has broken counts, as before it did.
    pub chain_nodes: Vec<ChainNode>,
    /// See [`Self::relaxation`].
    relaxation: OnceLock<(f64, Option<u32>)>,
    pub rows: Rows,
}

/// A node between two springs, and one of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChainNode {
    pub node: u32,
    pub spring: u32,
}

/// The same springs by rows for the kernels, which are for `f32`.
#[derive(Clone, Debug, Default)]
pub(crate) enum Rows {
    /// To be made when they are needed, so that a body may be edited often before it moves. A new body has them at once.
    #[default]
    Later,
    Made(Box<Sell>),
    /// Not to be made.
    Never,
}

impl<S: Scalar> SpringTable<S> {
    /// The table of resolved springs; those broken in `state` have no stiffness.
    pub fn new(springs: &[Spring], state: &State<S>) -> Self {
        let limited = springs.iter().any(|s| {
            [
                s.yield_tension,
                s.yield_compression,
                s.break_force,
                s.break_strain,
            ]
            .iter()
            .any(|limit| limit.is_finite())
        });
        let mut table = Self {
            links: springs.iter().map(link).collect(),
            limits: if limited {
                springs.iter().map(limit).collect()
            } else {
                Vec::new()
            },
            damped: springs.iter().any(|s| s.damping > 0.0),
            chain_nodes: chain_nodes(springs, state.particles.len()),
            relaxation: OnceLock::new(),
            rows: Rows::Later,
        };
        for (spring, _) in state.broken.iter().enumerate().filter(|(_, b)| **b) {
            table.cut(spring);
        }
        table
    }

    /// The least c/k of any spring \[s\], and of which. It is asked for in every step, and looked for once.
    pub fn relaxation(&self) -> (f64, Option<u32>) {
        *self.relaxation.get_or_init(|| {
            let mut least = (f64::INFINITY, None);
            for (i, link) in (0..).zip(&self.links) {
                let (k, c) = (link.stiffness.f64(), link.damping.f64());
                if k > 0.0 && c / k < least.0 {
                    least = (c / k, Some(i));
                }
            }
            least
        })
    }

    /// Takes all force from a spring.
    fn cut(&mut self, spring: usize) {
        self.relaxation.take();
        self.links[spring].stiffness = S::ZERO;
        self.links[spring].damping = S::ZERO;
        if let Some(limit) = self.limits.get_mut(spring) {
            *limit = Limit::NEVER;
        }
    }

    /// Takes all force from the springs that broke, and says so in the state.
    pub fn cut_broken(&mut self, state: &mut State<S>, events: &[LimitEvent<S>]) {
        for event in events.iter().filter(|e| e.broke) {
            let spring = event.spring as usize;
            state.broken[spring] = true;
            self.cut(spring);
            if let (Some(table), Some(state)) =
                (of_f32_mut::<_, SpringTable<f32>>(self), of_f32_mut(state))
                && let Rows::Made(sell) = &mut table.rows
            {
                sell.cut((spring, &table.links[spring]), state);
            }
        }
    }

    /// Writes to the state what has flowed, if only the rows have it.
    pub fn write_back(&mut self, state: &mut State<S>) {
        if let (Some(table), Some(state)) =
            (of_f32_mut::<_, SpringTable<f32>>(self), of_f32_mut(state))
            && let Rows::Made(sell) = &mut table.rows
        {
            sell.write_back(state);
        }
    }
}

impl SpringTable<f32> {
    /// Makes the rows where there should be some.
    pub fn make_rows(&mut self, state: &State<f32>) {
        if matches!(self.rows, Rows::Later) {
            let sell = Sell::new(&self.links, &self.limits, state);
            self.rows = sell.map_or(Rows::Never, |sell| Rows::Made(Box::new(sell)));
        }
    }

    /// Forgets the rows, because another pass is about to change the state.
    pub fn drop_rows(&mut self, state: &mut State<f32>) {
        if let Rows::Made(sell) = &mut self.rows {
            sell.write_back(state);
            self.rows = Rows::Later;
        }
    }
}

impl<S: Scalar> Limit<S> {
    /// Whether a spring of this tension \[N\] and length \[m\] may flow or break. It does not before its first yield force,
    /// because flow only hardens it.
    #[inline(always)]
    pub fn may_matter(&self, tension: S, length: S) -> bool {
        let elastic = (tension <= self.yields.tension) & (-tension <= self.yields.compression);
        !(elastic & (tension <= self.break_force) & (length <= self.break_length))
    }

    /// Of a spring that never yields or breaks.
    pub const NEVER: Self = Self {
        yields: Yield {
            tension: S::INFINITY,
            compression: S::INFINITY,
            hardening: S::ZERO,
            inverse: S::ZERO,
        },
        break_force: S::INFINITY,
        break_length: S::INFINITY,
    };
}

fn chain_nodes(springs: &[Spring], nodes: usize) -> Vec<ChainNode> {
    let mut counts = vec![0_u32; nodes];
    for node in springs.iter().flat_map(|s| s.nodes) {
        counts[node as usize] += 1;
    }
    let ends = (0..)
        .zip(springs)
        .flat_map(|(spring, s)| s.nodes.map(|node| ChainNode { node, spring }));
    ends.filter(|end| counts[end.node as usize] == 2).collect()
}

fn real<S: Scalar>(x: Real) -> S {
    S::of(x.into())
}

fn link<S: Scalar>(s: &Spring) -> Link<S> {
    Link {
        a: s.nodes[0],
        b: s.nodes[1],
        stiffness: real(s.stiffness),
        damping: real(s.damping),
    }
}

fn limit<S: Scalar>(s: &Spring) -> Limit<S> {
    let rest = f64::from(s.rest_length.unwrap_or(0.0));
    let hardening = real(s.hardening);
    Limit {
        yields: Yield {
            tension: real(s.yield_tension),
            compression: real(s.yield_compression),
            hardening,
            inverse: plastic::inverse(real(s.stiffness), hardening),
        },
        break_force: real(s.break_force),
        break_length: S::of(rest * (1.0 + f64::from(s.break_strain))),
    }
}
