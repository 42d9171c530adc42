//! TetGen meshes: a `.node` and an `.ele` file.
//!
//! The boundary is made from the tets, so the optional `.face` file is not needed. The middle nodes of tets of ten have had
//! several orders; each is given to the edge whose middle it is nearest to. A file whose tets all turn left-handed is
//! taken as one written by that convention and turned over; one left-handed tet among others is an error.

use super::scan::Cursor;
use super::{ImportError, tets};
use crate::body::tets::sort_by_edge;
use crate::body::{TetMesh, Tets};
use crate::math::DVec3;
use std::path::Path;

/// Reads `path` with the ending `.node` and its neighbour with the ending `.ele`, whatever ending `path` has; see
/// [`parse`].
///
/// # Errors
/// [`ImportError::Read`] if one can't be read, and those of [`parse`].
pub fn load(path: impl AsRef<Path>) -> Result<TetMesh, ImportError> {
    let path = path.as_ref();
    let (node, ele) = (path.with_extension("node"), path.with_extension("ele"));
    let read = |path: &Path| {
        std::fs::read(path).map_err(|source| ImportError::Read {
            path: path.into(),
            source,
        })
    };
    parse(&read(&node)?, &node, &read(&ele)?, &ele)
}

/// Reads the bytes of a `.node` and of an `.ele` file, in metres; the names are what errors call them. Nodes are numbered
/// from 0 or from 1; those no tet has are left out.
///
/// # Errors
/// [`ImportError::Line`] for what is wrong, missing or not supported; [`ImportError::Empty`] without tets;
/// [`ImportError::Shape`] for tets that are flat or inside out.
pub fn parse(
    node: &[u8],
    node_name: &Path,
    ele: &[u8],
    ele_name: &Path,
) -> Result<TetMesh, ImportError> {
    let mut table = Table::open(node, node_name, "the number of points")?;
    if table.width != 3 {
        return Err(table.wrong("the dimension", table.width.to_string(), "3"));
    }
    let mut nodes = Vec::with_capacity(table.count);
    let mut first = 0;
    for row in 0..table.count {
        let words = table.row("a point")?;
        let id = table.whole("the index of a point", &words[0])?;
        if row == 0 {
            first = id;
            if first > 1 {
                return Err(table.wrong("the index of the first point", &words[0], "0 or 1"));
            }
        }
        if id != first + row {
            return Err(table.wrong(
                "the index of a point",
                &words[0],
                &(first + row).to_string(),
            ));
        }
        let mut place = [0.0; 3];
        for (p, word) in place.iter_mut().zip(&words[1..]) {
            *p = word.parse().unwrap_or(f64::NAN);
            if !f64::is_finite(*p) {
                return Err(table.wrong("a coordinate", word, "a finite number"));
            }
        }
        nodes.push(DVec3::from_array(place));
    }
    let mut table = Table::open(ele, ele_name, "the number of tetrahedra")?;
    let arity = table.width;
    if arity != 4 && arity != 10 {
        return Err(table.wrong(
            "the number of nodes of a tetrahedron",
            arity.to_string(),
            "4 or 10",
        ));
    }
    let (mut linear, mut quadratic) = (Vec::new(), Vec::new());
    for _ in 0..table.count {
        let words = table.row("a tetrahedron")?;
        let mut tet = [0; 10];
        for (n, word) in tet.iter_mut().zip(&words[1..=arity]) {
            let id = table.whole("a node of a tetrahedron", word)?;
            match id.checked_sub(first) {
                Some(i) if i < nodes.len() => *n = i as u32,
                _ => {
                    let must = format!(
                        "from {first} to {}",
                        (first + nodes.len()).saturating_sub(1)
                    );
                    return Err(table.wrong("a node of a tetrahedron", word, &must));
                }
            }
        }
        if arity == 4 {
            linear.push([tet[0], tet[1], tet[2], tet[3]]);
        } else {
            let must = "each near the middle of an edge of its own";
            let sorted = sort_by_edge(&nodes, tet);
            quadratic.push(
                sorted.ok_or_else(|| table.wrong("the middle nodes", words.join(" "), must))?,
            );
        }
    }
    let mut found = if arity == 4 {
        Tets::Linear(linear)
    } else {
        Tets::Quadratic(quadratic)
    };
    turn_over(&nodes, &mut found);
    tets::finish(nodes, found, ele_name)
}

