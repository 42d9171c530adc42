//! Deformables and what holds them.

use super::super::check::{
    BODY, COUNT, DEFORMABLE, FINITE, LESS_THAN_ALL, Length, NOT_NEGATIVE, POINT, POSITIVE, SIZE,
    STRENGTH,
};
use super::super::decode::{Decode, Decoder};
use super::super::formula::Formula;
use super::super::limits::NODES;
use super::super::schema::{choice, record};
use super::super::tree::Node;
use super::material::{Made, SolidMaterial, SpringMaterial};
use super::rigid::{Groups, Rule};
use super::shape::{Mesh, file, named};
use super::world::{Scheme, Substepping};
use std::path::PathBuf;

/// What a formula of a region may name: a place in the body's own frame \[m\], and the corners of the body there.
pub(crate) const PLACE: [&str; 9] = [
    "x", "y", "z", "min_x", "min_y", "min_z", "max_x", "max_y", "max_z",
];

/// Which nodes are meant: a formula that is not 0 there.
#[derive(Clone, Debug, PartialEq)]
pub struct Region(pub Formula);

impl Decode for Region {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        d.formula_of(node, &PLACE).map(Self)
    }
}

impl serde::Serialize for Region {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.text())
    }
}

record! {
    /// A deformable body.
    pub struct Deformable {
        /// Its name.
        name: String;
        /// What it is made of: nodes and springs, or tets.
        body: Body;
        /// The material of its springs; of bodies with springs that have sections.
        material: Option<Made<SpringMaterial>> = None;
        /// Its springs, all alike, instead of a material; its nodes share its mass by their volumes.
        springs: Option<Alike> = None;
        /// The solid of its tets; of bodies of tets.
        solid: Option<Made<SolidMaterial>> = None;
        /// A finer surface in its own frame that its tets carry: it is drawn, and touches in their place.
        embed: Option<Mesh> = None;
        /// Other materials in parts of it; later ones win.
        parts: Vec<Part> = Vec::new(), Length { from: 0, to: 100 };
        /// Its whole mass \[kg\]; by volumes and densities if it is left out.
        mass: Option<f64> = None, POSITIVE;
        /// Which nodes are pinned: a formula of x, y, z.
        pin: Option<Region> = None;
        /// Where its own frame is \[m\].
        translation: [f64; 3] = [0.0; 3], POINT;
        /// Along which axes its lowest node is put where, instead of its frame \[m\]; None for the others.
        low: [Option<f64>; 3] = [None; 3], POINT;
        /// Along which axes its highest node is put where, instead of its frame \[m\]; None for the others.
        high: [Option<f64>; 3] = [None; 3], POINT;
        /// How its own frame is turned: an axis, as long as the angle \[rad\].
        rotation: [f64; 3] = [0.0; 3], FINITE;
        /// Velocity of its centre of mass \[m/s\].
        linvel: [f64; 3] = [0.0; 3], FINITE;
        /// Angular velocity about it \[rad/s\].
        angvel: [f64; 3] = [0.0; 3], FINITE;
        /// Coulomb's μ.
        friction: f64 = 0.5, NOT_NEGATIVE;
        /// How μ combines with that of what it touches.
        friction_rule: Rule = Rule::Average;
        /// Thickness of its surface \[m\]: of a sheet, the diameter of a rope.
        thickness: f64 = 0.0, NOT_NEGATIVE;
        /// Stiffness of its contacts per node \[N/m\]; contacts that do not give if it is left out.
        contact_stiffness: Option<f64> = None, POSITIVE;
        /// Which things it meets.
        groups: Groups = Groups::all();
        /// Which things push it.
        solver_groups: Groups = Groups::all();
        /// Its dominance group.
        dominance: i8 = 0;
        /// Whether it may fall asleep.
        can_sleep: bool = true;
        /// Factor on gravity.
        gravity_scale: f64 = 1.0, FINITE;
        /// D in the force −D·v on every node \[N·s/m\].
        drag: f64 = 0.0, NOT_NEGATIVE;
        /// Substeps of its own.
        substeps: Option<Substepping> = None;
        /// A scheme of its own.
        integrator: Option<Scheme> = None;
    }
    then fits
}

record! {
    /// Springs that are all alike, whatever their length and section.
    pub struct Alike {
        /// Stiffness \[N/m\].
        stiffness: f64, POSITIVE;
        /// Damping as a share of 2·√(k·m), m being the mass of the heaviest node.
        damping_ratio: f64 = 0.0, NOT_NEGATIVE;
    }
}

record! {
    /// Another material in a part of a body.
    pub struct Part {
        /// Where: a formula of x, y, z.
        at: Region;
        /// What.
        material: Made<SpringMaterial>;
    }
}

