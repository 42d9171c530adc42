//! What came out of a run, held against what was expected.

use super::super::{Run, survey};
use super::build::RunError;
use super::model::{Channel, Expectation, Quantity};
use super::reduce::Measured;
use super::run::{ScenarioRun, Series};
use std::fmt::{Display, Formatter};

/// An expectation, and what was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What it is about.
    pub name: String,
    /// What was measured, in the quantity's unit; NaN where nothing was, and for the hash.
    pub measured: f64,
    /// What it must be, in words.
    pub bound: String,
    /// When it was measured \[s\], for quantities that belong to a time.
    pub time: Option<f64>,
    /// Whether it is what it must be. NaN never is.
    pub passed: bool,
}

/// What a run came to.
pub struct Outcome {
    /// Every expectation, in the order of the file, and what no run may come to: bodies or actuators
    /// that are not finite.
    pub checks: Vec<Check>,
    /// The probes by name.
    pub probes: Vec<(String, Series)>,
    /// Bit for bit the state of all deformables.
    pub state_hash: String,
    /// With which [`Kernel`](crate::solve::Kernel) it was computed; all give the same bits.
    pub kernel: &'static str,
    /// The run itself.
    pub run: ScenarioRun,
}

impl Outcome {
    /// Evaluates a run.
    pub(super) fn of(run: ScenarioRun) -> Result<Self, RunError> {
        let state_hash = format!("{:016x}", run.run.deformables.state_hash());
        let checks: Result<Vec<Check>, RunError> = run
            .scenario
            .expect
            .iter()
            .map(|e| check(e, &run, &state_hash))
            .collect();
        let mut checks = checks?;
        let asked = |e: &Expectation| matches!(e.that, Quantity::Finite);
        if !run.scenario.expect.iter().any(asked) {
            checks.extend(not_finite(&run));
        }
        let probes = run.scenario.probes.iter();
        let probes: Result<Vec<_>, RunError> = probes
            .map(|p| Ok((p.name.clone(), run.probe(p)?)))
            .collect();
        Ok(Self {
            checks,
            probes: probes?,
            state_hash,
            kernel: run.run.deformables.params.kernel.name(),
            run,
        })
    }

    /// Whether every expectation was met.
    pub fn passed(&self) -> bool {
        self.checks.iter().all(|c| c.passed)
    }

    /// Nothing where every expectation was met, for tests.
    ///
    /// # Errors
    /// [`Failed`], whose text is the table of all expectations.
    pub fn verdict(&self) -> Result<(), Failed> {
        match self.passed() {
            true => Ok(()),
            false => Err(Failed {
                table: self.to_string(),
                about: self.run.scenario.about.clone(),
            }),
        }
    }
}

/// A run did not come to what was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{about}: not what was expected\n{table}")]
pub struct Failed {
    /// What the scene is about.
    pub about: String,
    /// Every expectation: check, measured, bound, at which time, verdict.
    pub table: String,
}

/// What fails of a run in which something has become infinite or NaN: the rest of it is worth nothing.
fn not_finite(run: &ScenarioRun) -> Option<Check> {
    (!run.run.is_sound()).then(|| Check {
        name: what_is_not(&run.run),
        measured: 0.0,
        bound: "= 1".into(),
        time: None,
        passed: false,
    })
}

/// `Finite`, with what was not.
fn what_is_not(run: &Run) -> String {
    let frozen = |h| run.deformables.get(h).is_some_and(|b| b.is_frozen());
    let frozen = run.cast.deformables.iter().filter(|(_, h)| frozen(*h));
    let froze = frozen.map(|(name, _)| format!("`{name}` froze"));
    let names: Vec<String> = run.fault.iter().cloned().chain(froze).collect();
    match names[..] {
        [] => "Finite".to_owned(),
        _ => format!("Finite: {}", names.join(", ")),
    }
}

