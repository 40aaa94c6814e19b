//! What the answers are compared with: the dense matrix on as many texels as take a few seconds.

use crate::judge::comparison::Told;
use crate::judge::diff::pair::Pair;
use crate::judge::diff::reflected::Reflected;
use crate::solve::dense;
use crate::solve::solver::Solver;
use crate::solve::task::Task;
use crate::solve::watch::{Watch, unwatched};
use common::Result;
use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::Field;
use glam::DVec3;

/// Texels of the truth: their form factors take about five seconds on two cores, growing with the
/// square.
const TEXELS: usize = 2500;
/// Texels a side below which a matrix is no truth: shadows would be smaller than its texels.
const LEAST: u32 = 4;

/// The matrix's answer.
pub struct Truth {
    scene: Scene,
    resolutions: Vec<[u32; 2]>,
    values: Vec<DVec3>,
    /// What it is.
    pub told: Told,
}

impl Truth {
    /// The matrix on N×N texels a face, N as asked for or as many as there may be; none where
    /// that would be fewer than four. Both ways to solve are held against the same truth.
    pub fn new(scene: &Scene, texels: u32, watch: &Watch) -> Result<Option<Self>> {
        let most = (TEXELS / scene.faces.len().max(1)).isqrt() as u32;
        let side = most.min(texels.max(2 * LEAST));
        if side < LEAST {
            return Ok(None);
        }
        let told = |_: &str, done| watch.tell("truth", done);
        let fine = solve(scene, side, &Watch::new(&told))?;
        let coarse = solve(scene, side / 2, &unwatched())?;
        let mut truth = Self {
            scene: scene.clone(),
            resolutions: fine.resolutions,
            values: fine.values,
            told: Told {
                name: format!("the matrix solver on {side}×{side} texels a face"),
                texels: side,
                own_error: f64::NAN,
            },
        };
        truth.told.own_error = truth.error_of(&coarse);
        Ok(Some(truth))
    }

    /// Relative RMS of a field on the texels of `mesh`, both averaged on common texels.
    pub fn error(&self, mesh: &Mesh, field: &Field) -> f64 {
        self.error_of(&Reflected::of(&self.scene, mesh, field))
    }

    fn error_of(&self, answer: &Reflected) -> f64 {
        let truth = Reflected {
            scene: &self.scene,
            resolutions: self.resolutions.clone(),
            values: self.values.clone(),
        };
        match Pair::new(answer, &truth, None) {
            Ok(pair) => pair.worst().0,
            Err(_) => f64::NAN,
        }
    }
}

fn solve<'a>(scene: &'a Scene, texels: u32, watch: &Watch) -> Result<Reflected<'a>> {
    let solved = scene.once(&dense::settings(texels), Solver::Matrix, watch)?;
    Ok(Reflected::of(scene, &solved.mesh, &solved.run.field))
}
