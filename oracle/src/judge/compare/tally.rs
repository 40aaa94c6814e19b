//! The errors of one stage, counted.

use crate::judge::comparison::Stage;

/// Values compared, and the largest error of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    values: u64,
    differing: u64,
    max: f64,
}

impl Tally {
    /// One more value, so far off.
    pub fn add(&mut self, error: f64) {
        self.merge(Self {
            values: 1,
            differing: u64::from(error != 0.0),
            max: error,
        });
    }

    /// So many more values that are equal.
    pub fn alike(&mut self, values: u64) {
        self.values += values;
    }

    /// Two values that must be equal.
    pub fn same(&mut self, equal: bool) {
        self.add(f64::from(u8::from(!equal)));
    }

    /// Adds another part.
    pub fn merge(&mut self, other: Self) {
        self.values += other.values;
        self.differing += other.differing;
        // A NaN must stay: f64::max would drop it.
        if other.max > self.max || other.max.is_nan() {
            self.max = other.max;
        }
    }

    /// How many were compared.
    pub fn values(&self) -> u64 {
        self.values
    }

    /// The verdict on the stage; one that was asked nothing does not pass.
    pub fn stage(&self, name: &str, bound: f64, reason: &str) -> Stage {
        Stage {
            name: name.to_owned(),
            values: self.values,
            differing: self.differing,
            worst: self.max,
            bound,
            reason: reason.to_owned(),
            agree: self.values > 0 && self.max <= bound,
        }
    }
}

impl FromIterator<f64> for Tally {
    fn from_iter<I: IntoIterator<Item = f64>>(errors: I) -> Self {
        let mut tally = Self::default();
        for error in errors {
            tally.add(error);
        }
        tally
    }
}

/// |a − b| in units in the last place of the larger of the two and of `size`.
pub fn ulps(a: f32, b: f32, size: f32) -> f64 {
    let largest = f64::from(a.abs().max(b.abs()).max(size));
    if a == b {
        0.0
    } else {
        (f64::from(a) - f64::from(b)).abs() / (largest * f64::from(f32::EPSILON))
    }
}
