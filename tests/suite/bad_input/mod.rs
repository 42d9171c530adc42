//! Whatever is put in, an error names what is wrong, and a step goes on.

mod build;
#[cfg(feature = "import")]
mod files;
mod numbers;
mod queries;
#[cfg(feature = "cli")]
mod scene_files;
mod scene_limits;
mod setters;
mod shapes;
mod stepping;
