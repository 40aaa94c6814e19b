//! The catalogue: every case once, by what it is about.

mod contact;
mod light;
mod pixels;
mod relight;
mod shadows;
pub mod shapes;
mod space;
mod surfaces;
mod walls;

use super::About;
use super::RELATIVE;
use super::trial::{Build, Case};

/// All cases, in the order of the report.
pub fn all() -> Vec<&'static Case> {
    [
        contact::CASES,
        pixels::CASES,
        surfaces::CASES,
        shadows::CASES,
        walls::CASES,
        light::CASES,
        space::CASES,
        relight::CASES,
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A case judged by its relative RMS.
const fn case(
    [name, parameter]: [&'static str; 2],
    breaks: &'static str,
    truth: &'static str,
    values: &'static [f64],
    build: Build,
) -> Case {
    let about = About {
        name,
        parameter,
        breaks,
        truth,
        measure: RELATIVE,
    };
    Case {
        about,
        values,
        build,
    }
}

const LAMBERT: &str = "Lambert's factor, exact, mean over each texel";
const SHADOWS: &str = "Lambert's factor of what is left of the lamp once shadows are cut out of it, mean over each texel";
const FINER: &str = "the matrix solver on texels twice as fine, averaged";
const FURNACE: &str = "furnace: B = E/(1 − ρ)";
