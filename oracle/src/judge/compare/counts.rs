//! Counts over pairs.

use crate::judge::comparison::Pairs;

/// Bins of half a pixel.
const BINS: usize = 8;
/// Unexplained pairs that are named.
const EXAMPLES: usize = 12;

/// Counts over pairs.
#[derive(Default)]
pub struct Tally {
    facing: u64,
    explainable: u64,
    mismatched: u64,
    explained: u64,
    vanished: u64,
    weight: f64,
    weight_mismatched: f64,
    weight_explainable: f64,
    histogram: [u64; BINS],
    examples: Vec<(u32, u32)>,
}

impl Tally {
    /// A pair on which rays and the GPU disagree, so far from what explains it.
    pub fn mismatch(&mut self, pair: (u32, u32), weight: f64, distance: Option<f32>) {
        self.mismatched += 1;
        self.weight_mismatched += weight;
        match distance {
            Some(distance) => {
                self.explained += 1;
                self.explainable += 1;
                self.weight_explainable += weight;
                self.histogram[((distance * 2.0) as usize).min(BINS - 1)] += 1;
            }
            None => {
                self.examples.push(pair);
                self.examples.sort_unstable();
                self.examples.truncate(EXAMPLES);
            }
        }
    }

    /// A pair that could see each other.
    pub fn facing(&mut self, weight: f64) {
        self.facing += 1;
        self.weight += weight;
    }

    /// One that pixels may err on, though they did not.
    pub fn explainable(&mut self, weight: f64) {
        self.explainable += 1;
        self.weight_explainable += weight;
    }

    /// The last mismatch is explained by an outline that is too thin to show.
    pub fn vanished(&mut self) {
        self.vanished += 1;
    }

    /// Adds another part.
    pub fn merge(&mut self, other: Self) {
        self.facing += other.facing;
        self.explainable += other.explainable;
        self.mismatched += other.mismatched;
        self.explained += other.explained;
        self.vanished += other.vanished;
        self.weight += other.weight;
        self.weight_mismatched += other.weight_mismatched;
        self.weight_explainable += other.weight_explainable;
        for (a, b) in self.histogram.iter_mut().zip(other.histogram) {
            *a += b;
        }
        self.examples.extend(other.examples);
        self.examples.sort_unstable();
        self.examples.truncate(EXAMPLES);
    }

    /// The counts of `asked` pairs.
    pub fn finish(self, asked: u64) -> Pairs {
        let share = |part: f64| {
            if self.weight > 0.0 {
                part / self.weight
            } else {
                0.0
            }
        };
        Pairs {
            pairs: asked,
            facing: self.facing,
            mismatched: self.mismatched,
            explained: self.explained,
            vanished: self.vanished,
            unexplained: self.mismatched - self.explained,
            explainable: self.explainable,
            weighted_mismatch: share(self.weight_mismatched),
            weighted_explainable: share(self.weight_explainable),
            histogram: self.histogram.to_vec(),
            examples: self.examples,
        }
    }
}
