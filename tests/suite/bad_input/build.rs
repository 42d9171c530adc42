//! Every error of building, inserting and attaching, with the element and the value it names.

use crate::fixtures::{bead, pair};
use crumple::body::{Binding, Net, Node, Skin, Surface, Tets};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::world::AttachError;

fn build(net: Net) -> BuildError {
    DeformableBuilder::new(net)
        .build()
        .expect_err("must be refused")
}

fn with(change: impl FnOnce(&mut Net)) -> BuildError {
    let mut net = pair();
    change(&mut net);
    build(net)
}

const BAD: [f32; 3] = [f32::NAN, f32::INFINITY, -1.0];

/// NaN is not equal to itself.
fn same(a: f32, b: f32) -> bool {
    a == b || (a.is_nan() && b.is_nan())
}

#[test]
fn numbers_of_a_node() {
    type Set = fn(&mut Node, f32);
    let fields: [(&str, Set); 2] = [("mass", |n, v| n.mass = v), ("volume", |n, v| n.volume = v)];
    for (name, set) in fields {
        for bad in BAD {
            let error = with(|net| set(&mut net.nodes[1], bad));
            assert!(
                matches!(error, BuildError::Node { node: 1, what, value, .. } if what == name && same(value, bad)),
                "{error:?}"
            );
            assert!(error.to_string().starts_with(&format!("node 1: {name} is")));
        }
    }
    for bad in [f32::NAN, f32::INFINITY] {
        let at = Vector::new(0.0, bad, 0.0);
        let position = with(|net| net.nodes[1].position = at);
        assert!(
            matches!(position, BuildError::NodeVector { node: 1, what: "position", value } if same(value.y, bad))
        );
        let velocity = with(|net| net.nodes[0].linvel = at);
        assert!(
            matches!(velocity, BuildError::NodeVector { node: 0, what: "velocity", value } if same(value.y, bad))
        );
    }
}

#[test]
fn numbers_of_a_spring() {
    type Set = fn(&mut Spring, f32);
    let fields: [(&str, Set, &[f32]); 9] = [
        ("section", |s, v| s.section = v, &BAD),
        ("stiffness", |s, v| s.stiffness = v, &BAD),
        ("damping", |s, v| s.damping = v, &BAD),
        ("hardening", |s, v| s.hardening = v, &BAD),
        (
            "rest length",
            |s, v| s.rest_length = Some(v),
            &[f32::NAN, f32::INFINITY, -1.0, 0.0],
        ),
        (
            "yield tension",
            |s, v| s.yield_tension = v,
            &[f32::NAN, -1.0, 0.0],
        ),
        (
            "yield compression",
            |s, v| s.yield_compression = v,
            &[f32::NAN, -1.0, 0.0],
        ),
        (
            "break force",
            |s, v| s.break_force = v,
            &[f32::NAN, -1.0, 0.0],
        ),
        (
            "break strain",
            |s, v| s.break_strain = v,
            &[f32::NAN, -1.0, 0.0],
        ),
    ];
    for (name, set, values) in fields {
        for &bad in values {
            let error = with(|net| set(&mut net.springs[0], bad));
            assert!(
                matches!(error, BuildError::Spring { spring: 0, what, value, .. } if what == name && same(value, bad)),
                "{name} = {bad}: {error:?}"
            );
        }
    }
}

#[test]
fn topology() {
    assert_eq!(build(Net::default()), BuildError::Empty);
    let out = |what, index, node| BuildError::IndexOutOfRange {
        what,
        index,
        node,
        count: 2,
    };
    let second = |a, b| move |net: &mut Net| net.springs.push(Spring::new(a, b, 1.0));
    assert_eq!(with(second(0, 2)), out("spring", 1, 2));
    assert_eq!(with(second(u32::MAX, 1)), out("spring", 1, u32::MAX));
    assert_eq!(with(|net| net.faces = vec![[0, 1, 7]]), out("face", 0, 7));
    assert_eq!(
        with(second(1, 1)),
        BuildError::SelfSpring { spring: 1, node: 1 }
    );
    let zero = with(|net| net.nodes[1].position = Vector::ZERO);
    assert!(
        matches!(zero, BuildError::Spring { spring: 0, what: "rest length", value, .. } if value == 0.0)
    );
}

