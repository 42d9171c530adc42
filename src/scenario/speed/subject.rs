//! What is measured: a body on its own, moved by a kernel or by the loop that anyone would write.

use crate::body::{Blueprint, Net, Spring, State};
use crate::solve::{Integrator, Kernel, Solver};
use crate::world::Deformable;

/// A substep far below stability \[s\]: the bodies rest, and what is measured is the passes.
pub const H: f32 = 1e-6;

/// A spring of the scalar loop.
#[derive(Debug)]
struct Link {
    nodes: [u32; 2],
    stiffness: f32,
    rest: f32,
}

/// One loop over springs that adds to both nodes, one over nodes with compensated positions.
#[derive(Debug)]
pub struct ScalarLoop {
    links: Vec<Link>,
    state: State<f32>,
    forces: Vec<[f32; 4]>,
}

impl ScalarLoop {
    /// Of a body at rest.
    pub fn new(blueprint: &Blueprint) -> Self {
        let state = blueprint.rest_state();
        let link = |s: &Spring| Link {
            nodes: s.nodes,
            stiffness: s.stiffness,
            rest: s.rest_length.unwrap_or(0.0),
        };
        Self {
            links: blueprint.springs.iter().map(link).collect(),
            forces: vec![[0.0; 4]; state.particles.len()],
            state,
        }
    }

    /// Symplectic Euler over [`H`].
    pub fn substep(&mut self) {
        self.forces.fill([0.0; 4]);
        for link in &self.links {
            let [a, b] = link.nodes.map(|n| n as usize);
            let (p, q) = (self.state.particles[a].x, self.state.particles[b].x);
            let d = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
            let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            let pull = link.stiffness * (length - link.rest) / length;
            for (k, d) in d.into_iter().enumerate() {
                self.forces[a][k] += d * pull;
                self.forces[b][k] -= d * pull;
            }
        }
        for (i, f) in self.forces.iter().enumerate() {
            let p = &mut self.state.particles[i];
            for (v, f) in p.v.iter_mut().zip(f) {
                *v += H * f * p.inv_mass;
            }
            let by = p.v.map(|v| H * v);
            self.state.displace(i, by);
        }
    }
}

/// A body with a kernel.
#[derive(Debug)]
pub struct Subject {
    /// What moves it.
    pub solver: Solver<f32>,
    /// Where it is.
    pub state: State<f32>,
}

impl Subject {
    /// At rest, but for being shorter along x by a share of `squeeze`, and getting shorter by a thousand times that share
    /// per second.
    pub fn new(blueprint: &Blueprint, kernel: Kernel, squeeze: f32) -> Self {
        let mut state = blueprint.rest_state();
        for p in &mut state.particles {
            p.v[0] = -1e3 * squeeze * p.x[0];
            p.x[0] *= 1.0 - squeeze;
        }
        let mut solver = Solver::new(&blueprint.springs, &state);
        solver.kernel = kernel;
        let mut subject = Self { solver, state };
        // The tables of the kernels are made by the first substep, which takes as long as a thousand others.
        subject.substep();
        subject
    }

    /// A body in the midst of a scene.
    pub fn of(body: &Deformable) -> Self {
        let (solver, state) = body.motion();
        Self { solver, state }
    }

    /// Symplectic Euler over [`H`], one of many substeps.
    pub fn substep(&mut self) {
        let Self { solver, state } = self;
        solver.predict(state, Integrator::SymplecticEuler, H.into(), None);
        solver.finish(state, Integrator::SymplecticEuler, H.into(), None);
    }
}

/// The same net with its nodes in any order.
pub fn shuffled(net: &Net) -> Net {
    let mut names: Vec<u32> = (0..net.nodes.len() as u32).collect();
    let mut seed = 1_u64;
    for i in (1..names.len()).rev() {
        seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        names.swap(i, (seed >> 33) as usize % (i + 1));
    }
    let mut nodes = net.nodes.clone();
    for (node, name) in net.nodes.iter().zip(&names) {
        nodes[*name as usize] = *node;
    }
    let renamed = |s: &Spring| Spring {
        nodes: s.nodes.map(|n| names[n as usize]),
        ..*s
    };
    Net::new(nodes, net.springs.iter().map(renamed).collect())
}
