//! The builder: a net with materials or a solid of tets, and how the body enters the world.

mod build;

use super::into::{IntoNet, IntoTetMesh};
use super::params::Substeps;
use crate::body::{self, BuildError, Material, Net, Solid, SolidMesh};
use crate::contact::target::SurfaceProperties;
use crate::math::{Pose, Real, Rotation, Vector};
use crate::solve::Integrator;
use crate::solve::external::ForceField;
use rapier3d::dynamics::CoefficientCombineRule;
use rapier3d::geometry::InteractionGroups;
use std::sync::Arc;

/// What the skin of a body is for.
#[derive(Clone, Debug)]
enum SkinUse {
    /// Pictures.
    Drawn,
    /// That of the net touches others.
    Touches,
    /// This one does, bound to the mesh of tets.
    Embedded(body::Surface),
}

type Region = Arc<dyn Fn(Vector) -> bool + Send + Sync>;

/// Builds a [`Deformable`](super::Deformable).
///
/// ```
/// use crumple::prelude::*;
/// use crumple::rapier3d::prelude::*;
/// let net = lattice(Vector::new(1.0, 0.5, 0.5), 0.1)?;
/// let body = DeformableBuilder::new(net)
///     .material(Material::rubber())
///     .translation(Vector::new(0.0, 2.0, 0.0))
///     .friction(0.8)
///     .build()?;
/// assert!((body.mass() - 0.25 * 930.0).abs() < 0.1);
/// # Ok::<(), crumple::body::BuildError>(())
/// ```
#[derive(Clone)]
#[must_use]
pub struct DeformableBuilder {
    net: Result<Net, BuildError>,
    solid: Option<SolidMesh>,
    skin: SkinUse,
    pins: Vec<Region>,
    material: Option<Material>,
    regions: Vec<(Region, Material)>,
    total_mass: Option<Real>,
    pose: Pose,
    linvel: Vector,
    angvel: Vector,
    surface: SurfaceProperties,
    gravity_scale: Real,
    drag: Real,
    integrator: Option<Integrator>,
    substeps: Option<Substeps>,
    field: Option<Arc<dyn ForceField>>,
    enabled: bool,
    can_sleep: bool,
    user_data: u128,
}

impl DeformableBuilder {
    /// A body of this net; the result of a shape function may be passed as it is, its error comes out of `build`.
    pub fn new(net: impl IntoNet) -> Self {
        Self {
            net: net.into_net(),
            solid: None,
            skin: SkinUse::Drawn,
            pins: Vec::new(),
            material: None,
            regions: Vec::new(),
            total_mass: None,
            pose: Pose::IDENTITY,
            linvel: Vector::ZERO,
            angvel: Vector::ZERO,
            surface: SurfaceProperties::default(),
            gravity_scale: 1.0,
            drag: 0.0,
            integrator: None,
            substeps: None,
            field: None,
            enabled: true,
            can_sleep: true,
            user_data: 0,
        }
    }

    /// A body of finite elements: this mesh made of this solid. The result of a shape function may be passed as it is.
    /// The surface, with the middle nodes of quadratic tets, is what touches others.
    ///
    /// ```
    /// use crumple::prelude::*;
    /// use crumple::rapier3d::prelude::*;
    /// use crumple::shape::{TetSplit, tet_box};
    /// let rubber = Solid::new(2.0e6, 0.45, 1100.0).law(SolidLaw::NeoHookean);
    /// let mesh = tet_box(Vector::new(0.4, 0.1, 0.1), 0.05, TetSplit::Six)?;
    /// let body = DeformableBuilder::tets(mesh.quadratic(), rubber)
    ///     .pin(|x| x.x < -0.199)
    ///     .build()?;
    /// assert_eq!(body.tet_count(), 8 * 2 * 2 * 6);
    /// assert!((body.mass() - 4.4).abs() < 1e-4);
    /// # Ok::<(), crumple::body::BuildError>(())
    /// ```
    pub fn tets(mesh: impl IntoTetMesh, solid: Solid) -> Self {
        match mesh.into_tet_mesh() {
            Ok(mesh) => Self {
                solid: Some(SolidMesh { mesh, solid }),
                ..Self::new(Net::default())
            },
            Err(error) => Self::new(Err(error)),
        }
    }

    /// A finer surface that a mesh of tets carries: it is drawn, and touches others, in the place of the mesh's own surface. What
    /// pushes it pushes the nodes of the tets it is bound to. The mesh should fill the surface, and may stand out of it.
    /// Rays and other queries, sensors and attachments see the mesh.
    ///
    /// ```
    /// use crumple::body::Surface;
    /// use crumple::prelude::*;
    /// use crumple::rapier3d::prelude::*;
    /// use crumple::shape::{TetSplit, tet_box};
    /// // A ball of 1,200 triangles in a box of 40 tets.
    /// let (vertices, triangles) = Ball::new(0.5).to_trimesh(24, 24);
    /// let mesh = tet_box(Vector::splat(1.0), 0.5, TetSplit::Five)?;
    /// let body = DeformableBuilder::tets(mesh, Solid::new(1.0e6, 0.3, 900.0))
    ///     .embed(Surface::new(vertices, triangles))
    ///     .build()?;
    /// assert_eq!(body.node_count(), 27);
    /// assert!(body.skin_positions().len() > 500);
    /// # Ok::<(), crumple::body::BuildError>(())
    /// ```
    pub fn embed(mut self, surface: body::Surface) -> Self {
        self.skin = SkinUse::Embedded(surface);
        self
    }

