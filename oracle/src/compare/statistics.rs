//! Counts errors of stages ([`ErrorTally`]) and mismatches of pairs of points ([`PairTally`]). The checks of stages,
//! links and visibility count by them.

use crate::compare::comparison::{DifferingValue, StageCheck, StageDifference, VisibilityStatistics};
use common::mesh::Mesh;
use stage_check::tally::{Compared, Tally, Value, ulp_distance};

/// Number of histogram bins of half a pixel.
const HISTOGRAM_BINS: usize = 8;
/// Largest number of unexplained pairs that are listed.
const MAX_EXAMPLES: usize = 12;

/// Elements of which a stage makes values, in workgroups of `lanes`.
#[derive(Clone, Copy, Debug)]
pub struct Elements {
    /// `texel`, `patch`, `pixel`.
    pub name: &'static str,
    /// Their number.
    pub count: usize,
    /// Lanes of a workgroup; 1 if it makes one element.
    pub lanes: usize,
}

/// Place of a value: number of the element, and of the value's name.
pub type ValuePlace = [usize; 2];

/// Shot that a value belongs to.
#[derive(Clone, Copy, Debug, Default)]
pub struct ValueSource {
    /// The shooter.
    pub shooter: Option<u32>,
    /// Number of the shooter's sample.
    pub sample: Option<u32>,
}

impl ValueSource {
    /// Returns the source of values of a shot.
    pub fn shot_by(patch: u32) -> Self {
        Self {
            shooter: Some(patch),
            sample: None,
        }
    }
}

/// Comparisons of the values of a stage with those of its twin.
#[derive(Clone, Debug)]
pub struct ErrorTally {
    /// Name of the stage.
    pub name: &'static str,
    reason: &'static str,
    elements: Elements,
    value_names: &'static [&'static str],
    tally: Tally<ValueSource>,
}

impl ErrorTally {
    /// Starts a tally of errors of `bound` at most, for a `reason`.
    pub fn new(
        name: &'static str,
        (bound, reason): (f64, &'static str),
        elements: Elements,
        value_names: &'static [&'static str],
    ) -> Self {
        Self {
            name,
            reason,
            elements,
            value_names,
            tally: Tally::new(bound),
        }
    }

    /// Adds a value of the GPU, and its twin, with this error.
    pub fn add<T: Into<Value>>(&mut self, source: ValueSource, place: ValuePlace, values: [T; 2], error: f64) {
        let [found, expected] = values.map(T::into);
        self.tally.add(Compared {
            element: place[0],
            component: place[1],
            label: source,
            found,
            expected,
            error,
        });
    }

    /// Adds a number of the GPU, and its twin, that differ in ulp of the largest of them and `size`.
    pub fn add_ulps(&mut self, source: ValueSource, place: ValuePlace, values: [f32; 2], size: f32) {
        self.add(source, place, values, ulp_distance(values[0], values[1], size));
    }

    /// Adds equal values.
    pub fn add_equal(&mut self, values: u64) {
        self.tally.add_equal(values);
    }

    /// Returns the number of compared values.
    pub fn values(&self) -> u64 {
        self.tally.values
    }

    /// Returns true if all values are within the bound, and there are some.
    pub fn agrees(&self) -> bool {
        self.tally.agrees()
    }

    /// Returns the check of the stage on `mesh`; without values it does not pass.
    pub fn stage_check(&self, mesh: &Mesh) -> StageCheck {
        self.named_check(|compared| self.describe_element(mesh, compared))
    }

    /// Returns the outcome, with a name for each element.
    pub fn named_check(&self, element_name: impl Fn(&Compared<ValueSource>) -> String) -> StageCheck {
        let difference = describe_difference(
            &self.tally,
            [self.elements.count, self.elements.lanes],
            |k| self.value_names[k].to_owned(),
            element_name,
        );
        StageCheck::of_tally((self.name, self.reason), &self.tally, difference)
    }

    fn describe_element(&self, mesh: &Mesh, compared: &Compared<ValueSource>) -> String {
        let ValueSource { shooter, sample } = compared.label;
        let Compared { element, component, .. } = *compared;
        let (value, kind) = (self.value_names[component], self.elements.name);
        let texel = mesh.texels.get(element).filter(|_| kind == "texel");
        let face = texel.map_or(String::new(), |texel| format!(" of face {}", texel.face));
        let patch = shooter.map_or(String::new(), |patch| format!(" from patch {patch}"));
        let sample = sample.map_or(String::new(), |s| format!(", sample {s}"));
        format!("{value} of {kind} {element}{face}{patch}{sample}")
    }
}

/// Describes the values beyond the bound of a tally, of so many elements and lanes, by the names of values and elements.
pub fn describe_difference<L: Copy>(
    tally: &Tally<L>,
    [elements, lanes]: [usize; 2],
    value_name: impl Fn(usize) -> String,
    element_name: impl Fn(&Compared<L>) -> String,
) -> Option<StageDifference> {
    let describe = |compared: Compared<L>| DifferingValue {
        element: element_name(&compared),
        gpu: compared.found.to_string(),
        twin: compared.expected.to_string(),
    };
    Some(StageDifference {
        first: describe(tally.first?),
        worst: describe(tally.worst?),
        beyond: tally.beyond,
        values: tally.values,
        pattern: tally.describe_pattern(elements, lanes, value_name),
    })
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