choice! {
    /// What a deformable is made of, in its own frame.
    pub enum Body {
        /// A box of springs about the origin, with Poisson's ratio ¼.
        Lattice {
            /// Its sides \[m\].
            size: [f64; 3], SIZE;
            /// Side of a cell \[m\].
            cell: f64, SIZE;
        };
        /// A sheet of springs in the plane y = 0 about the origin, with Poisson's ratio ⅓.
        Sheet {
            /// Its sides along x and z \[m\].
            size: [f64; 2], SIZE;
            /// Nodes along x and z.
            nodes: [usize; 2], COUNT;
            /// Thickness \[m\].
            thickness: f64, SIZE;
            /// Share of the stiffness in springs that keep it from folding.
            bending: f64 = 0.1, LESS_THAN_ALL;
        };
        /// A chain of springs.
        Rope {
            /// Its first node \[m\].
            from: [f64; 3], POINT;
            /// Its last node \[m\].
            to: [f64; 3], POINT;
            /// Springs.
            segments: usize, COUNT;
            /// Its section \[m²\].
            section: f64, POSITIVE;
        };
        /// A closed surface filled with cells of springs.
        Filled {
            /// The surface.
            mesh: Mesh;
            /// Side of a cell \[m\].
            cell: f64, SIZE;
        };
        /// Nodes and springs one by one.
        Net {
            /// The nodes.
            nodes: Vec<NodeSpec>, Length { from: 1, to: 1_000_000 };
            /// The springs.
            springs: Vec<SpringSpec> = Vec::new(), Length { from: 0, to: 1_000_000 };
            /// Triangles of nodes, counter-clockwise seen from outside.
            faces: Vec<[u32; 3]> = Vec::new(), Length { from: 0, to: 1_000_000 };
        };
        /// A box of tets about the origin.
        TetBox {
            /// Its sides \[m\].
            size: [f64; 3], SIZE;
            /// Side of a cell \[m\].
            cell: f64, SIZE;
            /// How cells are cut.
            split: Split = Split::Five;
            /// Whether tets have ten nodes.
            quadratic: bool = false;
        };
        /// A closed surface covered by tets.
        TetFilled {
            /// The surface.
            mesh: Mesh;
            /// Size of the tets \[m\].
            cell: f64, SIZE;
            /// Whether tets have ten nodes.
            quadratic: bool = false;
        };
        /// Tets of a Gmsh (.msh) or TetGen (.node and .ele) file, relative to the scene's own.
        TetMesh(TetFile);
    }
}

/// A file of tets.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(transparent)]
pub struct TetFile(pub PathBuf);

impl Decode for TetFile {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        let path = file(node, d, &["msh", "node"])?;
        let is_node = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("node"));
        if is_node {
            // What is read beside it must be allowed as well.
            let beside = path.with_extension("ele");
            let name = beside.file_name().unwrap_or_default().to_string_lossy();
            named(node, d, &path, &name)?;
        }
        Some(Self(path))
    }
}

choice! {
    /// How a cell of a box is cut into tets.
    pub enum Split {
        /// Five, mirrored from cell to cell.
        Five;
        /// Six around a diagonal.
        Six;
    }
}

record! {
    /// A node of a net.
    pub struct NodeSpec {
        /// Where it is \[m\].
        at: [f64; 3], POINT;
        /// Mass \[kg\].
        mass: f64, POSITIVE;
        /// Velocity beside that of the body \[m/s\].
        linvel: [f64; 3] = [0.0; 3], FINITE;
        /// Whether it is held.
        pinned: bool = false;
    }
}

record! {
    /// A spring of a net.
    pub struct SpringSpec {
        /// The two nodes, counted from 0.
        nodes: [u32; 2];
        /// Stiffness \[N/m\].
        stiffness: f64, POSITIVE;
        /// Damping \[N·s/m\].
        damping: f64 = 0.0, NOT_NEGATIVE;
        /// Length without force \[m\]; the distance of its nodes if it is left out.
        rest_length: Option<f64> = None, POSITIVE;
        /// Force at which it flows, either way \[N\]; inf for none.
        yield_force: f64 = f64::INFINITY, STRENGTH;
        /// Growth of that force per elongation \[N/m\].
        hardening: f64 = 0.0, NOT_NEGATIVE;
        /// Tension at which it breaks \[N\]; inf for never.
        break_force: f64 = f64::INFINITY, STRENGTH;
    }
}

record! {
    /// Nodes of a deformable that are followed: their mean place and velocity stand in its history.
    pub struct Set {
        /// Its name.
        name: String;
        /// The deformable.
        of: String, DEFORMABLE;
        /// Which nodes: a formula of x, y, z.
        nodes: Region;
    }
}

record! {
    /// What holds nodes of a deformable.
    pub struct Attachment {
        /// Its name.
        name: String;
        /// The deformable.
        of: String, DEFORMABLE;
        /// Which nodes: a formula of x, y, z.
        nodes: Region;
        /// The rigid body or the other deformable; the world if it is left out.
        to: Option<String> = None, BODY;
        /// How they are held.
        hold: Hold = Hold::Weld;
        /// Point of the world that a pin turns about and moments are taken about \[m\].
        at: Option<[f64; 3]> = None, FINITE;
        /// Force at which it breaks \[N\]; inf for never.
        strength: f64 = f64::INFINITY, STRENGTH;
        /// Moment at which it breaks \[N·m\]; inf for never.
        moment_strength: f64 = f64::INFINITY, STRENGTH;
    }
    then holds_another
}

