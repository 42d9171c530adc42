//! A scene that runs: the two worlds, the recorder, and names for what takes part.

use super::survey::{all_finite, mechanical_energy};
use super::{Figures, Options};
use crate::math::{Real, Vector};
use crate::record::{Frame, Recorder};
use crate::world::{AttachmentHandle, DeformableHandle, DeformableWorld};
use rapier3d::dynamics::RigidBodyHandle;
use rapier3d::geometry::ColliderHandle;
use rapier3d::pipeline::{PhysicsHooks, PhysicsWorld};
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

/// What takes part in a scene, by name.
#[derive(Clone, Debug, Default)]
pub struct Cast {
    /// Deformables.
    pub deformables: Vec<(String, DeformableHandle)>,
    /// Rigid bodies with their colliders; the fixed ones have no body.
    pub rigid: Vec<(String, Option<RigidBodyHandle>, ColliderHandle)>,
    /// Rigid bodies of scene files, those without colliders included.
    pub bodies: Vec<(String, RigidBodyHandle)>,
    /// Attachments.
    pub attachments: Vec<(String, AttachmentHandle)>,
    /// Runs of the first deformable's skin triangles that are drawn in a colour of their own (glass, tyres), and of all
    /// whose skins have as many.
    pub parts: Vec<(String, Range<usize>)>,
}

impl Cast {
    /// A deformable by name.
    pub fn deformable(&self, name: &str) -> Option<DeformableHandle> {
        let mut all = self.deformables.iter();
        all.find(|(n, _)| n == name).map(|(_, h)| *h)
    }

    /// A collider by name.
    pub fn collider(&self, name: &str) -> Option<ColliderHandle> {
        let mut all = self.rigid.iter();
        all.find(|(n, ..)| n == name).map(|(_, _, c)| *c)
    }

    /// A rigid body of a scene file by name.
    pub fn body(&self, name: &str) -> Option<RigidBodyHandle> {
        let mut all = self.bodies.iter();
        all.find(|(n, _)| n == name).map(|(_, b)| *b)
    }

    /// A rigid body by the name of its first collider.
    pub fn rigid(&self, name: &str) -> Option<RigidBodyHandle> {
        let mut all = self.rigid.iter();
        all.find(|(n, ..)| n == name).and_then(|(_, b, _)| *b)
    }
}

/// What is done before a step.
pub type Lead = Box<dyn Fn(&mut Run) + Send>;

/// A scene that runs.
pub struct Run {
    /// Rapier's world.
    pub world: PhysicsWorld,
    /// The deformables.
    pub deformables: DeformableWorld,
    /// What is recorded.
    pub recorder: Recorder,
    /// Who is who.
    pub cast: Cast,
    /// With what it was built.
    pub options: Options,
    /// The frames taken so far.
    pub frames: Vec<Frame>,
    /// When frames are taken, each at the end of the step nearest to it \[s\]; ascending.
    pub frame_times: Vec<f64>,
    /// From which direction pictures are taken.
    pub view: Vector,
    /// Substeps of the deformable that took most.
    pub substeps: u64,
    /// Spring forces evaluated.
    pub spring_updates: u64,
    /// Forces of tets evaluated.
    pub tet_updates: u64,
    /// Work of shadows that Rapier did otherwise, summed over its absolute values \[J\].
    pub coupling_defect: f64,
    /// Time spent stepping \[s\], wall clock.
    pub wall_s: f64,
    /// Steps made.
    pub steps: u64,
    /// Mechanical energy of everything that moves freely at the beginning and after every step \[J\].
    pub energy: Vec<f64>,
    /// What the scene does before every step, such as to move a platform.
    pub lead: Option<Lead>,
    /// The first thing that `lead` could not do, in words. A run of a scene file with a fault fails.
    pub fault: Option<String>,
    /// What Rapier asks about pairs of colliders.
    pub hooks: Arc<dyn PhysicsHooks>,
    most: Vec<(DeformableHandle, u64)>,
}

impl Run {
    /// Takes over a scene's worlds at the beginning; the recorder begins here.
    pub fn new(
        mut world: PhysicsWorld,
        deformables: DeformableWorld,
        cast: Cast,
        options: &Options,
    ) -> Self {
        world.integration_parameters.dt = options.dt as Real;
        let mut recorder = Recorder::new();
        recorder.begin(&deformables);
        Self {
            world,
            deformables,
            recorder,
            cast,
            options: *options,
            frames: Vec::new(),
            frame_times: Vec::new(),
            view: Vector::new(-0.05, 0.38, 1.0),
            substeps: 0,
            spring_updates: 0,
            tet_updates: 0,
            coupling_defect: 0.0,
            wall_s: 0.0,
            steps: 0,
            energy: Vec::new(),
            lead: None,
            fault: None,
            hooks: Arc::new(()),
            most: Vec::new(),
        }
    }

