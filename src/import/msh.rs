//! Gmsh meshes, format 4.1, text and binary of either byte order.
//!
//! Of a mesh the tetrahedra of four and ten nodes are taken; points, lines and surface elements are passed over, other
//! solids are refused, since a mesh without its hexahedra would have holes. Node tags may have gaps and any
//! order. Sections this reader does not know are passed over, as the format asks.

use super::scan::{Coding, Cursor};
use super::{ImportError, tets};
use crate::body::{TetMesh, Tets};
use crate::math::DVec3;
use std::path::Path;

/// Nodes of the element types that are passed over: points, lines, triangles and quadrangles of order 1 and 2.
const FLAT: [(i64, usize); 9] = [
    (1, 2),
    (2, 3),
    (3, 4),
    (8, 3),
    (9, 6),
    (10, 9),
    (15, 1),
    (16, 8),
    (26, 4),
];

/// Reads the file at `path`; see [`parse`].
///
/// # Errors
/// [`ImportError::Read`] if it can't be read, and those of [`parse`].
pub fn load(path: impl AsRef<Path>) -> Result<TetMesh, ImportError> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|source| ImportError::Read {
        path: path.into(),
        source,
    })?;
    parse(&bytes, path)
}

/// Reads the bytes of a `.msh` file, in metres; `name` is what errors call it. Nodes no tet has are left out. Tets are
/// numbered from 0 in the order of the file.
///
/// # Errors
/// [`ImportError::Line`] or, in a binary file, [`ImportError::Byte`] for what is wrong, missing or not supported;
/// [`ImportError::Empty`] without tets; [`ImportError::Shape`] for tets that are flat or inside out.
pub fn parse(bytes: &[u8], name: &Path) -> Result<TetMesh, ImportError> {
    let mut cursor = Cursor::new(bytes, name);
    let mut raw = Raw::default();
    let coding = header(&mut cursor)?;
    while !cursor.ended() {
        cursor.coding = Coding::Text;
        let line = cursor.line();
        let Some(section) = line.strip_prefix('$') else {
            if line.is_empty() {
                continue;
            }
            return Err(cursor.wrong("a section", line, "a line that begins with $"));
        };
        cursor.coding = coding;
        match section {
            "Nodes" => nodes(&mut cursor, &mut raw)?,
            "Elements" => elements(&mut cursor, &mut raw)?,
            _ => {}
        }
        cursor.skip_past(&format!("$End{section}"))?;
    }
    raw.mesh(name)
}

/// What stands in the file.
#[derive(Default)]
struct Raw {
    tags: Vec<usize>,
    places: Vec<DVec3>,
    /// Node tags of all tets, one after the other.
    tets: Vec<usize>,
    /// Nodes of each tet; 0 before the first.
    arity: usize,
}

/// `$MeshFormat`, which must come first.
fn header(cursor: &mut Cursor) -> Result<Coding, ImportError> {
    let first = cursor.line();
    if first != "$MeshFormat" {
        return Err(cursor.wrong("the first line", first, "$MeshFormat"));
    }
    let line = cursor.line();
    let words: Vec<&str> = line.split_whitespace().collect();
    let (version, kind, size) = match words[..] {
        [version, kind, size] => (version, kind, size),
        _ => {
            return Err(cursor.wrong("the format", line, "a version, a file type and a data size"));
        }
    };
    if version != "4.1" {
        return Err(cursor.wrong(
            "the version of the format",
            version,
            "4.1; save it anew as \"Version 4\"",
        ));
    }
    let size = match size {
        "8" => 8,
        "4" => 4,
        _ => return Err(cursor.wrong("the data size", size, "8 or 4")),
    };
    let coding = match kind {
        "0" => Coding::Text,
        "1" => {
            cursor.coding = Coding::Binary {
                big_endian: false,
                size,
            };
            // An int of 1, in the byte order of the file.
            let big_endian = match cursor.int("the byte order")? {
                1 => false,
                0x0100_0000 => true,
                other => {
                    return Err(cursor.wrong("the byte order", other.to_string(), "the int 1"));
                }
            };
            Coding::Binary { big_endian, size }
        }
        _ => return Err(cursor.wrong("the file type", kind, "0 for text or 1 for binary")),
    };
    cursor.skip_past("$EndMeshFormat")?;
    cursor.coding = Coding::Text;
    cursor.line();
    Ok(coding)
}

/// Bytes a size takes at the least: packed, or a digit and a space.
fn least(cursor: &Cursor) -> usize {
    match cursor.coding {
        Coding::Text => 2,
        Coding::Binary { size, .. } => size,
    }
}

