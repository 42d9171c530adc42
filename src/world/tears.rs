//! What springs that break do to the faces that they held together.

use super::Deformable;
use crate::body::Topology;
use crate::body::tears::Seams;
use crate::contact::encounter::outline::Outline;
use std::sync::Arc;

impl Deformable {
    /// Whether a face, by its index in [`Blueprint::faces`](crate::body::Blueprint::faces), is torn: so many of the springs between its
    /// corners have broken that these do not hang together any more as they did. Nothing meets it then, neither contact nor
    /// queries. `None` for an unknown index.
    pub fn is_torn(&self, face: usize) -> Option<bool> {
        let known = face < self.blueprint.faces.len();
        known.then(|| self.topology.is_torn(face as u32))
    }

    /// Tears faces whose springs have broken in the substep under way.
    pub(super) fn tear(&mut self) {
        let events = self.solver.events.iter();
        let broken: Vec<u32> = events.filter(|e| e.broke).map(|e| e.spring).collect();
        self.tear_at(&broken);
    }

    /// Tears what is torn of a body whose faces are taken for whole, or that has been put back to an earlier state.
    pub(super) fn tear_anew(&mut self) {
        let broken = (0..).zip(&self.state.broken);
        let broken: Vec<u32> = broken.filter(|(_, b)| **b).map(|(i, _)| i).collect();
        if self.topology.torn.any() {
            self.topology = Arc::new(Topology::of(&self.blueprint));
            if self.outline.is_some() {
                self.outline = Some(Box::new(Outline::new(self.contact_blueprint())));
            }
        }
        self.tear_at(&broken);
    }

    fn tear_at(&mut self, springs: &[u32]) {
        if springs.is_empty() {
            return;
        }
        let seams = self.seams.take().unwrap_or_else(|| {
            let (springs, nodes) = (&self.blueprint.springs, self.blueprint.nodes.len());
            Arc::new(Seams::new(&self.topology, springs, nodes))
        });
        let topology = Arc::make_mut(&mut self.topology);
        seams.tear(topology, springs, &self.state.broken);
        self.seams = Some(seams);
        self.tear_outline();
    }

    /// An outline that was made anew is whole.
    pub(super) fn tear_outline(&mut self) {
        if self.topology.torn.any()
            && self.embedded.is_none()
            && let Some(outline) = &mut self.outline
        {
            outline.tear(&self.topology);
        }
    }
}
