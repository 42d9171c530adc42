//! The border of a net's faces, and pinning nodes by their ids.

use super::{Net, NodeId};

impl Net {
    /// The same net with these nodes pinned; ids it does not have are left out.
    pub fn pin_nodes(mut self, nodes: impl IntoIterator<Item = NodeId>) -> Self {
        for id in nodes {
            if let Some(node) = self.nodes.get_mut(id.index()) {
                node.pinned = true;
            }
        }
        self
    }

    /// The same net with its [border](Self::border_nodes) pinned.
    ///
    /// ```
    /// let drum = crumple::shape::sheet(1.0, 1.0, 5, 5, 0.001)?.pin_border();
    /// assert_eq!(drum.nodes.iter().filter(|n| n.pinned).count(), 16);
    /// # Ok::<(), crumple::body::BuildError>(())
    /// ```
    pub fn pin_border(self) -> Self {
        let border = self.border_nodes();
        self.pin_nodes(border)
    }

    /// The nodes along sides that only one face has, in the order of their ids: the hem of a sheet and the rims of its
    /// holes. A closed body and one without faces have none.
    pub fn border_nodes(&self) -> Vec<NodeId> {
        let mut sides: Vec<(u32, u32)> = self
            .faces
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect();
        sides.sort_unstable();
        let mut nodes: Vec<NodeId> = sides
            .chunk_by(|s, t| s == t)
            .filter(|uses| uses.len() == 1)
            .flat_map(|uses| [NodeId(uses[0].0), NodeId(uses[0].1)])
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }
}
