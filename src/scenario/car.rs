//! The car of the crash scenes, as far as figures need it; what it is made of stands in `assets/scenes/parts/car.ron`.

/// Mass of the whole car with its engine \[kg\].
pub const MASS: f64 = 1300.0;
/// Mass of the engine block \[kg\].
pub const ENGINE_MASS: f64 = 200.0;
