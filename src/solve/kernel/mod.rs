//! The vector kernels: the force pass over springs and the pass of symplectic Euler over nodes, in `f32`.
//!
//! Springs lie in a table of sliced ELLPACK form: rows are nodes, sixteen side by side, and each row has all springs
//! of its node. Both ends of a spring compute it, so forces are written once per node, not added to twice per spring: no
//! two lanes write to one place, nothing needs to be cleared before, and each sum has one order. Twice the arithmetic is
//! less than the price of scattering. Differences change sign exactly in floating point, and everything else of a spring is
//! even in them, so both ends find the same tension to the last bit.
//!
//! Where nodes follow each other in memory as they do in the body, their neighbours do so too: then nodes are copied column by
//! column first, and neighbours are read from there without indices (`regular.rs`), in the same order of sums.
//!
//! **Every width gives the same bits**, and those of the scalar pass ([`super::forces`]): a row sums its springs in their order,
//! products are not fused with sums, and square roots and quotients are exact. So [`Kernel`] is a matter of speed alone.

mod extent;
mod integrate;
mod limits;
mod log;
mod mirror;
mod order;
mod palette;
mod pass;
mod ranges;
mod rates;
mod regular;
pub mod roof;
mod sell;
mod table;
mod telling;
#[cfg(test)]
mod tests;
mod trial;
mod vector;
mod write_back;

pub(crate) use extent::{box_around, velocities_around};
pub(crate) use integrate::{Totals, symplectic_euler};
pub(crate) use pass::{make_rows, spring_forces};
pub(crate) use rates::rates;
pub(crate) use sell::Sell;
pub(crate) use vector::{Half, Pass, Places, Vector, put_four, run};

use super::threads::BLOCK;
use std::any::Any;
use vector::{LANES, Width};

/// Slices that are summed together.
const SLICES: usize = BLOCK / LANES;

/// A value that is generic over the scalar, where the scalar is `f32`, which the kernels are for.
pub(crate) fn of_f32<T: Any, F: Any>(value: &T) -> Option<&F> {
    (value as &dyn Any).downcast_ref()
}

/// The same to be changed.
pub(crate) fn of_f32_mut<T: Any, F: Any>(value: &mut T) -> Option<&mut F> {
    (value as &mut dyn Any).downcast_mut()
}

/// With which vectors forces are computed. All give the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub enum Kernel {
    /// The widest that the processor has.
    #[default]
    Auto,
    /// Springs one by one, nodes and tets four numbers at a time: what every processor has.
    Portable,
    /// Eight at a time with AVX2 (and FMA, which only processors with AVX2 have), or what the processor has of it.
    Avx2,
    /// Sixteen at a time with AVX-512, or what the processor has of it.
    Avx512,
}

impl Kernel {
    /// What this processor makes of the setting.
    ///
    /// ```
    /// use crumple::solve::Kernel;
    /// println!("kernel: {}", Kernel::Auto.name());
    /// assert_eq!(Kernel::Portable.name(), "portable");
    /// ```
    pub fn name(self) -> &'static str {
        match Width::of(self) {
            Width::Portable => "portable",
            Width::Avx2 => "AVX2 ×8",
            Width::Avx512 => "AVX-512 ×16",
        }
    }
}