/// Turns all tets over if all are left-handed.
fn turn_over(nodes: &[DVec3], tets: &mut Tets) {
    let left = |[a, b, c, d]: [u32; 4]| {
        let [a, b, c, d] = [a, b, c, d].map(|n| nodes[n as usize]);
        (b - a).cross(c - a).dot(d - a) < 0.0
    };
    if !tets.corners().all(left) {
        return;
    }
    match tets {
        Tets::Linear(tets) => tets.iter_mut().for_each(|t| t.swap(2, 3)),
        // Corners 2 and 3, and with them the edges 12 and 13, 02 and 03.
        Tets::Quadratic(tets) => tets.iter_mut().for_each(|t| {
            t.swap(2, 3);
            t.swap(5, 8);
            t.swap(6, 7);
        }),
    }
}

/// A file of a header, `count width …`, and `count` rows of an index and at least `width` words.
struct Table<'a> {
    cursor: Cursor<'a>,
    name: &'a Path,
    line: usize,
    count: usize,
    width: usize,
}

impl<'a> Table<'a> {
    fn open(bytes: &'a [u8], name: &'a Path, what: &'static str) -> Result<Self, ImportError> {
        let mut table = Self {
            cursor: Cursor::new(bytes, name),
            name,
            line: 1,
            count: 0,
            width: 1,
        };
        let words = table.row("the header")?;
        table.count = table.whole(what, &words[0])?;
        table.width = table.whole("the second number of the header", &words[1])?;
        if table.cursor.room_for(what, table.count, 4).is_err() {
            let must = "at most what the rest of the file can hold";
            return Err(table.wrong(what, &words[0], must));
        }
        Ok(table)
    }

    /// The words of the next row, at least `width` + 1.
    fn row(&mut self, what: &'static str) -> Result<Vec<String>, ImportError> {
        let Some((line, text)) = self.cursor.row() else {
            self.line += 1;
            return Err(self.wrong(what, "", "there; the file ends too early"));
        };
        self.line = line;
        let words: Vec<String> = text.split_whitespace().map(String::from).collect();
        if words.len() <= self.width {
            let must = format!("at least {} numbers", self.width + 1);
            return Err(self.wrong(what, text, &must));
        }
        Ok(words)
    }

    fn whole(&self, what: &'static str, word: &str) -> Result<usize, ImportError> {
        word.parse::<u32>()
            .map(|n| n as usize)
            .map_err(|_| self.wrong(what, word, "a whole number, zero or more"))
    }

