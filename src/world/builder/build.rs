//! How a body comes about: values are checked, materials and masses found, and the body put in its place.

use super::{DeformableBuilder, Region, SkinUse};
use crate::body::error::not_negative;
use crate::body::{
    Blueprint, BuildError, Embedded, Material, Net, Node, SolidMesh, State, Topology,
};
use crate::contact::target::wide_rotation;
use crate::math::{DVec3, Real, Vector, narrow, wide};
use crate::solve::Solver;
use crate::solve::fem::{Model, Part};
use crate::world::Deformable;
use crate::world::sleep::Sleep;
use std::sync::Arc;

impl DeformableBuilder {
    /// Resolves materials and masses and places the body.
    ///
    /// # Errors
    /// Everything a [`BuildError`] can say of nets, materials and values. Whether the body is stable within its budget is
    /// checked at insertion into a world, which knows the default scheme.
    pub fn build(mut self) -> Result<Deformable, BuildError> {
        self.check()?;
        let (mut net, model) = self.mesh()?;
        self.give_skin(&mut net)?;
        let materials = |p: Vector| material_at(&self.regions, self.material, p);
        let mut blueprint = Blueprint::resolve(net, materials, self.total_mass)?;
        blueprint.solid = self.solid.take().map(Arc::new);
        let embedded = Embedded::of(&blueprint);
        let touching = embedded.as_ref().map_or(&blueprint, |e| &e.blueprint);
        self.surface.check_thickness(touching)?;
        let state = self.placed(&blueprint);
        let mut solver = Solver::new(&blueprint.springs, &state);
        if let Some(model) = model {
            let masses: Vec<f64> = blueprint.nodes.iter().map(|n| n.mass.into()).collect();
            solver = solver.with_elements(Part::new(Arc::new(model), &masses));
        }
        solver.external.drag = self.drag;
        let mut body = Deformable {
            slots: vec![u32::MAX; state.particles.len()],
            backup: state.clone(),
            topology: Arc::new(Topology::of(&blueprint)),
            embedded,
            blueprint,
            state,
            solver,
            surface: self.surface,
            gravity_scale: self.gravity_scale,
            integrator: self.integrator,
            substeps: self.substeps,
            field: self.field,
            enabled: self.enabled,
            sleep: Sleep::new(self.can_sleep),
            user_data: self.user_data,
            ..Deformable::default()
        };
        body.set_going(wide(self.linvel), wide(self.angvel));
        body.datum = body.center_of_mass();
        body.moment = body.moment_of(0..body.node_count());
        body.follow();
        Ok(body)
    }

    /// Whether all values are what they may be.
    fn check(&self) -> Result<(), BuildError> {
        for (what, v) in [
            ("the translation", self.pose.translation),
            ("the velocity", self.linvel),
            ("the angular velocity", self.angvel),
        ] {
            if let Some(value) = v.to_array().into_iter().find(|c| !c.is_finite()) {
                return Err(BuildError::Value {
                    what,
                    value: value.into(),
                    must: "finite",
                });
            }
        }
        self.surface.check()?;
        not_negative("the drag", self.drag.into())?;
        if !self.gravity_scale.is_finite() {
            return Err(BuildError::Value {
                what: "the gravity scale",
                value: self.gravity_scale.into(),
                must: "finite",
            });
        }
        if !wide_rotation(self.pose.rotation).is_finite() {
            return Err(BuildError::Value {
                what: "the length of the rotation's quaternion",
                value: self.pose.rotation.length().into(),
                must: "positive and finite",
            });
        }
        if let Some(substeps) = self.substeps {
            substeps.check()?;
        }
        self.material.iter().try_for_each(Material::check)?;
        for (region, (_, material)) in self.regions.iter().enumerate() {
            let refused = |error| BuildError::Region {
                region,
                refused: Box::new(error),
            };
            material.check().map_err(refused)?;
        }
        Ok(())
    }

    /// The net with its pinned nodes, that of a solid from its mesh, and the elements of that.
    fn mesh(&mut self) -> Result<(Net, Option<Model<Real>>), BuildError> {
        let mut net = std::mem::replace(&mut self.net, Ok(Net::default()))?;
        let model = match &self.solid {
            Some(_) if self.material.is_some() || !self.regions.is_empty() => {
                return Err(BuildError::MaterialForTets);
            }
            Some(solid) => Some(elements(solid, &mut net)?),
            None => None,
        };
        for pins in &self.pins {
            net = net.pin(|x| pins(x));
        }
        Ok((net, model))
    }

    /// Gives a net the skin that is to touch.
    fn give_skin(&mut self, net: &mut Net) -> Result<(), BuildError> {
        match (&self.skin, &self.solid) {
            (SkinUse::Drawn, _) => {}
            (SkinUse::Touches, _) => net.skin.as_mut().ok_or(BuildError::NoSkin)?.touches = true,
            (SkinUse::Embedded(surface), Some(solid)) => {
                net.skin = Some(solid.mesh.bind(surface)?);
            }
            (SkinUse::Embedded(_), None) => return Err(BuildError::SkinWithoutTets),
        }
        Ok(())
    }

    /// The nodes at rest in their place, with the velocities of the net.
    fn placed(&self, blueprint: &Blueprint) -> State<Real> {
        let mut state = blueprint.rest_state();
        let turn = wide_rotation(self.pose.rotation);
        state.origin = wide(self.pose.translation);
        for i in 0..state.particles.len() {
            let (x, v) = (state.local(i), state.velocity(i));
            state.set_position(i, state.origin + turn * x);
            state.set_velocity(i, turn * v);
        }
        state.recentre(0.0);
        state
    }
}

impl Deformable {
    /// Adds the velocity of a rigid body about its centre of mass to all nodes but pinned ones, which stand still.
    fn set_going(&mut self, linvel: DVec3, angvel: DVec3) {
        let com = self.center_of_mass();
        for i in 0..self.node_count() {
            let v = if self.state.particles[i].inv_mass > 0.0 {
                let arm = self.state.position(i) - com;
                self.state.velocity(i) + (linvel + angvel.cross(arm))
            } else {
                DVec3::ZERO
            };
            self.state.set_velocity(i, v);
        }
    }
}

/// The material of a place: that of the last region around it, or that of the body.
fn material_at(
    regions: &[(Region, Material)],
    material: Option<Material>,
    p: Vector,
) -> Option<Material> {
    let found = regions.iter().rev().find(|(inside, _)| inside(p));
    found.map(|(_, m)| *m).or(material)
}

/// The elements of a solid, their nodes and faces put into a net.
fn elements(solid: &SolidMesh, net: &mut Net) -> Result<Model<Real>, BuildError> {
    let model = Model::new(&solid.mesh, solid.solid)?;
    let node = |(x, mass): (&DVec3, f64)| Node::new(narrow(*x), mass as Real);
    net.nodes = solid
        .mesh
        .nodes
        .iter()
        .zip(model.masses())
        .map(node)
        .collect();
    net.faces = solid.mesh.faces.clone();
    Ok(model)
}
