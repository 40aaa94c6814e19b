//! Settings and figures of the benchmarks.

pub mod accuracy;

use common::form_factor::FormFactor;
use common::settings::{Iteration, Settings, Visibility};
use radiosity_tests::engines::settings_of;

/// Returns the paper's settings: whole faces, disc factors between centres, rays.
pub fn whole_faces(texels: u32) -> Settings {
    let mut settings = settings_of([texels, 1, 1], Visibility::Rays, Settings::default().schedule.epsilon);
    settings.transport.form_factor = FormFactor::Disc;
    settings.schedule.iteration = Iteration::Cg;
    settings
}

/// Returns the median, the least and the largest of some values.
pub fn median_and_range(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    [values[values.len() / 2], values[0], values[values.len() - 1]]
}
