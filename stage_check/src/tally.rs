//! Counts comparisons of values, and describes those that differ by more than a bound: the first, the worst, how many,
//! and what they have in common.

use std::fmt;

/// A value in a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A number in f32.
    Float(f32),
    /// An integer.
    Integer(i64),
    /// No value: the buffer still has what was there before the stage.
    Unwritten,
}

impl From<f32> for Value {
    fn from(value: f32) -> Self {
        Self::Float(value)
    }
}

impl From<u32> for Value {
    fn from(value: u32) -> Self {
        Self::Integer(value.into())
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Float(value) => write!(f, "{value:?}"),
            Self::Integer(value) => write!(f, "{value}"),
            Self::Unwritten => f.write_str("not written"),
        }
    }
}

/// A value that a stage made, beside the reference.
#[derive(Clone, Copy, Debug)]
pub struct Compared<L> {
    /// Number of the element, of which the pattern is found.
    pub element: usize,
    /// Number of the component in the element.
    pub component: usize,
    /// What the element is, for the message.
    pub label: L,
    /// The stage's value.
    pub found: Value,
    /// The reference.
    pub expected: Value,
    /// Error, in the unit of the bound.
    pub error: f64,
}

/// Numbers of compared values, and a description of those beyond the bound.
#[derive(Clone, Debug)]
pub struct Tally<L> {
    /// Largest error allowed.
    pub bound: f64,
    /// Compared values.
    pub values: u64,
    /// Values with an error.
    pub unequal: u64,
    /// Largest error; NaN if one is NaN.
    pub largest_error: f64,
    /// Values beyond the bound.
    pub beyond: u64,
    /// The value beyond the bound that has the lowest element; of several the one that was added first.
    pub first: Option<Compared<L>>,
    /// The value beyond the bound that has the largest error.
    pub worst: Option<Compared<L>>,
    last_element: usize,
    /// Greatest common divisor of the distances between elements beyond the bound.
    step: usize,
    /// Bits of the components: of all compared values, and of those beyond the bound.
    components: [u64; 2],
    unwritten: u64,
}

impl<L: Copy> Tally<L> {
    /// Starts a tally.
    pub fn new(bound: f64) -> Self {
        Self {
            bound,
            values: 0,
            unequal: 0,
            largest_error: 0.0,
            beyond: 0,
            first: None,
            worst: None,
            last_element: 0,
            step: 0,
            components: [0; 2],
            unwritten: 0,
        }
    }

    /// Adds a value.
    pub fn add(&mut self, compared: Compared<L>) {
        self.values += 1;
        self.unequal += u64::from(compared.error != 0.0);
        self.largest_error = larger_or_nan(self.largest_error, compared.error);
        let component = 1 << compared.component.min(63);
        self.components[0] |= component;
        // A NaN is beyond any bound.
        if compared.error <= self.bound {
            return;
        }
        self.beyond += 1;
        self.components[1] |= component;
        self.unwritten += u64::from(compared.found == Value::Unwritten);
        let first = self.first.get_or_insert(compared);
        self.step = greatest_common_divisor(self.step, compared.element.abs_diff(first.element));
        if compared.element < first.element {
            *first = compared;
        }
        self.last_element = self.last_element.max(compared.element);
        let worst = self.worst.get_or_insert(compared);
        if larger_or_nan(worst.error, compared.error).to_bits() != worst.error.to_bits() && !worst.error.is_nan() {
            *worst = compared;
        }
    }

    /// Adds values without an error.
    pub fn add_equal(&mut self, values: u64) {
        self.values += values;
    }

    /// True if there are values, and all are within the bound.
    pub fn agrees(&self) -> bool {
        self.values > 0 && self.beyond == 0
    }

