//! Freshly drawn scenes, on which nothing was tuned: what `solve` answers there, whether it warns, and
//! whether it knows how wrong it is.

mod chart;
pub mod gates;
pub mod page;
pub mod ratio;

use super::outcome::sides;
use super::run::Run;
use super::trial::{Case, Trial, Truth};
use super::{About, RELATIVE, Row, Specimen};
use crate::judge::path_tracer::trace;
use crate::solve::watch::Watch;
use crate::study::random::{self, Options};
use common::Result;
use common::mesh::Mesh;
use common::settings::Quality;
use ratio::Ratios;

/// Its name on the command line.
pub const NAME: &str = "random";
/// Texels a side, unless others are asked for.
pub const TEXELS: u32 = 8;
/// Paths that all texels share, some four seconds on two cores: what is left of their noise in an
/// error is 0.2 to 0.5 % of the light.
pub const PATHS: u32 = 1 << 22;
/// And where answers are of reference quality: their errors are smaller.
pub const FINER_PATHS: u32 = 1 << 25;
/// Scenes of which pictures are kept.
const PICTURES: usize = 4;

const ABOUT: About = About {
    name: NAME,
    parameter: "seed",
    breaks: "whatever was tuned to the scenes that it was built on",
    truth: "paths traced through the scene's faces, their noise taken off",
    measure: RELATIVE,
};

/// What its rows are rows of.
pub const CASE: Case = Case {
    about: ABOUT,
    values: &[],
    build: |seed| trial(&Asked::default(), &drawn(&Asked::default(), seed as u64)),
};

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// What is drawn.
    pub options: Options,
    /// Texels a side of a face.
    pub texels: u32,
    /// `normal` or `reference`.
    pub quality: Quality,
    /// Paths of the truth, shared by all texels.
    pub paths: u32,
}

impl Default for Asked {
    fn default() -> Self {
        Self {
            options: Options::default(),
            texels: TEXELS,
            quality: Quality::Normal,
            paths: PATHS,
        }
    }
}

/// A scene, solved.
pub struct Found {
    /// It is drawn anew from this number.
    pub seed: u64,
    /// What it has, in words.
    pub told: String,
    /// Texels a side of a face.
    pub texels: u32,
    /// Both solvers' answers.
    pub row: Row,
}

impl Found {
    /// The worse of the errors; without an answer it is the worst.
    pub fn error(&self) -> f64 {
        self.row.error.unwrap_or(f64::INFINITY)
    }
}

/// All that was found.
#[derive(Default)]
pub struct Findings {
    /// In the order of their seeds.
    pub all: Vec<Found>,
    /// The worst of them, to be looked at; the worst first.
    pub worst: Vec<Specimen>,
}

/// The scene of a seed.
fn drawn(asked: &Asked, seed: u64) -> random::Drawn {
    random::scene(seed, asked.options)
}

/// The question that it puts.
fn trial(asked: &Asked, drawn: &random::Drawn) -> Result<Trial> {
    let method: &[&str] = match asked.quality {
        Quality::Reference => &["reference"],
        _ => &["default"],
    };
    let mesh = Mesh::uniform(&drawn.scene, asked.texels, 1)?;
    let traced = trace(
        &drawn.scene,
        &mesh,
        asked.paths / mesh.texels.len() as u32,
        0,
    );
    let truth = Truth::Traced(traced.reflected.values, traced.error);
    Ok(Trial::new(drawn.scene.clone(), asked.texels, truth).only(method))
}

impl Findings {
    /// Draws and solves `count` scenes from `seed` on; `watch` is told how many are done. After a stop
    /// those that were done are there.
    pub fn gather(
        run: &Run,
        asked: &Asked,
        (seed, count): (u64, u64),
        watch: &Watch,
    ) -> Result<Self> {
        let mut findings = Self::default();
        for k in 0..count {
            let _ = watch.count("scenes", k, count);
            if (run.stop)() {
                break;
            }
            let seed = seed + k;
            let drawn = drawn(asked, seed);
            let trial = trial(asked, &drawn)?;
            let texels = trial.texels;
            let truth = super::truth::of(&trial)?;
            let Some((rows, specimen)) = run.tried(&CASE, seed as f64, trial, &truth) else {
                break;
            };
            findings.all.extend(rows.into_iter().map(|row| Found {
                seed,
                told: drawn.to_string(),
                texels,
                row,
            }));
            findings.keep(specimen);
        }
        Ok(findings)
    }

    /// What the estimates are worth, of both solvers.
    pub fn ratios(&self) -> Ratios {
        let sides = self.all.iter().flat_map(|found| sides(&found.row));
        ratio::of(sides.map(|(_, side)| side))
    }

    /// Keeps the pictures of the worst.
    fn keep(&mut self, specimen: Option<Specimen>) {
        self.worst.extend(specimen);
        let all = &self.all;
        let error = |specimen: &Specimen| {
            let found = all.iter().find(|found| found.seed as f64 == specimen.value);
            found.map_or(0.0, Found::error)
        };
        self.worst.sort_by(|a, b| error(b).total_cmp(&error(a)));
        self.worst.truncate(PICTURES);
    }
}
