//! From the tree to typed values, with every complaint kept.
//!
//! A [`Decode`] gives `None` only after it has told the [`Decoder`] why, and goes on to its other parts first: so one pass
//! finds everything that is wrong.

use super::formula::{Formula, Variables};
use super::model::material::Made;
use super::problem::{MOST, Problem, unknown};
use super::tree::{Field, Node, Place, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What a name in a scene can stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Rigid,
    Collider,
    Deformable,
    Joint,
    Attachment,
    Probe,
    Set,
    SoftBody,
}

impl Kind {
    /// What one is called.
    pub const ALL: [(Self, &'static str); 8] = [
        (Self::Rigid, "rigid body"),
        (Self::Collider, "collider"),
        (Self::Deformable, "deformable"),
        (Self::Joint, "joint"),
        (Self::Attachment, "attachment"),
        (Self::Probe, "probe"),
        (Self::Set, "set"),
        (Self::SoftBody, "soft body"),
    ];
}

/// Decides which file of data a path in a scene means, and how many bytes it has; or why none.
pub(crate) type Locate<'a> = &'a dyn Fn(&Path, &str) -> Result<(PathBuf, u64), String>;

/// What is known while a scene is decoded, and what is wrong with it.
pub(crate) struct Decoder<'a> {
    pub files: &'a [PathBuf],
    pub variables: &'a Variables,
    pub names: BTreeMap<Kind, BTreeSet<String>>,
    pub materials: BTreeMap<String, Node>,
    pub locate: Locate<'a>,
    pub problems: Vec<Problem>,
    pub more: usize,
    /// Bytes of the files of data that were named so far.
    pub data_bytes: u64,
    key: Vec<String>,
    looking_up: usize,
}

impl<'a> Decoder<'a> {
    pub fn new(files: &'a [PathBuf], variables: &'a Variables, locate: Locate<'a>) -> Self {
        Self {
            files,
            variables,
            names: BTreeMap::new(),
            materials: BTreeMap::new(),
            locate,
            problems: Vec::new(),
            more: 0,
            data_bytes: 0,
            key: Vec::new(),
            looking_up: 0,
        }
    }

    /// Tells what is wrong at a place. The message is made only if it is still listed.
    pub fn wrong(&mut self, at: Place, what: impl FnOnce(&Self) -> String) {
        if self.is_full() {
            self.more += 1;
        } else {
            let what = what(self);
            self.list(at, what);
        }
    }

    fn list(&mut self, at: Place, what: String) {
        self.problems.push(Problem {
            file: self.files.get(at.file).cloned().unwrap_or_default(),
            line: at.line,
            column: at.column,
            key: self.key.concat().trim_start_matches('.').to_owned(),
            what,
        });
    }

    /// Whether as much is wrong as is listed: then no more is looked for in lists.
    pub fn is_full(&self) -> bool {
        self.problems.len() == MOST
    }

    /// Tells what is wrong with an item of a list of the whole scene.
    pub fn wrong_item(&mut self, scene: &Node, list: &str, i: usize, what: String) {
        let items = scene.get(list).and_then(Node::items);
        let at = items.and_then(|items| items.get(i)).unwrap_or(scene).at;
        self.within(format!(".{list}[{i}]"), |d| d.wrong(at, |_| what));
    }

    /// Whether anything was wrong so far.
    pub fn failed(&self) -> bool {
        !self.problems.is_empty()
    }

    /// Works on a part of the scene, which messages name.
    pub fn within<T>(&mut self, step: impl Into<String>, work: impl FnOnce(&mut Self) -> T) -> T {
        self.key.push(step.into());
        let result = work(self);
        self.key.pop();
        result
    }

    /// Tells that another kind of value is expected.
    pub fn expected<T>(&mut self, node: &Node, what: &str) -> Option<T> {
        self.wrong(node.at, |_| {
            format!("expected {what}, found {}", node.value.kind())
        });
        None
    }

