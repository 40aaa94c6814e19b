//! Merges bracketed photographs of one view into a radiance map: `radiance.exr` and `merge.html`.
//! [`brackets`] holds the mathematics.

pub mod brackets;
pub mod page;
pub mod photographs;

use crate::report::picture::compute_luminance;
use brackets::{Brackets, CameraResponse, ExposureStep, RadianceMap};

/// Maximum difference between measured and nominal exposure step without a note, in stops. Cameras label 1/64 s as
/// 1/60 s (0.09 stops), and shutters deviate by a few hundredths.
const MAX_STEP_DEVIATION: f64 = 0.25;

/// Returns the ratio of the 99th to the 1st percentile of luminance over the pixels above 0, in stops; none if all
/// pixels are black.
pub fn luminance_stops(merged: &RadianceMap) -> Option<f64> {
    let mut values: Vec<f32> = merged.radiance.iter().map(|v| compute_luminance(*v)).collect();
    values.retain(|value| *value > 0.0);
    values.sort_by(f32::total_cmp);
    let at = |share: f64| Some(f64::from(*values.get((share * values.len() as f64) as usize)?));
    Some((at(0.99)? / at(0.01)?).log2())
}

/// Returns notes on implausible steps, missing exposures and falling response curves.
pub fn merge_notes(brackets: &Brackets, response: &CameraResponse, steps: &[ExposureStep]) -> Vec<String> {
    let mut notes = Vec::new();
    let pairs = brackets.photographs().windows(2);
    for (pair, step) in pairs.zip(steps) {
        let names = [&pair[0].path, &pair[1].path].map(|path| path.display().to_string());
        match step.measured {
            Some(seen) if (seen - step.nominal).abs() > MAX_STEP_DEVIATION => notes.push(format!(
                "from {} to {} the pictures show a step of {seen:.2} stops and their seconds say {:.2}: are the seconds right?",
                names[0], names[1], step.nominal
            )),
            None => notes.push(format!(
                "no pixel is well exposed in both {} and {}: an exposure is missing in between",
                names[0], names[1]
            )),
            Some(_) => {}
        }
    }
    for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
        let falls = response.count_falls(channel);
        if falls > 0 {
            notes.push(format!(
                "the response of {name} does not rise at {falls} codes: did the camera or the scene move?"
            ));
        }
    }
    notes
}
