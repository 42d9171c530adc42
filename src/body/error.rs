//! What can be wrong with a body: which element, which value, and what would be right.

use super::net::{Net, Skin, Spring};
use crate::math::{Real, Vector};

/// Why a body can't be built or inserted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The net has no node.
    #[error("the body has no nodes; a net needs at least one")]
    Empty,
    /// A node's value is out of range.
    #[error("node {node}: {what} is {value}, it must be {must}")]
    Node {
        /// Index of the node.
        node: u32,
        /// Name of the value.
        what: &'static str,
        /// The value.
        value: Real,
        /// What it must be.
        must: &'static str,
    },
    /// A node's position or velocity is not finite.
    #[error("node {node}: {what} is {value}, it must be finite")]
    NodeVector {
        /// Index of the node.
        node: u32,
        /// Name of the value.
        what: &'static str,
        /// The value.
        value: Vector,
    },
    /// A node has neither a mass nor a volume and a density.
    #[error(
        "node {node} has no mass; give `Node::mass` in kg, or a volume and a material, or a total mass"
    )]
    Massless {
        /// Index of the node.
        node: u32,
    },
    /// A spring's value is out of range.
    #[error("spring {spring}: {what} is {value}, it must be {must}")]
    Spring {
        /// Index of the spring.
        spring: u32,
        /// Name of the value.
        what: &'static str,
        /// The value.
        value: Real,
        /// What it must be.
        must: &'static str,
    },
    /// A spring joins a node to itself.
    #[error("spring {spring} joins node {node} to itself")]
    SelfSpring {
        /// Index of the spring.
        spring: u32,
        /// Its node.
        node: u32,
    },
    /// A spring, a face or a skin names a node that does not exist.
    #[error("{what} {index} names node {node}, but there are {count}{}", up_to(*count))]
    IndexOutOfRange {
        /// "spring", "face" or "skin vertex".
        what: &'static str,
        /// Index of the element.
        index: u32,
        /// The node it names.
        node: u32,
        /// How many nodes there are.
        count: u32,
    },
    /// A material of a region is refused.
    #[error("material {region} of `material_where`: {refused}")]
    Region {
        /// Which of them, from 0 on.
        region: usize,
        /// Why.
        refused: Box<BuildError>,
    },
    /// A spring made from a section has no material to take its constants from.
    #[error(
        "spring {spring} has a section of {section} m² but the body has no material; call `.material(..)` or set its stiffness"
    )]
    NoMaterial {
        /// Index of the spring.
        spring: u32,
        /// Its section.
        section: Real,
    },
    /// A value of the builder or of a material is out of range.
    #[error("{what} is {value}, it must be {must}")]
    Value {
        /// Name of the value.
        what: &'static str,
        /// The value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// The surface has an edge that does not belong to exactly two triangles.
    #[error(
        "the surface is not closed: the edge of vertices {a} and {b} belongs to {triangles} triangle(s), it must belong to exactly two that run along it in opposite directions"
    )]
    OpenSurface {
        /// One end of the edge.
        a: u32,
        /// The other end.
        b: u32,
        /// How many triangles use it.
        triangles: u32,
    },
    /// Two triangles of the surface cross each other.
    #[error("the surface crosses itself: triangles {first} and {second} intersect")]
    SelfIntersecting {
        /// Index of one triangle.
        first: u32,
        /// Index of the other.
        second: u32,
    },
    /// A triangle without area.
    #[error("triangle {triangle} of the surface has no area ({area} m²)")]
    FlatTriangle {
        /// Index of the triangle.
        triangle: u32,
        /// Its area.
        area: Real,
    },
    /// A vertex of a skin is far from the mesh that is to carry it.
    #[error(
        "vertex {vertex} of the skin at {position} is farther outside of the mesh than a tet is thick; \
         the mesh must fill the surface"
    )]
    SkinOutside {
        /// Index of the vertex.
        vertex: u32,
        /// Where it is \[m\].
        position: Vector,
    },
    /// There is no mesh to carry a skin.
    #[error("a surface can be embedded in a mesh of tets only; nets have their own skins")]
    SkinWithoutTets,
    /// There is no skin to touch with.
    #[error("the body has no skin that could touch others; `filled` and `embed` give it one")]
    NoSkin,
    /// The cells a surface is to be filled with are larger than what is inside it.
    #[error("no cell of {cell} m has its centre inside the surface; cells of {enough} m do")]
    CellTooLarge {
        /// The side of the cells \[m\].
        cell: f64,
        /// A side with which at least one cell fits \[m\].
        enough: f64,
    },
    /// Tets that are flat or inside out.
    #[error(
        "{count} of the tets are flat or inverted: {}; corners a, b, c, d must turn right-handed",
        named(worst)
    )]
    FlatTets {
        /// How many.
        count: usize,
        /// The worst of them, eight at most: index and signed volume \[m³\].
        worst: Vec<(u32, f64)>,
    },
    /// The surface is thicker than its edges allow: nodes side by side would touch.
    #[error(
        "the surface is {thickness} m thick; half of its shortest edge, {limit} m, is the most for contact"
    )]
    TooThick {
        /// The thickness \[m\].
        thickness: f64,
        /// The most it may be \[m\].
        limit: f64,
    },
    /// No stable substep fits the budget.
    #[error(
        "spring {spring} (k = {stiffness} N/m, c = {damping} N·s/m, between {mass_a} kg and {mass_b} kg) needs substeps of {needed_h:e} s, shorter than the {min_h:e} s allowed; lower its stiffness or damping, make its nodes heavier, or allow more substeps with `Substeps`"
    )]
    Unstable {
        /// The worst spring.
        spring: u32,
        /// Its stiffness \[N/m\].
        stiffness: Real,
        /// Its damping \[N·s/m\].
        damping: Real,
        /// Mass of its first node \[kg\].
        mass_a: Real,
        /// Mass of its second node \[kg\].
        mass_b: Real,
        /// The longest stable substep \[s\].
        needed_h: f64,
        /// The shortest substep the budget allows \[s\].
        min_h: f64,
    },
    /// No stable substep fits the budget, and it is the drag that asks for such short ones.
    #[error(
        "a drag of {drag} N·s/m on nodes of {mass} kg needs substeps of {needed_h:e} s, shorter than the {min_h:e} s allowed; lower it, make the lightest nodes heavier, or allow more substeps with `Substeps`"
    )]
    UnstableDrag {
        /// The drag \[N·s/m\].
        drag: Real,
        /// Mass of the lightest node that is not pinned \[kg\].
        mass: Real,
        /// The longest stable substep \[s\].
        needed_h: f64,
        /// The shortest substep the budget allows \[s\].
        min_h: f64,
    },
    /// No stable substep of a solid fits the budget.
    #[error(
        "tet {tet} (E = {young} Pa, ν = {poisson}, ρ = {density} kg/m³, {volume:e} m³) needs substeps of {needed_h:e} s, shorter than the {min_h:e} s allowed; lower its stiffness or damping, make the smallest tets larger, or allow more substeps with `Substeps`"
    )]
    UnstableTet {
        /// The worst tet.
        tet: u32,
        /// Young's modulus \[Pa\].
        young: f64,
        /// Poisson's ratio.
        poisson: f64,
        /// Density \[kg/m³\].
        density: f64,
        /// Its volume \[m³\].
        volume: f64,
        /// The longest stable substep \[s\].
        needed_h: f64,
        /// The shortest substep the budget allows \[s\].
        min_h: f64,
    },
    /// The integrator is unstable at any substep for an undamped solid.
    #[error(
        "{integrator} is not stable at any substep for a solid without damping; choose another integrator, or `Substeps::Unchecked` to see it grow"
    )]
    NeverStableSolid {
        /// Name of the scheme.
        integrator: &'static str,
    },
    /// A material of springs for a body of tets.
    #[error("a body of tets has its constants from its `Solid`; `.material(..)` is for springs")]
    MaterialForTets,
    /// The integrator is unstable at any substep for an undamped body.
    #[error(
        "{integrator} is not stable at any substep for spring {spring}, which has no damping; choose another integrator, or `Substeps::Unchecked` to see it grow"
    )]
    NeverStable {
        /// Name of the scheme.
        integrator: &'static str,
        /// An undamped spring.
        spring: u32,
    },
}

