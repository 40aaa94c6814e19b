//! Counts errors of stages ([`ErrorTally`]) and mismatches of pairs of points ([`PairTally`]). The checks of stages,
//! links and visibility count by them.

use crate::compare::comparison::{StageCheck, VisibilityStatistics};

/// Number of histogram bins of half a pixel.
const HISTOGRAM_BINS: usize = 8;
/// Largest number of unexplained pairs that are listed.
const MAX_EXAMPLES: usize = 12;

/// Number of compared values, and their largest error.
#[derive(Clone, Copy, Debug, Default)]
pub struct ErrorTally {
    values: u64,
    differing: u64,
    largest: f64,
}

impl ErrorTally {
    /// Adds a value with this error.
    pub fn add(&mut self, error: f64) {
        self.merge(Self {
            values: 1,
            differing: u64::from(error != 0.0),
            largest: error,
        });
    }

    /// Adds equal values.
    pub fn add_equal(&mut self, values: u64) {
        self.values += values;
    }

    /// Adds a comparison of two values that must be equal.
    pub fn add_equality(&mut self, equal: bool) {
        self.add(f64::from(u8::from(!equal)));
    }

    /// Adds the counts of another tally.
    pub fn merge(&mut self, other: Self) {
        self.values += other.values;
        self.differing += other.differing;
        self.largest = larger_or_nan(self.largest, other.largest);
    }

    /// Returns the number of compared values.
    pub fn values(&self) -> u64 {
        self.values
    }

    /// Returns the check of the stage; without values it does not pass.
    pub fn stage_check(&self, name: &str, bound: f64, reason: &str) -> StageCheck {
        StageCheck {
            name: name.to_owned(),
            values: self.values,
            differing: self.differing,
            worst: self.largest,
            bound,
            reason: reason.to_owned(),
            agree: self.values > 0 && self.largest <= bound,
        }
    }
}

impl FromIterator<f64> for ErrorTally {
    fn from_iter<I: IntoIterator<Item = f64>>(errors: I) -> Self {
        let mut tally = Self::default();
        for error in errors {
            tally.add(error);
        }
        tally
    }
}

/// Returns the larger number; NaN if any is NaN, which `f64::max` would drop.
pub fn larger_or_nan(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Returns |a − b| in units in the last place of the largest of |a|, |b| and `size`.
pub fn ulp_distance(a: f32, b: f32, size: f32) -> f64 {
    let largest = f64::from(a.abs().max(b.abs()).max(size));
    if a == b {
        0.0
    } else {
        (f64::from(a) - f64::from(b)).abs() / (largest * f64::from(f32::EPSILON))
    }
}

/// Outcome of a comparison of rays and pixels on a pair of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PairOutcome {
    /// Equal, and far from silhouettes.
    Equal,
    /// Equal, but near a silhouette, where pixels may be wrong.
    EqualNearSilhouette,
    /// Different, within this distance of its explanation in pixels.
    Explained(f32),
    /// Different, explained by an outline at this distance that is too thin for the buffer.
    Vanished(f32),
    /// Different without an explanation.
    Unexplained,
}

/// Counts of pairs; the weighted ones are sums until [`PairTally::into_statistics`].
#[derive(Default)]
pub struct PairTally {
    counts: VisibilityStatistics,
    weight: f64,
}

impl PairTally {
    /// Adds a facing pair (patch, texel) of this weight.
    pub fn add_pair(&mut self, pair: (u32, u32), weight: f64, outcome: PairOutcome) {
        let counts = &mut self.counts;
        counts.facing += 1;
        self.weight += weight;
        if outcome == PairOutcome::Equal {
            return;
        }
        if outcome != PairOutcome::Unexplained {
            counts.explainable += 1;
            counts.weighted_explainable += weight;
        }
        if outcome == PairOutcome::EqualNearSilhouette {
            return;
        }
        counts.mismatched += 1;
        counts.weighted_mismatch += weight;
        match outcome {
            PairOutcome::Explained(distance) | PairOutcome::Vanished(distance) => {
                counts.explained += 1;
                counts.vanished += u64::from(matches!(outcome, PairOutcome::Vanished(_)));
                counts.histogram.resize(HISTOGRAM_BINS, 0);
                counts.histogram[((distance * 2.0) as usize).min(HISTOGRAM_BINS - 1)] += 1;
            }
            _ => self.add_examples([pair]),
        }
    }

    fn add_examples(&mut self, pairs: impl IntoIterator<Item = (u32, u32)>) {
        self.counts.examples.extend(pairs);
        self.counts.examples.sort_unstable();
        self.counts.examples.truncate(MAX_EXAMPLES);
    }

    /// Adds the counts of another tally.
    pub fn merge(&mut self, other: Self) {
        let (found, more) = (&mut self.counts, other.counts);
        found.facing += more.facing;
        found.explainable += more.explainable;
        found.mismatched += more.mismatched;
        found.explained += more.explained;
        found.vanished += more.vanished;
        found.weighted_mismatch += more.weighted_mismatch;
        found.weighted_explainable += more.weighted_explainable;
        found.histogram.resize(HISTOGRAM_BINS, 0);
        for (a, b) in found.histogram.iter_mut().zip(more.histogram) {
            *a += b;
        }
        self.weight += other.weight;
        self.add_examples(more.examples);
    }

    /// Returns the statistics; `pairs` is the number of all pairs.
    pub fn into_statistics(mut self, pairs: u64) -> VisibilityStatistics {
        self.counts.histogram.resize(HISTOGRAM_BINS, 0);
        let weight = self.weight;
        let share = |part: f64| if weight > 0.0 { part / weight } else { 0.0 };
        VisibilityStatistics {
            pairs,
            unexplained: self.counts.mismatched - self.counts.explained,
            weighted_mismatch: share(self.counts.weighted_mismatch),
            weighted_explainable: share(self.counts.weighted_explainable),
            ..self.counts
        }
    }
}
