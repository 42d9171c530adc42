//! Dense ids. They count from 0 in the order of insertion and never change: a broken spring keeps its id, so that
//! recordings, events and plots stay joinable.

/// A node of one body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct NodeId(pub u32);

/// A spring of one body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct SpringId(pub u32);

/// A tetrahedron of one body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct TetId(pub u32);

impl NodeId {
    /// The id as an index into per-node slices.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl SpringId {
    /// The id as an index into per-spring slices.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl TetId {
    /// The id as an index into per-tet slices.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}
