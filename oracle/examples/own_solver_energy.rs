//! A solver of your own, held to the radiosity equation: what its answer shines is gathered anew at
//! every texel (B = E + ρH), as `radiosity check` does, and every watt is accounted for.
//!
//! `cargo run --release --example own_solver_energy [SCENE]`, of a convex scene

use oracle::prelude::*;
use std::path::Path;

/// Texels per side of a face.
const SIDE: u32 = 8;
/// Bounces that the solver follows.
const BOUNCES: usize = 30;

fn main() -> Result<()> {
    let scene = std::env::args().nth(1);
    let scene = scene.unwrap_or_else(|| "scenes/furnace.obj".into());
    let judged = judged(Path::new(&scene))?;
    println!(
        "{:.2} % off; gathered anew it differs by {:.2} %; imbalance {:.1e}",
        100.0 * judged.diff.worst(),
        100.0 * judged.one_bounce,
        judged.energy.imbalance
    );
    Ok(())
}

/// What is found of the solver's answer.
pub fn judged(path: &Path) -> Result<Judged> {
    let scene = load(path, &ImportOptions::default())?;
    let radiosity = own_solver(&scene);
    // Texels face after face, within a face row by row.
    let resolutions = vec![[SIDE; 2]; scene.faces.len()];
    let answer = Stored::of(scene, resolutions, radiosity)?;
    judge(&answer, None, &unwatched())
}

/// A texel as a point.
struct Spot {
    at: DVec3,
    normal: DVec3,
    area: f64,
    emission: DVec3,
    reflectance: DVec3,
}

/// B of each texel, without visibility, from point to point: put yours in its place.
fn own_solver(scene: &Scene) -> Vec<Vec3> {
    let spots: Vec<Spot> = scene.faces.iter().flat_map(spots).collect();
    let mut radiosity: Vec<DVec3> = spots.iter().map(|spot| spot.emission).collect();
    for _ in 0..BOUNCES {
        let gathered = spots.iter().map(|to| {
            let shining = spots.iter().zip(&radiosity);
            let light: DVec3 = shining.map(|(from, b)| form_factor(to, from) * b).sum();
            to.emission + to.reflectance * light
        });
        radiosity = gathered.collect();
    }
    radiosity.iter().map(|b| b.as_vec3()).collect()
}

fn spots(face: &Face) -> Vec<Spot> {
    let normal = face.vector_area().normalize();
    let spot = |k| {
        let outline = texel::outline(face, [SIDE; 2], k);
        Spot {
            at: outline.centroid(),
            normal,
            area: outline.area(),
            emission: face.emission.as_dvec3(),
            reflectance: face.reflectance.as_dvec3(),
        }
    };
    (0..texel::count([SIDE; 2])).map(spot).collect()
}

/// Wallace's disc: cosθ cosθ' A / (π r² + A).
fn form_factor(to: &Spot, from: &Spot) -> f64 {
    let line = from.at - to.at;
    let cosines = to.normal.dot(line).max(0.0) * (-from.normal.dot(line)).max(0.0);
    let squared = line.length_squared().max(f64::MIN_POSITIVE);
    cosines / squared * from.area / (std::f64::consts::PI * squared + from.area)
}