fn holds_another(attachment: &Attachment, node: &Node, d: &mut Decoder) -> Option<()> {
    if attachment.to.as_ref() == Some(&attachment.of) {
        d.wrong(node.at, |_| {
            "a deformable can't be attached to itself".into()
        });
        return None;
    }
    Some(())
}

choice! {
    /// How nodes are held.
    pub enum Hold {
        /// Each where it is.
        Weld;
        /// Their centre of mass, free to turn.
        Pin;
        /// Each by a spring of no length.
        Link {
            /// Stiffness per node \[N/m\].
            stiffness: f64, POSITIVE;
            /// Damping per node \[N·s/m\].
            damping: f64 = 0.0, NOT_NEGATIVE;
        };
    }
}

/// Sizes before anything is allocated, indices, and the material that the body needs.
fn fits(body: &Deformable, node: &Node, d: &mut Decoder) -> Option<()> {
    let tets = body.body.has_tets();
    let both = (0..3).find(|i| body.low[*i].is_some() && body.high[*i].is_some());
    let net = matches!(body.body, Body::Net { .. });
    let complaint = match body.body.too_many() {
        Some(what) => what,
        None if both.is_some() => "`low` and `high` can't both be given along one axis".into(),
        None if tets && body.solid.is_none() => "bodies of tets need a `solid`".into(),
        None if tets && (body.material.is_some() || !body.parts.is_empty()) => {
            "bodies of tets have a `solid` instead of `material` and `parts`".into()
        }
        None if !tets && body.solid.is_some() => {
            "bodies of springs have a `material` instead of a `solid`".into()
        }
        None if !tets && body.embed.is_some() => "only bodies of tets can `embed` a surface".into(),
        None if body.springs.is_some() && (tets || net || body.material.is_some()) => {
            "only bodies of springs by sections have `springs`, instead of a `material`".into()
        }
        None if body.springs.is_some() && body.mass.is_none() => {
            "a body whose `springs` are alike needs a `mass`".into()
        }
        None if !tets && !net && body.material.is_none() && body.springs.is_none() => {
            "the springs of this body need a `material`".into()
        }
        None => return Some(()),
    };
    d.wrong(node.at, |_| complaint);
    None
}

impl Body {
    /// Whether it is of tets.
    pub(crate) fn has_tets(&self) -> bool {
        matches!(
            self,
            Self::TetBox { .. } | Self::TetFilled { .. } | Self::TetMesh(_)
        )
    }

    /// How many nodes it has at the most, as far as that is known before files are read.
    pub(crate) fn nodes(&self) -> Option<f64> {
        let cells = |size: &[f64; 3], cell: f64| {
            let counts = size.iter().map(|s| (s / cell).round().max(1.0) + 1.0);
            counts.product::<f64>()
        };
        // Nodes in the middles of edges are seven times as many as corners.
        let with_middles = |quadratic: bool| if quadratic { 8.0 } else { 1.0 };
        Some(match self {
            Self::Lattice { size, cell } => cells(size, *cell),
            Self::TetBox {
                size,
                cell,
                quadratic,
                ..
            } => cells(size, *cell) * with_middles(*quadratic),
            Self::Sheet { nodes, .. } => nodes[0] as f64 * nodes[1] as f64,
            Self::Rope { segments, .. } => *segments as f64 + 1.0,
            Self::Net { nodes, .. } => nodes.len() as f64,
            Self::Filled { mesh, cell } => cells_around(mesh.sides()?, *cell),
            Self::TetFilled {
                mesh,
                cell,
                quadratic,
            } => cells_around(mesh.sides()?, *cell) * with_middles(*quadratic),
            Self::TetMesh(_) => return None,
        })
    }

    /// What would be too many, by sizes alone, or an index that is none.
    fn too_many(&self) -> Option<String> {
        if let Self::Net {
            nodes,
            springs,
            faces,
        } = self
        {
            let count = nodes.len();
            let named = springs.iter().flat_map(|s| s.nodes);
            let mut named = named.chain(faces.iter().flatten().copied());
            let wrong = named.find(|n| *n as usize >= count)?;
            return Some(format!(
                "node {wrong} is named, but there are {count}, counted from 0"
            ));
        }
        let nodes = self.nodes().filter(|n| *n > NODES)?;
        Some(format!(
            "{nodes:.0} nodes are too many, at most {NODES} are possible"
        ))
    }
}

/// How many corners the cells around a box of these sides have at the most.
pub(crate) fn cells_around(sides: [f64; 3], cell: f64) -> f64 {
    sides.iter().map(|s| (s / cell).ceil() + 1.0).product()
}
