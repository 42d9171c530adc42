//! Which facets are near which node.

use super::Soup;
use super::facet::Patch;
use super::near::Near;
use crate::math::DVec3;

/// The nodes near a soup and the facets near each; a list to be made again when something has moved by its margin.
#[derive(Clone, Debug, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct NodeFacets {
    nodes: Vec<u32>,
    /// Where the facets of each node begin in `slots`, and one more.
    offsets: Vec<u32>,
    /// Indices into `patches`.
    slots: Vec<u32>,
    /// Every facet that is near any node, in ascending order of id.
    patches: Vec<Patch>,
    oriented: bool,
    radius: f64,
    ids: Vec<u32>,
}

impl NodeFacets {
    /// Fills the list with the nodes that have facets within `margin` m, in the order given, and those facets. Positions
    /// are in the frame of the soup \[m\].
    pub fn gather(&mut self, soup: &Soup, nodes: impl Iterator<Item = (u32, DVec3)>, margin: f64) {
        self.gather_each(soup, nodes.map(|(node, p)| (node, p, margin)));
    }

    /// The same with a margin for every node.
    pub fn gather_each(&mut self, soup: &Soup, nodes: impl Iterator<Item = (u32, DVec3, f64)>) {
        self.clear();
        self.oriented = soup.oriented();
        self.radius = soup.radius();
        for (node, p, margin) in nodes {
            // The shape's own thickness brings it nearer.
            let margin = margin + self.radius;
            let corner = DVec3::splat(margin);
            soup.facets_in(p - corner, p + corner, &mut self.ids);
            let start = self.slots.len();
            for &id in &self.ids {
                if let Some(facet) = soup.facet(id)
                    && Patch::new(id, &facet).foot(p).distance2 <= margin * margin
                {
                    self.slots.push(id);
                }
            }
            if self.slots.len() > start {
                self.nodes.push(node);
                self.offsets.push(self.slots.len() as u32);
            }
        }
        self.intern(soup);
    }

    /// Empties the list.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.offsets.clear();
        self.offsets.push(0);
        self.slots.clear();
        self.patches.clear();
    }

    /// Prepares each facet once and turns ids into indices.
    fn intern(&mut self, soup: &Soup) {
        self.ids.clear();
        self.ids.extend_from_slice(&self.slots);
        self.ids.sort_unstable();
        self.ids.dedup();
        // An id is only in the list if its facet was there.
        self.patches.extend(
            self.ids
                .iter()
                .filter_map(|&id| Some(Patch::new(id, &soup.facet(id)?))),
        );
        for slot in &mut self.slots {
            *slot = self.ids.partition_point(|id| id < slot) as u32;
        }
    }

    /// The nodes that have facets near them, in the order they were given.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Half the thickness the facets have by themselves \[m\].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The facets near the node at `index` of [`nodes`](Self::nodes); none if there is no such index.
    #[inline]
    pub fn near(&self, index: usize) -> Near<'_> {
        let range = self
            .offsets
            .get(index)
            .zip(self.offsets.get(index + 1))
            .map_or(0..0, |(&start, &end)| start as usize..end as usize);
        Near {
            patches: &self.patches,
            slots: &self.slots[range],
            oriented: self.oriented,
            radius: self.radius,
        }
    }
}
