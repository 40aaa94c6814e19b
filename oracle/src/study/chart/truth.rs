//! What the points are judged by: a given result, else the matrix's, else the finest of the CPU.

use super::store::digest;
use crate::judge::diff::pair::Pair;
use crate::judge::diff::reflected::Reflected;
use crate::solve::dense;
use crate::solve::refine::{Rung, refine};
use common::mesh::Mesh;
use common::passes::solve;
use common::scene::Scene;
use common::settings::{Iteration, Quality, Settings};
use common::shooting::Run;
use common::solution::{Seconds, Solution, Stored};
use common::{Error, Result};
use cpu::CpuSolver;
use cpu::matrix::Matrix;
use cpu::matrix::memory::{MEMORY, bytes};
use cpu::occlusion::cover::sampled;
use glam::DVec3;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::path::Path;

/// The truth.
pub struct Truth {
    /// What it is, in words.
    pub name: String,
    /// Its texels and values.
    pub stored: Stored,
    /// The values' own name: points judged by others are other points.
    pub id: u64,
}

/// Told the phase, steps done and steps in all; may break.
pub type Watch<'a> = &'a mut dyn FnMut(&str, u64, u64) -> ControlFlow<()>;

impl Truth {
    /// A result of `solve`.
    pub fn read(dir: &Path, name: String) -> Result<Self> {
        let stored = Stored::read(dir)?;
        let bits: Vec<[u32; 3]> = stored
            .radiosity
            .iter()
            .map(|v| v.to_array().map(f32::to_bits))
            .collect();
        let id = digest(&(bits, &stored.resolutions));
        Ok(Self { name, stored, id })
    }

    /// Refuses a truth of another scene.
    pub fn check(&self, scene: &Scene) -> Result<()> {
        let truth = Reflected::from(&self.stored);
        let black = Reflected {
            scene,
            resolutions: truth.resolutions.clone(),
            values: vec![DVec3::ZERO; truth.values.len()],
        };
        match Pair::new(&black, &truth, None) {
            Ok(_) => Ok(()),
            Err(mismatch) => Err(Error::input(
                self.stored.dir.join("result.json"),
                mismatch.face.map_or(String::new(), |k| format!("face {k}")),
                format!("{} ({})", mismatch.message, scene.name),
            )),
        }
    }

    /// Ours on N×N texels, kept in `dir`: one that is there already is taken.
    pub fn own(scene: &Scene, texels: u32, dir: &Path, watch: Watch) -> Result<Self> {
        let count = scene.faces.len() as u64 * u64::from(texels).pow(2);
        let dense = bytes(count) <= MEMORY;
        let name = if dense {
            format!("the matrix solver on {texels}×{texels} texels a face")
        } else {
            format!("the CPU at --quality reference, {texels}×{texels} texels a face")
        };
        if let Ok(there) = Self::read(dir, name.clone()) {
            return Ok(there);
        }
        common::solution::prepare(dir)?;
        if dense {
            by_matrix(scene, texels, dir, watch)?;
        } else {
            by_refinement(scene, texels, dir, watch)?;
        }
        Self::read(dir, name)
    }
}

fn by_matrix(scene: &Scene, texels: u32, dir: &Path, watch: Watch) -> Result<()> {
    let settings = Settings {
        texels,
        cells: 1,
        ..Settings::default()
    };
    let mesh = Mesh::uniform(scene, texels, 1)?;
    let (matrix, _) = Matrix::assemble(scene, &mesh, &mut |done, all| watch("truth", done, all))?;
    let (run, _) = dense::solve(&mesh, &matrix)?;
    write(scene, &mesh, &settings, ("matrix", &run), dir)
}

fn by_refinement(scene: &Scene, texels: u32, dir: &Path, watch: Watch) -> Result<()> {
    let (_, cells, samples, epsilon) = Quality::Reference.settings();
    let settings = Settings {
        quality: Quality::Reference,
        texels,
        cells,
        samples,
        epsilon,
        iteration: Iteration::Cg,
        ..Settings::default()
    };
    let stopped = Cell::new(false);
    let rung = |settings: &Settings| {
        let mesh = sampled(scene, settings)?;
        let mut engine = CpuSolver::new(&mesh, settings);
        let run = solve(&mut engine, &mesh, settings, &mut |done| {
            let flow = watch("truth", (1000.0 * done) as u64, 1000);
            stopped.set(stopped.get() || flow.is_break());
            flow
        })?;
        Ok(Rung {
            settings: settings.clone(),
            mesh,
            run,
        })
    };
    let refined = refine(scene, &settings, rung, || stopped.get())?;
    if stopped.get() {
        return Err(Error::Interrupted);
    }
    let run = Run {
        field: refined.field,
        ..refined.rung.run
    };
    write(scene, &refined.answer, &settings, ("cpu", &run), dir)
}

fn write(
    scene: &Scene,
    mesh: &Mesh,
    settings: &Settings,
    (solver, run): (&str, &Run),
    dir: &Path,
) -> Result<()> {
    let solution = Solution {
        scene,
        mesh,
        solver,
        adapter: None,
        settings,
        run,
        certificate: None,
        warnings: &[],
        notes: &[],
        matrix: None,
        relit: None,
        seconds: Seconds::default(),
    };
    solution.write(dir)
}
