//! Channels: what a recording says of one number over time.

use super::super::super::{Run, survey};
use super::super::build::{Places, RunError, selected};
use super::super::limits::USUAL_RATE;
use super::super::model::{Axis, Channel, Class, Energy, Probe, Region, Scenario};
use super::ScenarioRun;
use crate::body::TetId;
use crate::math::{DVec3, narrow};
use crate::record::{Interface, Moments, Resampled, SignalError, resample};
use crate::world::{DeformableHandle, Energies};

/// A number over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// When \[s\].
    pub times: Vec<f64>,
    /// The values, in the channel's unit.
    pub values: Vec<f64>,
    /// Width of the bins the values are means over \[s\]; `None` for samples of an instant.
    pub bins: Option<f64>,
}

impl From<Resampled> for Series {
    fn from(r: Resampled) -> Self {
        Self {
            times: r.times,
            values: r.values,
            bins: Some(r.dt),
        }
    }
}

/// The sets of nodes and tets that are followed for the channels of a scene: which body and formula has which set.
#[derive(Default)]
pub(super) struct Follows {
    nodes: Vec<(DeformableHandle, Region, usize)>,
    tets: Vec<(DeformableHandle, Option<Region>, usize)>,
}

impl Follows {
    /// Begins to follow what the probes and expectations of a scene are about.
    pub fn begin(scene: &Scenario, run: &mut Run) -> Result<Self, RunError> {
        let mut follows = Self::default();
        let expected = scene.expect.iter().filter_map(|e| e.that.channel());
        for channel in scene.probes.iter().map(|p| &p.of).chain(expected) {
            match channel {
                Channel::Position { of, nodes, .. }
                | Channel::Velocity { of, nodes, .. }
                | Channel::Acceleration { of, nodes, .. } => {
                    if let Some(region) = nodes {
                        follows.nodes(run, of, region)?;
                    }
                }
                Channel::Stress { of, at } => follows.tets(run, of, at.as_ref())?,
                _ => {}
            }
        }
        Ok(follows)
    }

    fn nodes(&mut self, run: &mut Run, of: &str, region: &Region) -> Result<(), RunError> {
        let handle = run.cast.deformable(of);
        let body = handle.and_then(|h| run.deformables.get(h));
        let (Some(handle), Some(body)) = (handle, body) else {
            let what = "only a deformable has nodes";
            return Err(RunError::Unfit {
                name: of.into(),
                what,
            });
        };
        if self
            .nodes
            .iter()
            .all(|(h, r, _)| (h, r) != (&handle, region))
        {
            let nodes = selected(body, Some(region), "a channel", of)?;
            let name = format!("set_{}", self.nodes.len() + 1);
            let recorder = &mut run.recorder;
            let set = recorder.follow(name, &run.deformables, handle, nodes)?;
            self.nodes.push((handle, region.clone(), set));
        }
        Ok(())
    }

    fn tets(&mut self, run: &mut Run, of: &str, at: Option<&Region>) -> Result<(), RunError> {
        let handle = run.cast.deformable(of);
        let body = handle.and_then(|h| run.deformables.get(h));
        let (Some(handle), Some(body)) = (handle, body) else {
            return Ok(());
        };
        let places = Places::of(body);
        let tets: Vec<TetId> = body.tet_mesh().map_or_else(Vec::new, |mesh| {
            let middle =
                |c: [u32; 4]| c.map(|n| mesh.nodes[n as usize]).iter().sum::<DVec3>() / 4.0;
            let holds = |c| at.is_none_or(|r| places.holds(&r.0, narrow(middle(c))));
            let chosen = (0..).zip(mesh.tets.corners()).filter(|(_, c)| holds(*c));
            chosen.map(|(i, _)| TetId(i)).collect()
        });
        let name = format!("tets_{}", self.tets.len() + 1);
        let recorder = &mut run.recorder;
        let set = recorder.follow_tets(name, &run.deformables, handle, &tets)?;
        self.tets.push((handle, at.cloned(), set));
        Ok(())
    }
}

fn index(axis: &Axis) -> usize {
    match axis {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    }
}

fn along(values: &[DVec3], axis: &Axis) -> Vec<f64> {
    values.iter().map(|v| v.to_array()[index(axis)]).collect()
}

