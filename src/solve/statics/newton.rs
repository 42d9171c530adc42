//! Newton's method with a line search, load by load.

use super::error::StaticError;
use super::structure::Structure;
use super::supports;
use super::system::System;
use crate::math::DVec3;

/// The smallest part of the load that is tried by itself.
const LEAST_LOAD: f64 = 1.0 / 4096.0;

/// How often a step is halved before it is given up.
const HALVINGS: usize = 24;

/// How a static solve is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statics {
    /// Largest force out of balance at any node, relative to the largest load or reaction.
    pub tolerance: f64,
    /// Newton steps per part of the load.
    pub iterations: usize,
}

impl Default for Statics {
    fn default() -> Self {
        Self {
            tolerance: 1e-9,
            iterations: 200,
        }
    }
}

/// What acts on a body.
#[derive(Clone, Copy, Debug)]
pub struct Load<'a> {
    /// Where the solve starts \[m\]; fixed coordinates stay there, which is how displacements are prescribed.
    pub positions: &'a [DVec3],
    /// Which coordinates of each node are fixed.
    pub fixed: &'a [[bool; 3]],
    /// Dead load on each node \[N\]: it keeps its direction.
    pub forces: &'a [DVec3],
}

/// A state of rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium {
    /// Where the nodes are \[m\].
    pub positions: Vec<DVec3>,
    /// What the supports do to each node \[N\]; zero along free coordinates.
    pub reactions: Vec<DVec3>,
    /// Elastic energy \[J\].
    pub energy: f64,
    /// The largest force out of balance \[N\].
    pub residual: f64,
    /// Newton steps made.
    pub iterations: usize,
    /// Parts the load was put on in.
    pub load_steps: usize,
}

impl Statics {
    /// The equilibrium of a structure under a load.
    ///
    /// # Errors
    /// [`StaticError::Length`], [`StaticError::Node`] and [`StaticError::Value`] for input out of range,
    /// [`StaticError::Supports`] when a part can move as a whole, [`StaticError::NotConverged`] when the forces do not come
    /// to balance, [`StaticError::Solver`] when memory runs out.
    pub fn solve(
        &self,
        structure: &impl Structure,
        load: &Load,
    ) -> Result<Equilibrium, StaticError> {
        self.check(structure, load)?;
        supports::check(structure, load.positions, load.fixed)?;
        let mut run = Run {
            structure,
            load,
            settings: *self,
            system: System::new(structure, load.positions, load.fixed)?,
            x: load.positions.to_vec(),
            internal: vec![DVec3::ZERO; load.positions.len()],
            energy: 0.0,
            iterations: 0,
        };
        let mut on = 0.0;
        let mut part = 1.0;
        let mut load_steps = 0;
        let mut residual = 0.0;
        while on < 1.0 {
            let next = f64::min(on + part, 1.0);
            let before = run.x.clone();
            match run.balance(next) {
                Ok(left) => {
                    residual = left;
                    on = next;
                    load_steps += 1;
                    part *= 2.0;
                }
                Err(error) if matches!(error, StaticError::NotConverged { .. }) => {
                    part *= 0.25;
                    if part < LEAST_LOAD {
                        return Err(error);
                    }
                    run.x = before;
                }
                Err(error) => return Err(error),
            }
        }
        run.internal_forces();
        let reaction = |n: usize| {
            let missing = -(run.internal[n] + load.forces[n]);
            let keep = |axis: usize| {
                if load.fixed[n][axis] {
                    missing[axis]
                } else {
                    0.0
                }
            };
            DVec3::new(keep(0), keep(1), keep(2))
        };
        Ok(Equilibrium {
            reactions: (0..run.x.len()).map(reaction).collect(),
            energy: run.energy,
            residual,
            iterations: run.iterations,
            load_steps,
            positions: run.x,
        })
    }

    fn check(&self, structure: &impl Structure, load: &Load) -> Result<(), StaticError> {
        let nodes = structure.node_count();
        for (what, found) in [
            ("the list of positions", load.positions.len()),
            ("the list of fixed coordinates", load.fixed.len()),
            ("the list of forces", load.forces.len()),
        ] {
            if found != nodes {
                return Err(StaticError::Length { what, found, nodes });
            }
        }
        for (what, list) in [("the position", load.positions), ("the force", load.forces)] {
            if let Some(node) = list.iter().position(|v| !v.is_finite()) {
                return Err(StaticError::Node {
                    what,
                    node: node as u32,
                    value: list[node],
                });
            }
        }
        if self.tolerance > 0.0 && self.tolerance < 1.0 {
            return Ok(());
        }
        Err(StaticError::Value {
            what: "the tolerance of the static solve",
            value: self.tolerance,
            must: "between 0 and 1",
        })
    }
}

/// A solve under way.
struct Run<'a, T> {
    structure: &'a T,
    load: &'a Load<'a>,
    settings: Statics,
    system: System,
    x: Vec<DVec3>,
    internal: Vec<DVec3>,
    energy: f64,
    iterations: usize,
}

