//! What threads gain.

use super::{SceneError, Sizes};

/// All threads against one.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Threads {
    /// How many.
    pub threads: usize,
    /// Time of one over time of all, by the clock on the wall \[1\].
    pub speedup: f64,
    /// Why nothing was gained.
    pub note: Option<&'static str>,
}

pub(super) fn threads(_: &Sizes) -> Result<Threads, SceneError> {
    Ok(Threads {
        threads: 1,
        speedup: 1.0,
        note: Some("there are no threads"),
    })
}