#[test]
fn skins() {
    let skin = || Skin {
        vertices: vec![Vector::ZERO; 3],
        triangles: vec![[0, 1, 2]],
        bindings: vec![
            Binding {
                nodes: [0; 8],
                weights: [0.125; 8]
            };
            3
        ],
        touches: true,
    };
    let refused = |change: fn(&mut Skin)| {
        let mut skin = skin();
        change(&mut skin);
        with(|net| net.skin = Some(skin))
    };
    assert_eq!(
        refused(|s| s.bindings[2].nodes[3] = 9),
        BuildError::IndexOutOfRange {
            what: "skin vertex",
            index: 2,
            node: 9,
            count: 2
        }
    );
    assert!(matches!(
        refused(|s| s.triangles[0][1] = 3),
        BuildError::Value { value: 3.0, .. }
    ));
    assert!(matches!(
        refused(|s| s.bindings.truncate(2)),
        BuildError::Value { value: 2.0, .. }
    ));
    assert!(matches!(
        refused(|s| s.bindings[1].weights[0] = f32::NAN),
        BuildError::Value { value, .. } if value.is_nan()
    ));
    let mut net = pair();
    net.skin = Some(skin());
    assert!(DeformableBuilder::new(net).build().is_ok());
}

#[test]
fn masses_and_materials() {
    assert_eq!(
        with(|net| net.nodes[1].mass = 0.0),
        BuildError::Massless { node: 1 }
    );
    // 1/m must be a number, too.
    assert_eq!(
        with(|net| net.nodes[1].mass = 1e-40),
        BuildError::Massless { node: 1 }
    );
    let section = with(|net| net.springs[0] = Spring::of_section(0, 1, 0.02));
    assert_eq!(
        section,
        BuildError::NoMaterial {
            spring: 0,
            section: 0.02
        }
    );
    let elsewhere = DeformableBuilder::new(lattice(Vector::splat(0.2), 0.1))
        .material_where(|_| false, Material::rubber())
        .build();
    assert!(matches!(
        elsewhere,
        Err(BuildError::NoMaterial { spring: 0, .. })
    ));
    for bad in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
        let error = DeformableBuilder::new(pair())
            .total_mass(bad)
            .build()
            .unwrap_err();
        assert!(
            matches!(error, BuildError::Value { what: "the total mass", value, .. } if same(value as f32, bad))
        );
    }
}

/// 1/m of what is left of so little does not exist.
#[test]
fn a_total_mass_that_leaves_nodes_none() {
    let net = DeformableBuilder::new(pair()).total_mass(1e-40);
    let error = net.build().unwrap_err();
    assert!(matches!(error, BuildError::Massless { node: 0 }), "{error}");
}

/// Two nodes in one place with a spring that wants 1 m between them: its stiffness counts in whatever direction they part.
#[test]
fn nodes_in_one_place_have_a_stable_step() {
    let nodes = [Vector::ZERO; 2].map(|x| Node::new(x, 1.0));
    let spring = Spring::new(0, 1, 1.0e6).rest_length(1.0);
    let net = DeformableBuilder::new(Net::new(nodes.into(), vec![spring]));
    let mut set = DeformableWorld::new();
    set.insert(net).unwrap();
    let mut world = PhysicsWorld::default();
    set.step(&mut world);
    // ω = √(2k/m), h < 2/ω.
    assert!(
        set.report().substeps[0].1 >= 12,
        "{:?}",
        set.report().substeps
    );
}

#[test]
fn bad_materials() {
    type Set = fn(&mut Material, f32);
    let fields: [(&str, Set, &[f32]); 8] = [
        (
            "young modulus",
            |m, v| m.young = v,
            &[f32::NAN, f32::INFINITY, -1.0, 0.0],
        ),
        (
            "density",
            |m, v| m.density = v,
            &[f32::NAN, f32::INFINITY, -1.0, 0.0],
        ),
        ("viscosity", |m, v| m.viscosity = v, &BAD),
        ("hardening", |m, v| m.hardening = v, &BAD),
        (
            "yield stress in tension",
            |m, v| m.yield_tension = v,
            &[f32::NAN, -1.0, 0.0],
        ),
        (
            "yield stress in compression",
            |m, v| m.yield_compression = v,
            &[f32::NAN, -1.0, 0.0],
        ),
        ("strength", |m, v| m.strength = v, &[f32::NAN, -1.0, 0.0]),
        (
            "break strain",
            |m, v| m.break_strain = v,
            &[f32::NAN, -1.0, 0.0],
        ),
    ];
    for (name, set, values) in fields {
        for &bad in values {
            let mut material = Material::rubber();
            set(&mut material, bad);
            let net = || lattice(Vector::splat(0.2), 0.1);
            let builders = [
                DeformableBuilder::new(net()).material(material),
                DeformableBuilder::new(net())
                    .material(Material::rubber())
                    .material_where(|_| true, material),
            ];
            for builder in builders {
                let error = match builder.build().unwrap_err() {
                    BuildError::Region { region: 0, refused } => *refused,
                    error => error,
                };
                assert!(
                    matches!(error, BuildError::Value { what, value, .. }
                        if what == format!("the material's {name}") && same(value as f32, bad)),
                    "{error:?}"
                );
            }
        }
    }
}

