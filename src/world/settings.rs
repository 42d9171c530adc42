//! Settings of a body that may change between steps: what of gravity and drag acts on it, and how it is stepped.

use super::Deformable;
use super::params::Substeps;
use crate::body::BuildError;
use crate::math::Real;
use crate::solve::Integrator;

impl Deformable {
    /// Factor on the world's gravity.
    pub fn gravity_scale(&self) -> Real {
        self.gravity_scale
    }

    /// Sets the factor on the world's gravity, from the next step on. A factor that is not finite changes nothing: `false`.
    pub fn set_gravity_scale(&mut self, scale: Real) -> bool {
        let ok = scale.is_finite();
        if ok && scale != self.gravity_scale {
            self.gravity_scale = scale;
            self.wake_up();
        }
        ok
    }

    /// D in the force −D·v on every node \[N·s/m\].
    pub fn drag(&self) -> Real {
        self.solver.external.drag
    }

    /// Sets D in the force −D·v on every node \[N·s/m\].
    ///
    /// # Errors
    /// A drag that is negative or not finite, or one that needs substeps shorter than the budget; the body is then as
    /// before.
    pub fn set_drag(&mut self, drag: Real) -> Result<(), BuildError> {
        crate::body::error::not_negative("the drag", drag.into())?;
        self.try_edit(|body| body.solver.external.drag = drag)
    }

    /// Gives the body a scheme of its own; `None` for the world's.
    ///
    /// # Errors
    /// A scheme that is not stable within the budget; the body is then as before.
    pub fn set_integrator(&mut self, integrator: Option<Integrator>) -> Result<(), BuildError> {
        self.try_edit(|body| body.integrator = integrator)
    }

    /// Gives the body substeps of its own; `None` for the world's.
    ///
    /// # Errors
    /// Numbers out of range, or substeps that are too long for the body; it is then as before.
    pub fn set_substeps(&mut self, substeps: Option<Substeps>) -> Result<(), BuildError> {
        self.try_edit(|body| body.substeps = substeps)
    }

    /// Changes settings of the step, unless the body would then be unstable.
    fn try_edit(&mut self, change: impl FnOnce(&mut Self)) -> Result<(), BuildError> {
        let before = (
            self.solver.external.drag,
            self.integrator,
            self.substeps,
            self.solver.work,
        );
        self.edit(change);
        self.check_changed().inspect_err(|_| {
            let work;
            (
                self.solver.external.drag,
                self.integrator,
                self.substeps,
                work,
            ) = before;
            self.solver.work = work;
        })
    }
}