fn check(e: &Expectation, run: &ScenarioRun, hash: &str) -> Result<Check, RunError> {
    let name = match (e.name.as_str(), &e.that) {
        ("", Quantity::Finite) => what_is_not(&run.run),
        ("", that) => title(that),
        (name, _) => name.into(),
    };
    if let Some(expected) = &e.hash {
        return Ok(Check {
            name: format!(
                "{name} {hash}, kernel {}",
                run.run.deformables.params.kernel.name()
            ),
            measured: f64::NAN,
            bound: format!("= {expected}"),
            time: None,
            passed: expected.eq_ignore_ascii_case(hash),
        });
    }
    let (measured, time) = measure(e, run)?;
    let tolerance = match (e.within, e.within_share, e.equals) {
        (Some(within), ..) => within,
        (None, Some(share), Some(value)) => share * value.abs(),
        _ => 0.0,
    };
    let not_below = e.at_least.is_none_or(|least| measured >= least);
    let not_above = e.at_most.is_none_or(|most| measured <= most);
    let equal = e.equals.is_none_or(|x| (measured - x).abs() <= tolerance);
    Ok(Check {
        name,
        measured,
        bound: bound(e),
        time,
        passed: not_below && not_above && equal && !measured.is_nan(),
    })
}

fn bound(e: &Expectation) -> String {
    let mut words = Vec::new();
    if let Some(least) = e.at_least {
        words.push(format!("≥ {}", short(least)));
    }
    if let Some(most) = e.at_most {
        words.push(format!("≤ {}", short(most)));
    }
    if let Some(value) = e.equals {
        words.push(match (e.within, e.within_share) {
            (Some(within), _) => format!("= {} ± {}", short(value), short(within)),
            (_, share) => format!(
                "= {} ± {} %",
                short(value),
                short(100.0 * share.unwrap_or(0.0))
            ),
        });
    }
    words.join(" and ")
}

fn measure(e: &Expectation, run: &ScenarioRun) -> Result<Measured, RunError> {
    let whole = |x: f64| (x, None);
    if let Quantity::At { channel, time } = &e.that {
        return Ok((run.channel(channel)?.at(*time), Some(*time)));
    }
    if let Some(channel) = e.that.channel() {
        let series = run.channel(channel)?.between(e.over);
        return Ok(reduced(&e.that, &series));
    }
    let (world, soft) = (&run.run.world, &run.run.deformables);
    let recorder = &run.run.recorder;
    Ok(match &e.that {
        Quantity::Crush { of, axis } | Quantity::LastingCrush { of, axis } => {
            let extent = run.channel(&Channel::Extent {
                of: of.clone(),
                axis: axis.clone(),
            })?;
            let (now, time) = match e.that {
                Quantity::Crush { .. } => extent.lowest(),
                _ => extent.last(),
            };
            (extent.first().0 - now, time)
        }
        Quantity::EnergyResidual => whole(recorder.max_residual()),
        Quantity::MomentumClosure => whole(recorder.momentum_closure()),
        Quantity::CouplingDefect => whole(run.run.coupling_defect),
        Quantity::EnergyRise => whole(survey::largest_rise(&run.run.energy)),
        Quantity::DeepestPenetration => {
            let channels = recorder.bodies.iter().flat_map(|b| &b.channels);
            let deepest = channels.max_by(|a, b| a.max_depth.total_cmp(&b.max_depth));
            deepest.map_or((0.0, None), |c| (c.max_depth, Some(c.depth_time)))
        }
        Quantity::NodesThrough(depth) => whole(survey::nodes_through(world, soft, *depth) as f64),
        Quantity::RestTime(speed) => whole(run.rest_time(*speed)),
        Quantity::Asleep => {
            let bodies = world.bodies.iter();
            let asleep = bodies.filter(|(_, b)| b.is_dynamic() && b.is_sleeping());
            whole(asleep.count() as f64)
        }
        Quantity::Finite => whole(f64::from(u8::from(run.run.is_sound()))),
        Quantity::Time => whole(soft.time()),
        counted => whole(run.count(counted).unwrap_or(f64::NAN)),
    })
}

