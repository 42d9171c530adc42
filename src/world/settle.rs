//! Bodies that start at rest under their loads instead of swinging into it.

use super::Deformable;
use crate::math::{DVec3, Vector, wide};
use crate::solve::fem::Model;
use crate::solve::statics::{Load, SpringNet, StaticError, Statics, Structure};

/// Springs and tets of one body.
struct Body {
    springs: SpringNet,
    tets: Option<Model<f64>>,
}

impl Structure for Body {
    fn node_count(&self) -> usize {
        self.springs.node_count()
    }

    fn forces(&self, positions: &[DVec3], forces: &mut [DVec3]) -> f64 {
        let tets = self.tets.as_ref();
        let held = tets.map_or(0.0, |tets| Structure::forces(tets, positions, forces));
        held + self.springs.forces(positions, forces)
    }

    fn stiffness(&self, positions: &[DVec3], add: &mut dyn FnMut(u32, u32, [[f64; 3]; 3])) {
        if let Some(tets) = &self.tets {
            Structure::stiffness(tets, positions, add);
        }
        self.springs.stiffness(positions, add);
    }
}

impl Deformable {
    /// Puts every node where it rests, without velocity, under `gravity` \[m/s²\] and the forces on its nodes, held by its pinned
    /// nodes. Springs have the rest lengths to which they have flowed; contacts, attachments and force fields are
    /// not seen. What that changes in energy is external work. Returns the largest force left out of balance \[N\].
    ///
    /// ```
    /// use crumple::prelude::*;
    /// use crumple::rapier3d::prelude::*;
    /// use crumple::shape::{TetSplit, tet_box};
    /// let mesh = tet_box(Vector::new(2.0, 0.2, 0.2), 0.2, TetSplit::Six)?.quadratic();
    /// let mut beam = DeformableBuilder::tets(mesh, Solid::new(1.2e7, 0.0, 100.0))
    ///     .pin(|x| x.x < -0.99)
    ///     .build()?;
    /// beam.settle(Vector::new(0.0, -9.81, 0.0))?;
    /// let sag = -beam.bounds().0.y - 0.1;
    /// assert!((sag - 0.049442).abs() < 0.001);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Statics::solve`]: [`StaticError::Supports`] when what is pinned does not hold the body. The body is then as
    /// before.
    pub fn settle(&mut self, gravity: Vector) -> Result<f64, StaticError> {
        let at = |n: usize| self.state.local(n);
        let positions: Vec<DVec3> = (0..self.node_count()).map(at).collect();
        let particles = self.state.particles.iter();
        let fixed: Vec<[bool; 3]> = particles.map(|p| [p.inv_mass == 0.0; 3]).collect();
        let pull = wide(gravity * self.gravity_scale);
        let applied = |n: usize| self.node_forces.get(n).map_or(DVec3::ZERO, |f| wide(f.0));
        let forces: Vec<DVec3> = self
            .nodes_with_mass()
            .map(|(n, mass)| pull * mass + applied(n))
            .collect();
        let solid = self.blueprint.solid.as_deref();
        let body = Body {
            springs: SpringNet::of_state(&self.blueprint, &self.state),
            // The mesh was checked when the body was built.
            tets: solid.and_then(|s| Model::new(&s.mesh, s.solid).ok()),
        };
        let load = Load {
            positions: &positions,
            fixed: &fixed,
            forces: &forces,
        };
        let found = Statics::default().solve(&body, &load)?;
        self.edits += 1;
        self.edit(|body| {
            let origin = body.state.origin;
            for (n, x) in found.positions.iter().enumerate() {
                if body.state.particles[n].inv_mass > 0.0 {
                    body.state.set_position(n, origin + *x);
                    body.state.set_velocity(n, DVec3::ZERO);
                }
            }
        });
        Ok(found.residual)
    }
}
