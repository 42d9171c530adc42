//! A blueprint: the fixed part of a body, a net whose every constant has been resolved.

use super::error::positive;
use super::net::{Net, Node, Skin, Spring};
use super::state::State;
use super::{BuildError, Material, SolidMesh};
use crate::law::spring::of_section;
use crate::math::{Real, Vector};
use std::sync::Arc;

/// Topology and constants of a body. Nodes have their mass, springs their rest length and constants.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Blueprint {
    /// The nodes, in their rest configuration.
    pub nodes: Vec<Node>,
    /// The springs.
    pub springs: Vec<Spring>,
    /// Surface triangles.
    pub faces: Vec<[u32; 3]>,
    /// The surface for pictures, and for contact if it says so.
    pub skin: Option<Skin>,
    /// The tets over the nodes, if there are any.
    pub solid: Option<Arc<SolidMesh>>,
}

impl Blueprint {
    /// Resolves a net: `material_at` gives the material at a point of the rest configuration, `total_mass` \[kg\]
    /// rescales all masses.
    ///
    /// # Errors
    /// Every [`BuildError`] a net can have, a material out of range, and a node or spring whose constants stay unknown.
    pub fn resolve(
        net: Net,
        material_at: impl Fn(Vector) -> Option<Material>,
        total_mass: Option<Real>,
    ) -> Result<Self, BuildError> {
        net.check()?;
        let mut springs = net.springs.clone();
        for (id, spring) in springs.iter_mut().enumerate() {
            let length = spring.rest_length.unwrap_or_else(|| net.length(spring));
            spring.rest_length = Some(length);
            if spring.section > 0.0 {
                let [a, b] = spring.nodes;
                let middle =
                    (net.nodes[a as usize].position + net.nodes[b as usize].position) * 0.5;
                let material = material_at(middle).ok_or(BuildError::NoMaterial {
                    spring: id as u32,
                    section: spring.section,
                })?;
                material.check()?;
                apply(&material, spring, length);
            }
        }
        let mut nodes = net.nodes;
        for (id, node) in nodes.iter_mut().enumerate() {
            if node.mass == 0.0 {
                let density = material_at(node.position).map_or(
                    // A total mass alone shares itself by volume.
                    if total_mass.is_some() { 1.0 } else { 0.0 },
                    |m| m.density,
                );
                node.mass = density * node.volume;
            }
            weighed(id, node)?;
        }
        if let Some(total) = total_mass {
            positive("the total mass", total.into())?;
            let sum: f64 = nodes.iter().map(|n| f64::from(n.mass)).sum();
            for node in &mut nodes {
                node.mass = (f64::from(node.mass) * f64::from(total) / sum) as Real;
            }
            for (id, node) in nodes.iter().enumerate() {
                weighed(id, node)?;
            }
        }
        Ok(Self {
            nodes,
            springs,
            faces: net.faces,
            skin: net.skin,
            solid: None,
        })
    }

    /// The state at rest: no flow, nothing broken, the nodes' own velocities.
    pub fn rest_state(&self) -> State<Real> {
        let mut state = State::new(
            self.nodes.iter().map(|n| {
                let inv_mass = if n.pinned { 0.0 } else { 1.0 / n.mass };
                (n.position.to_array(), n.linvel.to_array(), inv_mass)
            }),
            self.springs.iter().map(|s| s.rest_length.unwrap_or(0.0)),
        );
        // The digits of a mesh that `f32` does not have.
        for (i, x) in self
            .solid
            .iter()
            .flat_map(|s| s.mesh.nodes.iter().enumerate())
        {
            state.set_position(i, *x);
        }
        state
    }
}

/// The solver needs 1/m, which a subnormal mass does not have.
fn weighed(id: usize, node: &Node) -> Result<(), BuildError> {
    if node.mass.is_normal() && node.mass > 0.0 {
        Ok(())
    } else {
        Err(BuildError::Massless { node: id as u32 })
    }
}

/// Gives a spring what its material makes of its section, but for limits and damping that it was given itself.
fn apply(material: &Material, spring: &mut Spring, length: Real) {
    let section = spring.section;
    let of_length = |per_strain| of_section(per_strain, section, length);
    spring.stiffness = of_length(material.young);
    if spring.damping == 0.0 {
        spring.damping = of_length(material.viscosity);
    }
    if spring.yield_tension.is_infinite() && spring.yield_compression.is_infinite() {
        spring.yield_tension = material.yield_tension * section;
        spring.yield_compression = material.yield_compression * section;
        spring.hardening = of_length(material.hardening);
    }
    if spring.break_force.is_infinite() {
        spring.break_force = material.strength * section;
    }
    if spring.break_strain.is_infinite() {
        spring.break_strain = material.break_strain;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape;

    /// Symptom: springs of a sheet that were given a break force never broke. Cause: the material's strength took its place.
    #[test]
    fn what_a_spring_was_given_it_keeps() {
        let mut net = shape::rope(Vector::ZERO, Vector::X * 5.0, 5, 1e-4).unwrap();
        let material = Material {
            strength: 1e6,
            break_strain: 0.3,
            ..Material::elastic(1e6, 500.0).viscosity(1e3)
        };
        net.springs[1] = net.springs[1].breaking(5.0).damping(2.0);
        net.springs[2] = net.springs[2].yielding(3.0, 7.0);
        net.springs[3].break_strain = 0.1;
        let springs = Blueprint::resolve(net, |_| Some(material), None).unwrap();
        let [first, broken, flowing, brittle, _] = springs.springs[..] else {
            panic!("five springs");
        };
        assert_eq!((broken.break_force, broken.damping), (5.0, 2.0));
        let flow = |s: &Spring| (s.yield_tension, s.yield_compression, s.hardening);
        assert_eq!(flow(&flowing), (3.0, 3.0, 7.0));
        assert_eq!(brittle.break_strain, 0.1);
        for other in [&flowing, &brittle] {
            assert_eq!(other.break_force, first.break_force);
            assert_eq!(other.damping, first.damping);
        }
        assert_eq!(flow(&first), flow(&brittle));
        assert_eq!(broken.break_strain, 0.3);
        for spring in [first, broken, flowing, brittle] {
            assert_eq!(spring.stiffness, first.stiffness);
        }
    }
}
