//! Features as a snapshot has them: distances and touches, without the solid's geometry.

use super::Features;
use super::part::Waking;
use crate::contact::touches::Touches;
use crate::contact::watch::Watch;

/// What is remembered of faces and edges near a target.
#[derive(serde::Serialize, serde::Deserialize)]
pub struct Saved {
    parts: Vec<(Watch, Watch, Waking)>,
    on_faces: Touches,
    on_edges: Touches,
}

impl Features {
    /// What is to be saved.
    pub fn save(&self) -> Saved {
        let parts = self.parts.iter();
        Saved {
            parts: parts
                .map(|p| (p.faces.clone(), p.edges.clone(), p.state))
                .collect(),
            on_faces: self.on_faces.clone(),
            on_edges: self.on_edges.clone(),
        }
    }

    /// Takes what was saved of the same solid; `None` if it can't have been the same.
    pub fn restore(&mut self, saved: Saved) -> Option<()> {
        if saved.parts.len() != self.parts.len() {
            return None;
        }
        for (part, (faces, edges, state)) in self.parts.iter_mut().zip(saved.parts) {
            (part.faces, part.edges, part.state) = (faces, edges, state);
        }
        (self.on_faces, self.on_edges) = (saved.on_faces, saved.on_edges);
        Some(())
    }
}
