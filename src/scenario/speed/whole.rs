//! Whole steps of a crash scene, contact and Rapier included, against the force loops of its bodies alone.

use super::clock::{Clock, median, per_call};
use super::subject::Subject;
use super::{SceneError, Sizes};
use crate::scenario::{Scene, find};
use crate::solve::Kernel;
use crate::world::DeformableWorld;

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

/// Seconds per substep of the bodies' springs and nodes alone, at rest, each measured for at least `least` s.
pub fn force_loop(deformables: &DeformableWorld, least: f64) -> f64 {
    let bodies = deformables.iter().map(|(_, body)| {
        let mut subject = Subject::new(body.blueprint(), Kernel::Auto, 0.0);
        let count = 200_000 / body.spring_count().max(1) + 1;
        per_call(least, count, || subject.substep())
    });
    bodies.sum()
}

/// Seconds and spring updates of a scene, with or without its recorder.
///
/// # Errors
/// [`SceneError`] where it can't be built.
pub fn steps(scene: &Scene, duration: f64, recorded: bool) -> Result<(f64, f64), SceneError> {
    let mut options = scene.options;
    options.duration = duration;
    let mut run = scene.build(&options)?;
    let mut updates = 0.0;
    let clock = Clock::start();
    for _ in 0..run.total_steps() {
        if recorded {
            run.deformables
                .step_with(&mut run.world, &(), &(), &mut run.recorder);
        } else {
            run.deformables.step(&mut run.world);
        }
        updates += run.deformables.report().spring_updates as f64;
    }
    Ok((clock.spent().as_secs_f64(), updates))
}

pub(super) fn rows(sizes: &Sizes) -> Result<Vec<WholeRow>, SceneError> {
    let crash = find("wall").map_err(|_| SceneError::Missing("wall"))?;
    let built = crash.build(&crash.options)?;
    let springs: usize = built
        .deformables
        .iter()
        .map(|(_, b)| b.spring_count())
        .sum();
    let pairs: Result<Vec<[f64; 2]>, SceneError> = (0..sizes.rounds.min(3))
        .map(|_| {
            let (spent, updates) = steps(crash, sizes.crash, false)?;
            let alone = springs as f64 / force_loop(&built.deformables, sizes.long);
            Ok([updates / spent, alone])
        })
        .collect();
    let pairs = pairs?;
    Ok(vec![WholeRow {
        scene: crash.name,
        updates_per_s: median(pairs.iter().map(|p| p[0])),
        alone_per_s: median(pairs.iter().map(|p| p[1])),
        share: median(pairs.iter().map(|[whole, alone]| whole / alone)),
    }])
}