    fn wrong(&self, what: &'static str, value: impl Into<String>, must: &str) -> ImportError {
        ImportError::Line {
            path: self.name.into(),
            line: self.line,
            what,
            value: value.into(),
            must: must.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;
    use crate::shape::{TetSplit, tet_box};
    use proptest::prelude::*;
    use std::fmt::Write;

    fn write(mesh: &TetMesh, first: u32, order: &[usize]) -> (String, String) {
        let mut node = format!("# made by a test\n{} 3 0 1\n", mesh.nodes.len());
        for (i, p) in mesh.nodes.iter().enumerate() {
            writeln!(node, "  {} {} {} {}  0", i as u32 + first, p.x, p.y, p.z).unwrap();
        }
        let mut ele = format!("{} {} 1\n\n", mesh.tets.len(), order.len());
        for (i, tet) in mesh.tets.iter().enumerate() {
            write!(ele, "{}", i as u32 + first).unwrap();
            order
                .iter()
                .for_each(|&o| write!(ele, " {}", tet[o] + first).unwrap());
            writeln!(ele, " 7 # region").unwrap();
        }
        (node, ele)
    }

    fn read(node: &[u8], ele: &[u8]) -> Result<TetMesh, ImportError> {
        parse(node, Path::new("t.node"), ele, Path::new("t.ele"))
    }

    fn cube() -> TetMesh {
        tet_box(Vector::splat(1.0), 0.5, TetSplit::Six).unwrap()
    }

    #[test]
    fn what_is_written_comes_back() {
        for first in [0, 1] {
            let mesh = cube();
            let (node, ele) = write(&mesh, first, &[0, 1, 2, 3]);
            assert_eq!(read(node.as_bytes(), ele.as_bytes()).unwrap(), mesh);
            // Left-handed throughout.
            let (node, ele) = write(&mesh, first, &[0, 1, 3, 2]);
            assert_eq!(
                read(node.as_bytes(), ele.as_bytes()).unwrap().quality(),
                mesh.quality()
            );
            let mesh = mesh.quadratic();
            // TetGen's own order of middle nodes: edges 23, 03, 01, 12, 13, 02.
            let (node, ele) = write(&mesh, first, &[0, 1, 2, 3, 9, 7, 4, 5, 8, 6]);
            assert_eq!(read(node.as_bytes(), ele.as_bytes()).unwrap(), mesh);
            let (node, ele) = write(&mesh, first, &[0, 1, 3, 2, 9, 7, 4, 5, 8, 6]);
            read(node.as_bytes(), ele.as_bytes()).unwrap();
        }
    }

    #[test]
    fn errors_name_the_file_and_the_line() {
        let (node, ele) = write(&cube(), 1, &[0, 1, 2, 3]);
        let check = |node: &str, ele: &str, start: &str, part: &str| {
            let error = read(node.as_bytes(), ele.as_bytes())
                .unwrap_err()
                .to_string();
            assert!(error.starts_with(start) && error.contains(part), "{error}");
        };
        check(
            &node.replace("27 3 0 1", "27 2 0 1"),
            &ele,
            "t.node:2: ",
            "dimension",
        );
        check(
            &node.replace("27 3 0 1", "99999999 3 0 1"),
            &ele,
            "t.node:2: ",
            "can hold",
        );
        check(
            &node.replacen("-0.5", "NaN", 1),
            &ele,
            "t.node:3: ",
            "finite",
        );
        check(
            &node.replacen("  2 ", "  5 ", 1),
            &ele,
            "t.node:4: ",
            "index of a point",
        );
        check(
            &node,
            &ele.replacen("48 4 1", "48 8 1", 1),
            "t.ele:1: ",
            "4 or 10",
        );
        check(
            &node,
            &ele.replacen("1 1 ", "1 77 ", 1),
            "t.ele:3: ",
            "from 1 to 27",
        );
        check(&node, &ele[..ele.len() / 2], "t.ele:", "tetrahedron");
        check(&node, "0 4 0\n", "t.ele has no", "");
        let mut swapped = ele.clone();
        let line = ele.lines().nth(2).unwrap();
        let w: Vec<&str> = line.split_whitespace().collect();
        swapped = swapped.replace(line, &format!("1 {} {} {} {} 7", w[1], w[2], w[4], w[3]));
        check(&node, &swapped, "t.ele: ", "tet 0 (");
        assert!(matches!(load("/nowhere/x"), Err(ImportError::Read { .. })));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]
        #[test]
        fn mutated_files_never_panic(
            edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0u8..3), 1..12),
            in_node in any::<bool>(),
        ) {
            let (node, ele) = write(&cube().quadratic(), 0, &[0, 1, 2, 3, 9, 7, 4, 5, 8, 6]);
            let (mut node, mut ele) = (node.into_bytes(), ele.into_bytes());
            super::super::msh::tests::mutate(if in_node { &mut node } else { &mut ele }, &edits);
            if let Ok(mesh) = read(&node, &ele) {
                mesh.check().unwrap();
            }
        }
    }
}
