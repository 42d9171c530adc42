//! Where a picture is taken from: a pinhole, and the one light that travels with it.
//!
//! The light hangs over the camera's left shoulder, so that whatever side of a wreck is looked at is lit, its shadow falls
//! away from the viewer, and pictures from different sides can be compared.

use crate::math::{Real, Vector};

/// A perspective camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands \[m\].
    pub eye: Vector,
    /// What it looks at, the middle of the picture \[m\].
    pub target: Vector,
    /// The direction that is up in the picture; any length, not along the view.
    pub up: Vector,
    /// Vertical angle of view \[rad\], between 0 and π.
    pub fov_y: Real,
}

impl Camera {
    /// A camera at `eye` looking at `target` with +y up and a vertical angle of 0.6 rad (34°).
    pub fn new(eye: Vector, target: Vector) -> Self {
        Self {
            eye,
            target,
            up: Vector::Y,
            fov_y: 0.6,
        }
    }

    /// A camera that looks along −`from` and stands as close as shows the whole box from `low` to `high` \[m\] in a picture of
    /// `aspect` = width/height, with a margin of about a tenth.
    pub fn framing(low: Vector, high: Vector, from: Vector, aspect: Real) -> Self {
        let target = 0.5 * (low + high);
        let from = from.try_normalize().unwrap_or(Vector::Z);
        let mut camera = Self::new(target + from, target);
        let Some(view) = View::new(&camera, [1.0, 1.0]) else {
            return camera;
        };
        let half = 0.9 * (0.5 * camera.fov_y).tan();
        let room = [half * aspect.max(0.01), half];
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|corner| {
            let side = |bit: u32, a: Real, b: Real| if corner & (1 << bit) == 0 { a } else { b };
            let p = Vector::new(
                side(0, low.x, high.x),
                side(1, low.y, high.y),
                side(2, low.z, high.z),
            ) - target;
            [p.dot(view.right), p.dot(view.up), p.dot(view.forward)]
        });
        let (mut distance, mut offset) = (2.0 * (high - low).length().max(1.0e-3), [0.0; 2]);
        // The middle of what is seen depends on the distance and the other way round; a few rounds settle both.
        for _ in 0..20 {
            let mut needed = Real::NEG_INFINITY;
            for k in 0..2 {
                let at =
                    |c: &[Real; 3]| (c[k] - offset[k]) / (distance + c[2]).max(1.0e-3 * distance);
                let [least, most] = [Real::min as fn(Real, Real) -> Real, Real::max]
                    .map(|f| corners.iter().map(at).fold(at(&corners[0]), f));
                offset[k] += 0.5 * (least + most) * distance;
                let reach = |c: &[Real; 3]| (c[k] - offset[k]).abs() / room[k] - c[2];
                needed = corners.iter().map(reach).fold(needed, Real::max);
            }
            distance = needed.max(1.0e-3);
        }
        let target = target + view.right * offset[0] + view.up * offset[1];
        camera.target = target;
        camera.eye = target + distance * from;
        camera
    }
}

/// A camera worked out for a picture's size.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub eye: Vector,
    pub right: Vector,
    pub up: Vector,
    pub forward: Vector,
    /// Pixels per unit of tangent.
    pub focal: Real,
    /// The middle of the picture \[pixels\].
    pub center: [Real; 2],
    /// Nothing nearer than this is drawn \[m\].
    pub near: Real,
    /// Towards the light.
    pub light: Vector,
}

impl View {
    /// `None` for a camera that looks nowhere: not finite, or without an angle or a direction.
    pub fn new(camera: &Camera, size: [Real; 2]) -> Option<Self> {
        let along = camera.target - camera.eye;
        let forward = along.try_normalize()?;
        let right = forward.cross(camera.up).try_normalize();
        let right = right.unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let half = (0.5 * camera.fov_y).tan();
        if !(camera.eye.is_finite() && right.is_finite() && half > 0.0 && half.is_finite()) {
            return None;
        }
        let sky = camera.up.try_normalize().unwrap_or(up);
        let back = (-forward + sky * forward.dot(sky)).try_normalize();
        let light = 0.85 * sky - 0.5 * right + 0.5 * back.unwrap_or(up);
        Some(Self {
            eye: camera.eye,
            right,
            up,
            forward,
            focal: 0.5 * size[1] / half,
            center: [0.5 * size[0], 0.5 * size[1]],
            near: 1.0e-3 * along.length(),
            light: light.try_normalize().unwrap_or(sky),
        })
    }

    /// Right, up and forward of the eye \[m\].
    pub fn local(&self, p: Vector) -> Vector {
        let d = p - self.eye;
        Vector::new(d.dot(self.right), d.dot(self.up), d.dot(self.forward))
    }

    /// Column, row \[pixels\] and 1/distance of a point in front of the near plane, from [`local`](Self::local) coordinates.
    pub fn project(&self, local: Vector) -> [Real; 3] {
        let w = 1.0 / local.z;
        let scale = self.focal * w;
        [
            self.center[0] + local.x * scale,
            self.center[1] - local.y * scale,
            w,
        ]
    }

    /// The direction through a point of the picture \[pixels\]; its part along `forward` is 1.
    pub fn ray(&self, x: Real, y: Real) -> Vector {
        let [x, y] = [x - self.center[0], self.center[1] - y];
        self.forward + (self.right * x + self.up * y) / self.focal
    }
}
