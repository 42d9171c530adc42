//! Whole steps of a crash scene, contact and Rapier included, against the force loops of its bodies alone.

use super::clock::{Clock, median, per_call};
use super::subject::Subject;
use super::{SceneError, Sizes};
use crate::scenario::{Scene, find};
use crate::solve::Kernel;
use std::time::Instant;

/// Many grains of the clock \[s\].
const TURN: f64 = 0.12;

/// A crash scene.
#[derive(Clone, Debug, serde::Serialize)]
pub struct WholeRow {
    /// Which scene.
    pub scene: &'static str,
    /// Spring updates per second of whole steps.
    pub updates_per_s: f64,
    /// Of the passes over springs and nodes alone, nothing flowing.
    pub alone_per_s: f64,
    /// The same in the midst of the scene, springs flowing as they do there.
    pub flowing_per_s: f64,
    /// Whole steps over the passes alone, nothing flowing, median over rounds \[1\].
    pub share: f64,
    /// The same over passes in which they flow: what contact, coupling, Rapier and the books leave \[1\].
    pub share_of_flowing: f64,
}

/// Spring updates per second.
#[derive(Clone, Copy, Debug)]
pub struct Paces {
    /// Of whole steps.
    pub whole: f64,
    /// Of the passes over springs and nodes alone, at rest.
    pub alone: f64,
    /// The same in the midst of the scene.
    pub flowing: f64,
}

/// How fast a scene goes, and the passes over its bodies alone, at rest and as they crumple. The three take turns all along:
/// what else a machine has to do comes and goes within seconds.
///
/// # Errors
/// [`SceneError`] where it can't be built.
pub fn in_turn(scene: &Scene, duration: f64) -> Result<Paces, SceneError> {
    let mut options = scene.options;
    options.duration = duration;
    let mut run = scene.build(&options)?;
    let bodies = || run.deformables.iter().map(|(_, body)| body);
    let mut at_rest: Vec<Subject> = bodies()
        .map(|body| Subject::new(body.blueprint(), Kernel::Auto, 0.0))
        .collect();
    let springs: usize = bodies().map(|body| body.spring_count()).sum();
    let [mut whole, mut alone, mut flowing] = [Pace::default(); 3];
    let mut left = run.total_steps();
    while left > 0 {
        let (clock, wall) = (Clock::start(), Instant::now());
        while left > 0 && wall.elapsed().as_secs_f64() < TURN {
            run.deformables.step(&mut run.world);
            whole.updates += run.deformables.report().spring_updates as f64;
            left -= 1;
        }
        whole.spent += clock.spent().as_secs_f64();
        alone.pass_over(&mut at_rest, springs);
        let bodies = run.deformables.iter().map(|(_, body)| body);
        let mut as_they_are: Vec<Subject> = bodies.map(Subject::of).collect();
        flowing.pass_over(&mut as_they_are, springs);
    }
    Ok(Paces {
        whole: whole.rate(),
        alone: alone.rate(),
        flowing: flowing.rate(),
    })
}

#[derive(Clone, Copy, Default)]
struct Pace {
    spent: f64,
    updates: f64,
}

impl Pace {
    /// A turn of passes over bodies with so many springs.
    fn pass_over(&mut self, subjects: &mut [Subject], springs: usize) {
        let count = 200_000 / springs.max(1) + 1;
        self.updates += springs as f64;
        self.spent += per_call(TURN, count, || {
            subjects.iter_mut().for_each(Subject::substep);
        });
    }

    fn rate(&self) -> f64 {
        self.updates / self.spent
    }
}

pub(super) fn rows(sizes: &Sizes) -> Result<Vec<WholeRow>, SceneError> {
    let crash = find("wall").map_err(|_| SceneError::Missing("wall"))?;
    let rounds: Result<Vec<Paces>, SceneError> = (0..sizes.rounds.min(3))
        .map(|_| in_turn(crash, sizes.crash))
        .collect();
    let rounds = rounds?;
    let middle = |of: fn(&Paces) -> f64| median(rounds.iter().map(of));
    Ok(vec![WholeRow {
        scene: crash.name,
        updates_per_s: middle(|p| p.whole),
        alone_per_s: middle(|p| p.alone),
        flowing_per_s: middle(|p| p.flowing),
        share: middle(|p| p.whole / p.alone),
        share_of_flowing: middle(|p| p.whole / p.flowing),
    }])
}
