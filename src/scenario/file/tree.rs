//! The located value tree: what stands in a file, and where.
//!
//! A typed reader stops at the first mistake and knows no place for a value that is well formed and wrong. So a file is
//! read to this tree first; includes and variables are resolved on it, and a [decoder](super::decode) that collects its
//! complaints makes the typed scene of it. RON and JSON give the same tree.

/// Where something stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place {
    /// Index of the file.
    pub file: usize,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

/// A value and its place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Node {
    pub at: Place,
    pub value: Value,
}

/// A key of a record with its value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Field {
    pub key: String,
    pub at: Place,
    pub value: Node,
}

/// What can stand in a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    /// `None` or `null`: as if the key were not there.
    Nothing,
    Flag(bool),
    Number(f64),
    Text(String),
    /// `[a, b]` and `(a, b)`.
    List(Vec<Node>),
    /// `(a: 1)` and `{"a": 1}`.
    Record(Vec<Field>),
    /// `Name` and `Name(..)`; what is in the brackets is a list or a record.
    Named(String, Option<Box<Node>>),
}

impl Value {
    /// What it is, for messages.
    pub fn kind(&self) -> String {
        match self {
            Self::Nothing => "nothing".into(),
            Self::Flag(flag) => flag.to_string(),
            Self::Number(x) => x.to_string(),
            Self::Text(text) => format!("the text {text:?}"),
            Self::List(items) => format!("a list of {}", items.len()),
            Self::Record(_) => "a record".into(),
            Self::Named(name, _) => format!("`{name}`"),
        }
    }
}

impl Node {
    /// The value of a key of a record.
    pub fn get(&self, key: &str) -> Option<&Node> {
        let fields = self.fields()?;
        fields.iter().find(|f| f.key == key).map(|f| &f.value)
    }

    /// The fields of a record, of one with a name as well.
    pub fn fields(&self) -> Option<&[Field]> {
        match &self.value {
            Value::Record(fields) => Some(fields),
            Value::Named(_, Some(inner)) => inner.fields(),
            _ => None,
        }
    }

    /// The items of a list.
    pub fn items(&self) -> Option<&[Node]> {
        match &self.value {
            Value::List(items) => Some(items),
            _ => None,
        }
    }

    /// The text, where it is one.
    pub fn text(&self) -> Option<&str> {
        match &self.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }
}