fn named(tets: &[(u32, f64)]) -> String {
    let each: Vec<String> = tets
        .iter()
        .map(|(tet, volume)| format!("tet {tet} ({volume:.3e} m³)"))
        .collect();
    each.join(", ")
}

/// The numbers of so many nodes, in brackets.
fn up_to(count: u32) -> String {
    let last = count.checked_sub(1);
    last.map_or(String::new(), |last| format!(" (0 to {last})"))
}

const POSITIVE: &str = "a positive finite number";
const NOT_NEGATIVE: &str = "a finite number, zero or more";
const POSITIVE_OR_INFINITE: &str = "positive (infinite for never)";

/// The part of [`BuildError`] that needs no material.
pub(super) fn check_net(net: &Net) -> Result<(), BuildError> {
    if net.nodes.is_empty() {
        return Err(BuildError::Empty);
    }
    let count = net.nodes.len() as u32;
    let index = |what, index: usize, nodes: &[u32]| match nodes.iter().find(|&&n| n >= count) {
        Some(&node) => Err(BuildError::IndexOutOfRange {
            what,
            index: index as u32,
            node,
            count,
        }),
        None => Ok(()),
    };
    for (i, node) in net.nodes.iter().enumerate() {
        let node_id = i as u32;
        for (what, value) in [("position", node.position), ("velocity", node.linvel)] {
            if !value.is_finite() {
                return Err(BuildError::NodeVector {
                    node: node_id,
                    what,
                    value,
                });
            }
        }
        for (what, value) in [("mass", node.mass), ("volume", node.volume)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(BuildError::Node {
                    node: node_id,
                    what,
                    value,
                    must: NOT_NEGATIVE,
                });
            }
        }
    }
    for (i, spring) in net.springs.iter().enumerate() {
        index("spring", i, &spring.nodes)?;
        check_spring(net, i as u32, spring)?;
    }
    for (i, face) in net.faces.iter().enumerate() {
        index("face", i, face)?;
    }
    if let Some(skin) = &net.skin {
        for (i, binding) in skin.bindings.iter().enumerate() {
            index("skin vertex", i, &binding.nodes)?;
        }
        check_skin(skin)?;
    }
    Ok(())
}

