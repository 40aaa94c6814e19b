//! The catalogue of cases by topic.

mod contact;
mod light;
mod pixels;
mod relight;
mod shadows;
pub mod shapes;
mod space;
mod surfaces;
mod walls;

use super::CaseInfo;
use super::RELATIVE_RMS;
use super::trial::{BuildTrial, Case};

/// Returns all cases in the order of the report.
pub fn all_cases() -> Vec<&'static Case> {
    [
        contact::CONTACT_CASES,
        pixels::PIXEL_CASES,
        surfaces::SURFACE_CASES,
        shadows::SHADOW_CASES,
        walls::WALL_CASES,
        light::LIGHT_CASES,
        space::SPACE_CASES,
        relight::RELIGHT_CASES,
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Makes a case that is judged by relative RMS error.
const fn rms_case(
    [name, parameter]: [&'static str; 2],
    breaks: &'static str,
    truth: &'static str,
    values: &'static [f64],
    build: BuildTrial,
) -> Case {
    let about = CaseInfo {
        name,
        parameter,
        breaks,
        truth,
        measure: RELATIVE_RMS,
    };
    Case {
        info: about,
        values,
        build,
    }
}

const LAMBERT_TRUTH: &str = "Lambert's factor, exact, mean over each texel";
const SHADOW_TRUTH: &str =
    "Lambert's factor of what is left of the lamp once shadows are cut out of it, mean over each texel";
const FINER_TRUTH: &str = "the matrix solver on texels twice as fine, averaged";
const FURNACE_TRUTH: &str = "furnace: B = E/(1 − ρ)";
