use super::*;
use crate::body::{Blueprint, Material, Net, Node, Solid, SolidLaw, Spring, TetMesh, Tets};
use crate::math::{DVec3, Real, Vector};
use crate::shape::{TetSplit, tet_box, tet_box_of_cells};
use crate::solve::fem::Model;

mod supports;

#[track_caller]
fn close(what: &str, measured: f64, expected: f64, tolerance: f64) {
    let error = (measured - expected).abs() / expected.abs();
    println!("{what}: {measured} (expected {expected})");
    assert!(
        error <= tolerance,
        "{what}: measured {measured}, expected {expected} to {tolerance}"
    );
}

fn clamp(mesh: &TetMesh, which: impl Fn(DVec3) -> bool) -> Vec<[bool; 3]> {
    mesh.nodes.iter().map(|p| [which(*p); 3]).collect()
}

/// The cantilever of V15 with nodes `n` times as close as 9×3×3 along every axis.
fn beam(n: u32, quadratic: bool) -> TetMesh {
    let size = Vector::new(2.0, 0.2, 0.2);
    if quadratic {
        let mesh = tet_box_of_cells(size, [4 * n, n, n], TetSplit::Six);
        mesh.unwrap().quadratic()
    } else {
        tet_box_of_cells(size, [8 * n, 2 * n, 2 * n], TetSplit::Five).unwrap()
    }
}

/// Mean deflection of its end under its own weight.
fn tip(mesh: &TetMesh, masses: &[f64], law: SolidLaw) -> f64 {
    let model = Model::<f64>::new(mesh, Solid::new(1.2e7, 0.0, 100.0).law(law)).unwrap();
    let forces: Vec<DVec3> = masses.iter().map(|m| DVec3::NEG_Y * 9.81 * *m).collect();
    let load = Load {
        positions: &mesh.nodes,
        fixed: &clamp(mesh, |p| p.x < -0.999),
        forces: &forces,
    };
    let found = Statics::default().solve(&model, &load).unwrap();
    let weight: f64 = found.reactions.iter().map(|r| r.y).sum();
    let total: f64 = masses.iter().sum();
    assert!((weight / (9.81 * total) - 1.0).abs() < 0.2, "{weight}");
    let end: Vec<f64> = (0..mesh.nodes.len())
        .filter(|&n| mesh.nodes[n].x > 0.999)
        .map(|n| found.positions[n].y - mesh.nodes[n].y)
        .collect();
    end.iter().sum::<f64>() / end.len() as f64
}

fn volume_masses(mesh: &TetMesh) -> Vec<f64> {
    Model::<f64>::new(mesh, Solid::new(1.2e7, 0.0, 100.0))
        .unwrap()
        .masses()
}

/// V15 (a): the discrete answers of linear tets, which bend too little, and of 24 quadratic ones.
#[test]
fn v15_discrete_answers() {
    let law = SolidLaw::Corotational;
    let mesh = beam(1, false);
    assert_eq!(mesh.nodes.len(), 81);
    let equal = |mesh: &TetMesh| vec![8.0 / mesh.nodes.len() as f64; mesh.nodes.len()];
    close(
        "9×3×3, equal masses",
        tip(&mesh, &equal(&mesh), law),
        -0.01475,
        5e-3,
    );
    close(
        "9×3×3, by volume",
        tip(&mesh, &volume_masses(&mesh), law),
        -0.01424,
        5e-3,
    );
    let mesh = beam(2, false);
    close(
        "17×5×5, equal masses",
        tip(&mesh, &equal(&mesh), law),
        -0.03102,
        5e-3,
    );
    let mesh = beam(4, false);
    assert_eq!(mesh.nodes.len(), 33 * 81);
    close(
        "33×9×9, equal masses",
        tip(&mesh, &equal(&mesh), law),
        -0.04318,
        5e-3,
    );
    let mesh = beam(1, true);
    assert_eq!((mesh.nodes.len(), mesh.tets.len()), (81, 24));
    close(
        "24 quadratic tets",
        tip(&mesh, &volume_masses(&mesh), law),
        -0.04876,
        5e-3,
    );
}

/// V15 (b): the analytic answer, with every law.
#[test]
fn v15_recommended_element_bends_as_a_beam() {
    for law in SolidLaw::ALL {
        for n in [1, 2] {
            let mesh = beam(n, true);
            let what = format!("{law:?}, {} nodes", mesh.nodes.len());
            close(
                &what,
                tip(&mesh, &volume_masses(&mesh), law),
                -0.049442,
                0.02,
            );
        }
    }
}

/// V15: first frequency by inverse iteration with the lumped masses.
#[test]
fn v15_first_frequency() {
    for (n, tolerance) in [(1, 0.01), (2, 0.01)] {
        let mesh = beam(n, true);
        let model = Model::<f64>::new(&mesh, Solid::new(1.2e7, 0.0, 100.0)).unwrap();
        let (masses, fixed) = (model.masses(), clamp(&mesh, |p| p.x < -0.999));
        let mut shape: Vec<DVec3> = mesh.nodes.iter().map(|p| DVec3::Y * (p.x + 1.0)).collect();
        let mut value = 0.0;
        for _ in 0..8 {
            let forces: Vec<DVec3> = shape
                .iter()
                .zip(&masses)
                .map(|(u, m)| *u * *m * 1e-3)
                .collect();
            let load = Load {
                positions: &mesh.nodes,
                fixed: &fixed,
                forces: &forces,
            };
            let found = Statics::default().solve(&model, &load).unwrap();
            let next: Vec<DVec3> = (0..shape.len())
                .map(|n| (found.positions[n] - mesh.nodes[n]) * 1e3)
                .collect();
            let form = |a: &[DVec3], b: &[DVec3]| -> f64 {
                (0..a.len()).map(|n| masses[n] * a[n].dot(b[n])).sum()
            };
            value = form(&next, &shape) / form(&next, &next);
            let norm = form(&next, &next).sqrt();
            shape = next.iter().map(|u| *u / norm).collect();
        }
        let hertz = value.sqrt() / std::f64::consts::TAU;
        close(
            &format!("{} nodes", mesh.nodes.len()),
            hertz,
            2.79796,
            tolerance,
        );
    }
}

