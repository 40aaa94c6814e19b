//! Forecasts the time of a solve by shooting, and announces one of more than a minute before it starts, with the
//! settings that would take a tenth of the time.

use super::passes::{ExpectedPasses, estimate_passes};
use super::trial::{SolveTime, time_patches};
use super::{SceneCounts, trial};
use common::Result;
use common::cover;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::{Iteration, Meshing, Settings};
use oracle::solve::solver::SolverChoice;
use std::time::Instant;

/// Longest solve without an announcement, in seconds.
const MAX_UNANNOUNCED_SECONDS: f64 = 60.0;
/// Largest number of (patch, texel, sample) triples of a solve that is certainly shorter: some seconds by rays.
const MAX_SHORT_TRIPLES: u64 = 1 << 24;
/// Cost of the shaft of a pair of faces, in triples.
const TRIPLES_PER_PAIR: u64 = 64;

/// Expected cost of a solve.
pub struct Forecast {
    /// Passes and shots.
    pub expected: ExpectedPasses,
    /// Seconds of linking and shooting.
    pub time: SolveTime,
    /// Seconds of preparation before them.
    pub prepare: f64,
}

impl Forecast {
    /// Returns all seconds.
    pub fn total_seconds(&self) -> f64 {
        self.prepare + self.time.total_seconds()
    }
}

/// Forecasts a solve from a trial of a few seconds.
pub fn forecast_solve(scene: &Scene, settings: &Settings, solver: SolverChoice) -> Result<Forecast> {
    let start = Instant::now();
    // Covered sample points do not change the time of the trial, so they are not looked for; their time is added.
    let mut mesh = Mesh::uniform(scene, settings.meshing.texels, settings.meshing.patches)?;
    mesh.place_samples(settings.meshing.samples);
    let mut engine = solver.create_engine(&mesh, &settings.transport)?;
    let made = start.elapsed().as_secs_f64();
    let prepare = made + cover::estimate_seconds(&mesh);
    let mut settings = *settings;
    if !engine.has_room() {
        settings.schedule.iteration = Iteration::Southwell;
    }
    let expected = estimate_passes(scene, &settings)?;
    let time = time_patches(engine.as_mut(), &mesh, &expected)?;
    Ok(Forecast {
        expected,
        time,
        prepare,
    })
}

/// Returns the announcement of a solve of more than a minute.
pub fn announce_long_solve(scene: &Scene, settings: &Settings, solver: SolverChoice) -> Result<Option<String>> {
    if count_triples(scene, settings) <= MAX_SHORT_TRIPLES {
        return Ok(None);
    }
    let seconds = forecast_solve(scene, settings, solver)?.total_seconds();
    Ok((seconds > MAX_UNANNOUNCED_SECONDS).then(|| {
        let advice = match options_for_a_tenth(scene, settings) {
            Some(options) => format!("{options} would take a tenth of that or less"),
            None => "no setting would take a tenth of that: simplify the mesh".into(),
        };
        format!(
            "{} is expected to take about {}: {advice}",
            scene.name,
            format_duration(seconds)
        )
    }))
}

/// Counts (patch, texel, sample) triples, those of shafts included.
fn count_triples(scene: &Scene, settings: &Settings) -> u64 {
    let counts = SceneCounts::new(scene, &settings.meshing);
    let pairs = counts.faces.saturating_mul(counts.faces);
    let links = counts.link_count().saturating_mul(counts.samples);
    links.saturating_add(pairs.saturating_mul(TRIPLES_PER_PAIR.min(counts.samples)))
}

/// Returns the finest options with a tenth of the triples: fewer texels, then whole faces, then single samples.
fn options_for_a_tenth(scene: &Scene, settings: &Settings) -> Option<String> {
    let most = count_triples(scene, settings) / 10;
    let ways = [
        (settings.meshing.patches, settings.meshing.samples, ""),
        (1, settings.meshing.samples, " --patches 1"),
        (1, 1, " --patches 1 --samples 1"),
    ];
    ways.into_iter().find_map(|(patches, samples, options)| {
        let with = |texels: u32| Settings {
            meshing: Meshing {
                texels,
                patches,
                samples,
            },
            ..*settings
        };
        let fits = |texels: &u32| count_triples(scene, &with(*texels)) <= most;
        let texels = (1..=settings.meshing.texels).rev().find(fits)?;
        Some(format!("--texels {texels}{options}"))
    })
}

/// Formats a time with two digits in seconds, minutes, hours or days.
pub fn format_duration(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 120.0 => (s, "seconds"),
        s if s < 7200.0 => (s / 60.0, "minutes"),
        s if s < 172_800.0 => (s / 3600.0, "hours"),
        s => (s / 86_400.0, "days"),
    };
    format!("{} {unit}", trial::format_two_digits(value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Face;
    use glam::{DVec3, Vec3};

    fn scene_of_quads(count: usize) -> Scene {
        let c = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let face = Face::quad("", c, Vec3::ONE, Vec3::splat(0.5));
        Scene {
            name: "many".into(),
            faces: vec![face; count],
            ..Scene::default()
        }
    }

    #[test]
    fn a_tenth_is_a_tenth() {
        let settings = Settings {
            meshing: Meshing {
                samples: 4,
                ..Meshing::default()
            },
            ..Settings::default()
        };
        // 5² of 16² texels are 9.8 % of the work.
        for (count, options) in [(100, Some("--texels 5")), (3000, Some("--texels 5"))] {
            assert_eq!(
                options_for_a_tenth(&scene_of_quads(count), &settings).as_deref(),
                options,
                "{count}"
            );
        }
        let single = Settings {
            meshing: Meshing {
                texels: 1,
                patches: 1,
                samples: 1,
            },
            ..Settings::default()
        };
        assert_eq!(options_for_a_tenth(&scene_of_quads(100_000), &single), None);
    }

    #[test]
    fn times_are_told_in_units_for_people() {
        let told: Vec<String> = [64.0, 1234.0, 13_000.0, 1e7].map(format_duration).into();
        assert_eq!(told, ["64 seconds", "21 minutes", "3.6 hours", "120 days"]);
    }

    #[test]
    fn a_small_scene_is_not_tried() {
        assert_eq!(
            announce_long_solve(&scene_of_quads(2), &Settings::default(), SolverChoice::Cpu).unwrap(),
            None
        );
    }
}
