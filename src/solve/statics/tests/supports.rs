use super::*;

#[test]
fn supports_that_are_missing_are_named() {
    let mesh = tet_box(Vector::splat(1.0), 0.5, TetSplit::Five).unwrap();
    let model = Model::<f64>::new(&mesh, Solid::new(1.0e6, 0.3, 1000.0)).unwrap();
    let forces = vec![DVec3::X; mesh.nodes.len()];
    let free = |fixed: &[[bool; 3]]| {
        let load = Load {
            positions: &mesh.nodes,
            fixed,
            forces: &forces,
        };
        match Statics::default().solve(&model, &load) {
            Err(StaticError::Supports { free, .. }) => free,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(free(&clamp(&mesh, |_| false)).len(), 6);
    // A hinge along the edge x = y = −½.
    let hinge = free(&clamp(&mesh, |p| p.x < -0.49 && p.y < -0.49));
    assert_eq!(hinge.len(), 1);
    assert_eq!(
        hinge[0].to_string().replace("-1)", "1)"),
        "rotation about (0, 0, 1) through (-0.5, -0.5, 0)"
    );
    // A ball joint.
    assert_eq!(free(&clamp(&mesh, |p| p.max_element() < -0.49)).len(), 3);
    // A slide along x.
    let slide: Vec<[bool; 3]> = mesh.nodes.iter().map(|_| [false, true, true]).collect();
    let slide = free(&slide);
    assert_eq!(slide.len(), 1);
    assert!(
        slide[0].to_string().contains("translation along"),
        "{}",
        slide[0]
    );
}

fn resolved(nodes: Vec<Node>, springs: Vec<Spring>) -> Blueprint {
    Blueprint::resolve(Net::new(nodes, springs), |_| None::<Material>, None).unwrap()
}

fn chain(n: usize) -> (Blueprint, Vec<DVec3>) {
    let nodes: Vec<Node> = (0..=n)
        .map(|i| Node::new(Vector::X * i as Real, 0.1))
        .collect();
    let springs = (0..n as u32)
        .map(|i| Spring::new(i, i + 1, 1000.0))
        .collect();
    let places = (0..=n).map(|i| DVec3::X * i as f64).collect();
    (resolved(nodes, springs), places)
}

/// V08: a straight chain let hang sideways from one end must swing down by itself, being without side stiffness.
#[test]
fn v08_a_chain_hangs_from_its_end() {
    let (blueprint, places) = chain(10);
    let forces: Vec<DVec3> = (0..=10).map(|_| DVec3::NEG_Y * 0.981).collect();
    let mut fixed = vec![[false; 3]; 11];
    fixed[0] = [true; 3];
    // The chain as a whole could turn about its end in the plane across the load, which the energy does not feel.
    fixed.iter_mut().for_each(|f| f[2] = true);
    let load = Load {
        positions: &places,
        fixed: &fixed,
        forces: &forces,
    };
    let structure = SpringNet::new(&blueprint);
    match Statics::default().solve(&structure, &load) {
        Err(StaticError::Supports { free, .. }) => assert_eq!(free.len(), 1, "{free:?}"),
        other => panic!("{other:?}"),
    }
    // Held at both ends, 8 m apart, it sags.
    fixed[10] = [true; 3];
    let places: Vec<DVec3> = (0..=10)
        .map(|i| {
            let s = f64::from(i) / 10.0;
            DVec3::new(8.0 * s, -8.0 * s * (1.0 - s), 0.0)
        })
        .collect();
    let stiff = {
        let nodes: Vec<Node> = (0..=10)
            .map(|i| Node::new(Vector::X * i as Real, 0.1))
            .collect();
        let springs = (0..10).map(|i| Spring::new(i, i + 1, 1e6)).collect();
        resolved(nodes, springs)
    };
    let load = Load {
        positions: &places,
        fixed: &fixed,
        forces: &forces,
    };
    let found = Statics::default()
        .solve(&SpringNet::new(&stiff), &load)
        .unwrap();
    let sag = -found.positions.iter().map(|p| p.y).fold(0.0, f64::min);
    // Ten links: a polygon, a little off the catenary's 2.654375 m.
    close("sag", sag, 2.654375, 0.02);
    let carried: f64 = found.reactions.iter().map(|r| r.y).sum();
    close("carried", carried, 9.0 * 0.981 + 2.0 * 0.981, 1e-9);
}

/// V20 through elements: a cube pulled and squeezed with free sides.
#[test]
fn v20_uniaxial_cube() {
    let mesh = tet_box(Vector::splat(1.0), 0.5, TetSplit::Six)
        .unwrap()
        .quadratic();
    let solid = Solid::new(1.0e6, 0.3, 1000.0).law(SolidLaw::NeoHookean);
    let model = Model::<f64>::new(&mesh, solid).unwrap();
    for (stretch, side, stress) in [(0.5, 1.210767, -0.935352), (1.5, 0.880175, 0.378280)] {
        let start: Vec<DVec3> = mesh
            .nodes
            .iter()
            .map(|p| DVec3::new(p.x * stretch, p.y, p.z))
            .collect();
        let fixed: Vec<[bool; 3]> = mesh
            .nodes
            .iter()
            .map(|p| [p.x.abs() > 0.499, p.y < -0.499, p.z < -0.499])
            .collect();
        let load = Load {
            positions: &start,
            fixed: &fixed,
            forces: &vec![DVec3::ZERO; start.len()],
        };
        let found = Statics::default().solve(&model, &load).unwrap();
        let (mut pull, mut high) = (0.0, f64::NEG_INFINITY);
        for n in 0..start.len() {
            if mesh.nodes[n].x > 0.499 {
                pull += found.reactions[n].x;
            }
            high = high.max(found.positions[n].y + 0.5);
        }
        close(&format!("P/E at {stretch}"), pull / 1.0e6, stress, 1e-5);
        close(&format!("side at {stretch}"), high, side, 1e-5);
    }
}

#[test]
fn bad_input_is_a_typed_error() {
    let (blueprint, places) = chain(3);
    let structure = SpringNet::new(&blueprint);
    let (fixed, forces) = (vec![[true; 3]; 4], vec![DVec3::ZERO; 4]);
    let good = Load {
        positions: &places,
        fixed: &fixed,
        forces: &forces,
    };
    let found = Statics::default().solve(&structure, &good).unwrap();
    assert_eq!(found.positions, places);
    let nan = [DVec3::ZERO, DVec3::NAN, DVec3::ZERO, DVec3::ZERO];
    let error = Statics::default()
        .solve(
            &structure,
            &Load {
                forces: &nan,
                ..good
            },
        )
        .unwrap_err();
    assert!(
        matches!(error, StaticError::Node { node: 1, .. }),
        "{error}"
    );
    let error = Statics::default()
        .solve(
            &structure,
            &Load {
                fixed: &fixed[1..],
                ..good
            },
        )
        .unwrap_err();
    assert!(
        matches!(error, StaticError::Length { found: 3, .. }),
        "{error}"
    );
    let bad = Statics {
        tolerance: f64::NAN,
        ..Statics::default()
    };
    assert!(matches!(
        bad.solve(&structure, &good),
        Err(StaticError::Value { .. })
    ));
}

/// A load beyond what St. Venant–Kirchhoff's law can carry in compression has no equilibrium short of turning inside out.
#[test]
fn what_does_not_converge_is_reported() {
    let mesh = TetMesh::new(
        vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        Tets::Linear(vec![[0, 1, 2, 3]]),
    )
    .unwrap();
    let model = Model::<f64>::new(&mesh, Solid::new(1.0e6, 0.3, 1000.0)).unwrap();
    let mut forces = vec![DVec3::ZERO; 4];
    forces[3] = DVec3::Z * 1e300;
    let fixed: Vec<[bool; 3]> = (0..4).map(|n| [n < 3; 3]).collect();
    let load = Load {
        positions: &mesh.nodes,
        fixed: &fixed,
        forces: &forces,
    };
    let error = Statics::default().solve(&model, &load).unwrap_err();
    assert!(
        matches!(error, StaticError::NotConverged { node: 3, .. }),
        "{error}"
    );
}
