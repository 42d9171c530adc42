//! The floors: a module uses only what lies below it. This table is the only place where the order is written down.

use std::fs;
use std::path::{Path, PathBuf};

/// Modules and their floors. Both contact and coupling look at colliders and rigid bodies; coupling may use contact, so
/// it stands half a floor higher. `cli` are the commands of `main`.
const FLOORS: &[(&str, f32)] = &[
    ("math", 0.0),
    ("law", 1.0),
    ("body", 2.0),
    ("solve", 3.0),
    ("import", 3.0),
    ("contact", 4.0),
    ("coupling", 4.5),
    ("world", 5.0),
    ("record", 6.0),
    ("scenario", 7.0),
    ("report", 7.0),
    ("cli", 7.5),
    ("main", 8.0),
];

/// Names at the crate root that stand for a module.
const ALIASES: &[(&str, &str)] = &[("shape", "body")];

/// Who may name Rapier.
const RAPIER: &[&str] = &[
    "math", "contact", "coupling", "world", "record", "scenario", "report", "cli", "main",
];

#[test]
fn every_module_uses_only_the_floors_below() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    collect(&src, &mut files);
    assert!(files.len() > 30, "the sources must be found");
    let mut violations = Vec::new();
    for file in files {
        let inside = file.strip_prefix(&src).unwrap();
        // The crate root names every module.
        if inside != Path::new("lib.rs") {
            violations.extend(check(inside, &fs::read_to_string(&file).unwrap()));
        }
    }
    assert!(violations.is_empty(), "\n{}", violations.join("\n"));
}

/// Where unsafe code may be: vectors by intrinsics, and the rows they are fetched from.
const UNSAFE: &[&str] = &[
    "solve/kernel/vector.rs",
    "solve/kernel/vector/pack.rs",
    "solve/kernel/vector/rows.rs",
    "solve/kernel/vector/runs.rs",
    "solve/kernel/vector/tests.rs",
    "solve/kernel/vector/x86.rs",
    "solve/kernel/vector/x86/eight.rs",
    "solve/kernel/vector/x86/sixteen.rs",
    "solve/threads/team.rs",
];

#[test]
fn only_vectors_and_teams_are_unsafe() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    collect(&src, &mut files);
    let unsafe_files: Vec<PathBuf> = files
        .iter()
        .filter(|file| {
            let code = without_text(&fs::read_to_string(file).unwrap());
            ["unsafe", "unsafe_code"]
                .iter()
                .any(|word| words(&code, word).next().is_some())
        })
        .map(|file| file.strip_prefix(&src).unwrap().to_path_buf())
        .collect();
    // The crate root forbids it to all others.
    let allowed = UNSAFE.iter().chain(&["lib.rs"]).map(PathBuf::from);
    let mut allowed: Vec<PathBuf> = allowed.collect();
    allowed.sort();
    assert_eq!(unsafe_files, allowed);
}

#[test]
fn the_checker_sees_violations() {
    let found = |file: &str, text: &str| check(Path::new(file), text);
    for (file, text) in [
        ("law/x.rs", "use crate::body::Net;"),
        ("solve/x.rs", "use crate::import;"),
        ("report/x.rs", "use crate::scenario::run;"),
        ("contact/x.rs", "fn f() { crate::coupling::attach::x() }"),
        (
            "solve/x.rs",
            "use crate::{\n    law::{row, stable},\n    world::{Deformable, Substeps},\n};",
        ),
        ("law/x.rs", "use crate::nonsense::X;"),
        ("world/x.rs", "use crumple::body::Net;"),
        ("solve/x.rs", "use rapier3d::dynamics::RigidBody;"),
        ("body/x.rs", "use rapier3d::dynamics::RigidBody;"),
        ("body/shape/x.rs", "use super::super::super::world::X;"),
        ("body/mod.rs", "use super::world::X;"),
        ("unheard/x.rs", "use crate::math::Real;"),
        (
            "law/x.rs",
            "#[cfg(test)] mod tests { fn f() { \"}\"; '}'; } }\nuse crate::body::Net;",
        ),
    ] {
        assert_eq!(found(file, text).len(), 1, "{file}: {text}");
    }
    for (file, text) in [
        ("coupling/x.rs", "use crate::contact::target::Target;"),
        (
            "solve/x.rs",
            "use crate::{body::{Net, state::State}, math};",
        ),
        (
            "body/shape/x.rs",
            "use super::super::Net; use crate::body::Net;",
        ),
        ("body/x.rs", "use rapier3d::parry::shape::TriMesh;"),
        ("import/x.rs", "use crate::shape;"),
        (
            "main.rs",
            "use crumple::world::Deformable; use rapier3d::prelude::*;",
        ),
        (
            "law/x.rs",
            "/// See crate::world.\n// crate::body\nconst X: &str = \"crate::solve\";",
        ),
        (
            "law/x.rs",
            "#[cfg(test)]\nmod tests {\n    use crate::world::X;\n    fn f<'a>() { '{' }\n}",
        ),
    ] {
        assert_eq!(found(file, text), [""; 0], "{file}: {text}");
    }
}

