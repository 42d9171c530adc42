//! Figures: what a run comes to, each a number with a name and a unit.

/// A number of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its key in a summary, the unit as a suffix, like `crush_m`.
    pub key: &'static str,
    /// Its name in a table.
    pub label: &'static str,
    /// The number, in `unit`.
    pub value: f64,
    /// Its unit; empty for a plain number.
    pub unit: &'static str,
}

/// The figures of a run, in the order of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures(pub Vec<Figure>);

impl Figures {
    /// Adds one.
    pub fn add(&mut self, key: &'static str, label: &'static str, value: f64, unit: &'static str) {
        self.0.push(Figure {
            key,
            label,
            value,
            unit,
        });
    }

    /// The value of a key; `None` where there is none.
    pub fn get(&self, key: &str) -> Option<f64> {
        self.0.iter().find(|f| f.key == key).map(|f| f.value)
    }
}
