//! From files to a [`Scenario`]: read, include, resolve variables and names, decode.

use super::decode::{Decode, Decoder, Kind};
use super::formula::{CONSTANTS, Formula, Variables};
use super::model::Scenario;
use super::model::deformable::PLACE;
use super::parse::parse;
use super::problem::{LoadError, Problem, unknown};
use super::source::Source;
use super::tree::{Field, Node, Place, Value};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Most files of a scene.
const MOST_FILES: usize = 64;
/// Keys whose lists an including file adds to; it replaces everything else.
const ADDED: [&str; 11] = [
    "rigid",
    "joints",
    "deformables",
    "soft_bodies",
    "attachments",
    "sets",
    "no_contact",
    "actuators",
    "probes",
    "expect",
    "frames",
];

/// What may be said of a scene when it is loaded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// Variables that get other values.
    pub set: Vec<(String, f64)>,
    /// Another seed.
    pub seed: Option<u64>,
    /// Whether files outside of the scene's own folder may be read.
    pub allow_outside: bool,
}

impl Scenario {
    /// Reads a scene file, RON or JSON.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Self, LoadError> {
        let path = path.as_ref();
        load(&Source::disk(path, options.allow_outside), path, options)
    }

    /// Reads a scene from text; `name` is what errors call it. It can't name files.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn parse(text: &str, name: &Path, options: &LoadOptions) -> Result<Self, LoadError> {
        load(&Source::Text(text), name, options)
    }

    /// A scene that comes with the crate, by its name without an ending.
    ///
    /// # Errors
    /// Everything that is wrong with it; the scenes of the crate are in order, a variable that is set may not be.
    pub fn embedded(name: &str, options: &LoadOptions) -> Result<Self, LoadError> {
        let file = PathBuf::from(format!("{name}.ron"));
        load(&Source::Embedded, &file, options)
    }
}

fn load(source: &Source, top: &Path, options: &LoadOptions) -> Result<Scenario, LoadError> {
    let mut files = Files {
        source,
        names: Vec::new(),
        open: Vec::new(),
        problems: Vec::new(),
    };
    let tree = files.read(top, None);
    let failed = |problems| LoadError { problems, more: 0 };
    let (Some(tree), true) = (tree, files.problems.is_empty()) else {
        return Err(failed(files.problems));
    };
    let names = files.names;
    let (variables, mut problems) = variables(&tree, &names, options);
    let locate = |from: &Path, text: &str| source.locate(from, text);
    let mut d = Decoder::new(&names, &variables, &locate);
    d.problems.append(&mut problems);
    collect_names(&tree, &mut d);
    let materials = tree.get("materials").and_then(Node::fields).unwrap_or(&[]);
    d.materials = materials
        .iter()
        .map(|f| (f.key.clone(), f.value.clone()))
        .collect();
    let scenario = Scenario::decode(&tree, &mut d);
    match scenario {
        Some(mut scenario) if !d.failed() => {
            scenario.include.clear();
            scenario.world.seed = options.seed.unwrap_or(scenario.world.seed);
            scenario.variables = variables;
            scenario.variables.remove("seed");
            Ok(scenario)
        }
        _ => Err(LoadError {
            problems: d.problems,
            more: d.more,
        }),
    }
}

/// The files of a scene while they are read.
struct Files<'a> {
    source: &'a Source<'a>,
    names: Vec<PathBuf>,
    /// Those that are being read, from the top.
    open: Vec<PathBuf>,
    problems: Vec<Problem>,
}

