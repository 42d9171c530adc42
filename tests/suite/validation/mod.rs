//! Closed forms and discrete references.

mod crash;
mod impact;
