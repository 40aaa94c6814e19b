//! Tests that take long or need the files of RADIOSITY_DATA; `make atlas` runs them.

mod brackets_data;
mod breaks;
mod capture_data;
mod capture_light;
mod estimate;
mod healthy;
mod leaks;
mod matrix_truth;
mod properties;
mod quality;
mod stress;
mod stress_random;
