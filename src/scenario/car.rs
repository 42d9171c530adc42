//! The car of the crash scenes: the hatchback filled with cells, and what it is made of.
//!
//! A car is a folded shell, and a lattice of 0.1 m cells has no folds: its springs stand for the shell's crush behaviour
//! smeared over its volume. Three numbers of a full-width barrier test fix that smeared solid. The front must hold about
//! 200 kN over its 1.1 m² when it begins to fold and rise by half until it is as short as it gets, so that ½mv² is used up
//! on 0.6 m. A lattice squeezed along an edge carries about 2·σ_y when it begins to flow (edges .4, face diagonals 1.6),
//! and as its diagonals turn away from the load it would weaken and let one layer after the other go flat; a plastic
//! modulus of some 8·σ_y outweighs that and stands for sheets that meet as they fold. The cabin is a cage: ten times as
//! strong, and stiff. The unloading stiffness, hence the rebound, comes from E; the viscosity is the rate dependence of
//! sheet steel, which at a mean rate of 15 /s adds some 20 % to its flow stress (Cowper–Symonds with 40.4 /s and 5 would
//! even say 80 %, at the rates of the folds themselves).

use super::SceneError;
use crate::body::{Material, Net, NodeId};
use crate::import::hatchback;
use crate::math::{Real, Vector};
use crate::shape::filled;
use crate::world::DeformableBuilder;
use rapier3d::geometry::{Group, InteractionGroups, InteractionTestMode};
use std::ops::Range;

/// Mass of the whole car with its engine \[kg\].
pub const MASS: f64 = 1300.0;
/// Mass of the engine block \[kg\].
pub const ENGINE_MASS: f64 = 200.0;
/// Half the sides of the engine block \[m\].
pub const ENGINE_HALF: Vector = Vector::new(0.20, 0.18, 0.30);
/// Middle of the engine block in the car's frame \[m\]: over the front axle, as in any car with a transverse engine.
pub const ENGINE_AT: Vector = Vector::new(1.20, 0.58, 0.0);
/// The group that the engine's collider is in; the car's own nodes ignore it, because they carry the engine and some of
/// them are inside it.
pub const ENGINE_GROUP: Group = Group::GROUP_2;

/// Wheels: axles along x, height of the axles, radius with some room, inner face \[m\].
const AXLES: [Real; 2] = [1.30, -1.26];
const WHEEL: [Real; 3] = [0.31, 0.36, 0.60];
/// Where the crumple zone ends and where the cabin begins, along x \[m\].
const CRUMPLE_END: Real = 0.95;
const CABIN_FROM: Real = 0.70;

/// The folding front: some 65 kPa per spring section make 130 kPa of the lattice when it begins to flow.
pub fn front() -> Material {
    Material::elastic(20.0e6, 180.0)
        .yielding(65.0e3, 520.0e3)
        .viscosity(2.0e3)
}

/// The cage around the people.
pub fn cabin() -> Material {
    Material::elastic(40.0e6, 180.0)
        .yielding(600.0e3, 1.2e6)
        .viscosity(4.0e3)
}

/// The firewall: between the two.
pub fn firewall() -> Material {
    Material::elastic(28.0e6, 180.0)
        .yielding(200.0e3, 800.0e3)
        .viscosity(2.8e3)
}

/// Wheels and what they hang on: they carry the car, and are the last of a front to give way.
pub fn wheels() -> Material {
    Material::elastic(30.0e6, 180.0)
        .yielding(400.0e3, 800.0e3)
        .viscosity(3.0e3)
}

fn in_wheel(p: Vector) -> bool {
    let near = |x: Real| (p.x - x).hypot(p.y - WHEEL[0]) < WHEEL[1];
    p.z.abs() > WHEEL[2] && AXLES.into_iter().any(near)
}

/// The car before it enters a world.
pub struct Car {
    /// The builder: materials, mass and collision groups are set, place and speed are not.
    pub builder: DeformableBuilder,
    /// Its net, in its own frame: x forward, y up.
    pub net: Net,
    /// Groups of its skin triangles.
    pub parts: Vec<(String, Range<usize>)>,
}

impl Car {
    /// The car of cells of side `cell` \[m\].
    ///
    /// # Errors
    /// Those of the filling: a cell so large that nothing is inside.
    pub fn new(cell: f64) -> Result<Self, SceneError> {
        let surface = hatchback()?;
        let net = filled(&surface, cell as Real)?;
        let groups =
            InteractionGroups::new(Group::GROUP_1, !ENGINE_GROUP, InteractionTestMode::And);
        let builder = DeformableBuilder::new(net.clone())
            .material(cabin())
            .material_where(|p| p.x > CABIN_FROM, firewall())
            .material_where(|p| p.x > CRUMPLE_END, front())
            .material_where(in_wheel, wheels())
            .total_mass((MASS - ENGINE_MASS) as Real)
            .collision_groups(groups);
        let parts = surface.groups.into_iter().map(|g| (g.name, g.triangles));
        Ok(Self {
            builder,
            net,
            parts: parts.collect(),
        })
    }

    /// The nodes at which `inside` holds, in the car's own frame.
    pub fn nodes(&self, inside: impl Fn(Vector) -> bool) -> Vec<NodeId> {
        let all = self.net.nodes.iter().enumerate();
        all.filter(|(_, n)| inside(n.position))
            .map(|(i, _)| NodeId(i as u32))
            .collect()
    }

    /// The nodes that carry the engine: those inside the block and those half a cell around it.
    pub fn engine_nodes(&self, cell: f64) -> Vec<NodeId> {
        let reach = ENGINE_HALF + Vector::splat(0.5 * cell as Real);
        self.nodes(|p| (p - ENGINE_AT).abs().cmple(reach).all())
    }

    /// The cabin's nodes: the slice of the body at the B-pillars, from sill to waist, where a crash test has its
    /// accelerometers.
    pub fn cabin_nodes(&self) -> Vec<NodeId> {
        self.nodes(|p| (-0.65..=-0.15).contains(&p.x) && p.y < 1.0)
    }
}