/// Which of several materials is refused, and of what has no nodes which one it names.
#[test]
fn errors_say_which() {
    let net = lattice(Vector::splat(0.2), 0.1);
    let mut heavy = Material::rubber();
    heavy.density = -1.0;
    let error = DeformableBuilder::new(net)
        .material(Material::rubber())
        .material_where(|_| true, Material::rubber())
        .material_where(|_| true, heavy)
        .build()
        .unwrap_err();
    let said = error.to_string();
    assert!(said.starts_with("material 1 of `material_where`: the material's density"));
    let tets = Tets::Linear(vec![[0, 1, 2, 3]]);
    let none = TetMesh::new(Vec::new(), tets).unwrap_err().to_string();
    assert_eq!(none, "tet 0 names node 0, but there are 0");
    let surface = Surface::new(Vec::new(), vec![[0, 1, 2]]);
    let none = surface.check_triangles().unwrap_err().to_string();
    assert_eq!(none, "surface triangle 0 names node 0, but there are 0");
}

#[test]
fn numbers_of_the_builder() {
    let nan = Vector::new(f32::NAN, 0.0, 0.0);
    let builders = [
        ("the translation", bead(1.0).translation(nan)),
        ("the velocity", bead(1.0).linvel(nan)),
        ("the angular velocity", bead(1.0).angvel(nan)),
        ("the friction coefficient", bead(1.0).friction(f32::NAN)),
        ("the friction coefficient", bead(1.0).friction(-0.1)),
        ("the drag", bead(1.0).drag(f32::NAN)),
        ("the drag", bead(1.0).drag(-1.0)),
        ("the gravity scale", bead(1.0).gravity_scale(f32::INFINITY)),
        (
            "the length of the rotation's quaternion",
            bead(1.0).rotation(Rotation::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)),
        ),
        (
            "the length of the rotation's quaternion",
            bead(1.0).rotation(Rotation::from_xyzw(0.0, 0.0, 0.0, 0.0)),
        ),
        (
            "the number of substeps",
            bead(1.0).substeps(Substeps::Fixed(0)),
        ),
        (
            "the number of substeps",
            bead(1.0).substeps(Substeps::Unchecked(0)),
        ),
        (
            "the safety factor of the substep",
            bead(1.0).substeps(Substeps::Auto {
                safety: f64::NAN,
                min_h: 0.0,
            }),
        ),
        (
            "the safety factor of the substep",
            bead(1.0).substeps(Substeps::Auto {
                safety: 1.1,
                min_h: 0.0,
            }),
        ),
        (
            "the shortest substep min_h",
            bead(1.0).substeps(Substeps::Auto {
                safety: 0.9,
                min_h: f64::NAN,
            }),
        ),
    ];
    for (name, builder) in builders {
        let error = builder.build().expect_err(name);
        assert!(
            matches!(error, BuildError::Value { what, .. } if what == name),
            "{name}: {error:?}"
        );
    }
}

#[test]
fn an_unstable_body_names_its_worst_spring() {
    let mut net = pair();
    net.nodes.push(Node::new(Vector::new(2.0, 0.0, 0.0), 0.5));
    net.springs.push(Spring::new(1, 2, 4.0e6).damping(3.0));
    let mut deformables = DeformableWorld::new();
    let mut insert =
        |substeps| deformables.insert(DeformableBuilder::new(net.clone()).substeps(substeps));
    let refused = [
        (
            Substeps::Auto {
                safety: 0.9,
                min_h: 1e-3,
            },
            1e-3 / 0.9,
        ),
        (Substeps::Fixed(16), 1.0 / 60.0 / 16.0),
    ];
    for (substeps, allowed) in refused {
        match insert(substeps).unwrap_err() {
            BuildError::Unstable {
                spring: 1,
                stiffness: 4.0e6,
                damping: 3.0,
                mass_a: 1.0,
                mass_b: 0.5,
                needed_h,
                min_h,
            } => {
                assert!((min_h - allowed).abs() < 1e-12, "{min_h} {allowed}");
                assert!(needed_h < min_h && needed_h > 1e-4, "{needed_h}");
            }
            other => panic!("{other:?}"),
        }
    }
    assert!(insert(Substeps::Fixed(200)).is_ok());
    assert!(insert(Substeps::Unchecked(1)).is_ok());
    assert!(insert(Substeps::default()).is_ok());
    assert_eq!(deformables.len(), 3, "what was refused is not there");
}

