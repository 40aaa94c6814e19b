//! What must hold of the solvers, by subject. What takes long or needs RADIOSITY_DATA is in `atlas`.

mod capture;
mod dense;
mod exact;
mod hierarchy;
mod house;
mod relight;
mod robustness;
mod shooting;
mod twins;
