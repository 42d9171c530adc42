use super::*;
use crate::math::Vector;
use crate::shape::{TetSplit, tet_box};
use proptest::prelude::*;
use std::fmt::Write;

/// Changes, removes or repeats bytes.
pub fn mutate(bytes: &mut Vec<u8>, edits: &[(prop::sample::Index, u8, u8)]) {
    for (place, value, kind) in edits {
        if bytes.is_empty() {
            return;
        }
        let at = place.index(bytes.len());
        match kind {
            0 => bytes[at] = *value,
            1 => {
                // Digits make other numbers of numbers.
                bytes[at] = b'0' + value % 10;
            }
            _ if *value < 16 => bytes.truncate(at),
            _ => bytes.insert(at, *value),
        }
    }
}

fn gmsh_order(tet: &[u32]) -> Vec<usize> {
    let swap = |i: usize| match i {
        8 => 9,
        9 => 8,
        i => i,
    };
    (0..tet.len())
        .map(|i| 10 + 3 * tet[swap(i)] as usize)
        .collect()
}

/// Tags are 10 + 3·index, with a triangle and a comment for company.
fn text(mesh: &TetMesh) -> String {
    let mut out =
        String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Comments\nnot $Nodes\n$EndComments\n");
    let n = mesh.nodes.len();
    writeln!(out, "$Nodes\n2 {n} 10 {}", 10 + 3 * (n - 1)).unwrap();
    for (dimension, range) in [(2, 0..2), (3, 2..n)] {
        writeln!(
            out,
            "{dimension} 1 {} {}",
            i32::from(dimension == 2),
            range.len()
        )
        .unwrap();
        range
            .clone()
            .for_each(|i| writeln!(out, "{}", 10 + 3 * i).unwrap());
        for i in range {
            let p = mesh.nodes[i];
            write!(out, "{} {} {}", p.x, p.y, p.z).unwrap();
            writeln!(out, "{}", if dimension == 2 { " 0.5 0.25" } else { "" }).unwrap();
        }
    }
    let t = mesh.tets.len();
    writeln!(out, "$EndNodes\n$Elements\n2 {} 1 {}", t + 1, t + 1).unwrap();
    writeln!(out, "2 1 2 1\n1 10 13 16").unwrap();
    let kind = if matches!(mesh.tets, Tets::Linear(_)) {
        4
    } else {
        11
    };
    writeln!(out, "3 1 {kind} {t}").unwrap();
    for (i, tet) in mesh.tets.iter().enumerate() {
        write!(out, "{}", i + 2).unwrap();
        gmsh_order(tet)
            .iter()
            .for_each(|tag| write!(out, " {tag}").unwrap());
        out.push('\n');
    }
    out + "$EndElements\n"
}

fn binary(mesh: &TetMesh, big: bool, size: usize) -> Vec<u8> {
    let mut out = format!("$MeshFormat\n4.1 1 {size}\n").into_bytes();
    let turn = |mut bytes: Vec<u8>| {
        if big {
            bytes.reverse();
        }
        bytes
    };
    let int = |out: &mut Vec<u8>, v: i32| out.extend(turn(v.to_le_bytes().to_vec()));
    let tag = |out: &mut Vec<u8>, v: usize| out.extend(turn(v.to_le_bytes()[..size].to_vec()));
    int(&mut out, 1);
    out.extend(b"\n$EndMeshFormat\n$Entities\n\x00$\xff\n$EndEntities\n$Nodes\n");
    let n = mesh.nodes.len();
    [1, n, 10, 10 + 3 * (n - 1)]
        .iter()
        .for_each(|v| tag(&mut out, *v));
    [3, 1, 0].iter().for_each(|v| int(&mut out, *v));
    tag(&mut out, n);
    (0..n).for_each(|i| tag(&mut out, 10 + 3 * i));
    for x in mesh.nodes.iter().flat_map(|p| p.to_array()) {
        out.extend(turn(x.to_le_bytes().to_vec()));
    }
    out.extend(b"\n$EndNodes\n$Elements\n");
    let t = mesh.tets.len();
    [1, t, 1, t].iter().for_each(|v| tag(&mut out, *v));
    let kind = if matches!(mesh.tets, Tets::Linear(_)) {
        4
    } else {
        11
    };
    [3, 1, kind].iter().for_each(|v| int(&mut out, *v));
    tag(&mut out, t);
    for (i, tet) in mesh.tets.iter().enumerate() {
        tag(&mut out, i + 1);
        gmsh_order(tet).iter().for_each(|v| tag(&mut out, *v));
    }
    out.extend(b"\n$EndElements\n");
    out
}