impl Files<'_> {
    fn wrong(&mut self, at: Option<Place>, name: &Path, key: &str, what: String) {
        let place = at.unwrap_or_default();
        self.problems.push(Problem {
            file: at.map_or(name, |at| &self.names[at.file]).to_owned(),
            line: place.line,
            column: place.column,
            key: key.into(),
            what,
        });
    }

    /// Reads a file and what it includes; `at` is where it is included.
    fn read(&mut self, path: &Path, at: Option<Place>) -> Option<Node> {
        if self.open.iter().any(|p| p == path) {
            let what = format!("{} includes itself", path.display());
            self.wrong(at, path, "include", what);
            return None;
        }
        if self.names.len() == MOST_FILES {
            let what = format!("a scene has at most {MOST_FILES} files");
            self.wrong(at, path, "include", what);
            return None;
        }
        let text = self.source.read(path).map_err(|what| {
            let key = if at.is_some() { "include" } else { "" };
            self.wrong(at, path, key, what);
        });
        let text = text.ok()?;
        self.names.push(path.to_owned());
        let tree = parse(&text, self.names.len() - 1);
        let tree = tree.map_err(|e| self.wrong(Some(e.at), path, "", e.what));
        let tree = tree.ok()?;
        let Some(own) = tree.fields() else {
            self.wrong(
                Some(tree.at),
                path,
                "",
                "a scene is a record, like `(rigid: […])`".into(),
            );
            return None;
        };
        self.open.push(path.to_owned());
        let mut fields = Vec::new();
        let included = own.iter().find(|f| f.key == "include");
        let included = included.and_then(|f| f.value.items()).unwrap_or(&[]);
        // What is no text is told of when the list is decoded.
        for (node, text) in included.iter().filter_map(|n| Some((n, n.text()?))) {
            match self.source.locate(path, text) {
                Ok(found) => {
                    let other = self.read(&found, Some(node.at));
                    let other = other.as_ref().and_then(Node::fields).unwrap_or(&[]);
                    fields = overlaid(fields, other, true);
                }
                Err(what) => self.wrong(Some(node.at), path, "include", what),
            }
        }
        self.open.pop();
        let value = Value::Record(overlaid(fields, own, true));
        Some(Node { at: tree.at, value })
    }
}

/// The fields of one record with those of another put over them.
fn overlaid(mut below: Vec<Field>, above: &[Field], top: bool) -> Vec<Field> {
    for field in above {
        let Some(old) = below.iter_mut().find(|f| f.key == field.key) else {
            below.push(field.clone());
            continue;
        };
        match (&mut old.value.value, &field.value.value) {
            (Value::List(old), Value::List(new)) if top && ADDED.contains(&field.key.as_str()) => {
                old.extend(new.iter().cloned());
            }
            (Value::Record(old), Value::Record(new)) if top => {
                *old = overlaid(std::mem::take(old), new, false);
            }
            _ => *old = field.clone(),
        }
    }
    below
}

/// Values of the variables in the order they stand, with those that are set from outside.
fn variables(tree: &Node, files: &[PathBuf], options: &LoadOptions) -> (Variables, Vec<Problem>) {
    let (mut variables, mut problems) = (Variables::new(), Vec::new());
    let seed = tree.get("world").and_then(|w| w.get("seed"));
    let seed = match seed.map(|n| (n.at, &n.value)) {
        Some((_, Value::Number(x))) => *x,
        Some((at, _)) if options.seed.is_none() => {
            problems.push(Problem {
                file: files.get(at.file).cloned().unwrap_or_default(),
                line: at.line,
                column: at.column,
                key: "world.seed".into(),
                what: "must be a number: formulas draw from it, so it can't be one".into(),
            });
            0.0
        }
        _ => 0.0,
    };
    variables.insert("seed".into(), options.seed.map_or(seed, |s| s as f64));
    let fields = tree.get("variables").and_then(Node::fields).unwrap_or(&[]);
    for field in fields {
        let mut wrong = |what: String| {
            problems.push(Problem {
                file: files.get(field.at.file).cloned().unwrap_or_default(),
                line: field.at.line,
                column: field.at.column,
                key: format!("variables.{}", field.key),
                what,
            });
        };
        if let Err(what) = good_variable(&field.key) {
            wrong(what);
            continue;
        }
        let set = options
            .set
            .iter()
            .rev()
            .find(|(name, _)| *name == field.key);
        let value = match (set, &field.value.value) {
            (Some((_, x)), _) => Ok(*x),
            (None, Value::Number(x)) => Ok(*x),
            (None, Value::Text(text)) => Formula::new(text, &variables, &[]).map(|f| f.value(&[])),
            _ => Err("expected a number or a formula in quotes".into()),
        };
        match value {
            Ok(x) if x.is_finite() => _ = variables.insert(field.key.clone(), x),
            Ok(x) => wrong(format!("is {x}, it must be finite")),
            Err(what) => wrong(what),
        }
    }
    for (name, _) in &options.set {
        if !fields.iter().any(|f| f.key == *name) {
            let known = fields.iter().map(|f| f.key.as_str());
            problems.push(Problem {
                file: files.first().cloned().unwrap_or_default(),
                line: 0,
                column: 0,
                key: format!("--set {name}"),
                what: unknown("variable", name, known),
            });
        }
    }
    problems.truncate(super::problem::MOST);
    (variables, problems)
}

