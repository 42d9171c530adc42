//! The command line: arguments → scenario → report. No physics here.
//!
//! Exit codes: 0 for a run that is written and came to what was expected, 1 for one that did not, 2 for anything the user can
//! mend (an unknown scene, a bad option, a wrong file, a folder that can't be written), with clear lines on stderr.

mod cli;

use clap::{Parser, Subcommand};
use cli::Failure;
use std::process::ExitCode;

/// Tens of thousands take minutes to start before any of them does something.
const MOST_THREADS: i64 = 1024;

/// Crash scenes of deformable bodies in a Rapier world.
#[derive(Parser)]
#[command(version, about)]
struct Arguments {
    /// How many threads compute, by default as many as the machine has. Results don't depend on it.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Lists the scenes.
    List,
    /// Runs a scene and writes its channels, plots, pictures and figures.
    Run(cli::run::RunArguments),
    /// Says everything that is wrong with scene files, building them but not running them.
    Check(cli::check::CheckArguments),
    /// Runs every scene file of a folder; exit code 1 if one does not come to what it expects.
    Test(cli::check::TestArguments),
    /// Runs a scene file with many values of its variables; begun again, it goes on where it ended.
    Sweep(cli::sweep::SweepArguments),
    /// Puts the results of a sweep, from one or several folders, into one file in the order of the variants.
    Merge(cli::sweep::MergeArguments),
    /// Measures what this machine reaches, in less than a minute.
    Speed(cli::speed::SpeedArguments),
    /// Explains the keys of scene files: all, or those of one thing, like `keys World`.
    Keys {
        /// The thing.
        of: Option<String>,
    },
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some(threads) = arguments.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        if let Err(error) = pool.build_global() {
            eprintln!("error: can't start {threads} threads: {error}");
            return ExitCode::from(2);
        }
    }
    let result = match arguments.command {
        Command::List => {
            cli::list();
            Ok(())
        }
        Command::Run(arguments) => cli::run::run(&arguments),
        Command::Check(arguments) => cli::check::check(&arguments),
        Command::Test(arguments) => cli::check::test(&arguments),
        Command::Sweep(arguments) => cli::sweep::sweep(&arguments),
        Command::Merge(arguments) => cli::sweep::merge(&arguments),
        Command::Speed(arguments) => cli::speed::speed(&arguments),
        Command::Keys { of } => cli::keys::print(of.as_deref()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Expectation) => ExitCode::from(1),
        Err(failure) => {
            eprintln!("error: {}", cli::chain(&failure));
            ExitCode::from(2)
        }
    }
}
