//! How the types of a scene are written down once: their keys, units, defaults and ranges.
//!
//! `record!` makes a struct whose fields are keys, `choice!` an enum whose variants are names. Both make the type, its
//! decoder and its entry in the [reference](super::reference) of the one declaration, so that what the documentation says
//! of a default is the default.

/// An entry of the reference: a key or a variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The type it belongs to.
    pub owner: &'static str,
    /// The key; empty for the type itself.
    pub key: &'static str,
    /// The type of its value.
    pub kind: &'static str,
    /// Its default; empty for a key that must be there.
    pub default: &'static str,
    /// What it means, with its unit, in Markdown.
    pub doc: &'static str,
}

/// A struct whose fields are keys: `key: Type = default, CHECK;`, without a default the key must be there. `then` names a
/// function that looks at the whole.
macro_rules! record {
    (
        $(#[doc = $about:literal])*
        pub struct $name:ident {
            $( $(#[doc = $doc:literal])* $field:ident: $type:ty $(= $default:expr)? $(, $check:expr)?; )*
        }
        $(then $then:path)?
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize)]
        pub struct $name {
            $(
                $(#[doc = $doc])*
                $(#[doc = concat!("\n\nDefault: `", stringify!($default), "`.")])?
                pub $field: $type,
            )*
        }

        impl crate::scenario::file::decode::Decode for $name {
            fn decode(
                node: &crate::scenario::file::tree::Node,
                d: &mut crate::scenario::file::decode::Decoder,
            ) -> Option<Self> {
                let fields = d.fields(node, stringify!($name), &[$(stringify!($field)),*])?;
                $( let $field: Option<$type> = $crate::scenario::file::schema::field!(
                    node, fields, d, $field, $type $(= $default)? $(, $check)?
                ); )*
                let whole = Self { $($field: $field?),* };
                $( $then(&whole, node, d)?; )?
                Some(whole)
            }
        }

        impl $name {
            /// Its keys, for the reference.
            pub(crate) const KEYS: &'static [crate::scenario::file::schema::Entry] = &[
                crate::scenario::file::schema::Entry {
                    owner: stringify!($name), key: "", kind: "record", default: "",
                    doc: concat!($($about, "\n"),*),
                },
                $( crate::scenario::file::schema::Entry {
                    owner: stringify!($name),
                    key: stringify!($field),
                    kind: stringify!($type),
                    default: concat!($(stringify!($default))?),
                    doc: concat!($($doc, "\n"),*),
                }, )*
            ];
        }
    };
}

/// An enum whose variants are names: `Name;`, `Name(Type);` or `Name { key: Type = default, CHECK; };`.
macro_rules! choice {
    (
        $(#[doc = $about:literal])*
        pub enum $name:ident {
            $( $(#[doc = $doc:literal])* $variant:ident
               $( ($payload:ty $(, $pcheck:expr)?) )?
               $( { $( $(#[doc = $fdoc:literal])* $field:ident: $type:ty $(= $default:expr)? $(, $check:expr)?; )* } )? ; )*
        }
        $(otherwise $otherwise:path)?
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize)]
        pub enum $name {
            $(
                $(#[doc = $doc])*
                $variant $( ($payload) )? $( { $(
                    $(#[doc = $fdoc])*
                    $(#[doc = concat!("\n\nDefault: `", stringify!($default), "`.")])?
                    $field: $type,
                )* } )?,
            )*
        }

        impl crate::scenario::file::decode::Decode for $name {
            #[allow(unused_variables)]
            fn decode(
                node: &crate::scenario::file::tree::Node,
                d: &mut crate::scenario::file::decode::Decoder,
            ) -> Option<Self> {
                const NAMES: &[&str] = &[$(stringify!($variant)),*];
                $( if let Some(value) = $otherwise(node, d) { return value; } )?
                let Some((name, inner)) = crate::scenario::file::decode::variant(node) else {
                    return d.expected(node, &format!("one of {}", NAMES.join(", ")));
                };
                match name {
                    $( stringify!($variant) => $crate::scenario::file::schema::variant!(
                        node, inner, d, $variant
                        $( ($payload $(, $pcheck)?) )? $( { $($field: $type $(= $default)? $(, $check)?;)* } )?
                    ), )*
                    _ => {
                        d.wrong(node.at, |_| {
                            crate::scenario::file::problem::unknown(
                                stringify!($name), name, NAMES.iter().copied(),
                            )
                        });
                        None
                    }
                }
            }
        }

        impl $name {
            /// Its variants and their keys, for the reference.
            pub(crate) const KEYS: &'static [crate::scenario::file::schema::Entry] = &[
                crate::scenario::file::schema::Entry {
                    owner: stringify!($name), key: "", kind: "choice", default: "",
                    doc: concat!($($about, "\n"),*),
                },
                $(
                    crate::scenario::file::schema::Entry {
                        owner: stringify!($name), key: stringify!($variant),
                        kind: concat!($(stringify!($payload))?), default: "",
                        doc: concat!($($doc, "\n"),*),
                    },
                    $( $( crate::scenario::file::schema::Entry {
                        owner: concat!(stringify!($name), "::", stringify!($variant)),
                        key: stringify!($field),
                        kind: stringify!($type),
                        default: concat!($(stringify!($default))?),
                        doc: concat!($($fdoc, "\n"),*),
                    }, )* )?
                )*
            ];
        }
    };
}

/// One field: with a default or required, with a check or without.
macro_rules! field {
    ($node:ident, $fields:ident, $d:ident, $field:ident, $type:ty = $default:expr $(, $check:expr)?) => {
        crate::scenario::file::decode::optional::<$type>(
            || $default, $fields, stringify!($field), $d, &[$(&$check)?],
        )
    };
    ($node:ident, $fields:ident, $d:ident, $field:ident, $type:ty $(, $check:expr)?) => {
        crate::scenario::file::decode::required::<$type>(
            $node.at, $fields, stringify!($field), $d, &[$(&$check)?],
        )
    };
}

/// What a variant is made of.
macro_rules! variant {
    ($node:ident, $inner:ident, $d:ident, $variant:ident) => {
        match $inner {
            Some(inner) if !inner.items().is_some_and(<[_]>::is_empty) => {
                $d.wrong(inner.at, |_| {
                    format!("`{}` takes nothing in brackets", stringify!($variant))
                });
                None
            }
            _ => Some(Self::$variant),
        }
    };
    ($node:ident, $inner:ident, $d:ident, $variant:ident ($payload:ty $(, $check:expr)?)) => {{
        let Some(inner) = $inner else {
            return $d.expected($node, concat!("`", stringify!($variant), "(…)`"));
        };
        let field = crate::scenario::file::tree::Field {
            key: stringify!($variant).into(),
            at: inner.at,
            value: inner.clone(),
        };
        let fields = std::slice::from_ref(&field);
        let value = crate::scenario::file::decode::required::<$payload>(
            inner.at, fields, stringify!($variant), $d, &[$(&$check)?],
        );
        value.map(Self::$variant)
    }};
    ($node:ident, $inner:ident, $d:ident, $variant:ident
     { $($field:ident: $type:ty $(= $default:expr)? $(, $check:expr)?;)* }) => {{
        let empty = crate::scenario::file::tree::Node {
            at: $node.at,
            value: crate::scenario::file::tree::Value::Record(Vec::new()),
        };
        let inner = $inner.unwrap_or(&empty);
        $d.within(concat!(".", stringify!($variant)), |d| {
            let fields = d.fields(inner, stringify!($variant), &[$(stringify!($field)),*])?;
            $( let $field: Option<$type> = $crate::scenario::file::schema::field!(
                inner, fields, d, $field, $type $(= $default)? $(, $check)?
            ); )*
            Some(Self::$variant { $($field: $field?),* })
        })
    }};
}

pub(crate) use {choice, field, record, variant};