fn reduced(quantity: &Quantity, series: &Series) -> Measured {
    match quantity {
        Quantity::Peak(_) => series.peak(),
        Quantity::Lowest(_) => series.lowest(),
        Quantity::PeakSize(_) => series.peak_size(),
        Quantity::First(_) => series.first(),
        Quantity::Final(_) => series.last(),
        Quantity::Change(_) => (series.last().0 - series.first().0, None),
        Quantity::Mean(_) => (series.mean(), None),
        Quantity::Integral(_) => (series.integral(), None),
        Quantity::Period(_) => (series.period(), None),
        Quantity::PeakTime(_) => (series.peak().1.unwrap_or(f64::NAN), None),
        Quantity::Rebound(_) => (-series.last().0 / series.first().0, None),
        _ => (f64::NAN, None),
    }
}

/// A quantity in a few words, for those without a name.
fn title(quantity: &Quantity) -> String {
    let whole = format!("{quantity:?}");
    let end = whole.find(['(', ' ', '{']).unwrap_or(whole.len());
    let kind = &whole[..end];
    match (quantity, quantity.channel()) {
        (Quantity::At { channel, time }, _) => format!("{} at {} s", of(channel), short(*time)),
        (Quantity::Crush { of, axis } | Quantity::LastingCrush { of, axis }, _) => {
            format!("{kind} of {of} along {axis:?}")
        }
        (_, Some(channel)) => format!("{kind} of {}", of(channel)),
        (_, None) => kind.into(),
    }
}

fn of(channel: &Channel) -> String {
    let along = |what: &str, of: &str, axis| format!("{what} of {of} along {axis:?}");
    match channel {
        Channel::Probe(name) => name.clone(),
        Channel::Force { by, axis, .. } => along("force", by, axis),
        Channel::Position { of, axis, .. } => along("position", of, axis),
        Channel::Velocity { of, axis, .. } => along("velocity", of, axis),
        Channel::Acceleration { of, axis, .. } => along("acceleration", of, axis),
        Channel::Spin { of, axis } => along("spin", of, axis),
        Channel::Low { of, axis } => along("lowest point", of, axis),
        Channel::High { of, axis } => along("highest point", of, axis),
        Channel::Extent { of, axis } => along("extent", of, axis),
        Channel::Energy { of, term } => format!("{term:?} energy of {of}"),
        Channel::Stress { of, .. } => format!("stress of {of}"),
        Channel::MechanicalEnergy => "mechanical energy".into(),
        Channel::Fastest => "fastest".into(),
    }
}

/// A number with at most five digits.
pub(crate) fn short(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    if !(1.0e-3..1.0e6).contains(&size) {
        let text = format!("{x:.4e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let digits = digits.trim_end_matches('0').trim_end_matches('.');
        return format!("{digits}e{exponent}");
    }
    let decimals = (4 - size.log10().floor() as i32).max(0) as usize;
    let text = format!("{x:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').into(),
        false => text,
    }
}

impl Display for Outcome {
    /// A table: check, measured, bound, at which time, verdict.
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let head = ["check", "measured", "bound", "at", ""].map(String::from);
        let row = |c: &Check| {
            let measured = match c.measured.is_nan() && c.bound.starts_with("= ") {
                true if !c.bound.contains('±') => String::new(),
                _ => short(c.measured),
            };
            let at = c
                .time
                .map_or_else(String::new, |t| format!("{} s", short(t)));
            let verdict = if c.passed { "ok" } else { "FAILED" };
            [
                c.name.clone(),
                measured,
                c.bound.clone(),
                at,
                verdict.into(),
            ]
        };
        let rows: Vec<[String; 5]> = std::iter::once(head)
            .chain(self.checks.iter().map(row))
            .collect();
        let width: [usize; 5] = std::array::from_fn(|i| {
            let widths = rows.iter().map(|r| r[i].chars().count());
            widths.max().unwrap_or(0)
        });
        for [name, measured, bound, at, verdict] in &rows {
            let [a, b, c, d, _] = width;
            let line = format!("{name:a$}  {measured:>b$}  {bound:c$}  {at:>d$}  {verdict}");
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_are_short() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.01, "0.01"),
            (1234.5678, "1234.6"),
            (1.0e-9, "1e-9"),
            (-2.5e7, "-2.5e7"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(short(x), text);
        }
    }
}