    /// How many steps the whole run has.
    pub fn total_steps(&self) -> u64 {
        ((self.options.duration / self.options.dt - 1.0e-3).ceil() as u64).max(1)
    }

    /// Makes a step; `false` once the run is over.
    pub fn step(&mut self) -> bool {
        self.take_frames();
        if self.steps >= self.total_steps() {
            return false;
        }
        if self.energy.is_empty() {
            self.energy = vec![mechanical_energy(&self.world, &self.deformables)];
        }
        if let Some(lead) = self.lead.take() {
            lead(self);
            self.lead = Some(lead);
        }
        let start = Instant::now();
        self.deformables
            .step_with(&mut self.world, &*self.hooks, &(), &mut self.recorder);
        self.wall_s += start.elapsed().as_secs_f64();
        self.steps += 1;
        let energy = mechanical_energy(&self.world, &self.deformables);
        self.energy.push(energy);
        let report = self.deformables.report();
        self.spring_updates += report.spring_updates;
        self.tet_updates += report.tet_updates;
        self.coupling_defect += report.coupling_defect.abs();
        for (handle, n) in &report.substeps {
            match self.most.iter_mut().find(|(h, _)| h == handle) {
                Some((_, sum)) => *sum += *n as u64,
                None => self.most.push((*handle, *n as u64)),
            }
        }
        self.substeps = self.most.iter().map(|(_, n)| *n).max().unwrap_or(0);
        true
    }

    /// Steps to the end; `progress` is told the steps made.
    pub fn finish(&mut self, mut progress: impl FnMut(u64)) {
        while self.step() {
            progress(self.steps);
        }
    }

    /// Whether everything is finite, and all that acted was.
    pub fn is_sound(&self) -> bool {
        self.fault.is_none() && all_finite(&self.world, &self.deformables)
    }

    /// Takes the frames that are still due, of a run that is over before its time.
    pub(super) fn take_last_frame(&mut self) {
        if self.frames.len() < self.frame_times.len() {
            self.frames.push(self.frame());
            self.frame_times.truncate(self.frames.len());
        }
    }

    fn frame(&self) -> Frame {
        Frame::take(&self.deformables, &self.world.bodies, &self.world.colliders)
    }

    fn take_frames(&mut self) {
        while let Some(&due) = self.frame_times.get(self.frames.len()) {
            if self.deformables.time() < due - 0.5 * self.options.dt
                && self.steps < self.total_steps()
            {
                return;
            }
            self.frames.push(self.frame());
        }
    }

    /// Largest energy residual, counts and cost: what every scene reports.
    pub fn common_figures(&self, f: &mut Figures) {
        let bodies = self.deformables.iter();
        let (nodes, springs, tets) = bodies.fold((0, 0, 0), |(n, s, t), (_, b)| {
            (n + b.node_count(), s + b.spring_count(), t + b.tet_count())
        });
        let r = &self.recorder;
        f.add("energy_residual", "energy residual", r.max_residual(), "");
        f.add(
            "coupling_defect_j",
            "coupling defect",
            self.coupling_defect,
            "J",
        );
        f.add("springs_yielded", "springs yielded", r.yielded as f64, "");
        f.add("springs_broken", "springs broken", r.broken as f64, "");
        f.add("nodes", "nodes", nodes as f64, "");
        f.add("springs", "springs", springs as f64, "");
        f.add("tets", "tets", tets as f64, "");
        f.add("steps", "steps", self.steps as f64, "");
        f.add("substeps", "substeps", self.substeps as f64, "");
        f.add("dt_s", "step", self.options.dt, "s");
        f.add("simulated_s", "simulated", self.deformables.time(), "s");
        f.add("wall_s", "wall clock", self.wall_s, "s");
        let rate = self.spring_updates as f64 / self.wall_s.max(f64::MIN_POSITIVE);
        f.add("spring_updates_per_second", "spring updates", rate, "1/s");
        let rate = self.tet_updates as f64 / self.wall_s.max(f64::MIN_POSITIVE);
        f.add("tet_updates_per_second", "tet updates", rate, "1/s");
    }
}