    /// Lets the skin that a net has for pictures touch others, in the place of its nodes, as that of
    /// [`Self::embed`], which does so anyway. The net of a [filled surface](crate::shape::filled) has one.
    pub fn touch_by_skin(mut self) -> Self {
        if !matches!(self.skin, SkinUse::Embedded(_)) {
            self.skin = SkinUse::Touches;
        }
        self
    }

    /// Pins the nodes whose place in the body's own frame satisfies `which`.
    pub fn pin(mut self, which: impl Fn(Vector) -> bool + Send + Sync + 'static) -> Self {
        self.pins.push(Arc::new(which));
        self
    }

    /// The material of all springs that have a section, and of all nodes that have a volume.
    pub fn material(mut self, material: Material) -> Self {
        self.material = Some(material);
        self
    }

    /// Another material where `region` holds, at points of the net's own frame; later regions win.
    pub fn material_where(
        mut self,
        region: impl Fn(Vector) -> bool + Send + Sync + 'static,
        material: Material,
    ) -> Self {
        self.regions.push((Arc::new(region), material));
        self
    }

    /// Rescales all masses to this total \[kg\].
    pub fn total_mass(mut self, mass: Real) -> Self {
        self.total_mass = Some(mass);
        self
    }

    /// Where the net's frame stands in the world \[m\].
    pub fn translation(mut self, translation: Vector) -> Self {
        self.pose.translation = translation;
        self
    }

    /// How the net's frame is turned.
    pub fn rotation(mut self, rotation: Rotation) -> Self {
        self.pose.rotation = rotation;
        self
    }

    /// Velocity of the centre of mass at insertion \[m/s\].
    pub fn linvel(mut self, linvel: Vector) -> Self {
        self.linvel = linvel;
        self
    }

    /// Angular velocity at insertion \[rad/s\].
    pub fn angvel(mut self, angvel: Vector) -> Self {
        self.angvel = angvel;
        self
    }

    /// Coulomb's μ of its surface.
    pub fn friction(mut self, friction: Real) -> Self {
        self.surface.friction = friction;
        self
    }

    /// How μ combines with a collider's.
    pub fn friction_combine_rule(mut self, rule: CoefficientCombineRule) -> Self {
        self.surface.friction_combine_rule = rule;
        self
    }

    /// Distance that its surface and what touches it keep, doubled \[m\], see [`SurfaceProperties::thickness`].
    pub fn thickness(mut self, thickness: Real) -> Self {
        self.surface.thickness = thickness;
        self
    }

    /// Which colliders and other deformables it meets.
    pub fn collision_groups(mut self, groups: InteractionGroups) -> Self {
        self.surface.collision_groups = groups;
        self
    }

    /// Mean force of a collider over a step above which an event tells of it \[N\].
    pub fn contact_force_event_threshold(mut self, threshold: Real) -> Self {
        self.surface.contact_force_event_threshold = Some(threshold);
        self
    }

    /// Which colliders push back; those of no agreement are only noticed.
    pub fn solver_groups(mut self, groups: InteractionGroups) -> Self {
        self.surface.solver_groups = groups;
        self
    }

    /// Stiffness of its contacts \[N/m\] per node, instead of contacts that do not give: springs without damping, which give
    /// back what they took. What they hold meanwhile is booked as [`contact_normal`](crate::solve::work::Work::contact_normal).
    pub fn contact_stiffness(mut self, stiffness: Real) -> Self {
        self.surface.stiffness = Some(stiffness);
        self
    }

    /// Its dominance group, as of Rapier's bodies: those of a higher group push it and feel nothing.
    pub fn dominance_group(mut self, group: i8) -> Self {
        self.surface.dominance_group = group;
        self
    }

    /// Factor on the world's gravity.
    pub fn gravity_scale(mut self, scale: Real) -> Self {
        self.gravity_scale = scale;
        self
    }

    /// D in the force −D·v on every node \[N·s/m\], the textbook's damping.
    pub fn drag(mut self, drag: Real) -> Self {
        self.drag = drag;
        self
    }

    /// A scheme of its own.
    pub fn integrator(mut self, integrator: Integrator) -> Self {
        self.integrator = Some(integrator);
        self
    }

    /// Substeps of its own.
    pub fn substeps(mut self, substeps: Substeps) -> Self {
        self.substeps = Some(substeps);
        self
    }

    /// A force field on every node; wind is the example.
    pub fn force_field(mut self, field: impl ForceField + 'static) -> Self {
        self.field = Some(Arc::new(field));
        self
    }

    /// Whether it takes part in the simulation from the start.
    pub fn enabled(mut self, enabled: bool) -> Self {
        self.enabled = enabled;
        self
    }

    /// Whether it may fall asleep, as it may by default: when it is damped, touches or is held by something, and has been
    /// [slow](super::DeformableParameters::sleep_speed) for a while, as have all bodies it touches.
    pub fn can_sleep(mut self, can_sleep: bool) -> Self {
        self.can_sleep = can_sleep;
        self
    }

    /// Anything the user wants to keep with the body.
    pub fn user_data(mut self, data: u128) -> Self {
        self.user_data = data;
        self
    }
}
