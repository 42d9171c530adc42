//! Two-way coupling with Rapier's rigid bodies.