    /// Describes what the values beyond the bound have in common. `elements` is the number of elements, which
    /// workgroups of `lanes` process in order; `name` returns the name of a component.
    pub fn describe_pattern(&self, elements: usize, lanes: usize, name: impl Fn(usize) -> String) -> String {
        let Some(first) = &self.first else {
            return "none".to_owned();
        };
        let (first, last, lanes) = (first.element, self.last_element, lanes.max(1));
        let last_group = elements.saturating_sub(1) / lanes * lanes;
        let place = if self.beyond == self.values {
            "all of them".to_owned()
        } else if first == last {
            format!("only element {first}")
        } else if lanes > 1 && self.step.is_multiple_of(lanes) {
            format!("only lane {} of the workgroups", first % lanes)
        } else if last_group > 0 && first >= last_group {
            "only in the last workgroup".to_owned()
        } else if self.step > 1 {
            format!("only 1 element in {}, from {first} to {last}", self.step)
        } else {
            format!("elements {first} to {last}")
        };
        let [all, wrong] = self.components;
        // The highest bit stands for all further components.
        let component = match all != wrong && wrong.is_power_of_two() && wrong < 1 << 63 {
            true => format!(", only {}", name(wrong.trailing_zeros() as usize)),
            false => String::new(),
        };
        let unwritten = match self.unwritten {
            0 => String::new(),
            count if count == self.beyond => ", none of them written".to_owned(),
            count => format!(", {count} of them not written"),
        };
        format!("{place}{component}{unwritten}")
    }
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// Returns the larger number; NaN if any is NaN, which `f64::max` would drop.
pub fn larger_or_nan(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Returns |a − b| in units in the last place of the largest of |a|, |b| and `size`; NaN if a number is.
pub fn ulp_distance(a: f32, b: f32, size: f32) -> f64 {
    let largest = f64::from(a.abs().max(b.abs()).max(size));
    if a == b {
        0.0
    } else {
        (f64::from(a) - f64::from(b)).abs() / (largest * f64::from(f32::EPSILON))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the pattern of 256 elements of two components in groups of 64, of which `wrong` differ.
    fn pattern_of(wrong: impl Fn(usize, usize) -> bool) -> String {
        let mut tally = Tally::new(1.0);
        for k in 0..512 {
            let (element, component) = (k / 2, k % 2);
            let error = if wrong(element, component) { 2.0 } else { 1.0 };
            tally.add(Compared {
                element,
                component,
                label: (),
                found: 0.0.into(),
                expected: 0.0.into(),
                error,
            });
        }
        tally.describe_pattern(256, 64, |k| format!(".{}", ["x", "y"][k]))
    }

    #[test]
    fn patterns_are_named() {
        assert_eq!(pattern_of(|_, _| false), "none");
        assert_eq!(pattern_of(|_, _| true), "all of them");
        assert_eq!(pattern_of(|k, _| k == 7), "only element 7");
        assert_eq!(pattern_of(|k, _| k % 64 == 5), "only lane 5 of the workgroups");
        assert_eq!(pattern_of(|k, _| k >= 200), "only in the last workgroup");
        assert_eq!(pattern_of(|k, _| k % 4 == 3), "only 1 element in 4, from 3 to 255");
        assert_eq!(pattern_of(|k, c| k > 1 && c == 1), "elements 2 to 255, only .y");
    }

    #[test]
    fn nan_is_beyond_any_bound_and_the_worst() {
        let mut tally = Tally::new(f64::MAX);
        for (element, error) in [1.0, f64::NAN, f64::INFINITY].into_iter().enumerate() {
            tally.add(Compared {
                element,
                component: 0,
                label: (),
                found: 0.0.into(),
                expected: 0.0.into(),
                error,
            });
        }
        assert_eq!((tally.beyond, tally.worst.map(|worst| worst.element)), (2, Some(1)));
        assert!(tally.largest_error.is_nan() && !tally.agrees());
        assert!(ulp_distance(f32::NAN, 1.0, 0.0).is_nan());
        assert_eq!(ulp_distance(1.0, 1.0 + f32::EPSILON, 2.0), 0.5);
    }
}
