//! Counts over pairs.

use crate::judge::comparison::Pairs;

/// Bins of half a pixel.
const BINS: usize = 8;
/// Unexplained pairs that are named.
const EXAMPLES: usize = 12;

/// Counts over pairs; until the end the weighted ones are sums.
pub struct Tally {
    found: Pairs,
    weight: f64,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            found: Pairs {
                histogram: vec![0; BINS],
                ..Pairs::default()
            },
            weight: 0.0,
        }
    }
}

impl Tally {
    /// A pair on which rays and the GPU disagree, so far from what explains it.
    pub fn mismatch(&mut self, pair: (u32, u32), weight: f64, distance: Option<f32>) {
        self.found.mismatched += 1;
        self.found.weighted_mismatch += weight;
        match distance {
            Some(distance) => {
                self.found.explained += 1;
                self.explainable(weight);
                self.found.histogram[((distance * 2.0) as usize).min(BINS - 1)] += 1;
            }
            None => self.name([pair]),
        }
    }

    /// A pair that could see each other.
    pub fn facing(&mut self, weight: f64) {
        self.found.facing += 1;
        self.weight += weight;
    }

    /// One that pixels may err on, whether or not they did.
    pub fn explainable(&mut self, weight: f64) {
        self.found.explainable += 1;
        self.found.weighted_explainable += weight;
    }

    /// The last mismatch is explained by an outline that is too thin to show.
    pub fn vanished(&mut self) {
        self.found.vanished += 1;
    }

    fn name(&mut self, pairs: impl IntoIterator<Item = (u32, u32)>) {
        self.found.examples.extend(pairs);
        self.found.examples.sort_unstable();
        self.found.examples.truncate(EXAMPLES);
    }

    /// Adds another part.
    pub fn merge(&mut self, other: Self) {
        let (found, more) = (&mut self.found, other.found);
        found.facing += more.facing;
        found.explainable += more.explainable;
        found.mismatched += more.mismatched;
        found.explained += more.explained;
        found.vanished += more.vanished;
        found.weighted_mismatch += more.weighted_mismatch;
        found.weighted_explainable += more.weighted_explainable;
        for (a, b) in found.histogram.iter_mut().zip(more.histogram) {
            *a += b;
        }
        self.weight += other.weight;
        self.name(more.examples);
    }

    /// The counts of `asked` pairs.
    pub fn finish(self, asked: u64) -> Pairs {
        let weight = self.weight;
        let share = |part: f64| if weight > 0.0 { part / weight } else { 0.0 };
        Pairs {
            pairs: asked,
            unexplained: self.found.mismatched - self.found.explained,
            weighted_mismatch: share(self.found.weighted_mismatch),
            weighted_explainable: share(self.found.weighted_explainable),
            ..self.found
        }
    }
}
