//! What a body is: a [`Net`] of nodes and springs with the constants a [`Material`] gives them, or a [`TetMesh`] of a
//! [`Solid`], and the state a solver writes.

pub(crate) mod adjacency;
pub mod blueprint;
mod border;
mod crossing;
mod embedded;
pub mod error;
pub mod id;
pub(crate) mod incidence;
pub mod material;
pub mod net;
pub mod search;
pub mod shape;
pub mod solid;
pub mod state;
pub mod surface;
pub(crate) mod tears;
pub mod tets;
pub mod topology;

pub use blueprint::Blueprint;
pub(crate) use embedded::Embedded;
pub use error::BuildError;
pub use id::{NodeId, SpringId, TetId};
pub use material::Material;
pub use net::{Binding, Net, Node, Skin, Spring};
pub use search::{Feature, SurfacePoint};
pub use solid::{Solid, SolidLaw, SolidMesh};
pub use state::State;
pub use surface::{Group, Surface};
pub use tets::{TetMesh, Tets};
pub use topology::Topology;