/// Cook's membrane of `n`×`n` cells; middle of the right edge.
fn cook(n: usize, quadratic: bool, poisson: f64, strain: bool) -> f64 {
    let side = n as Real;
    let mut mesh = tet_box(Vector::new(side, side, 1.0), 1.0, TetSplit::Six).unwrap();
    for p in &mut mesh.nodes {
        let (s, t) = (p.x / f64::from(side) + 0.5, p.y / f64::from(side) + 0.5);
        let (low, high) = (44.0 * s, 44.0 + 16.0 * s);
        *p = DVec3::new(48.0 * s, low + t * (high - low), p.z + 0.5);
    }
    if quadratic {
        mesh = mesh.quadratic();
    }
    mesh.check().unwrap();
    let model = Model::<f64>::new(&mesh, Solid::new(1.0, poisson, 1.0)).unwrap();
    let fixed: Vec<[bool; 3]> = mesh
        .nodes
        .iter()
        .map(|p| {
            let left = p.x < 1e-6;
            [left, left, p.z < 1e-6 || (strain && p.z > 1.0 - 1e-6)]
        })
        .collect();
    // A small load keeps the answer linear.
    let small = 1e-4;
    let mut forces = vec![DVec3::ZERO; mesh.nodes.len()];
    let step = if quadratic { 4 } else { 1 };
    for group in mesh.faces.chunks_exact(step) {
        let area = |f: &[u32; 3]| {
            let [a, b, c] = f.map(|v| mesh.nodes[v as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        if group
            .iter()
            .flatten()
            .all(|&v| mesh.nodes[v as usize].x > 48.0 - 1e-6)
        {
            // A uniform load goes to corners of linear faces, to middle nodes of quadratic ones: the last triangle.
            let total: f64 = group.iter().map(area).sum();
            for &v in &group[step - 1] {
                forces[v as usize] += DVec3::Y * (small * total / 16.0 / 3.0);
            }
        }
    }
    let load = Load {
        positions: &mesh.nodes,
        fixed: &fixed,
        forces: &forces,
    };
    let found = Statics::default().solve(&model, &load).unwrap();
    let middle = |n: &usize| {
        let p = mesh.nodes[*n];
        p.x > 48.0 - 1e-6 && (p.y - 52.0).abs() < 1e-6 && p.z < 1e-6
    };
    let node = (0..mesh.nodes.len()).find(middle).unwrap();
    (found.positions[node].y - mesh.nodes[node].y) / small
}

/// V18.
#[test]
fn v18_cooks_membrane() {
    close(
        "plane stress, 8 quadratic cells",
        cook(8, true, 1.0 / 3.0, false),
        23.965,
        0.02,
    );
    for n in [4, 8, 16] {
        println!(
            "quadratic, {n} cells, plane strain ν = .4999: {}",
            cook(n, true, 0.4999, true)
        );
    }
    close(
        "plane strain, 8 quadratic cells (16 half ones)",
        cook(8, true, 0.4999, true),
        18.50,
        0.10,
    );
    close(
        "plane strain, 16 quadratic cells",
        cook(16, true, 0.4999, true),
        18.50,
        0.10,
    );
    let locked = cook(16, false, 0.4999, true);
    assert!(
        locked < 0.5 * 18.5,
        "linear tets are known to lock: {locked}"
    );
}

/// V12, static: inner nodes find their places from the prescribed boundary.
#[test]
fn v12_static_patch() {
    let mut mesh = tet_box(Vector::splat(1.0), 0.5, TetSplit::Six).unwrap();
    mesh.nodes[13] += DVec3::new(0.11, -0.07, 0.09);
    for mesh in [mesh.clone(), mesh.quadratic()] {
        let model = Model::<f64>::new(&mesh, Solid::new(1.0e6, 0.25, 1000.0)).unwrap();
        let boundary = |p: DVec3| p.abs().max_element() > 0.499;
        let field = |p: DVec3| p + 0.5e-3 * (DVec3::splat(p.x + p.y + p.z) + p);
        let start: Vec<DVec3> = mesh
            .nodes
            .iter()
            .map(|p| if boundary(*p) { field(*p) } else { *p })
            .collect();
        let load = Load {
            positions: &start,
            fixed: &clamp(&mesh, boundary),
            forces: &vec![DVec3::ZERO; start.len()],
        };
        let found = Statics::default().solve(&model, &load).unwrap();
        for s in model.stresses(|n| found.positions[n].to_array()) {
            for i in 0..3 {
                for j in 0..3 {
                    let expected = if i == j { 2000.0 } else { 400.0 };
                    assert!(
                        (s.cauchy[i][j] / expected - 1.0).abs() < 1e-6,
                        "{:?}",
                        s.cauchy
                    );
                }
            }
        }
    }
}
