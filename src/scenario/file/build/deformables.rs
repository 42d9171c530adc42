//! Deformables and attachments.

use super::super::super::Cast;
use super::super::limits;
use super::super::model::deformable::{NodeSpec, Split, SpringSpec, cells_around};
use super::super::model::{
    Attachment, Body, Deformable, Hold, Law, Region, Scenario, SolidMaterial, SpringMaterial,
    Substepping,
};
use super::alike::alike;
use super::rigid::{groups, rule};
use super::{Places, RunError, scheme, selected, substeps, surface, tets, vector};
use crate::body::{BuildError, Material, Net, Node, Solid, SolidLaw, Spring, TetMesh};
use crate::math::{Pose, Real, Rotation, Vector, narrow};
use crate::shape;
use crate::world::{self, AttachTo, DeformableBuilder, DeformableWorld};
use rapier3d::pipeline::PhysicsWorld;

/// What a body is built of, before materials.
enum Frame {
    Net(Net),
    Tets(TetMesh),
}

/// Puts in a body; says where its own frame is in the world.
pub(super) fn insert(
    body: &Deformable,
    scene: &Scenario,
    world: &mut DeformableWorld,
    cast: &mut Cast,
) -> Result<Pose, RunError> {
    let failed = |source| RunError::Deformable {
        name: body.name.clone(),
        source: Box::new(source),
    };
    let before: usize = world.iter().map(|(_, b)| b.node_count()).sum();
    let mut middles = Vec::new();
    let (builder, nodes): (_, Vec<Vector>) = match frame(&body.body, &body.name, before, cast)? {
        Frame::Net(mut net) => {
            if let (Some(springs), Some(mass)) = (&body.springs, body.mass) {
                alike(&mut net, springs, mass as Real);
            }
            let at = |n: u32| net.nodes[n as usize].position;
            let springs = net.springs.iter();
            middles = springs
                .map(|s| 0.5 * (at(s.nodes[0]) + at(s.nodes[1])))
                .collect();
            let nodes = net.nodes.iter().map(|n| n.position).collect();
            (DeformableBuilder::new(net), nodes)
        }
        Frame::Tets(mesh) => {
            let nodes = mesh.nodes.iter().copied().map(narrow).collect();
            let Some(made) = &body.solid else {
                return Err(failed(BuildError::MaterialForTets));
            };
            let mut builder = DeformableBuilder::tets(mesh, solid(&made.0));
            if let Some(mesh) = &body.embed {
                builder = builder.embed(surface(mesh, &body.name)?);
            }
            (builder, nodes)
        }
    };
    few(&body.name, (before + nodes.len()) as f64)?;
    let pose = pose(body, &nodes);
    let places = Places::around(nodes.iter().copied());
    somewhere(body, &nodes, &middles, places)?;
    let builder = dressed(builder, body, places);
    let builder = builder
        .translation(pose.translation)
        .rotation(pose.rotation);
    let handle = world.insert(builder).map_err(failed)?;
    ends(body, scene, &world[handle])?;
    cast.deformables.push((body.name.clone(), handle));
    Ok(pose)
}

/// Refuses more nodes than a scene may have.
fn few(name: &str, value: f64) -> Result<(), RunError> {
    match value <= limits::NODES {
        true => Ok(()),
        false => Err(RunError::TooMany {
            name: name.into(),
            what: "nodes in all",
            value,
            most: limits::NODES,
        }),
    }
}

/// Refuses a body whose stable substep is so short that its record would not fit into memory.
fn ends(body: &Deformable, scene: &Scenario, made: &world::Deformable) -> Result<(), RunError> {
    let own = body.substeps.as_ref().unwrap_or(&scene.world.substeps);
    let Substepping::Auto { safety, .. } = own else {
        // Looked at when the scene was loaded.
        return Ok(());
    };
    let value = scene.world.duration / (safety * made.stable_step().h).min(scene.world.dt);
    match value <= limits::SUBSTEPS {
        true => Ok(()),
        false => Err(RunError::TooMany {
            name: body.name.clone(),
            what: "substeps",
            value,
            most: limits::SUBSTEPS,
        }),
    }
}

/// Refuses formulas that choose nothing of a body: no node for a pin, no spring and no node for a part.
fn somewhere(
    body: &Deformable,
    nodes: &[Vector],
    middles: &[Vector],
    places: Places,
) -> Result<(), RunError> {
    let pin = body.pin.iter().map(|region| ("a pin", region, &[][..]));
    let parts = body.parts.iter().map(|part| ("a part", &part.at, middles));
    for (what, region, middles) in pin.chain(parts) {
        let mut chosen = middles.iter().chain(nodes);
        if !chosen.any(|at| places.holds(&region.0, *at)) {
            return Err(RunError::Nothing {
                what,
                formula: region.0.text().into(),
                body: body.name.clone(),
            });
        }
    }
    Ok(())
}