impl<T: Structure> Run<'_, T> {
    fn internal_forces(&mut self) {
        self.internal.fill(DVec3::ZERO);
        self.energy = self.structure.forces(&self.x, &mut self.internal);
    }

    /// Forces out of balance with a part of the load; zero along fixed coordinates.
    fn missing(&self, part: f64) -> Vec<DVec3> {
        let each = |((f, internal), fixed): ((&DVec3, &DVec3), &[bool; 3])| {
            let mut r = part * *f + *internal;
            for (axis, fixed) in fixed.iter().enumerate() {
                if *fixed {
                    r[axis] = 0.0;
                }
            }
            r
        };
        self.load
            .forces
            .iter()
            .zip(&self.internal)
            .zip(self.load.fixed)
            .map(each)
            .collect()
    }

    fn potential(&self, part: f64) -> f64 {
        let moved = self.x.iter().zip(self.load.positions);
        let work: f64 = moved
            .zip(self.load.forces)
            .map(|((x, start), f)| (*x - *start).dot(*f))
            .sum();
        self.energy - part * work
    }

    /// Newton's method under a part of the load. What is left out of balance \[N\].
    fn balance(&mut self, part: f64) -> Result<f64, StaticError> {
        let mut shift = 0.0;
        self.internal_forces();
        for _ in 0..=self.settings.iterations {
            let missing = self.missing(part);
            let (node, residual) = worst(&missing);
            let stiffest = self.system.assemble(self.structure, &self.x);
            let allowed = self.allowed(part, stiffest);
            if residual.is_finite() && residual <= allowed {
                return Ok(residual);
            }
            let direction = self.direction(&missing, stiffest, &mut shift)?;
            self.iterations += 1;
            if !self.line_search(part, &direction, &missing, residual) {
                // A longer shift turns the step towards the steepest descent.
                shift = (4.0 * shift).max(1e-6 * stiffest);
                if shift > 1e3 * stiffest || !shift.is_finite() {
                    return Err(self.stuck(part, node, residual, allowed));
                }
            }
        }
        let (node, residual) = worst(&self.missing(part));
        Err(self.stuck(part, node, residual, self.settings.tolerance * residual))
    }

    fn stuck(&self, load: f64, node: u32, residual: f64, allowed: f64) -> StaticError {
        StaticError::NotConverged {
            load,
            node,
            residual,
            allowed,
            iterations: self.iterations,
        }
    }

    /// The residual that counts as none \[N\]: by tolerance, and what rounding of positions alone makes.
    fn allowed(&self, part: f64, stiffest: f64) -> f64 {
        let forces = self
            .load
            .forces
            .iter()
            .zip(&self.internal)
            .zip(self.load.fixed);
        let largest = forces
            .map(|((f, internal), fixed)| {
                let reaction = if fixed.contains(&true) {
                    internal.length()
                } else {
                    0.0
                };
                (part * f.length()).max(reaction)
            })
            .fold(0.0, f64::max);
        let extent = self.x.iter().fold(0.0, |m, x| x.abs().max_element().max(m));
        (self.settings.tolerance * largest).max(64.0 * f64::EPSILON * stiffest * extent)
    }

    /// A direction in which the energy falls. `shift` is that of the last step.
    fn direction(
        &mut self,
        missing: &[DVec3],
        stiffest: f64,
        shift: &mut f64,
    ) -> Result<Vec<DVec3>, StaticError> {
        *shift = if *shift < 1e-10 * stiffest {
            0.0
        } else {
            0.25 * *shift
        };
        for _ in 0..40 {
            let mut direction = missing.to_vec();
            let positive = self.system.solve(*shift, &mut direction)?;
            if positive && dot(&direction, missing) > 0.0 {
                return Ok(direction);
            }
            *shift = (4.0 * *shift).max(1e-9 * stiffest);
        }
        Ok(missing.to_vec())
    }

    /// Goes along a direction as far as the energy, or what is out of balance, falls enough. Whether it went at all.
    fn line_search(
        &mut self,
        part: f64,
        direction: &[DVec3],
        missing: &[DVec3],
        residual: f64,
    ) -> bool {
        let start = self.x.clone();
        let (before, slope) = (self.potential(part), dot(direction, missing));
        let mut length = 1.0;
        for _ in 0..HALVINGS {
            for ((x, s), d) in self.x.iter_mut().zip(&start).zip(direction) {
                *x = *s + length * *d;
            }
            self.internal_forces();
            let falls = self.potential(part) <= before - 1e-4 * length * slope;
            // Near the end differences of energy are rounding; there the residual decides.
            let tiny = length * slope < 1e-9 * before.abs().max(self.energy.abs());
            if falls || (tiny && worst(&self.missing(part)).1 < 0.9 * residual) {
                return true;
            }
            length *= 0.5;
        }
        self.x = start;
        self.internal_forces();
        false
    }
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// The longest vector and its index.
fn worst(list: &[DVec3]) -> (u32, f64) {
    let mut found = (0, 0.0);
    for (i, v) in list.iter().enumerate() {
        let length = v.length();
        if length > found.1 || length.is_nan() {
            found = (i as u32, length);
        }
    }
    found
}
