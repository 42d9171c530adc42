//! Whole steps of a crash scene, contact and Rapier included, against the force loops of its bodies alone.

use super::clock::{Clock, median, per_call};
use super::subject::Subject;
use super::{SceneError, Sizes};
use crate::scenario::{Scene, find};
use crate::solve::Kernel;
use std::time::Instant;

/// A crash scene.
#[derive(Clone, Debug, serde::Serialize)]
pub struct WholeRow {
    /// Which scene.
    pub scene: &'static str,
    /// Spring updates per second of whole steps.
    pub updates_per_s: f64,
    /// Of the passes over springs and nodes alone, nothing flowing.
    pub alone_per_s: f64,
    /// The one over the other, median over pairs \[1\].
    pub share: f64,
}

/// Spring updates per second of whole steps of a scene, and of the springs and nodes of its bodies alone, at rest. The two take
/// turns all along: what else a machine has to do comes and goes within seconds.
///
/// # Errors
/// [`SceneError`] where it can't be built.
pub fn in_turn(scene: &Scene, duration: f64) -> Result<[f64; 2], SceneError> {
    /// Many grains of the clock \[s\].
    const TURN: f64 = 0.12;
    let mut options = scene.options;
    options.duration = duration;
    let mut run = scene.build(&options)?;
    let bodies = run.deformables.iter().map(|(_, body)| body);
    let mut subjects: Vec<Subject> = bodies
        .map(|body| Subject::new(body.blueprint(), Kernel::Auto, 0.0))
        .collect();
    let bodies = run.deformables.iter().map(|(_, body)| body);
    let springs: usize = bodies.map(|body| body.spring_count()).sum();
    let (mut whole, mut alone) = (Pace::default(), Pace::default());
    let mut left = run.total_steps();
    while left > 0 {
        let clock = Clock::start();
        let wall = Instant::now();
        while left > 0 && wall.elapsed().as_secs_f64() < TURN {
            run.deformables.step(&mut run.world);
            whole.updates += run.deformables.report().spring_updates as f64;
            left -= 1;
        }
        whole.spent += clock.spent().as_secs_f64();
        let count = 200_000 / springs.max(1) + 1;
        let each = per_call(TURN, count, || {
            subjects.iter_mut().for_each(Subject::substep);
        });
        alone.updates += springs as f64;
        alone.spent += each;
    }
    Ok([whole.rate(), alone.rate()])
}

#[derive(Default)]
struct Pace {
    spent: f64,
    updates: f64,
}

impl Pace {
    fn rate(&self) -> f64 {
        self.updates / self.spent
    }
}

pub(super) fn rows(sizes: &Sizes) -> Result<Vec<WholeRow>, SceneError> {
    let crash = find("wall").map_err(|_| SceneError::Missing("wall"))?;
    let pairs: Result<Vec<[f64; 2]>, SceneError> = (0..sizes.rounds.min(3))
        .map(|_| in_turn(crash, sizes.crash))
        .collect();
    let pairs = pairs?;
    Ok(vec![WholeRow {
        scene: crash.name,
        updates_per_s: median(pairs.iter().map(|p| p[0])),
        alone_per_s: median(pairs.iter().map(|p| p[1])),
        share: median(pairs.iter().map(|[whole, alone]| whole / alone)),
    }])
}