/// Where a body's own frame stands in the world, given its nodes there.
fn pose(body: &Deformable, nodes: &[Vector]) -> Pose {
    let turn = Rotation::from_scaled_axis(vector(body.rotation));
    let mut shift = vector(body.translation).to_array();
    if (body.low, body.high) != ([None; 3], [None; 3]) {
        let start = (Vector::INFINITY, Vector::NEG_INFINITY);
        let turned = nodes.iter().map(|x| turn * *x);
        let (lo, hi) = turned.fold(start, |(lo, hi), x| (lo.min(x), hi.max(x)));
        for axis in 0..3 {
            if let Some(low) = body.low[axis] {
                shift[axis] = low as Real - lo[axis];
            } else if let Some(high) = body.high[axis] {
                shift[axis] = high as Real - hi[axis];
            }
        }
    }
    Pose::from_parts(Vector::from_array(shift), turn)
}

/// The builder with everything else that a scene says of a body.
fn dressed(mut builder: DeformableBuilder, body: &Deformable, places: Places) -> DeformableBuilder {
    let holds = move |region: &Region| {
        let formula = region.0.clone();
        move |at: Vector| places.holds(&formula, at)
    };
    if let Some(made) = &body.material {
        builder = builder.material(material(&made.0));
    }
    for part in &body.parts {
        builder = builder.material_where(holds(&part.at), material(&part.material.0));
    }
    if let Some(region) = &body.pin {
        builder = builder.pin(holds(region));
    }
    // Springs that are alike have made masses of it already.
    if let (Some(mass), None) = (body.mass, &body.springs) {
        builder = builder.total_mass(mass as Real);
    }
    if let Some(stiffness) = body.contact_stiffness {
        builder = builder.contact_stiffness(stiffness as Real);
    }
    if let Some(own) = &body.substeps {
        builder = builder.substeps(substeps(own));
    }
    if let Some(own) = &body.integrator {
        builder = builder.integrator(scheme(own));
    }
    builder
        .linvel(vector(body.linvel))
        .angvel(vector(body.angvel))
        .friction(body.friction as Real)
        .friction_combine_rule(rule(&body.friction_rule))
        .thickness(body.thickness as Real)
        .collision_groups(groups(&body.groups))
        .solver_groups(groups(&body.solver_groups))
        .dominance_group(body.dominance)
        .can_sleep(body.can_sleep)
        .gravity_scale(body.gravity_scale as Real)
        .drag(body.drag as Real)
}

/// Makes the nodes and elements of a body; `before` is how many nodes the bodies before it have.
fn frame(body: &Body, name: &str, before: usize, cast: &mut Cast) -> Result<Frame, RunError> {
    let failed = |source| RunError::Deformable {
        name: name.into(),
        source: Box::new(source),
    };
    let quadratic_if = |mesh: TetMesh, yes: bool| if yes { mesh.quadratic() } else { mesh };
    let net = match body {
        Body::Lattice { size, cell } => shape::lattice(vector(*size), *cell as Real),
        Body::Sheet {
            size: [w, h],
            nodes: [nx, ny],
            thickness,
            bending,
        } => {
            let [w, h, t, b] = [w, h, thickness, bending].map(|x| *x as Real);
            shape::sheet_with_bending(w, h, *nx, *ny, t, b)
        }
        Body::Rope {
            from,
            to,
            segments,
            section,
        } => shape::rope(vector(*from), vector(*to), *segments, *section as Real),
        Body::Filled { mesh, cell } => {
            let surface = surface(mesh, name)?;
            few_cells(&surface.vertices, *cell, name, before)?;
            let net = shape::filled(&surface, *cell as Real);
            if cast.parts.is_empty() {
                let parts = surface.groups.into_iter();
                cast.parts = parts.map(|g| (g.name, g.triangles)).collect();
            }
            net
        }
        Body::Net {
            nodes,
            springs,
            faces,
        } => Ok(Net {
            nodes: nodes.iter().map(node).collect(),
            springs: springs.iter().map(spring).collect(),
            faces: faces.clone(),
            skin: None,
        }),
        Body::TetBox {
            size,
            cell,
            split,
            quadratic,
        } => {
            let split = match split {
                Split::Five => shape::TetSplit::Five,
                Split::Six => shape::TetSplit::Six,
            };
            let mesh = shape::tet_box(vector(*size), *cell as Real, split).map_err(failed)?;
            return Ok(Frame::Tets(quadratic_if(mesh, *quadratic)));
        }
        Body::TetFilled {
            mesh,
            cell,
            quadratic,
        } => {
            let surface = surface(mesh, name)?;
            few_cells(&surface.vertices, *cell, name, before)?;
            let mesh = shape::tet_filled(&surface, *cell as Real).map_err(failed)?;
            return Ok(Frame::Tets(quadratic_if(mesh, *quadratic)));
        }
        Body::TetMesh(file) => return tets(&file.0, name).map(Frame::Tets),
    };
    net.map(Frame::Net).map_err(failed)
}

