//! Bodies as coloured lines, for those who want to see what the springs do.
//!
//! Colours are `[hue in degrees, saturation, lightness, alpha]`, as everywhere in Rapier's debug drawing; [`rgba`] turns
//! them into what most other programs want.

use super::{Deformable, DeformableHandle, DeformableWorld};
use crate::body::SpringId;
use crate::law::basis;
use crate::law::elastic::mean_pressure;
use crate::math::{DVec3, Real, Vector, narrow};

/// What is drawn, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DebugStyle {
    /// Unbroken springs, coloured by their load.
    pub springs: bool,
    /// Edges of tets between corners, coloured by von Mises stress, as tension or compression by its mean.
    pub tets: bool,
    /// Sides of the faces.
    pub faces: bool,
    /// A cross at each pinned node.
    pub pinned: bool,
    /// A cross at each attached node.
    pub attachments: bool,
    /// Strain at which a spring that never yields, or a tet, has its full colour; a spring that yields has it when it flows.
    pub full_strain: Real,
    /// Half the length of the crosses' arms \[m\].
    pub cross: Real,
    /// Of a spring without load.
    pub relaxed_color: [f32; 4],
    /// Of a spring in full tension.
    pub tension_color: [f32; 4],
    /// Of a spring in full compression.
    pub compression_color: [f32; 4],
    /// Of faces.
    pub face_color: [f32; 4],
    /// Of pinned nodes.
    pub pinned_color: [f32; 4],
    /// Of attached nodes.
    pub attachment_color: [f32; 4],
    /// Factor on the colours of bodies that take no part in the simulation.
    pub disabled_multiplier: [f32; 4],
}

impl Default for DebugStyle {
    fn default() -> Self {
        Self {
            springs: true,
            tets: true,
            faces: false,
            pinned: true,
            attachments: true,
            full_strain: 0.05,
            cross: 0.02,
            relaxed_color: [120.0, 0.1, 0.7, 1.0],
            tension_color: [0.0, 1.0, 0.5, 1.0],
            compression_color: [220.0, 1.0, 0.5, 1.0],
            face_color: [50.0, 0.5, 0.6, 1.0],
            pinned_color: [300.0, 1.0, 0.6, 1.0],
            attachment_color: [30.0, 1.0, 0.5, 1.0],
            disabled_multiplier: [1.0, 0.3, 0.6, 1.0],
        }
    }
}

impl DebugStyle {
    /// Colour of a load from −1, full compression, over 0 to 1, full tension.
    fn load_color(&self, load: f64) -> [f32; 4] {
        let full = if load < 0.0 {
            self.compression_color
        } else {
            self.tension_color
        };
        let share = load.abs().min(1.0) as f32;
        // The hue is the full colour's: a blend of hues would pass through colours that mean something else.
        let mut color = full;
        for i in 1..4 {
            color[i] = self.relaxed_color[i] + share * (full[i] - self.relaxed_color[i]);
        }
        if share == 0.0 {
            color[0] = self.relaxed_color[0];
        }
        color
    }
}

/// Red, green, blue and alpha in 0..=1 of a colour in Rapier's terms.
pub fn rgba([hue, saturation, lightness, alpha]: [f32; 4]) -> [f32; 4] {
    let chroma = saturation * lightness.min(1.0 - lightness);
    let channel = |n: f32| {
        let k = (n + hue / 30.0).rem_euclid(12.0);
        lightness - chroma * (k - 3.0).min(9.0 - k).clamp(-1.0, 1.0)
    };
    [channel(0.0), channel(8.0), channel(4.0), alpha]
}

