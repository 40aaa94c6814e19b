//! Announces a solve of more than a minute before it starts, with the setting that would take a tenth
//! of the time.

use super::passes::{Expected, expected};
use super::trial::{Time, time};
use super::{Counts, trial};
use crate::solve::solver::Solver;
use common::Result;
use common::cover;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::{Iteration, Meshing, Settings};
use std::time::Instant;

/// Seconds that need no announcement.
const LONG: f64 = 60.0;
/// (cell, texel, sample) triples of a solve that never takes as long: some seconds by rays alone.
const SHORT: u64 = 1 << 24;
/// A pair of faces costs as much as so many triples: its shaft.
const PAIR: u64 = 64;

/// What is expected of a solve.
pub struct Ahead {
    /// Passes and shots.
    pub expected: Expected,
    /// Seconds of shooting.
    pub time: Time,
    /// Seconds before it.
    pub prepare: f64,
}

impl Ahead {
    /// All of it.
    pub fn seconds(&self) -> f64 {
        self.prepare + self.time.seconds()
    }
}

/// From a trial of a few seconds.
pub fn ahead(scene: &Scene, settings: &Settings, solver: Solver) -> Result<Ahead> {
    let start = Instant::now();
    // What stands on the points changes no time, but takes its own.
    let mut mesh = Mesh::uniform(scene, settings.meshing.texels, settings.meshing.cells)?;
    mesh.sample(settings.meshing.samples);
    let mut engine = solver.engine(&mesh, &settings.transport)?;
    let made = start.elapsed().as_secs_f64();
    let prepare = made + cover::seconds(&mesh);
    let mut settings = *settings;
    if !engine.has_room() {
        settings.schedule.iteration = Iteration::Southwell;
    }
    let expected = expected(scene, &settings)?;
    let time = time(engine.as_mut(), &mesh, &expected)?;
    Ok(Ahead {
        expected,
        time,
        prepare,
    })
}

/// What is to be said before a solve that takes long.
pub fn warning(scene: &Scene, settings: &Settings, solver: Solver) -> Result<Option<String>> {
    if triples(scene, settings) <= SHORT {
        return Ok(None);
    }
    let seconds = ahead(scene, settings, solver)?.seconds();
    Ok((seconds > LONG).then(|| {
        let advice = match tenth(scene, settings) {
            Some(options) => format!("{options} would take a tenth of that or less"),
            None => "no setting would take a tenth of that: simplify the mesh".into(),
        };
        format!(
            "{} is expected to take about {}: {advice}",
            scene.name,
            long(seconds)
        )
    }))
}

fn triples(scene: &Scene, settings: &Settings) -> u64 {
    let counts = Counts::new(scene, &settings.meshing);
    let pairs = counts.faces.saturating_mul(counts.faces);
    let links = counts.links().saturating_mul(counts.samples);
    links.saturating_add(pairs.saturating_mul(PAIR.min(counts.samples)))
}

/// The finest of fewer texels, of whole faces as well, of single samples as well.
fn tenth(scene: &Scene, settings: &Settings) -> Option<String> {
    let most = triples(scene, settings) / 10;
    let ways = [
        (settings.meshing.cells, settings.meshing.samples, ""),
        (1, settings.meshing.samples, " --cells 1"),
        (1, 1, " --cells 1 --samples 1"),
    ];
    ways.into_iter().find_map(|(cells, samples, options)| {
        let with = |texels: u32| Settings {
            meshing: Meshing {
                texels,
                cells,
                samples,
            },
            ..*settings
        };
        let fits = |texels: &u32| triples(scene, &with(*texels)) <= most;
        let texels = (1..=settings.meshing.texels).rev().find(fits)?;
        Some(format!("--texels {texels}{options}"))
    })
}

/// Two digits, in a unit that people think in.
pub fn long(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 120.0 => (s, "seconds"),
        s if s < 7200.0 => (s / 60.0, "minutes"),
        s if s < 172_800.0 => (s / 3600.0, "hours"),
        s => (s / 86_400.0, "days"),
    };
    format!("{} {unit}", trial::two(value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Face;
    use glam::{DVec3, Vec3};

    fn quads(count: usize) -> Scene {
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
        // 5² of 16² texels are 9.8 %.
        for (count, options) in [(100, Some("--texels 5")), (3000, Some("--texels 5"))] {
            assert_eq!(
                tenth(&quads(count), &settings).as_deref(),
                options,
                "{count}"
            );
        }
        let single = Settings {
            meshing: Meshing {
                texels: 1,
                cells: 1,
                samples: 1,
            },
            ..Settings::default()
        };
        assert_eq!(tenth(&quads(100_000), &single), None);
    }

    #[test]
    fn times_are_told_in_units_for_people() {
        let told: Vec<String> = [64.0, 1234.0, 13_000.0, 1e7].map(long).into();
        assert_eq!(told, ["64 seconds", "21 minutes", "3.6 hours", "120 days"]);
    }

    #[test]
    fn a_small_scene_is_not_tried() {
        assert_eq!(
            warning(&quads(2), &Settings::default(), Solver::Cpu).unwrap(),
            None
        );
    }
}