/// Refuses a surface that would get more cells than a scene may have nodes, before they are made.
fn few_cells(vertices: &[Vector], cell: f64, name: &str, before: usize) -> Result<(), RunError> {
    let start = (Vector::INFINITY, Vector::NEG_INFINITY);
    let (lo, hi) = vertices
        .iter()
        .fold(start, |(lo, hi), v| (lo.min(*v), hi.max(*v)));
    let sides = (hi - lo).to_array().map(f64::from);
    few(name, before as f64 + cells_around(sides, cell))
}

fn node(n: &NodeSpec) -> Node {
    Node {
        linvel: vector(n.linvel),
        pinned: n.pinned,
        ..Node::new(vector(n.at), n.mass as Real)
    }
}

fn spring(s: &SpringSpec) -> Spring {
    let [a, b] = s.nodes;
    Spring {
        rest_length: s.rest_length.map(|l| l as Real),
        ..Spring::new(a, b, s.stiffness as Real)
            .damping(s.damping as Real)
            .yielding(s.yield_force as Real, s.hardening as Real)
            .breaking(s.break_force as Real)
    }
}

fn material(m: &SpringMaterial) -> Material {
    Material {
        young: m.young as Real,
        density: m.density as Real,
        viscosity: m.viscosity as Real,
        yield_tension: m.yield_tension as Real,
        yield_compression: m.yield_compression as Real,
        hardening: m.hardening as Real,
        strength: m.strength as Real,
        break_strain: m.break_strain as Real,
    }
}

fn solid(s: &SolidMaterial) -> Solid {
    let law = match s.law {
        Law::Corotational => SolidLaw::Corotational,
        Law::NeoHookean => SolidLaw::NeoHookean,
        Law::StableNeoHookean => SolidLaw::StableNeoHookean,
        Law::StVenantKirchhoff => SolidLaw::StVenantKirchhoff,
    };
    Solid::new(s.young, s.poisson, s.density)
        .law(law)
        .damping(s.mass_damping, s.stiffness_damping)
}

/// Puts in all attachments of a scene. Their bodies are known: the loader has looked.
pub(super) fn attach(
    scene: &Scenario,
    deformables: &mut DeformableWorld,
    world: &PhysicsWorld,
    cast: &mut Cast,
) -> Result<(), RunError> {
    for attachment in &scene.attachments {
        let Some(of) = cast.deformable(&attachment.of) else {
            continue;
        };
        let target = match &attachment.to {
            None => Some(AttachTo::World),
            Some(name) => match cast.body(name) {
                Some(body) => Some(body.into()),
                None => cast.deformable(name).map(AttachTo::from),
            },
        };
        let (Some(target), Some(body)) = (target, deformables.get(of)) else {
            continue;
        };
        let held = held(attachment, body)?;
        let made = deformables.attach(of, held, target, &world.bodies);
        let made = made.map_err(|source| RunError::Attachment {
            name: attachment.name.clone(),
            source,
        })?;
        cast.attachments.push((attachment.name.clone(), made));
    }
    Ok(())
}

fn held(a: &Attachment, body: &world::Deformable) -> Result<world::Attachment, RunError> {
    let nodes = selected(body, Some(&a.nodes), "an attachment", &a.of)?;
    let mut held = match a.hold {
        Hold::Weld => world::Attachment::weld(nodes),
        Hold::Pin => world::Attachment::pin(nodes),
        Hold::Link { stiffness, damping } => {
            world::Attachment::link(nodes, stiffness as Real).damping(damping as Real)
        }
    };
    if let Some(at) = a.at {
        held = held.at(vector(at));
    }
    Ok(held
        .strength(a.strength as Real)
        .moment_strength(a.moment_strength as Real))
}