impl DeformableWorld {
    /// Calls `draw` with the ends \[m\] and the colour of every line of the picture. Contacts are not drawn: they live for
    /// a substep, and an [`Observer`](super::Observer) sees their impulses.
    ///
    /// ```
    /// use crumple::prelude::*;
    /// use crumple::world::{DebugStyle, rgba};
    /// let mut deformables = DeformableWorld::default();
    /// deformables.insert(DeformableBuilder::new(lattice(Vector::ONE, 0.5)).material(Material::rubber()))?;
    /// let mut lines = Vec::new();
    /// deformables.debug_lines(&DebugStyle::default(), |a, b, color| lines.push((a, b, rgba(color))));
    /// # use crumple::rapier3d::prelude::Vector;
    /// # assert!(lines.len() > 100);
    /// # Ok::<(), crumple::body::BuildError>(())
    /// ```
    pub fn debug_lines(&self, style: &DebugStyle, mut draw: impl FnMut(Vector, Vector, [f32; 4])) {
        for (handle, body) in self.iter() {
            self.debug_body(handle, body, style, &mut draw);
        }
    }

    pub(super) fn debug_body(
        &self,
        handle: DeformableHandle,
        body: &Deformable,
        style: &DebugStyle,
        draw: &mut impl FnMut(Vector, Vector, [f32; 4]),
    ) {
        let mut line = |a: DVec3, b: DVec3, mut color: [f32; 4]| {
            if !body.is_enabled() {
                for (c, factor) in color.iter_mut().zip(style.disabled_multiplier) {
                    *c *= factor;
                }
            }
            draw(narrow(a), narrow(b), color);
        };
        let at = |node: u32| body.state.position(node as usize);
        if style.springs {
            for (i, spring) in body.blueprint.springs.iter().enumerate() {
                if let Some(load) = body.load(i, style.full_strain.into()) {
                    let [a, b] = spring.nodes.map(at);
                    line(a, b, style.load_color(load));
                }
            }
        }
        if let (true, Some(mesh)) = (style.tets, body.tet_mesh()) {
            let full = body.solid().map_or(1.0, |s| s.young) * f64::from(style.full_strain);
            for (corners, stress) in mesh.tets.corners().zip(body.stresses()) {
                let pressure = mean_pressure(&stress.cauchy);
                let load = -(stress.von_mises / full).copysign(pressure);
                for [a, b] in basis::EDGES {
                    line(at(corners[a]), at(corners[b]), style.load_color(load));
                }
            }
        }
        if style.faces {
            for [a, b, c] in body.whole_faces() {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    line(at(from), at(to), style.face_color);
                }
            }
        }
        let mut cross = |node: u32, color| {
            for arm in [DVec3::X, DVec3::Y, DVec3::Z] {
                let arm = arm * f64::from(style.cross);
                line(at(node) - arm, at(node) + arm, color);
            }
        };
        if style.pinned {
            let pinned = (0..).zip(&body.state.particles);
            for (node, _) in pinned.filter(|(_, p)| p.inv_mass == 0.0) {
                cross(node, style.pinned_color);
            }
        }
        if style.attachments {
            for (_, attachment) in self.attachments().filter(|(_, a)| a.deformable == handle) {
                for node in attachment.nodes.iter() {
                    cross(*node, style.attachment_color);
                }
            }
        }
    }
}

impl Deformable {
    /// Tension of a spring over what it yields at now, or its elastic strain over `full_strain` where it never yields;
    /// negative in compression. `None` if it has broken.
    fn load(&self, spring: usize, full_strain: f64) -> Option<f64> {
        if self.state.broken[spring] {
            return None;
        }
        let constants = &self.blueprint.springs[spring];
        let tension = self.tension(SpringId(spring as u32))?;
        let first = if tension < 0.0 {
            constants.yield_compression
        } else {
            constants.yield_tension
        };
        let grown = f64::from(constants.hardening) * f64::from(self.state.flow[spring]);
        let full = if first.is_finite() {
            f64::from(first) + grown
        } else {
            f64::from(constants.stiffness) * f64::from(self.state.rest[spring]) * full_strain
        };
        Some(if full > 0.0 { tension / full } else { 0.0 })
    }
}
