//! Shape functions: each returns a [`Net`](super::Net) whose springs carry sections and whose nodes carry volumes.

mod cells;
mod filled;
mod hexahedron;
mod inside;
mod lattice;
mod rope;
mod sheet;
mod skin;
mod tets;

pub use filled::filled;
pub use lattice::lattice;
pub use rope::rope;
pub use sheet::{BENDING_SHARE, sheet, sheet_with_bending};
pub use tets::{TetSplit, tet_box, tet_box_of_cells, tet_filled};