fn term(of: &Energy) -> fn(&Energies) -> f64 {
    match of {
        Energy::Kinetic => |e| e.kinetic,
        Energy::Elastic => |e| e.elastic,
        Energy::Plastic => |e| e.work.plastic,
        Energy::Damping => |e| e.work.damping,
        Energy::Fracture => |e| e.work.fracture,
        Energy::ContactNormal => |e| e.work.contact_normal,
        Energy::ContactFriction => |e| e.work.contact_friction,
        Energy::Gravity => |e| e.gravity,
        Energy::External => |e| e.work.external,
        Energy::Rigid => |e| e.work.rigid,
        Energy::PushOut => |e| e.work.push_out,
        Energy::Balance => Energies::balance,
    }
}

impl ScenarioRun {
    /// A probe as it was recorded.
    ///
    /// # Errors
    /// [`RunError::Signal`].
    pub fn probe(&self, probe: &Probe) -> Result<Series, RunError> {
        let signal = |source| RunError::Signal {
            channel: probe.name.clone(),
            source,
        };
        let rate = probe.rate.unwrap_or(USUAL_RATE);
        let mut series = self.measure(&probe.of, rate).map_err(signal)?;
        let cfc = probe.cfc.as_ref().map(Class::cfc);
        let mut dt = series.bins;
        if let (None, Some(recorded)) = (dt, series.interval())
            && (probe.rate.is_some() || cfc.is_some())
        {
            if let Some(cfc) = cfc {
                cfc.coefficients(recorded).map_err(|e| signal(e.into()))?;
            }
            let wanted = probe.rate.map_or(recorded, |rate| 1.0 / rate);
            series = series.spaced(wanted).map_err(|e| signal(e.into()))?;
            dt = Some(wanted);
        }
        if let (Some(cfc), Some(dt)) = (cfc, dt) {
            let filtered = cfc.filter(dt, &series.values);
            series.values = filtered.map_err(|e| signal(e.into()))?;
        }
        for value in &mut series.values {
            *value *= probe.scale;
        }
        Ok(series)
    }

    /// Any channel.
    ///
    /// # Errors
    /// [`RunError::Signal`].
    pub fn channel(&self, channel: &Channel) -> Result<Series, RunError> {
        if let Channel::Probe(name) = channel {
            let mut probes = self.scenario.probes.iter();
            let probe = probes.find(|p| p.name == *name);
            return probe.map_or_else(|| Ok(Series::default()), |p| self.probe(p));
        }
        self.measure(channel, USUAL_RATE)
            .map_err(|source| RunError::Signal {
                channel: format!("{channel:?}"),
                source,
            })
    }

    fn measure(&self, channel: &Channel, rate: f64) -> Result<Series, SignalError> {
        let samples = |times: &[f64], values: Vec<f64>| Series {
            times: times.to_vec(),
            values,
            bins: None,
        };
        let record = |of: &str| {
            let handle = self.run.cast.deformable(of)?;
            self.run.recorder.body(handle)
        };
        let bounds = |of: &str, value: &dyn Fn(&[DVec3; 2]) -> DVec3, axis| {
            let record = record(of)?;
            let values: Vec<DVec3> = record.bounds.iter().map(value).collect();
            Some(samples(&record.center.times, along(&values, axis)))
        };
        let found = match channel {
            Channel::Probe(_) => None,
            Channel::Force { by, on, axis } => {
                return self.force(by, on.as_deref(), index(axis), 1.0 / rate);
            }
            Channel::Position { of, nodes, axis } => match self.moments(of, nodes.as_ref()) {
                Some(m) => Some(samples(&m.times, along(&m.positions, axis))),
                None => self.path(of, |p| along(&p.centers, axis)),
            },
            Channel::Velocity { of, nodes, axis } => match self.moments(of, nodes.as_ref()) {
                Some(m) => Some(samples(&m.times, along(&m.velocities, axis))),
                None => self.path(of, |p| along(&p.linvels, axis)),
            },
            Channel::Acceleration { of, nodes, axis } => {
                let Some(m) = self.moments(of, nodes.as_ref()) else {
                    return Ok(Series::default());
                };
                let bins = resample(&m.times, &m.accelerations(index(axis)), 1.0 / rate)?;
                return Ok(bins.into());
            }
            Channel::Spin { of, axis } => self.path(of, |p| along(&p.angvels, axis)),
            Channel::Low { of, axis } => bounds(of, &|b| b[0], axis),
            Channel::High { of, axis } => bounds(of, &|b| b[1], axis),
            Channel::Extent { of, axis } => bounds(of, &|b| b[1] - b[0], axis),
            Channel::Energy { of, term: of_term } => record(of).map(|r| {
                let times: Vec<f64> = r.ledger.iter().map(|s| s.time).collect();
                let value = term(of_term);
                samples(
                    &times,
                    r.ledger.iter().map(|s| value(&s.energies)).collect(),
                )
            }),
            Channel::Stress { of, at } => self.stress(of, at.as_ref()),
            Channel::MechanicalEnergy => {
                let now = || survey::mechanical_energy(&self.run.world, &self.run.deformables);
                let values = match self.run.energy.as_slice() {
                    [] => vec![now()],
                    values => values.to_vec(),
                };
                Some(samples(&self.trace.times, values))
            }
            Channel::Fastest => Some(samples(&self.trace.times, self.trace.fastest.clone())),
        };
        Ok(found.unwrap_or_default())
    }

