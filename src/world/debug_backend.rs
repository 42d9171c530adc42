//! Debug drawing through Rapier's own backends.

use super::{DebugStyle, DeformableWorld};
use rapier3d::dynamics::{RigidBodyBuilder, RigidBodyHandle};
use rapier3d::pipeline::{DebugRenderBackend, DebugRenderObject};

impl DeformableWorld {
    /// Draws all bodies through a backend made for Rapier's debug renderer.
    ///
    /// Rapier's list of what can be drawn knows no deformables. The backend is told of a rigid body with the invalid
    /// handle, at the deformable's centre of mass and with its `user_data`, once to be filtered and then with every line.
    pub fn debug_render(&self, style: &DebugStyle, backend: &mut impl DebugRenderBackend) {
        for (handle, body) in self.iter() {
            let stand_in = RigidBodyBuilder::fixed()
                .translation(crate::math::narrow(body.center_of_mass()))
                .user_data(body.user_data)
                .enabled(body.is_enabled())
                .build();
            let object = DebugRenderObject::RigidBody(RigidBodyHandle::invalid(), &stand_in);
            if backend.filter_object(object) {
                self.debug_body(handle, body, style, &mut |a, b, color| {
                    backend.draw_line(object, a, b, color);
                });
            }
        }
    }
}
