//! What a run looks like: plots, pictures and tables, drawn on the CPU alone (feature `report`).
//!
//! A crash is judged by a force-time curve and by a look at the wreck. Both must come out of a server without a display or
//! a GPU and must be the same on every machine, so [`Plot`] draws with a software canvas and [`Picture`] is a small
//! z-buffer rasteriser of our own: a [`Camera`], a [`Mesh`], a [`Ground`], text and a [`ColorBar`].

pub mod camera;
pub mod charts;
pub mod color;
mod decimate;
pub mod error;
mod font;
pub mod ground;
pub mod line;
pub mod mesh;
pub mod picture;
pub mod plot;
mod raster;
mod rigid;
mod shadow;
pub mod shape;
pub mod stage;
pub mod table;
pub mod text;

pub use camera::Camera;
pub use color::{ColorBar, colormap};
pub use error::ReportError;
pub use ground::Ground;
pub use mesh::Mesh;
pub use picture::{Picture, contact_sheet};
pub use plot::{Plot, Series, Stroke};
pub use stage::Stage;
pub use table::Table;

#[cfg(test)]
mod tests;
