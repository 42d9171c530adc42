//! How many instructions a substep takes, counted by valgrind's callgrind and held against `tests/instructions.csv` within 5 %:
//! times on a busy machine say nothing, counts hardly change. And whether the kernels for AVX-512 are one piece.
//!
//! Valgrind 3.19 has no AVX-512, so the kernels for AVX2 and the portable ones are guarded. Counts belong to one compiler: with
//! another, without valgrind, and in a build without optimisation nothing is checked, and that is said. To renew them:
//! `cargo test --release --features cli --test instructions -- --renew`.

use crumple::body::Blueprint;
use crumple::prelude::*;
use crumple::rapier3d::prelude::Vector;
use crumple::scenario::speed::subject::{Subject, shuffled};
use crumple::shape::{TetSplit, tet_box_of_cells};
use libtest_mimic::{Arguments, Failed, Trial};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Command, ExitCode};
use std::sync::Arc;

/// The share by which a count may differ.
const BAND: f64 = 0.05;

/// A body, what it is made of, and a kernel.
struct Case {
    name: &'static str,
    lattice: bool,
    yields: bool,
    kernel: Kernel,
}

fn cases() -> Vec<Case> {
    let case = |name, lattice, yields, kernel| Case {
        name,
        lattice,
        yields,
        kernel,
    };
    vec![
        case("lattice AVX2", true, false, Kernel::Avx2),
        case("lattice portable", true, false, Kernel::Portable),
        case("lattice yield AVX2", true, true, Kernel::Avx2),
        case("mesh AVX2", false, false, Kernel::Avx2),
        case("mesh portable", false, false, Kernel::Portable),
        case("mesh yield AVX2", false, true, Kernel::Avx2),
    ]
}

/// Makes so many substeps.
fn run(case: &Case, substeps: usize) {
    let net = if case.lattice {
        lattice(Vector::ONE, 1.0 / 6.0).expect("a lattice")
    } else {
        let mesh = tet_box_of_cells(Vector::ONE, [6; 3], TetSplit::Six).expect("a box");
        shuffled(&mesh.springs())
    };
    let mut material = Material::elastic(1e6, 100.0);
    if case.yields {
        material = material.yielding(1e4, 0.0);
    }
    let blueprint = Blueprint::resolve(net, |_| Some(material), None).expect("a blueprint");
    let mut subject = Subject::new(&blueprint, case.kernel, 0.0);
    for _ in 0..substeps {
        subject.substep();
    }
}

/// Instructions of a run of this program with so many substeps; `None` where valgrind is not there or fails.
fn count(case: &Case, substeps: usize) -> Option<f64> {
    let done = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().ok()?)
        .args(["--run", case.name, &substeps.to_string()])
        .output()
        .ok()?;
    let told = String::from_utf8_lossy(&done.stderr).into_owned();
    let line = told.lines().find(|l| l.contains("Collected :"))?;
    line.split_whitespace().last()?.parse().ok()
}

/// Instructions of a substep, without what comes before.
fn per_substep(case: &Case) -> Option<f64> {
    const FEW: usize = 20;
    Some((count(case, 11 * FEW)? - count(case, FEW)?) / (10 * FEW) as f64)
}

fn file() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/instructions.csv")
}

fn rustc() -> Option<String> {
    let told = Command::new("rustc").arg("-V").output().ok()?;
    Some(String::from_utf8_lossy(&told.stdout).trim().to_owned())
}

/// The compiler and the counts that are written down.
fn expected() -> (String, BTreeMap<String, f64>) {
    let text = std::fs::read_to_string(file()).unwrap_or_default();
    let mut lines = text.lines();
    let compiler = lines.next().unwrap_or_default().trim_start_matches("# ");
    let counts = lines.filter_map(|line| {
        let (name, count) = line.split_once(',')?;
        Some((name.to_owned(), count.parse().ok()?))
    });
    (compiler.to_owned(), counts.collect())
}

fn renew(compiler: &str) -> Option<()> {
    let mut text = format!("# {compiler}\ncase,instructions_per_substep\n");
    for case in cases() {
        let count = per_substep(&case)?;
        text += &format!("{},{count:.0}\n", case.name);
    }
    std::fs::write(file(), text).ok()
}

/// Why nothing can be checked.
fn obstacle(compiler: &str, recorded: &str) -> Option<String> {
    if cfg!(debug_assertions) {
        return Some("a build without optimisation".into());
    }
    if Command::new("valgrind").arg("--version").output().is_err() {
        return Some("there is no valgrind".into());
    }
    (compiler != recorded).then(|| format!("counts are of {recorded}, this is {compiler}"))
}

/// Holds a count against what is written down.
fn check(case: &Case, counts: &BTreeMap<String, f64>) -> Result<(), Failed> {
    let found = per_substep(case).ok_or("valgrind counted nothing")?;
    let count = counts.get(case.name).ok_or("no count is written down")?;
    let change = found / count - 1.0;
    if change.abs() <= BAND {
        return Ok(());
    }
    Err(format!(
        "{found:.0} instructions per substep, {:+.1} %; if that is meant, renew the counts: see {}",
        100.0 * change,
        file!()
    )
    .into())
}

/// What the compiler does not inline into a kernel (closures above all) loses the processor's wider instructions: each intrinsic
/// in it becomes a function of a few instructions, whose name is then in the program, and whose arguments go through memory.
fn no_intrinsic_is_called() -> Result<(), Failed> {
    let program = std::fs::read(std::env::current_exe()?)?;
    // Not in one piece here, or it would be found in this very program.
    let name = [b"avx512f".as_slice(), b"__mm512_"];
    let length = |at: &[u8]| at.iter().take_while(|c| c.is_ascii_digit()).count();
    let called = program
        .windows(name[0].len())
        .enumerate()
        .find(|(at, found)| {
            let rest = &program[at + found.len()..];
            *found == name[0] && rest[length(rest)..].starts_with(name[1])
        });
    called.map_or(Ok(()), |(at, _)| {
        let name = program[at..].split(|c| *c == 0).next().unwrap_or_default();
        Err(format!("{} is called", String::from_utf8_lossy(name)).into())
    })
}

fn main() -> ExitCode {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    if let [how, name, substeps] = &asked[..]
        && how == "--run"
        && let Some(case) = cases().iter().find(|c| c.name == name)
    {
        run(case, substeps.parse().unwrap_or(0));
        return ExitCode::SUCCESS;
    }
    let compiler = rustc().unwrap_or_default();
    if asked.iter().any(|a| a == "--renew") {
        return renew(&compiler).map_or(ExitCode::FAILURE, |()| ExitCode::SUCCESS);
    }
    let arguments = Arguments::from_args();
    let (recorded, counts) = expected();
    let obstacle = obstacle(&compiler, &recorded);
    if let Some(why) = &obstacle
        && !arguments.list
    {
        println!("instructions are not counted: {why}");
    }
    let counts = Arc::new(counts);
    let whole = Trial::test(
        "instructions::no_intrinsic_is_called",
        no_intrinsic_is_called,
    );
    let counted = cases().into_iter().map(|case| {
        let counts = counts.clone();
        let name = format!("instructions::{}", case.name.replace(' ', "_"));
        Trial::test(name, move || check(&case, &counts))
    });
    let trials = counted.chain([whole]);
    let trials = trials.map(|t| t.with_ignored_flag(obstacle.is_some()));
    libtest_mimic::run(&arguments, trials.collect()).exit_code()
}
