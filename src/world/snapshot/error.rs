//! What can be wrong with a snapshot.

/// Why a world can't be saved or restored.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// The bytes begin as no snapshot does.
    #[error("these {length} bytes are no snapshot")]
    NoSnapshot {
        /// How many there are.
        length: usize,
    },
    /// Made by another version of this crate.
    #[error("the snapshot was made by version {found}, this is {expected}")]
    Version {
        /// Which made it.
        found: String,
        /// Which this is.
        expected: &'static str,
    },
    /// Made by a build that lays its data out in another way, such as one with another Rapier, or on a machine of 32 bits.
    #[error("the snapshot has layout {found:016x}, this build {expected:016x}")]
    Layout {
        /// That of the snapshot.
        found: u64,
        /// That of this build.
        expected: u64,
    },
    /// Bytes are missing at its end.
    #[error("the snapshot is cut short: {found} bytes{}", of(*.expected))]
    CutShort {
        /// How many there are.
        found: u64,
        /// How many there should be, if its beginning says so.
        expected: Option<u64>,
    },
    /// There are bytes after its end.
    #[error("the snapshot has {found} bytes and should have {expected}")]
    TooLong {
        /// How many there are.
        found: u64,
        /// How many there should be.
        expected: u64,
    },
    /// Its bytes are not those that were written.
    #[error("the snapshot is damaged: its checksum is wrong")]
    Damaged,
    /// It is of deformables alone, and a Rapier world was asked for.
    #[error("the snapshot has no Rapier world: restore it with `load_beside`")]
    WithoutRapier,
    /// It has a Rapier world, and deformables alone were asked for.
    #[error("the snapshot has a Rapier world as well: restore it with `load`")]
    WithRapier,
    /// Its content is none of a world.
    #[error("the snapshot can't be read: {reason}")]
    Unreadable {
        /// What the decoder says.
        reason: String,
    },
    /// A world can't be saved between `before_step` and `after_step`.
    #[error("a world can't be saved between the halves of a step")]
    MidStep,
    /// Something in it can't be saved, such as a collider of a custom shape.
    #[error("the world can't be saved: {reason}")]
    Unsaveable {
        /// What the encoder says.
        reason: String,
    },
}

fn of(expected: Option<u64>) -> String {
    expected.map_or_else(String::new, |n| format!(" of {n}"))
}