fn good_variable(name: &str) -> Result<(), String> {
    let letters = |c: char| c.is_alphanumeric() || c == '_';
    let first = name.chars().next();
    if !first.is_some_and(|c| c.is_alphabetic() || c == '_') || !name.chars().all(letters) {
        return Err("the name of a variable is a word of letters, digits and `_`".into());
    }
    let taken = CONSTANTS.iter().any(|(n, _)| *n == name) || PLACE.contains(&name);
    if taken || name == "t" || name == "seed" {
        return Err("this name has a meaning in formulas already; choose another".into());
    }
    Ok(())
}

/// Which names a scene gives to what, before anything refers to them.
fn collect_names(tree: &Node, d: &mut Decoder) {
    let list = |key: &str| tree.get(key).and_then(Node::items).unwrap_or(&[]);
    // What can be referred to in one place shares its names: bodies and what exerts forces; joints; probes.
    let mut taken: [BTreeSet<String>; 3] = Default::default();
    for (i, rigid) in list("rigid").iter().enumerate() {
        let at = format!("rigid[{i}]");
        take_name(rigid, Kind::Rigid, &at, &mut taken[0], d);
        let colliders = rigid.get("colliders").and_then(Node::items).unwrap_or(&[]);
        for (j, collider) in colliders.iter().enumerate() {
            let at = format!("rigid[{i}].colliders[{j}]");
            take_name(collider, Kind::Collider, &at, &mut taken[0], d);
        }
    }
    for (key, kind, space) in [
        ("deformables", Kind::Deformable, 0),
        ("attachments", Kind::Attachment, 0),
        ("joints", Kind::Joint, 1),
        ("probes", Kind::Probe, 2),
    ] {
        for (i, thing) in list(key).iter().enumerate() {
            take_name(thing, kind, &format!("{key}[{i}]"), &mut taken[space], d);
        }
    }
}

/// Names become columns and files, so they are plain words; within what can be referred to alike each stands once.
fn take_name(thing: &Node, kind: Kind, key: &str, taken: &mut BTreeSet<String>, d: &mut Decoder) {
    let Some((node, name)) = thing.get("name").and_then(|n| Some((n, n.text()?))) else {
        return;
    };
    let optional = matches!(kind, Kind::Collider | Kind::Joint);
    if name.is_empty() && optional {
        return;
    }
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-');
    let complaint = if name.is_empty() || name.len() > 60 || !name.chars().all(plain) {
        "a name has 1 to 60 letters, digits, `_` and `-`"
    } else if !taken.insert(name.into()) {
        "something has this name already"
    } else {
        d.names.entry(kind).or_default().insert(name.into());
        return;
    };
    d.within(format!("{key}.name"), |d| {
        d.wrong(node.at, |_| complaint.into())
    });
}