fn check_skin(skin: &Skin) -> Result<(), BuildError> {
    let bad = |what, value, must| Err(BuildError::Value { what, value, must });
    let vertices = skin.vertices.len();
    if skin.bindings.len() != vertices {
        return bad(
            "the number of bindings of the skin",
            skin.bindings.len() as f64,
            "the number of its vertices",
        );
    }
    let mut corners = skin.triangles.iter().flatten();
    if let Some(&corner) = corners.find(|&&v| v as usize >= vertices) {
        return bad(
            "a corner of a triangle of the skin",
            corner.into(),
            "the index of one of its vertices",
        );
    }
    let mut weights = skin.bindings.iter().flat_map(|b| b.weights);
    if let Some(weight) = weights.find(|w| !w.is_finite()) {
        return bad("a weight of the skin", weight.into(), "finite");
    }
    Ok(())
}

fn check_spring(net: &Net, id: u32, spring: &Spring) -> Result<(), BuildError> {
    let [a, b] = spring.nodes;
    if a == b {
        return Err(BuildError::SelfSpring {
            spring: id,
            node: a,
        });
    }
    let length = spring.rest_length.unwrap_or_else(|| net.length(spring));
    if !(length.is_finite() && length > 0.0) {
        return Err(BuildError::Spring {
            spring: id,
            what: "rest length",
            value: length,
            must: POSITIVE,
        });
    }
    check_constants(id, spring)
}

/// Checks the constants of a spring, its geometry left aside.
pub(crate) fn check_constants(id: u32, spring: &Spring) -> Result<(), BuildError> {
    let bad = |what, value, must| BuildError::Spring {
        spring: id,
        what,
        value,
        must,
    };
    for (what, value) in [
        ("section", spring.section),
        ("stiffness", spring.stiffness),
        ("damping", spring.damping),
        ("hardening", spring.hardening),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(bad(what, value, NOT_NEGATIVE));
        }
    }
    for (what, value) in [
        ("yield tension", spring.yield_tension),
        ("yield compression", spring.yield_compression),
        ("break force", spring.break_force),
        ("break strain", spring.break_strain),
    ] {
        if value.is_nan() || value <= 0.0 {
            return Err(bad(what, value, POSITIVE_OR_INFINITE));
        }
    }
    Ok(())
}

/// `value` if it is positive and finite, else the error that names it.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<f64, BuildError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(BuildError::Value {
            what,
            value,
            must: POSITIVE,
        })
    }
}

/// `value` if it is finite and not negative, else the error that names it.
pub(crate) fn not_negative(what: &'static str, value: f64) -> Result<f64, BuildError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(BuildError::Value {
            what,
            value,
            must: NOT_NEGATIVE,
        })
    }
}

/// `value` if it is positive, infinity included, else the error that names it.
pub(crate) fn positive_or_infinite(what: &'static str, value: f64) -> Result<f64, BuildError> {
    if value > 0.0 {
        Ok(value)
    } else {
        Err(BuildError::Value {
            what,
            value,
            must: POSITIVE_OR_INFINITE,
        })
    }
}