fn collect(dir: &Path, files: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(dir)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
}

fn floor(module: &str) -> Option<f32> {
    FLOORS.iter().find(|(m, _)| *m == module).map(|(_, f)| *f)
}

/// What is wrong with a file, given its path below src/.
fn check(file: &Path, text: &str) -> Vec<String> {
    let parts: Vec<String> = file
        .with_extension("")
        .iter()
        .map(|p| p.to_string_lossy().into_owned())
        .filter(|p| p != "mod")
        .collect();
    let module = parts[0].as_str();
    let Some(own) = floor(module) else {
        return vec![format!("{}: no floor for {module}", file.display())];
    };
    let code = without_tests(&without_text(text));
    let mut wrong = Vec::new();
    let mut say = |what: String| wrong.push(format!("{}: {what}", file.display()));
    for name in references(&code) {
        let target = ALIASES
            .iter()
            .find(|(alias, _)| *alias == name)
            .map_or(name.as_str(), |(_, module)| module);
        match floor(target) {
            None => say(format!("crate::{name} is on no floor")),
            Some(other) if target != module && other >= own => {
                say(format!("{module} ({own}) uses {target} ({other})"));
            }
            Some(_) => {}
        }
    }
    for (at, _) in words(&code, "crumple") {
        if !["main", "cli"].contains(&module) && code[at..].starts_with("crumple::") {
            say("names the crate as strangers do".into());
        }
    }
    for (at, _) in words(&code, "rapier3d") {
        let parry = module == "body" && code[at..].starts_with("rapier3d::parry::");
        if !RAPIER.contains(&module) && !parry {
            say(format!("{module} must not know Rapier"));
        }
    }
    if code.contains(&"super::".repeat(parts.len())) {
        say("leaves its module by super::, say crate::".into());
    }
    wrong
}

/// Where a whole word begins and ends.
fn words<'a>(code: &'a str, word: &'a str) -> impl Iterator<Item = (usize, usize)> + 'a {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(word).filter_map(move |(at, _)| {
        let end = at + word.len();
        let alone = !code[..at].ends_with(part) && !code[end..].starts_with(part);
        alone.then_some((at, end))
    })
}

/// The names after every `crate::`, also those of a group.
fn references(code: &str) -> Vec<String> {
    let name = |text: &str| -> String {
        let text = text.trim_start();
        let end = text
            .find(|c: char| !c.is_alphanumeric() && c != '_')
            .unwrap_or(text.len());
        text[..end].into()
    };
    let mut names = Vec::new();
    for (_, end) in words(code, "crate") {
        let Some(rest) = code[end..].trim_start().strip_prefix("::") else {
            continue;
        };
        let Some(group) = rest.trim_start().strip_prefix('{') else {
            names.push(name(rest));
            continue;
        };
        let (mut depth, mut fresh) = (1, true);
        for (i, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 1 => fresh = true,
                c if fresh && !c.is_whitespace() => {
                    names.push(name(&group[i..]));
                    fresh = false;
                }
                _ => {}
            }
            if depth == 0 {
                break;
            }
        }
    }
    names.retain(|n| !n.is_empty() && n != "self");
    names
}

/// The code with comments, strings and characters blanked.
fn without_text(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let skip = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |i| i + 2)
        } else if let Some(quote) = raw_string(rest) {
            let end = format!("\"{}", "#".repeat(quote - 2));
            quote + rest[quote..].find(&end).unwrap_or(0) + end.len()
        } else if c == '"' {
            closing(rest, '"')
        } else if c == '\'' && is_char(rest) {
            closing(rest, '\'')
        } else {
            out.push(c);
            rest = &rest[c.len_utf8()..];
            continue;
        };
        out.push(' ');
        rest = &rest[skip..];
    }
    out
}

/// Length of the opening of a raw string, `r#"` for example.
fn raw_string(rest: &str) -> Option<usize> {
    let hashes = rest.strip_prefix('r')?;
    let n = hashes.len() - hashes.trim_start_matches('#').len();
    hashes[n..].starts_with('"').then_some(n + 2)
}

/// A lifetime has no closing quote after one character.
fn is_char(rest: &str) -> bool {
    let mut chars = rest.chars().skip(1);
    matches!(
        (chars.next(), chars.next()),
        (Some('\\'), _) | (Some(_), Some('\''))
    )
}

/// Length of a literal with its quotes.
fn closing(rest: &str, quote: char) -> usize {
    let mut escaped = false;
    for (i, c) in rest.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            c if c == quote => return i + 1,
            _ => {}
        }
    }
    rest.len()
}

/// The code without modules under `#[cfg(test)]`.
fn without_tests(code: &str) -> String {
    let mut out = String::new();
    let mut rest = code;
    while let Some(at) = rest.find("#[cfg(test)]") {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let mut depth = 0;
        let end = rest.char_indices().find_map(|(i, c)| {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ';' if depth == 0 => return Some(i + 1),
                _ => return None,
            }
            (depth == 0).then_some(i + 1)
        });
        rest = &rest[end.unwrap_or(rest.len())..];
    }
    out + rest
}