    /// The value of a formula over the variables.
    pub fn formula(&mut self, node: &Node, text: &str) -> Option<f64> {
        match Formula::new(text, self.variables, &[]) {
            Ok(formula) => Some(formula.value(&[])),
            Err(what) => {
                self.wrong(node.at, |_| what);
                None
            }
        }
    }

    /// A formula whose `slots` get their values later.
    pub fn formula_of(&mut self, node: &Node, slots: &[&str]) -> Option<Formula> {
        let Some(text) = node.text() else {
            let what = format!("a formula of {} in quotes", slots.join(", "));
            return self.expected(node, &what);
        };
        let formula = Formula::new(text, self.variables, slots);
        formula.map_err(|what| self.wrong(node.at, |_| what)).ok()
    }

    /// Whether the scene has a material of that name.
    pub fn has_material(&self, name: &str) -> bool {
        self.materials.contains_key(name)
    }

    /// Decodes the material of a name; `None` after telling that it is neither one of the scene nor a preset.
    pub fn material<T>(
        &mut self,
        node: &Node,
        name: &str,
        presets: impl Iterator<Item = &'static str>,
    ) -> Option<T>
    where
        Made<T>: Decode,
    {
        let Some(found) = self.materials.get(name).cloned() else {
            let presets: Vec<&str> = presets.collect();
            self.wrong(node.at, |d| {
                let own = d.materials.keys().map(String::as_str);
                unknown("material", name, own.chain(presets.iter().copied()))
            });
            return None;
        };
        if self.looking_up > 0 {
            self.wrong(node.at, |_| "a material can't name another one".into());
            return None;
        }
        self.looking_up += 1;
        let result = Made::decode(&found, self);
        self.looking_up -= 1;
        result.map(|made| made.0)
    }

    /// The fields of a record of type `name`; complains of keys that are not `known`.
    pub fn fields<'n>(
        &mut self,
        node: &'n Node,
        name: &str,
        known: &[&str],
    ) -> Option<&'n [Field]> {
        let fields = match &node.value {
            Value::Record(fields) => fields,
            Value::List(items) if items.is_empty() => return Some(&[]),
            Value::Named(own, None) if own == name => return Some(&[]),
            Value::Named(own, Some(inner)) if own == name => {
                return self.fields(inner, name, known);
            }
            _ => return self.expected(node, "a record, like `(key: value)`"),
        };
        for field in fields {
            if !known.contains(&field.key.as_str()) {
                self.wrong(field.at, |_| {
                    unknown("key", &field.key, known.iter().copied())
                });
            }
        }
        Some(fields)
    }
}

/// What can be read from a scene.
pub(crate) trait Decode: Sized {
    /// Reads it; `None` after telling the decoder why not.
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self>;
}

/// What a value must satisfy beyond its type.
pub(crate) trait Check<T> {
    /// What is wrong with it, if anything.
    fn complaint(&self, value: &T, d: &Decoder) -> Option<String>;
}

/// A required field.
pub(crate) fn required<T: Decode>(
    at: Place,
    fields: &[Field],
    key: &'static str,
    d: &mut Decoder,
    checks: &[&dyn Check<T>],
) -> Option<T> {
    match present(fields, key) {
        Some(field) => checked(field, d, checks),
        None => {
            d.wrong(at, |_| format!("the key `{key}` is missing"));
            None
        }
    }
}

/// A field with a default.
pub(crate) fn optional<T: Decode>(
    default: impl FnOnce() -> T,
    fields: &[Field],
    key: &'static str,
    d: &mut Decoder,
    checks: &[&dyn Check<T>],
) -> Option<T> {
    match present(fields, key) {
        Some(field) => checked(field, d, checks),
        None => Some(default()),
    }
}

fn present<'n>(fields: &'n [Field], key: &str) -> Option<&'n Field> {
    let mut found = fields.iter().filter(|f| f.key == key);
    found.find(|f| f.value.value != Value::Nothing)
}

