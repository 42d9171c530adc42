//! `speed`: what this machine reaches, as a table and as JSON.

use super::{Failure, failed};
use crumple::scenario::speed::{Sizes, Speed, measure};
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct SpeedArguments {
    /// Writes everything to this file as well.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Sizes so small that the numbers mean nothing, to see that it works.
    #[arg(long, hide = true)]
    tiny: bool,
}

pub fn speed(arguments: &SpeedArguments) -> Result<(), Failure> {
    if let Some(path) = &arguments.json {
        // Before the measurement: nobody wants to hear after it that there is nowhere to write to.
        std::fs::write(path, "{}\n").map_err(failed(path))?;
    }
    let sizes = if arguments.tiny {
        Sizes::TINY
    } else {
        Sizes::USUAL
    };
    let speed = measure(&sizes, |what| eprintln!("{what} …"))?;
    print(&speed);
    if let Some(path) = &arguments.json {
        let text = serde_json::to_string_pretty(&speed).unwrap_or_default();
        std::fs::write(path, text + "\n").map_err(failed(path))?;
    }
    Ok(())
}

fn print(speed: &Speed) {
    say_line!("{}, {}", speed.cpu, speed.kernel);
    say_line!("\nmillion spring updates per second, one thread, integration included");
    for r in &speed.kernels {
        say_line!(
            "  {:20}{:17}{:14}{:7.0}  {:5.2} × scalar loop  {:5.2} × plain",
            r.body,
            r.material,
            r.kernel,
            1e-6 * r.updates_per_s,
            r.vs_scalar,
            r.vs_plain,
        );
    }
    for r in &speed.whole_steps {
        say_line!(
            "  {:51}{:7.0}  {:5.2} × its force loop, {:.2} × as springs flow there",
            format!("whole steps of the scene {}", r.scene),
            1e-6 * r.updates_per_s,
            r.share,
            r.share_of_flowing,
        );
    }
    say_line!("\nms per step of 1/60 s, crumple and Rapier's own soft body");
    for r in &speed.peers {
        say_line!(
            "  {:20}{:8} springs {:9.3} {:9.3}  {:5.1} ×   strains {:.2} {:.2}",
            r.scene,
            r.springs,
            r.ms_per_frame[0],
            r.ms_per_frame[1],
            r.ratio,
            r.strain[0],
            r.strain[1],
        );
    }
    say_line!("\nthreads on one body");
    for r in &speed.threads {
        let note = r.note.map_or(String::new(), |n| format!(": {n}"));
        let body = format!("{}, {} springs", r.body, r.springs);
        say_line!(
            "  {body:37}{:3} threads  {:5.2} × one{note}",
            r.threads,
            r.speedup
        );
    }
    let r = &speed.roofline;
    say_line!(
        "roofline of a lattice of {} springs: {:.2} of it at {:.0} million updates/s; {:.0} G operations/s over {:.0} each, {:.0} GB/s over {:.0} bytes each",
        r.springs,
        r.share,
        1e-6 * r.updates_per_s,
        1e-9 * r.operations_per_s,
        r.operations_per_update,
        1e-9 * r.bytes_per_s,
        r.bytes_per_update,
    );
}