    /// Force along an axis, of everything that `by` names.
    fn force(
        &self,
        by: &str,
        on: Option<&str>,
        axis: usize,
        dt: f64,
    ) -> Result<Series, SignalError> {
        let cast = &self.run.cast;
        let body = cast.body(by).and_then(|h| self.run.world.bodies.get(h));
        let mut sides: Vec<Interface> = match (body, cast.collider(by)) {
            (Some(body), _) => body
                .colliders()
                .iter()
                .copied()
                .map(Interface::Collider)
                .collect(),
            (None, collider) => collider.map(Interface::Collider).into_iter().collect(),
        };
        sides.extend(cast.deformable(by).map(Interface::Deformable));
        let attachments = cast.attachments.iter().filter(|(name, _)| name == by);
        sides.extend(attachments.map(|(_, handle)| Interface::Attachment(*handle)));
        let only = on.and_then(|name| cast.deformable(name));
        let record = only.and_then(|handle| self.run.recorder.body(handle));
        let mut sum = Series::default();
        for side in sides {
            let part = match record {
                None => self.run.recorder.force(side, axis, dt)?,
                Some(record) => match record.find(side) {
                    Some(channel) => channel.force(&record.edges, axis, dt)?,
                    None => {
                        let ends = [record.edges[0], record.edges[record.edges.len() - 1]];
                        match ends[0] < ends[1] {
                            true => resample(&ends, &[0.0], dt)?,
                            false => resample(&[], &[], dt)?,
                        }
                    }
                },
            };
            if sum.values.is_empty() {
                sum = part.into();
            } else {
                for (s, p) in sum.values.iter_mut().zip(part.values) {
                    *s += p;
                }
            }
        }
        Ok(sum)
    }

    fn moments(&self, of: &str, nodes: Option<&Region>) -> Option<&Moments> {
        let handle = self.run.cast.deformable(of)?;
        let recorder = &self.run.recorder;
        let Some(region) = nodes else {
            return recorder.body(handle).map(|r| &r.center);
        };
        let mut sets = self.follows.nodes.iter();
        let (.., set) = sets.find(|(h, r, _)| (h, r) == (&handle, region))?;
        recorder.sets.get(*set).map(|s| &s.history)
    }

    fn path(&self, of: &str, values: impl Fn(&super::trace::Path) -> Vec<f64>) -> Option<Series> {
        let body = self.run.cast.body(of)?;
        let values = match self.trace.path(body) {
            Some(path) => values(path),
            // A fixed body stays where it is.
            None => {
                let center = self.run.world.bodies.get(body)?.translation();
                let still = super::trace::Path {
                    body,
                    centers: vec![crate::math::wide(center)],
                    linvels: vec![DVec3::ZERO],
                    angvels: vec![DVec3::ZERO],
                };
                vec![values(&still)[0]; self.trace.times.len()]
            }
        };
        Some(Series {
            times: self.trace.times.clone(),
            values,
            bins: None,
        })
    }

    fn stress(&self, of: &str, at: Option<&Region>) -> Option<Series> {
        let handle = self.run.cast.deformable(of)?;
        let mut sets = self.follows.tets.iter();
        let (.., set) = sets.find(|(h, r, _)| *h == handle && r.as_ref() == at)?;
        let set = self.run.recorder.tet_sets.get(*set)?;
        Some(Series {
            times: set.times.clone(),
            values: set.stresses.iter().map(|s| s.von_mises).collect(),
            bins: None,
        })
    }
}