#[test]
fn schemes_that_are_never_stable_name_an_undamped_spring() {
    let mut net = pair();
    net.springs.push(Spring::new(0, 1, 10.0));
    for (integrator, name) in [
        (Integrator::ExplicitEuler, "explicit Euler"),
        (Integrator::Midpoint, "midpoint"),
    ] {
        let mut deformables = DeformableWorld::new();
        let body = DeformableBuilder::new(net.clone()).integrator(integrator);
        assert_eq!(
            deformables.insert(body.clone()),
            Err(BuildError::NeverStable {
                integrator: name,
                spring: 1
            })
        );
        assert!(
            deformables
                .insert(body.substeps(Substeps::Unchecked(10)))
                .is_ok()
        );
        // The world's scheme counts for bodies without one.
        deformables.params.integrator = integrator;
        assert!(
            deformables
                .insert(DeformableBuilder::new(net.clone()))
                .is_err()
        );
        assert!(deformables.insert(DeformableBuilder::new(pair())).is_ok());
    }
}

#[test]
fn attachments() {
    let mut world = PhysicsWorld::default();
    let rigid = world.insert_body(RigidBodyBuilder::dynamic());
    let gone = world.insert_body(RigidBodyBuilder::dynamic());
    world.remove_body(gone);
    let mut deformables = DeformableWorld::new();
    let soft = deformables.insert(bead(1.0)).unwrap();
    let stale = deformables.insert(bead(1.0)).unwrap();
    deformables.remove(stale);
    let mut attach = |d, nodes: &[u32], b| {
        let nodes: Vec<NodeId> = nodes.iter().map(|&n| NodeId(n)).collect();
        deformables.attach(d, &nodes, b, &world.bodies)
    };
    assert_eq!(
        attach(stale, &[0], rigid),
        Err(AttachError::UnknownDeformable(stale))
    );
    assert_eq!(
        attach(soft, &[0], gone),
        Err(AttachError::UnknownBody(gone))
    );
    assert_eq!(attach(soft, &[], rigid), Err(AttachError::NoNodes));
    assert_eq!(
        attach(soft, &[0, 5], rigid),
        Err(AttachError::UnknownNode { node: 5, count: 1 })
    );
    let held = attach(soft, &[0, 0], rigid).expect("one node named twice is one node");
    assert!(deformables.detach(held) && !deformables.detach(held));
    assert_eq!(deformables.attachment_force(held), None);

    let mut attach =
        |what: Attachment, to: AttachTo| deformables.attach(soft, what, to, &world.bodies);
    let node = || [NodeId(0)];
    let link = |k: f32| Attachment::link(node(), k);
    for (what, names) in [
        (link(f32::NAN), "stiffness"),
        (link(0.0), "stiffness"),
        (link(-1.0), "stiffness"),
        (link(f32::INFINITY), "stiffness"),
        (link(1.0).damping(-1.0), "damping"),
        (link(1.0).damping(f32::NAN), "damping"),
        (Attachment::weld(node()).damping(1.0), "damping"),
        (Attachment::weld(node()).strength(f32::NAN), "strength"),
        (Attachment::pin(node()).strength(-1.0), "strength"),
        (Attachment::weld(node()).moment_strength(-1.0), "moment"),
        (Attachment::pin(node()).at(Vector::X * f32::NAN), "pivot"),
    ] {
        match attach(what.clone(), rigid.into()) {
            Err(AttachError::Value { what, .. }) => assert!(what.contains(names), "{what}"),
            other => panic!("{what:?}: {other:?}"),
        }
    }
    assert_eq!(
        attach(Attachment::weld(node()), soft.into()),
        Err(AttachError::ToItself(soft))
    );
    assert_eq!(
        attach(Attachment::weld(node()), stale.into()),
        Err(AttachError::UnknownDeformable(stale))
    );
    assert_eq!(
        attach(Attachment::weld([]), AttachTo::World),
        Err(AttachError::NoNodes)
    );
    let off = attach(Attachment::pin(node()).at(Vector::X), AttachTo::World);
    assert_eq!(off, Err(AttachError::Pivot { distance: 1.0 }));
}

