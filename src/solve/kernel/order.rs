//! In which order the rows of a table go.
//!
//! Nodes keep their places in the state; only the order in which they are visited is chosen. Rows that follow each other
//! should have neighbours in common, which are then still in the cache, and rows side by side should have about as many
//! springs, because a slice is as long as its longest row.

use crate::body::adjacency::Adjacency;

/// Rows are sorted by length within so many, which is far less than the cache holds.
const WINDOW: usize = 256;

/// The order of rows. That of the nodes is kept where neighbours are near in it; a mesh of no order is visited by
/// reverse Cuthill–McKee.
pub fn rows(adjacency: &Adjacency) -> Vec<u32> {
    // A body as wide as it is high and long has neighbours nodes^(2/3) apart.
    let usual = (adjacency.nodes() as f64).powf(2.0 / 3.0);
    let mut rows = if adjacency.spread() > 4.0 * usual {
        adjacency.cuthill_mckee()
    } else {
        (0..adjacency.nodes() as u32).collect()
    };
    for window in rows.chunks_mut(WINDOW) {
        window.sort_by_key(|&node| std::cmp::Reverse(adjacency.at(node).len()));
    }
    rows
}
