//! Nodes near one target, and their rows.

use super::feature::Features;
use super::form::Form;
use super::site::Site;
use super::solid_nodes::SolidNodes;
use super::soup_nodes::SoupNodes;
use super::target::{Frame, Target};
use crate::body::state::State;
use crate::math::{DVec3, Real};
use crate::solve::rows::{Row, Rows};

/// The nodes of one body near one target, and what is remembered of those that touch it.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub enum Nodes {
    /// Of a target with an inside.
    Solid(SolidNodes),
    /// Of a surface.
    Soup(Box<SoupNodes>),
}

impl Default for Nodes {
    fn default() -> Self {
        Self::Solid(SolidNodes::default())
    }
}

impl Nodes {
    /// Takes in what has moved \[m\] besides the substeps.
    pub fn spend(&mut self, moved: f64) {
        if let Self::Soup(nodes) = self {
            nodes.spend(moved);
        }
    }

    /// Forgets all distances, which nodes touch, and on which side.
    pub fn reset(&mut self) {
        match self {
            Self::Solid(nodes) => nodes.reset(),
            Self::Soup(nodes) => {
                nodes.spend(f64::INFINITY);
                nodes.forget();
            }
        }
    }

    /// Makes the list of a soup anew if, after `moved` m since the last look, it might lack a node that can get a row in
    /// the coming substep, which is any within `farthest` m. A list should last for many substeps: the faster things move,
    /// the wider it is.
    pub fn refresh(
        &mut self,
        target: &Target,
        state: &State<Real>,
        frame: &Frame,
        moved: f64,
        farthest: f64,
    ) {
        // A list begins empty, and begins again when the collider gets a shape of the other kind.
        match (&target.form, &*self) {
            (Form::Solid(_), Self::Soup(_)) => *self = Self::Solid(SolidNodes::default()),
            (Form::Soup(_), Self::Solid(_)) => *self = Self::Soup(Box::default()),
            _ => {}
        }
        if let (Form::Soup(soup), Self::Soup(nodes)) = (&target.form, self) {
            nodes.refresh((soup, target.skin), state, frame, moved, farthest);
        }
    }

    /// Rows for every node that can touch within the substep, unless edges among the features bear it; `way` is how far body
    /// and collider have moved in all \[m\].
    pub fn add_rows(
        &mut self,
        (target, pair, features): (&Target, u32, Option<&Features>),
        frame: &Frame,
        site: &mut Site,
        way: f64,
    ) {
        match (&target.form, self) {
            (Form::Solid(solid), Self::Solid(nodes)) => {
                let have_features = features.is_some_and(Features::cover_all);
                nodes.add_rows(solid, (target, pair, have_features), (frame, way), site);
            }
            (Form::Soup(_), Self::Soup(nodes)) => {
                nodes.add_rows((target, pair, features), frame, site);
            }
            _ => {}
        }
    }

    /// The normal with which a node touched a solid last.
    pub fn touched(&self, node: u32) -> Option<DVec3> {
        match self {
            Self::Solid(nodes) => nodes.touched(node),
            Self::Soup(_) => None,
        }
    }

    /// How a node stands on a surface; see [`SoupNodes::standing`].
    pub fn standing(&self, node: u32, place: DVec3) -> Option<[DVec3; 2]> {
        match self {
            Self::Solid(_) => None,
            Self::Soup(nodes) => nodes.standing(node, place),
        }
    }

    /// Remembers which nodes touch, after the rows have been solved.
    pub fn remember(&mut self, rows: &Rows, touching: f64) {
        match self {
            Self::Solid(nodes) => nodes.remember(rows, touching),
            Self::Soup(nodes) => nodes.remember(rows, touching),
        }
    }

    /// Whether any node lies within `distance` m of the target; of a solid after a way as in [`Self::add_rows`].
    pub fn any_within(
        &self,
        target: &Target,
        state: &State<Real>,
        (frame, way): (&Frame, f64),
        distance: f64,
    ) -> bool {
        let distance = target.skin + distance;
        match (&target.form, self) {
            (Form::Solid(solid), Self::Solid(nodes)) => {
                nodes.any_within(solid, state, (frame, way), distance)
            }
            (Form::Soup(_), Self::Soup(nodes)) => nodes.any_within(state, frame, distance),
            _ => false,
        }
    }
}

/// Adds the row of a node.
pub fn add(i: u32, target: &Target, row: Row, site: &mut Site) {
    let first = site.rows.terms.len();
    let whole = (1.0, target.node_share, None);
    let carrier = site.side.carrier;
    carrier.add_terms(i, whole, site.slots, site.rows);
    let terms = site.rows.terms_since(first);
    site.rows.contacts.push(Row { terms, ..row });
}