/// Either side may be disabled, enabled again, and removed, in any order.
#[test]
fn sides_of_attachments_come_and_go() {
    let mut world = PhysicsWorld::default();
    let rigid = world.insert_body(RigidBodyBuilder::dynamic().additional_mass(1.0));
    let mut deformables = DeformableWorld::new();
    let [a, b] = [(); 2].map(|()| deformables.insert(bead(1.0)).unwrap());
    let node = [NodeId(0)];
    let hang = deformables
        .attach(
            a,
            Attachment::link(node, 1.0e4),
            AttachTo::World,
            &world.bodies,
        )
        .unwrap();
    let weld = deformables.attach(a, &node, rigid, &world.bodies).unwrap();
    let tie = deformables.attach(b, &node, a, &world.bodies).unwrap();
    assert_eq!(deformables.attachments().count(), 3);
    for step in 0..60 {
        world.bodies[rigid].set_enabled(step % 7 != 3);
        deformables[a].set_enabled(step % 11 != 5);
        deformables[b].set_enabled(step % 13 != 6);
        deformables.step(&mut world);
        assert!(deformables.report().frozen.is_empty());
        assert!(deformables[b].position(NodeId(0)).unwrap().is_finite());
    }
    world.remove_body(rigid);
    deformables.step(&mut world);
    assert!(!deformables.contains_attachment(weld) && deformables.contains_attachment(tie));
    let body = deformables.remove(a).unwrap();
    assert_eq!(body.energies().elastic, 0.0, "the link is gone");
    assert!(!deformables.contains_attachment(tie) && !deformables.contains_attachment(hang));
    deformables.step(&mut world);
    assert_eq!(deformables.attachments().count(), 0);
}

/// Stiffness over mass beyond all numbers has no substep at all: it was taken for a body without a limit.
#[test]
fn rates_beyond_all_numbers_are_refused() {
    let auto = Substeps::Auto {
        safety: 0.9,
        min_h: 0.0,
    };
    for substeps in [Substeps::default(), auto, Substeps::Fixed(10)] {
        for integrator in [Integrator::SymplecticEuler, Integrator::Rk4] {
            let net = lattice(Vector::splat(0.2), 0.1).unwrap();
            let body = DeformableBuilder::new(net)
                .material(Material::elastic(1e30, 1e-30))
                .substeps(substeps)
                .integrator(integrator);
            let error = DeformableWorld::default()
                .insert(body)
                .expect_err("must be refused");
            assert!(
                matches!(error, BuildError::Unstable { needed_h: 0.0, .. }),
                "{substeps:?} {integrator:?}: {error:?}"
            );
        }
    }
    let mesh = crumple::shape::tet_box(Vector::splat(0.2), 0.1, crumple::shape::TetSplit::Six);
    let solid = Solid::new(1e30, 0.3, 1e-30);
    let error = DeformableWorld::default()
        .insert(DeformableBuilder::tets(mesh.unwrap(), solid))
        .expect_err("must be refused");
    let refused = matches!(error, BuildError::UnstableTet { .. });
    assert!(refused, "{error:?}");
}

/// Where no spring is to blame for it, and where springs are that need no short substeps.
#[test]
fn a_drag_that_no_substep_bears_is_refused() {
    let pair = Net::new(
        vec![Node::new(Vector::ZERO, 1.0), Node::new(Vector::X, 0.125)],
        vec![Spring::new(0, 1, 100.0)],
    );
    let builders = [
        ("a point", bead(0.01).drag(1e8), 0.01),
        ("a pair", DeformableBuilder::new(pair).drag(1e8), 0.125),
    ];
    for (what, builder, lightest) in builders {
        let mut set = DeformableWorld::default();
        let refused = set.insert(builder.clone()).unwrap_err();
        let BuildError::UnstableDrag { drag, mass, .. } = refused else {
            panic!("{what}: {refused:?}");
        };
        assert_eq!((drag, mass), (1e8, lightest), "{what}");
        let body = set.insert(builder.drag(0.1)).unwrap();
        let changed = set[body].set_drag(1e8);
        assert!(
            matches!(changed, Err(BuildError::UnstableDrag { .. })),
            "{what}: {changed:?}"
        );
        assert_eq!(set[body].drag(), 0.1, "{what}");
    }
}
