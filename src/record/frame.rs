//! One instant of a run, kept to be drawn later: skins with their strain, rigid shapes with their poses.
//!
//! Copied out of the worlds instead of drawn at once, so that a run is not slowed by drawing and the same frames may be
//! drawn from several sides.

use crate::math::{Pose, Real, Vector};
use crate::world::{DeformableHandle, DeformableWorld};
use rapier3d::dynamics::RigidBodySet;
use rapier3d::geometry::{ColliderHandle, ColliderSet, SharedShape};

/// A deformable at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameBody {
    /// Which.
    pub deformable: DeformableHandle,
    /// Skin vertices, or nodes where there is no skin \[m\].
    pub vertices: Vec<Vector>,
    /// Mean plastic strain at each of them \[1\]; of a solid its von Mises stress over E.
    pub strain: Vec<Real>,
    /// Triangles of the skin, or the net's faces.
    pub triangles: Vec<[u32; 3]>,
}

/// A collider at one instant.
#[derive(Clone)]
pub struct FrameCollider {
    /// Which.
    pub collider: ColliderHandle,
    /// Its shape.
    pub shape: SharedShape,
    /// Its pose.
    pub pose: Pose,
    /// Whether its body can move.
    pub dynamic: bool,
}

/// Everything that can be seen at one instant.
#[derive(Clone, Default)]
pub struct Frame {
    /// When \[s\].
    pub time: f64,
    /// The deformables.
    pub bodies: Vec<FrameBody>,
    /// The colliders.
    pub colliders: Vec<FrameCollider>,
}

impl Frame {
    /// The worlds as they are now.
    pub fn take(
        deformables: &DeformableWorld,
        bodies: &RigidBodySet,
        colliders: &ColliderSet,
    ) -> Self {
        let soft = deformables.iter().map(|(handle, body)| {
            let nodes = match body.solid() {
                None => body.node_plastic_strain(),
                Some(solid) => {
                    let over = |s: Real| (f64::from(s) / solid.young) as Real;
                    body.node_von_mises().into_iter().map(over).collect()
                }
            };
            let blueprint = body.blueprint();
            let (strain, triangles) = match &blueprint.skin {
                None => (nodes, body.whole_faces().collect()),
                Some(skin) => {
                    let of = skin.bindings.iter().map(|b| {
                        // Weights of a vertex outside its cell may be negative, strain may not.
                        let (mut sum, mut total) = (0.0, 0.0);
                        for (&n, w) in b.nodes.iter().zip(b.weights) {
                            sum += nodes[n as usize] * w.max(0.0);
                            total += w.max(0.0);
                        }
                        if total > 0.0 { sum / total } else { 0.0 }
                    });
                    (of.collect(), skin.triangles.clone())
                }
            };
            FrameBody {
                deformable: handle,
                vertices: body.skin_positions(),
                strain,
                triangles,
            }
        });
        let rigid = colliders.iter().map(|(handle, c)| {
            let parent = c.parent().and_then(|h| bodies.get(h));
            FrameCollider {
                collider: handle,
                shape: c.shared_shape().clone(),
                pose: *c.position(),
                dynamic: parent.is_some_and(|b| b.is_dynamic()),
            }
        });
        Self {
            time: deformables.time(),
            bodies: soft.collect(),
            colliders: rigid.collect(),
        }
    }
}
