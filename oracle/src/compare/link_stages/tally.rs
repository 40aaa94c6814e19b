//! Counts the values of the stages of links that differ from their twins.

use crate::compare::comparison::StageCheck;
use crate::compare::statistics::describe_difference;
use gpu::hierarchy::link_probe::UNWRITTEN;
use gpu::link_records::PairRecord;
use stage_check::tally::{Compared, Tally, Value, ulp_distance};

/// What a value belongs to.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// A node and a block of receivers; of step 1 to 4 of refinement.
    Pair { block: u32, node: u32, step: usize },
    /// A node and a spot of a block.
    Spot { block: u32, node: u32, spot: usize },
    /// An item of a buffer.
    Item(&'static str, usize),
}

impl Place {
    pub fn of_pair(pair: &PairRecord, step: usize) -> Self {
        let PairRecord { block, node, .. } = *pair;
        Self::Pair { block, node, step }
    }

    pub fn of_spot(pair: &PairRecord, spot: usize) -> Self {
        let PairRecord { block, node, .. } = *pair;
        Self::Spot { block, node, spot }
    }

    fn describe(self) -> String {
        match self {
            Self::Pair { block, node, step: 0 } => format!("block {block} and node {node}"),
            Self::Pair { block, node, step } => format!("block {block} and node {node} after step {step}"),
            Self::Spot { block, node, spot } => format!("spot {spot} of block {block} and node {node}"),
            Self::Item(name, k) => format!("{name} {k}"),
        }
    }
}

/// A word of a buffer.
#[derive(Clone, Copy)]
pub enum Word {
    /// An integer: exact.
    Integer,
    /// A number, in ulp of the largest of both and this size.
    Float(f32),
}

/// Comparisons of a stage; an element is a pair, a spot or an item.
pub struct StageTally {
    pub name: &'static str,
    reason: &'static str,
    value_names: &'static [&'static str],
    tally: Tally<Place>,
    /// True if a number of workgroups differs.
    pub has_wrong_workgroups: bool,
}

impl StageTally {
    pub fn new(name: &'static str, (bound, reason): (f64, &'static str), value_names: &'static [&'static str]) -> Self {
        Self {
            name,
            reason,
            value_names,
            tally: Tally::new(bound),
            has_wrong_workgroups: false,
        }
    }

    /// Adds a word of the GPU and its twin's; one that was not written has no error if the twin writes none.
    pub fn add(&mut self, place: Place, [element, component]: [usize; 2], [found, expected]: [u32; 2], kind: Word) {
        if found == expected {
            return self.tally.add_equal(1);
        }
        self.has_wrong_workgroups |= self.value_names[component] == "workgroups";
        let value = |word: u32| match kind {
            _ if word == UNWRITTEN => Value::Unwritten,
            Word::Integer => word.into(),
            Word::Float(_) => f32::from_bits(word).into(),
        };
        let error = match kind {
            Word::Float(size) if ![found, expected].contains(&UNWRITTEN) => {
                ulp_distance(f32::from_bits(found), f32::from_bits(expected), size)
            }
            _ => f64::INFINITY,
        };
        self.tally.add(Compared {
            element,
            component,
            label: place,
            found: value(found),
            expected: value(expected),
            error,
        });
    }

    /// Adds equal values.
    pub fn add_equal(&mut self, values: u64) {
        self.tally.add_equal(values);
    }

    /// Returns whether two numbers differ by no more than the bound.
    pub fn allows(&self, found: f32, expected: f32, size: f32) -> bool {
        found.to_bits() == expected.to_bits() || ulp_distance(found, expected, size) <= self.tally.bound
    }

    /// Adds words of an item that are exact.
    pub fn add_exact(&mut self, name: &'static str, element: usize, component: usize, words: [u32; 2]) {
        self.add(Place::Item(name, element), [element, component], words, Word::Integer);
    }

    pub fn is_reached(&self) -> bool {
        self.tally.values > 0
    }

    /// Returns the check; without values it does not pass.
    pub fn stage_check(&self) -> StageCheck {
        let element = |compared: &Compared<Place>| {
            format!(
                "{} of {}",
                self.value_names[compared.component],
                compared.label.describe()
            )
        };
        let difference = describe_difference(&self.tally, [0, 1], |k| self.value_names[k].to_owned(), element);
        StageCheck::of_tally((self.name, self.reason), &self.tally, difference)
    }
}
