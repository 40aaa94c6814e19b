//! Bracketed photographs of one view, merged into a radiance map: `radiance.exr` and `merge.html`.
//! The mathematics is in [`brackets`].

pub mod brackets;
mod chart;
pub mod fisheye;
pub mod list;
pub mod page;
mod pictures;
pub mod read;

use crate::show::picture::luminance;
use brackets::{Brackets, Merged, Response, Step};

/// A step that is seen to be this much off what its seconds say, in stops, is worth a note.
/// Cameras call 1/60 s what is 1/64 s (0.09 stops), and shutters are off by a few hundredths.
const STEP: f64 = 0.25;

/// Luminances that most of a picture lies between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The 1st percentile of the luminance of the pixels above 0.
    pub low: f32,
    /// The 99th.
    pub high: f32,
}

impl Range {
    /// None where all is black.
    pub fn of(merged: &Merged) -> Option<Self> {
        let mut values: Vec<f32> = merged.radiance.iter().map(|v| luminance(*v)).collect();
        values.retain(|value| *value > 0.0);
        values.sort_by(f32::total_cmp);
        let at = |share: f64| values.get((share * values.len() as f64) as usize).copied();
        Some(Self {
            low: at(0.01)?,
            high: at(0.99)?,
        })
    }

    /// How far they lie apart.
    pub fn stops(&self) -> f64 {
        f64::from(self.high / self.low).log2()
    }
}

/// What makes a merge doubtful.
pub fn doubts(brackets: &Brackets, response: &Response, steps: &[Step]) -> Vec<String> {
    let mut notes = Vec::new();
    let pairs = brackets.exposures().windows(2);
    for (pair, step) in pairs.zip(steps) {
        let names = [&pair[0].path, &pair[1].path].map(|path| path.display().to_string());
        match step.seen {
            Some(seen) if (seen - step.said).abs() > STEP => notes.push(format!(
                "from {} to {} the pictures show a step of {seen:.2} stops and their seconds say {:.2}: are the seconds right?",
                names[0], names[1], step.said
            )),
            None => notes.push(format!(
                "no pixel is well exposed in both {} and {}: an exposure is missing in between",
                names[0], names[1]
            )),
            Some(_) => {}
        }
    }
    for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
        let falls = response.falls(channel);
        if falls > 0 {
            notes.push(format!(
                "the response of {name} does not rise at {falls} codes: did the camera or the scene move?"
            ));
        }
    }
    notes
}
