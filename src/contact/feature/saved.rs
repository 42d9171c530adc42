//! Features as a snapshot has them: distances and touches, without the geometry of solids.

use super::Features;
use super::convex::ConvexFeatures;
use super::part::Waking;
use crate::contact::touches::Touches;
use crate::contact::watch::Watch;

/// What is remembered of faces and edges near a target.
#[derive(serde::Serialize, serde::Deserialize)]
pub enum Saved {
    /// Near the convex parts of a solid.
    Convex(SavedParts),
    /// Points and edges that touch what is sharp.
    Sharp(Touches, Touches),
}

/// What is remembered near convex parts.
#[derive(serde::Serialize, serde::Deserialize)]
pub struct SavedParts {
    parts: Vec<(Watch, Watch, Waking)>,
    on_faces: Touches,
    on_edges: Touches,
}

impl Features {
    /// What is to be saved.
    pub fn save(&self) -> Saved {
        match self {
            Self::Convex(features) => Saved::Convex(features.save()),
            Self::Sharp(features) => {
                Saved::Sharp(features.on_faces.clone(), features.on_edges.clone())
            }
        }
    }

    /// Takes what was saved of the same form; `None` if it can't have been the same.
    pub fn restore(&mut self, saved: Saved) -> Option<()> {
        match (self, saved) {
            (Self::Convex(features), Saved::Convex(saved)) => features.restore(saved),
            (Self::Sharp(features), Saved::Sharp(on_faces, on_edges)) => {
                (features.on_faces, features.on_edges) = (on_faces, on_edges);
                Some(())
            }
            _ => None,
        }
    }
}

impl ConvexFeatures {
    fn save(&self) -> SavedParts {
        let parts = self.parts.iter();
        SavedParts {
            parts: parts
                .map(|p| (p.faces.clone(), p.edges.clone(), p.state))
                .collect(),
            on_faces: self.on_faces.clone(),
            on_edges: self.on_edges.clone(),
        }
    }

    fn restore(&mut self, saved: SavedParts) -> Option<()> {
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
