//! Check of a solver of your own by the radiosity equation: its answer is gathered again at every texel
//! (B = E + ρH), as `radiosity check` does, and its energy balance is computed.
//!
//! `cargo run --release --example own_solver_energy [SCENE]`, for a convex scene

use oracle::prelude::*;
use std::path::Path;

/// Texels per side of a face.
const TEXELS_PER_SIDE: u32 = 8;
/// Number of bounces of the solver.
const MAX_BOUNCES: usize = 30;

fn main() -> Result<()> {
    let scene = std::env::args().nth(1);
    let scene = scene.unwrap_or_else(|| "scenes/furnace.obj".into());
    let judged = check_own_solver(Path::new(&scene))?;
    println!(
        "error {:.2} %; difference to its own gather {:.2} %; imbalance {:.1e}",
        100.0 * judged.diff.worst_rms(),
        100.0 * judged.one_bounce,
        judged.energy.imbalance
    );
    Ok(())
}

/// Checks the solver's answer for the scene at `path`.
pub fn check_own_solver(path: &Path) -> Result<JudgedResult> {
    let scene = load_scene(path, &ImportOptions::default())?;
    let radiosity = solve_by_bounces(&scene);
    // Texels face after face, within a face row by row.
    let resolutions = vec![[TEXELS_PER_SIDE; 2]; scene.faces.len()];
    let answer = StoredSolution::from_radiosity(scene, resolutions, radiosity)?;
    judge_result(&answer, None, &without_progress())
}

/// Texel as a point.
struct TexelPoint {
    position: DVec3,
    normal: DVec3,
    area: f64,
    emission: DVec3,
    reflectance: DVec3,
}

/// Returns B of each texel, without visibility, from point to point. Put your own solver here.
fn solve_by_bounces(scene: &Scene) -> Vec<Vec3> {
    let points: Vec<TexelPoint> = scene.faces.iter().flat_map(texel_points).collect();
    let mut radiosity: Vec<DVec3> = points.iter().map(|point| point.emission).collect();
    for _ in 0..MAX_BOUNCES {
        let gathered = points.iter().map(|to| {
            let sources = points.iter().zip(&radiosity);
            let light: DVec3 = sources.map(|(from, b)| form_factor(to, from) * b).sum();
            to.emission + to.reflectance * light
        });
        radiosity = gathered.collect();
    }
    radiosity.iter().map(|b| b.as_vec3()).collect()
}

fn texel_points(face: &Face) -> Vec<TexelPoint> {
    let normal = face.vector_area().normalize();
    let point = |k| {
        let outline = texel::texel_outline(face, [TEXELS_PER_SIDE; 2], k);
        TexelPoint {
            position: outline.centroid(),
            normal,
            area: outline.area(),
            emission: face.emission.as_dvec3(),
            reflectance: face.reflectance.as_dvec3(),
        }
    };
    (0..texel::texel_count([TEXELS_PER_SIDE; 2])).map(point).collect()
}

/// Returns the form factor of Wallace's disc: cosθ cosθ' A / (π r² + A).
fn form_factor(to: &TexelPoint, from: &TexelPoint) -> f64 {
    let line = from.position - to.position;
    let cosines = to.normal.dot(line).max(0.0) * (-from.normal.dot(line)).max(0.0);
    let squared = line.length_squared().max(f64::MIN_POSITIVE);
    cosines / squared * from.area / (std::f64::consts::PI * squared + from.area)
}