fn checked<T: Decode>(field: &Field, d: &mut Decoder, checks: &[&dyn Check<T>]) -> Option<T> {
    d.within(format!(".{}", field.key), |d| {
        let value = T::decode(&field.value, d)?;
        for check in checks {
            if let Some(what) = check.complaint(&value, d) {
                d.wrong(field.value.at, |_| what);
                return None;
            }
        }
        Some(value)
    })
}

/// The payload of a variant of RON: `Name(x)` is x itself, `Name(a: 1)` and `Name(1, 2)` are what stands in the brackets.
fn payload(inner: &Node) -> &Node {
    match inner.items() {
        Some([one]) => one,
        _ => inner,
    }
}

/// The name of a variant and its payload, in RON's or JSON's form.
pub(crate) fn variant(node: &Node) -> Option<(&str, Option<&Node>)> {
    match &node.value {
        Value::Named(name, inner) => Some((name, inner.as_deref().map(payload))),
        Value::Text(name) => Some((name, None)),
        Value::Record(fields) => match fields.as_slice() {
            [one] => Some((&one.key, Some(&one.value))),
            _ => None,
        },
        _ => None,
    }
}

impl Decode for f64 {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        match &node.value {
            Value::Number(x) => Some(*x),
            Value::Text(text) => d.formula(node, text),
            _ => d.expected(node, "a number or a formula in quotes"),
        }
    }
}

/// Whole numbers, exactly held by an `f64`.
macro_rules! whole {
    ($($type:ty),*) => {$(
        impl Decode for $type {
            fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
                let x = f64::decode(node, d)?;
                let most = (<$type>::MAX as f64).min(9_007_199_254_740_992.0);
                if x.fract() == 0.0 && (<$type>::MIN as f64..=most).contains(&x) {
                    return Some(x as $type);
                }
                d.wrong(node.at, |_| {
                    format!("is {x}, it must be a whole number from {} to {most}", <$type>::MIN)
                });
                None
            }
        }
    )*};
}
whole!(usize, u32, u64, i8);

impl Decode for bool {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        match &node.value {
            Value::Flag(flag) => Some(*flag),
            _ => d.expected(node, "true or false"),
        }
    }
}

impl Decode for String {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        match node.text() {
            Some(text) => Some(text.to_owned()),
            None => d.expected(node, "a text in quotes"),
        }
    }
}

impl<T: Decode> Decode for Option<T> {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        match node.value {
            Value::Nothing => Some(None),
            _ => T::decode(node, d).map(Some),
        }
    }
}

impl<T: Decode> Decode for Box<T> {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        T::decode(node, d).map(Box::new)
    }
}

impl<T: Decode> Decode for Vec<T> {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        let Some(items) = node.items() else {
            return d.expected(node, "a list, like `[a, b]`");
        };
        let items: Vec<Option<T>> = items
            .iter()
            .enumerate()
            .map_while(|(i, item)| {
                let more = !d.is_full();
                more.then(|| d.within(format!("[{i}]"), |d| T::decode(item, d)))
            })
            .collect();
        match d.is_full() {
            true => None,
            false => items.into_iter().collect(),
        }
    }
}

impl<T: Decode, const N: usize> Decode for [T; N] {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        match node.items() {
            Some(items) if items.len() == N => {
                Vec::<T>::decode(node, d).and_then(|v| v.try_into().ok())
            }
            _ => d.expected(node, &format!("{N} values, like `{}`", example(N))),
        }
    }
}

fn example(n: usize) -> String {
    let letters: Vec<String> = ('a'..='z').take(n).map(String::from).collect();
    format!("({})", letters.join(", "))
}

impl<T: Decode> Decode for BTreeMap<String, T> {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        let fields = match &node.value {
            Value::Record(fields) => fields.as_slice(),
            Value::List(items) if items.is_empty() => &[],
            _ => return d.expected(node, "a record, like `(name: value)`"),
        };
        let entries: Vec<Option<(String, T)>> = fields
            .iter()
            .map(|f| {
                d.within(format!(".{}", f.key), |d| {
                    Some((f.key.clone(), T::decode(&f.value, d)?))
                })
            })
            .collect();
        entries.into_iter().collect()
    }
}