fn read(bytes: &[u8]) -> Result<TetMesh, ImportError> {
    parse(bytes, Path::new("t.msh"))
}

fn cubes() -> [TetMesh; 2] {
    let mesh = tet_box(Vector::splat(1.0), 0.5, TetSplit::Six).unwrap();
    [mesh.clone(), mesh.quadratic()]
}

#[test]
fn text_and_binary_come_back() {
    for mesh in cubes() {
        assert_eq!(read(text(&mesh).as_bytes()).unwrap(), mesh);
        for (big, size) in [(false, 8), (true, 8), (false, 4), (true, 4)] {
            assert_eq!(
                read(&binary(&mesh, big, size)).unwrap(),
                mesh,
                "{big} {size}"
            );
        }
    }
}

#[test]
fn errors_name_the_line_or_the_byte() {
    let [mesh, quadratic] = cubes();
    let good = text(&mesh);
    let check = |text: &str, parts: &[&str]| {
        let error = read(text.as_bytes()).unwrap_err().to_string();
        assert!(parts.iter().all(|p| error.contains(p)), "{error}");
    };
    check("", &["t.msh:1", "$MeshFormat"]);
    check(&good.replace("4.1 0 8", "2.2 0 8"), &["version", "2.2"]);
    check(&good.replace("4.1 0 8", "4.1 7 8"), &["file type"]);
    check(
        &good.replacen("-0.5 -0.5 -0.5", "-0.5 NaN -0.5", 1),
        &["t.msh:12: ", "coordinate", "NaN"],
    );
    check(
        &good.replace("3 1 4 48", "3 1 5 48"),
        &["element type", "\"5\"", "tetrahedra"],
    );
    check(
        &good.replace("3 1 4 48", "3 1 99 48"),
        &["element type", "99"],
    );
    check(
        &good.replace("3 1 4 48", "3 1 4 99999999999"),
        &["bytes left"],
    );
    check(&good.replacen("\n2 10 ", "\n2 11 ", 1), &["node tag", "11"]);
    check(&good.replace("\n13\n", "\n10\n"), &["node tag", "once"]);
    check(&good.replace("$EndElements", ""), &["$EndElements"]);
    check(&good[..good.len() / 2], &["t.msh:"]);
    check(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n",
        &["no tetrahedra)"],
    );
    let mixed = good.clone() + text(&quadratic).split("$EndComments\n").nth(1).unwrap();
    check(&mixed, &["same for all"]);
    let packed = binary(&mesh, false, 8);
    for cut in [30, 200, 700, packed.len() - 20] {
        let error = read(&packed[..cut]).unwrap_err().to_string();
        assert!(error.starts_with("t.msh, byte "), "{error}");
    }
    assert!(matches!(
        load("/nowhere/x.msh"),
        Err(ImportError::Read { .. })
    ));
    let mut left = mesh.clone();
    if let Tets::Linear(tets) = &mut left.tets {
        tets[5].swap(0, 1);
    }
    check(&text(&left), &["t.msh: ", "tet 5 (-"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]
    #[test]
    fn mutated_files_never_panic(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0u8..3), 1..12),
        coding in 0..3,
    ) {
        let [linear, quadratic] = cubes();
        let mut bytes = match coding {
            0 => text(&linear).into_bytes(),
            1 => text(&quadratic).into_bytes(),
            _ => binary(&linear, false, 8),
        };
        mutate(&mut bytes, &edits);
        if let Ok(mesh) = read(&bytes) {
            mesh.check().unwrap();
        }
    }
}
