//! What a case gives, and the clock that finds it.

/// What a case gives; NaN for what it does not have.
#[derive(Clone, Copy)]
pub struct Outcome {
    pub ms_per_frame: f64,
    /// Of the frames alone in which the body touches the floor.
    pub ms_in_contact: f64,
    /// Of any edge.
    pub max_strain: f64,
    /// The fastest that it comes back \[m/s\].
    pub rebound: f64,
    /// Tets × substeps per second; ours.
    pub tets_per_second: f64,
    /// Of a deflection.
    pub error_percent: f64,
}

impl Outcome {
    /// The first line of a table.
    pub const HEADER: &str =
        "case,ms_per_frame,ms_in_contact,max_strain,rebound_m_per_s,tets_per_second,error_percent";

    /// With a time alone.
    pub fn of(ms_per_frame: f64) -> Self {
        Self {
            ms_per_frame,
            ms_in_contact: f64::NAN,
            max_strain: f64::NAN,
            rebound: f64::NAN,
            tets_per_second: f64::NAN,
            error_percent: f64::NAN,
        }
    }

    /// A line of a table.
    pub fn row(&self, name: &str) -> String {
        let cell = |x: f64, shown: String| if x.is_nan() { String::new() } else { shown };
        let cells = [
            (self.ms_per_frame, format!("{:.3}", self.ms_per_frame)),
            (self.ms_in_contact, format!("{:.3}", self.ms_in_contact)),
            (self.max_strain, format!("{:.3}", self.max_strain)),
            (self.rebound, format!("{:.2}", self.rebound)),
            (
                self.tets_per_second,
                format!("{:.3e}", self.tets_per_second),
            ),
            (self.error_percent, format!("{:.2}", self.error_percent)),
        ];
        let cells = cells.map(|(x, shown)| cell(x, shown)).join(",");
        format!("\"{name}\",{cells}")
    }
}

/// Adds up frames of 1/60 s, those in contact apart.
pub struct Clock {
    /// Of the centre of mass, upwards \[m/s\].
    speed: f64,
    frames: [f64; 2],
    seconds: [f64; 2],
    max_strain: f64,
    rebound: f64,
}

impl Clock {
    /// For a body that begins with this velocity upwards \[m/s\].
    pub fn new(speed: f64) -> Self {
        Self {
            speed,
            frames: [0.0; 2],
            seconds: [0.0; 2],
            max_strain: 0.0,
            rebound: 0.0,
        }
    }

    /// Counts a frame that took `seconds`, with the velocity upwards and the largest strain after it. A body whose velocity
    /// changes otherwise than by gravity touches.
    pub fn frame(&mut self, seconds: f64, speed: f64, strain: f64) {
        let free = self.speed - 9.81 / 60.0;
        let touches = (speed - free).abs() > 0.01;
        self.frames[usize::from(touches)] += 1.0;
        self.seconds[usize::from(touches)] += seconds;
        self.max_strain = self.max_strain.max(strain);
        self.rebound = self.rebound.max(speed);
        self.speed = speed;
    }

    pub fn seconds(&self) -> f64 {
        self.seconds.iter().sum()
    }

    pub fn outcome(&self) -> Outcome {
        Outcome {
            ms_in_contact: 1e3 * self.seconds[1] / self.frames[1],
            max_strain: self.max_strain,
            rebound: self.rebound,
            ..Outcome::of(1e3 * self.seconds() / self.frames.iter().sum::<f64>())
        }
    }
}