fn nodes(cursor: &mut Cursor, raw: &mut Raw) -> Result<(), ImportError> {
    let blocks = cursor.size("the number of node blocks")?;
    for what in [
        "the number of nodes",
        "the least node tag",
        "the largest node tag",
    ] {
        cursor.size(what)?;
    }
    for _ in 0..blocks {
        let dimension = cursor.int("the dimension of a node block")?;
        cursor.int("the tag of a node block")?;
        let parametric = cursor.int("whether a node block is parametric")?;
        let count = cursor.size("the number of nodes of a block")?;
        cursor.room_for("the number of nodes of a block", count, 4 * least(cursor))?;
        let extra = match (parametric, dimension) {
            (0, 0..=3) => 0,
            (1, 0..=3) => dimension,
            (0 | 1, _) => {
                return Err(cursor.wrong(
                    "the dimension of a node block",
                    dimension.to_string(),
                    "0 to 3",
                ));
            }
            _ => {
                return Err(cursor.wrong(
                    "whether a node block is parametric",
                    parametric.to_string(),
                    "0 or 1",
                ));
            }
        };
        for _ in 0..count {
            raw.tags.push(cursor.size("a node tag")?);
        }
        for _ in 0..count {
            let mut coordinate = || cursor.double("a coordinate");
            raw.places
                .push(DVec3::new(coordinate()?, coordinate()?, coordinate()?));
            for _ in 0..extra {
                cursor.double("a parametric coordinate")?;
            }
        }
    }
    Ok(())
}

fn elements(cursor: &mut Cursor, raw: &mut Raw) -> Result<(), ImportError> {
    let blocks = cursor.size("the number of element blocks")?;
    for what in [
        "the number of elements",
        "the least element tag",
        "the largest element tag",
    ] {
        cursor.size(what)?;
    }
    for _ in 0..blocks {
        cursor.int("the dimension of an element block")?;
        cursor.int("the tag of an element block")?;
        let kind = cursor.int("an element type")?;
        let flat = FLAT.iter().find(|(k, _)| *k == kind).map(|(_, n)| *n);
        let (arity, taken) = match (kind, flat) {
            (4, _) => (4, true),
            (11, _) => (10, true),
            (_, Some(arity)) => (arity, false),
            _ => {
                let must = "4 or 11 (tetrahedra of 4 or 10 nodes) or an element of a surface";
                return Err(cursor.wrong("an element type", kind.to_string(), must));
            }
        };
        let count = cursor.size("the number of elements of a block")?;
        cursor.room_for(
            "the number of elements of a block",
            count,
            (1 + arity) * least(cursor),
        )?;
        if taken && count > 0 && raw.arity != 0 && raw.arity != arity {
            let must = "the same for all tetrahedra of a file, 4 or 11";
            return Err(cursor.wrong("an element type", kind.to_string(), must));
        }
        if taken && count > 0 {
            raw.arity = arity;
        }
        for _ in 0..count {
            cursor.size("an element tag")?;
            for _ in 0..arity {
                let tag = cursor.size("a node tag of an element")?;
                if taken {
                    raw.tets.push(tag);
                }
            }
        }
    }
    Ok(())
}

impl Raw {
    fn mesh(self, name: &Path) -> Result<TetMesh, ImportError> {
        let wrong = |what, value: usize, must: &str| ImportError::Value {
            path: name.into(),
            what,
            value: value.to_string(),
            must: must.into(),
        };
        let mut index: Vec<(usize, u32)> = self.tags.iter().copied().zip(0..).collect();
        index.sort_unstable();
        if let Some(same) = index.windows(2).find(|w| w[0].0 == w[1].0) {
            return Err(wrong("a node tag", same[0].0, "used once"));
        }
        let find = |tag: &usize| match index.binary_search_by_key(tag, |i| i.0) {
            Ok(i) => Ok(index[i].1),
            Err(_) => Err(wrong("a node tag of a tetrahedron", *tag, "that of a node")),
        };
        let nodes: Vec<u32> = self.tets.iter().map(find).collect::<Result<_, _>>()?;
        let tets = if self.arity == 10 {
            // The last two middle nodes are those of the edges 23 and 13.
            const ORDER: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8];
            Tets::Quadratic(
                nodes
                    .chunks_exact(10)
                    .map(|t| ORDER.map(|i| t[i]))
                    .collect(),
            )
        } else {
            Tets::Linear(
                nodes
                    .chunks_exact(4)
                    .map(|t| std::array::from_fn(|i| t[i]))
                    .collect(),
            )
        };
        tets::finish(self.places, tets, name)
    }
}

#[cfg(test)]
pub(super) mod tests;
