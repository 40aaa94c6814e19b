//! Scenes and settings of the benchmarks.

pub mod accuracy;

use common::form_factor::FormFactor;
use common::import::{ImportOptions, load_scene};
use common::scene::{Face, Scene};
use common::settings::{Iteration, Meshing, Schedule, Settings, Transport};
use common::texel;
use glam::{DVec3, Vec3};
use radiosity_tests::box_faces;
use std::path::Path;

/// Loads the bundled scene of this file name.
pub fn bundled_scene(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    load_scene(&folder.join(name), &ImportOptions::default()).expect("bundled scenes are sound")
}

/// Returns the inside of the unit cube, each wall divided into N×N faces.
pub fn divided_cube(side: u32, emission: Vec3, reflectance: Vec3) -> Vec<Face> {
    let walls = box_faces(DVec3::ZERO, DVec3::ONE, true, emission, reflectance);
    let parts = walls
        .iter()
        .flat_map(|wall| (0..side * side).map(move |part| (wall, part)));
    let face = |(wall, part)| {
        let corners = texel::texel_outline(wall, [side, side], part).padded_corners();
        Face::quad(&wall.name, corners, emission, reflectance)
    };
    parts.map(face).collect()
}

/// Returns the paper's settings: whole faces, disc factors between centres, rays.
pub fn whole_faces(texels: u32) -> Settings {
    Settings {
        meshing: Meshing {
            texels,
            patches: 1,
            ..Meshing::default()
        },
        transport: Transport {
            form_factor: FormFactor::Disc,
            ..Transport::default()
        },
        schedule: Schedule {
            iteration: Iteration::Cg,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

/// Returns the median, the least and the largest of some values.
pub fn median_and_range(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    [values[values.len() / 2], values[0], values[values.len() - 1]]
}
