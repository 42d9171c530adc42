//! From files to a [`Scenario`]: read, include, resolve variables and names, decode.

use super::decode::{Decode, Decoder, Kind};
use super::model::Scenario;
use super::parse::parse;
use super::problem::{LoadError, MOST, Problem};
use super::source::Source;
use super::tree::{Field, Node, Place, Value};
use super::variables::{unused, variables};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Most files of a scene.
const MOST_FILES: usize = 64;
/// Most bytes of all of them.
const MOST_BYTES: usize = 8 << 20;
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
        bytes: 0,
        problems: Vec::new(),
        more: 0,
    };
    let tree = files.read(top, None);
    let (Some(tree), true) = (tree, files.problems.is_empty()) else {
        let (problems, more) = (files.problems, files.more);
        return Err(LoadError { problems, more });
    };
    let names = files.names;
    let (variables, mut problems) = variables(&tree, &names, options);
    if problems.iter().any(|p| p.key.starts_with("variables.")) {
        // Whatever names these would be complained of as well.
        let more = problems.len().saturating_sub(MOST);
        problems.truncate(MOST);
        return Err(LoadError { problems, more });
    }
    let locate = |from: &Path, text: &str| source.data(from, text);
    let mut d = Decoder::new(&names, &variables, &locate);
    d.more = problems.len().saturating_sub(MOST);
    problems.truncate(MOST);
    d.problems = problems;
    unused(&tree, options, &mut d);
    collect_names(&tree, &mut d);
    let materials = tree.get("materials").and_then(Node::fields).unwrap_or(&[]);
    d.materials = materials
        .iter()
        .map(|f| (f.key.clone(), f.value.clone()))
        .collect();
    let scenario = Scenario::decode(&tree, &mut d);
    match scenario {
        Some(mut scenario) if !d.failed() => {
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
    /// Bytes read so far.
    bytes: usize,
    problems: Vec<Problem>,
    more: usize,
}

impl Files<'_> {
    fn wrong(&mut self, at: Option<Place>, name: &Path, key: &str, what: String) {
        if self.problems.len() == MOST {
            self.more += 1;
            return;
        }
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
        self.bytes += text.len();
        if self.bytes > MOST_BYTES {
            let n = self.bytes;
            let what = format!("with it the files have {n} bytes, at most {MOST_BYTES} are read");
            self.wrong(at, path, "include", what);
            return None;
        }
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
        let (included, own): (Vec<Field>, Vec<Field>) =
            own.iter().cloned().partition(|f| f.key == "include");
        for (at, text) in self.included(path, included.first()) {
            match self.source.locate(path, &text) {
                Ok(found) => {
                    let other = self.read(&found, Some(at));
                    let other = other.as_ref().and_then(Node::fields).unwrap_or(&[]);
                    fields = overlaid(fields, other, true);
                }
                Err(what) => self.wrong(Some(at), path, "include", what),
            }
        }
        self.open.pop();
        let value = Value::Record(overlaid(fields, &own, true));
        Some(Node { at: tree.at, value })
    }

    /// The texts of a file's list of includes.
    fn included(&mut self, path: &Path, list: Option<&Field>) -> Vec<(Place, String)> {
        let Some(field) = list.filter(|f| f.value.value != Value::Nothing) else {
            return Vec::new();
        };
        let Some(items) = field.value.items() else {
            let what = format!(
                "expected a list of texts, found {}",
                field.value.value.kind()
            );
            self.wrong(Some(field.value.at), path, "include", what);
            return Vec::new();
        };
        if items.len() > MOST_FILES {
            let what = format!("has {} items, it must have 0 to {MOST_FILES}", items.len());
            self.wrong(Some(field.value.at), path, "include", what);
            return Vec::new();
        }
        let mut texts = Vec::new();
        for item in items {
            match item.text() {
                Some(text) => texts.push((item.at, text.to_owned())),
                None => {
                    let what = format!("expected a text in quotes, found {}", item.value.kind());
                    self.wrong(Some(item.at), path, "include", what);
                }
            }
        }
        texts
    }
}

/// The fields of one record with those of another put over them.
fn overlaid(mut below: Vec<Field>, above: &[Field], top: bool) -> Vec<Field> {
    for field in above {
        let Some(old) = below.iter_mut().find(|f| f.key == field.key) else {
            below.push(field.clone());
            continue;
        };
        if let (Value::List(old), Value::List(new)) = (&mut old.value.value, &field.value.value)
            && top
            && ADDED.contains(&field.key.as_str())
        {
            old.extend(new.iter().cloned());
            continue;
        }
        match (old.value.fields(), field.value.fields()) {
            (Some(before), Some(new)) if top => {
                let whole = overlaid(before.to_vec(), new, false);
                old.value.value = Value::Record(whole);
            }
            _ => *old = field.clone(),
        }
    }
    below
}

/// Which names a scene gives to what, before anything refers to them.
fn collect_names(tree: &Node, d: &mut Decoder) {
    let list = |key: &str| tree.get(key).and_then(Node::items).unwrap_or(&[]);
    // What can be referred to in one place shares its names: bodies and what exerts forces; joints; probes.
    let mut taken: [BTreeSet<String>; 4] = Default::default();
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
        ("soft_bodies", Kind::SoftBody, 0),
        ("joints", Kind::Joint, 1),
        ("probes", Kind::Probe, 2),
        ("sets", Kind::Set, 3),
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
