//! Laws: numbers in, numbers out, generic over the scalar. A law knows no array, no body and no time loop, so each can be
//! read beside its equation and checked by itself.

pub mod basis;
pub mod elastic;
pub mod joint;
pub mod plastic;
pub mod row;
pub mod spring;
pub mod stable;
