//! Scene files that are wrong in every way: always a located error, never a panic, never a hang.

use crumple::scenario::file::{LoadOptions, Scenario, scenes_in};
use proptest::prelude::*;
use proptest::sample::Index;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

/// The scene files of the catalog, those that include others left out: a text can't.
fn valid() -> Vec<String> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/scenes");
    let files = scenes_in(folder).unwrap().into_iter();
    let texts = files.map(|(_, path)| std::fs::read_to_string(path).unwrap());
    texts.filter(|t| !t.contains("include:")).collect()
}

/// What may be done to a text at some places of it.
#[derive(Clone, Debug)]
enum Change {
    Cut(Index, Index),
    Twice(Index, Index),
    Insert(Index, &'static str),
    Number(Index, &'static str),
    Word(Index, Index),
    End(Index),
}

/// Bits of syntax, and things that no scene has.
const BITS: [&str; 20] = [
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    ",",
    ":",
    "\"",
    "\\",
    "/*",
    "//",
    "r#\"",
    "None",
    "é\u{0}",
    "Some(",
    "((((((((((((((((",
    "1e999",
    "include: [\"/etc/passwd\"],",
    "\"1+\"",
];
/// Numbers that make trouble.
const NUMBERS: [&str; 10] = [
    "NaN",
    "inf",
    "-inf",
    "-1",
    "0",
    "1e300",
    "1e-300",
    "4294967296",
    "\"speed / 0\"",
    "1e18",
];

fn change() -> impl Strategy<Value = Change> {
    let at = || any::<Index>();
    prop_oneof![
        (at(), at()).prop_map(|(a, b)| Change::Cut(a, b)),
        (at(), at()).prop_map(|(a, b)| Change::Twice(a, b)),
        (at(), prop::sample::select(&BITS[..])).prop_map(|(a, s)| Change::Insert(a, s)),
        (at(), prop::sample::select(&NUMBERS[..])).prop_map(|(a, s)| Change::Number(a, s)),
        (at(), at()).prop_map(|(a, b)| Change::Word(a, b)),
        at().prop_map(Change::End),
    ]
}

/// Where the pieces of a text begin and end that `part` holds for.
fn pieces(text: &str, part: fn(char) -> bool) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    for (i, c) in text.char_indices().filter(|(_, c)| part(*c)) {
        match found.last_mut() {
            Some(last) if last.1 == i => last.1 += c.len_utf8(),
            _ => found.push((i, i + c.len_utf8())),
        }
    }
    found
}

fn apply(text: &mut String, change: &Change) {
    let places: Vec<usize> = text.char_indices().map(|(i, _)| i).collect();
    if places.is_empty() {
        return;
    }
    let place = |i: &Index| places[i.index(places.len())];
    // At most forty bytes, so that the rest of the file still means something.
    let span = |a: &Index, b: &Index| {
        let from = place(a);
        let to = places
            .iter()
            .copied()
            .find(|p| *p >= from + 1 + b.index(40));
        (from, to.unwrap_or(text.len()))
    };
    match change {
        Change::Cut(a, b) => {
            let (from, to) = span(a, b);
            text.replace_range(from..to, "");
        }
        Change::Twice(a, b) => {
            let (from, to) = span(a, b);
            let piece = text[from..to].to_owned();
            text.insert_str(from, &piece);
        }
        Change::Insert(a, bit) => text.insert_str(place(a), bit),
        Change::Number(a, number) => {
            let all = pieces(text, |c| c.is_ascii_digit() || c == '.');
            if let Some((from, to)) = (!all.is_empty()).then(|| all[a.index(all.len())]) {
                text.replace_range(from..to, number);
            }
        }
        Change::Word(a, b) => {
            let all = pieces(text, |c| c.is_alphabetic() || c == '_');
            if !all.is_empty() {
                let (from, to) = all[a.index(all.len())];
                let (other, end) = all[b.index(all.len())];
                let word = text[other..end].to_owned();
                text.replace_range(from..to, &word);
            }
        }
        Change::End(a) => text.truncate(place(a)),
    }
}

/// Loads a text and looks at what is said of it.
fn examine(text: &str) -> Result<(), TestCaseError> {
    let start = Instant::now();
    let loaded = Scenario::parse(text, Path::new("scene.ron"), &LoadOptions::default());
    let took = start.elapsed();
    prop_assert!(took < Duration::from_secs(2), "{took:?} for\n{text}");
    if let Err(error) = loaded {
        prop_assert!(!error.problems.is_empty());
        prop_assert!(error.problems.len() <= 100);
        let lines = text.lines().count() as u32 + 1;
        for problem in &error.problems {
            let located = (1..=lines).contains(&problem.line) && problem.column > 0;
            prop_assert!(located && !problem.what.is_empty(), "{problem}");
        }
    }
    Ok(())
}

#[test]
fn changed_scene_files_are_errors_or_scenes() {
    let valid = valid();
    let config = ProptestConfig {
        cases: 12_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let changes = prop::collection::vec(change(), 1..5);
    proptest!(config, |(file in any::<Index>(), changes in changes)| {
        let mut text = valid[file.index(valid.len())].clone();
        for change in &changes {
            apply(&mut text, change);
        }
        examine(&text)?;
    });
}

/// What loads is built, or an error says why not; `BUILD_CASES=100000` tries more.
#[test]
fn changed_scenes_are_built_or_refused() {
    let valid = valid();
    let cases = std::env::var("BUILD_CASES")
        .ok()
        .and_then(|n| n.parse().ok());
    let config = ProptestConfig {
        cases: cases.unwrap_or(10_000),
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    // Numbers more than anything else: after most other changes nothing is left to build.
    let number = (any::<Index>(), prop::sample::select(&NUMBERS[..]));
    let number = number.prop_map(|(at, number)| Change::Number(at, number));
    let changes = prop::collection::vec(prop_oneof![3 => number, 1 => change()], 1..3);
    let built = Cell::new(0);
    proptest!(config, |(file in any::<Index>(), changes in changes)| {
        let mut text = valid[file.index(valid.len())].clone();
        for change in &changes {
            apply(&mut text, change);
        }
        let loaded = Scenario::parse(&text, Path::new("scene.ron"), &LoadOptions::default());
        if let Ok(scene) = loaded {
            let start = Instant::now();
            let started = catch_unwind(AssertUnwindSafe(|| scene.start().map(|_| ())));
            let took = start.elapsed();
            prop_assert!(started.is_ok(), "a panic for\n{text}");
            if let Ok(Err(error)) = &started {
                prop_assert!(!error.to_string().is_empty());
            }
            prop_assert!(took < Duration::from_secs(20), "{took:?} for\n{text}");
            built.set(built.get() + usize::from(matches!(started, Ok(Ok(())))));
        }
    });
    println!("{} scenes were built", built.get());
    assert!(built.get() > 10);
}

#[test]
fn large_and_deep_files_are_refused_quickly() {
    for text in [
        "(".repeat(1_000_000),
        format!("(rigid: [{}])", "(),".repeat(1_000_000)),
        format!(
            "{{{}}}",
            (0..200_000)
                .map(|i| format!("\"a{i}\": 1,"))
                .collect::<String>()
        ),
        format!("(about: \"{}\")", "x".repeat(5 << 20)),
        format!("(variables: (a: \"{}\"))", "(".repeat(900)),
        format!(
            "(deformables: [(name: \"a\", body: Rop{})])",
            "e".repeat(1_000_000)
        ),
        "/*".repeat(1_000_000),
        "[".repeat(40) + &"]".repeat(40),
    ] {
        examine(&text).unwrap();
        let scene = Scenario::parse(&text, Path::new("scene.ron"), &LoadOptions::default());
        assert!(scene.is_err());
    }
}

/// A folder for one test, gone afterwards.
pub struct Folder(pub std::path::PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("crumple-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn put(&self, name: &str, text: &str) -> std::path::PathBuf {
        let path = self.0.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn files_outside_of_the_folder_are_refused_unless_allowed() {
    let folder = Folder::new("outside");
    folder.put("shared/materials.ron", "(variables: (speed: 3))");
    let mesh = "(deformables: [(name: \"a\", body: Filled(mesh: \"../shared/a.obj\", cell: 1), material: Rubber)])";
    folder.put("shared/a.obj", "");
    let scene = "(include: [\"../shared/materials.ron\"], world: (duration: \"speed\"))";
    let scene = folder.put("scenes/a.ron", scene);
    let meshed = folder.put("scenes/b.ron", mesh);
    let allowed = LoadOptions {
        allow_outside: true,
        ..LoadOptions::default()
    };
    for path in [&scene, &meshed] {
        let error = Scenario::load(path, &LoadOptions::default()).unwrap_err();
        let text = error.to_string();
        assert!(text.contains(":1:") && text.contains("outside"), "{text}");
        assert!(text.contains("--allow-outside"), "{text}");
        Scenario::load(path, &allowed).unwrap();
    }
    let scene = Scenario::load(&scene, &allowed).unwrap();
    assert_eq!(scene.variables["speed"], 3.0);
}

#[test]
fn includes_that_lead_nowhere_are_located() {
    let folder = Folder::new("includes");
    folder.put("loop_b.ron", "(\n  include: [\"loop_a.ron\"],\n)");
    let scene = folder.put("loop_a.ron", "(include: [\"loop_b.ron\"])");
    let error = Scenario::load(&scene, &LoadOptions::default()).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("loop_b.ron:2:13") && text.contains("includes itself"),
        "{text}"
    );
    let scene = folder.put("none.ron", "(include: [\"nothing.ron\", 3])");
    let text = Scenario::load(&scene, &LoadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("none.ron:1:12") && text.contains("can't be read"),
        "{text}"
    );
    folder.put("part.ron", "(rigid: [(name: \"a\", mas: 3)])");
    let scene = folder.put(
        "uses.ron",
        "(include: [\"part.ron\"], rigid: [(name: \"a\")])",
    );
    let error = Scenario::load(&scene, &LoadOptions::default()).unwrap_err();
    let files: Vec<_> = error
        .problems
        .iter()
        .map(|p| p.file.file_name().unwrap())
        .collect();
    assert!(
        files.contains(&"part.ron".as_ref()) && files.contains(&"uses.ron".as_ref()),
        "{error}"
    );
    for path in [
        folder.0.join("missing.ron"),
        folder.0.clone(),
        "/dev/zero".into(),
    ] {
        let error = Scenario::load(&path, &LoadOptions::default()).unwrap_err();
        assert_eq!(error.problems.len(), 1, "{error}");
    }
}

/// What would be a guess is an error with its place.
#[test]
fn a_seed_that_is_a_formula_and_an_axis_that_vanishes_are_located() {
    for (text, key) in [
        (
            "(variables: (run: 3), world: (seed: \"run\"))",
            "world.seed",
        ),
        (
            "(rigid: [(name: \"a\"), (name: \"b\")], joints: [(kind: Revolute((1e-30, 0, 0)), a: \"a\", b: \"b\")])",
            "joints",
        ),
        (
            "(rigid: [(name: \"a\")], actuators: [Force(on: \"a\", force: ([(0, 1e300)], 0, 0))])",
            "actuators",
        ),
    ] {
        let error = Scenario::parse(text, Path::new("a.ron"), &LoadOptions::default());
        let shown = error.unwrap_err().to_string();
        assert!(shown.contains(key) && shown.contains("a.ron:1"), "{shown}");
    }
}

/// What can be read but not built names the thing.
#[test]
fn what_cant_be_built_is_named() {
    let error = |text: &str| {
        let scene = Scenario::parse(text, Path::new("a.ron"), &LoadOptions::default());
        let built = scene.unwrap().start().err();
        built
            .unwrap_or_else(|| panic!("{text} is built"))
            .to_string()
    };
    let net = "body: Net(nodes: [(at: (0, 0, 0), mass: 1)])";
    for (text, what) in [
        (
            "(deformables: [(name: \"a\", body: Lattice(size: (1, 1, 1), cell: 0.5), material: (young: 1e15, density: 1))])",
            "`a`",
        ),
        (
            &format!(
                "(deformables: [(name: \"a\", {net})], attachments: [(name: \"h\", of: \"a\", nodes: \"x > 1\")])"
            ),
            "\"x > 1\" selects nothing of `a`",
        ),
        (
            "(rigid: [(name: \"a\", colliders: [(shape: Hull(points: [(0, 0, 0)]))])])",
            "`a`",
        ),
    ] {
        let shown = error(text);
        assert!(shown.contains(what), "{text}: {shown}");
    }
}
