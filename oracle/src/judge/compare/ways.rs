//! Which ways of solving a scene are judged: the one that was asked for; with nothing asked, what
//! `solve` does by default and the paper's way. All are compared with one truth.

use super::truth::Truth;
use super::{Request, asked, compare};
use crate::judge::comparison::{Comparison, Judged, Way};
use crate::solve::solver::Asked;
use crate::solve::watch::Watch;
use common::Result;
use common::scene::Scene;
use common::settings::Settings;
use gpu::{Fault, Gpu};

/// What is judged; `visibility` is the GPU's.
pub enum Ways {
    /// The paper's way, and what `solve` does by default: it solves to an error.
    Both {
        /// Whole faces, discs, single shots.
        paper: Settings,
        /// The error.
        asked: Asked,
    },
    /// Shooting, as it is.
    Shooting(Settings),
    /// To an error.
    ToError(Asked, Settings),
}

/// Judges `scene` in all its ways.
pub fn judge(
    scene: &Scene,
    ways: &Ways,
    gpu: &Gpu,
    faults: &[Fault],
    watch: &Watch,
) -> Result<Judged> {
    let (Ways::Both {
        paper: settings, ..
    }
    | Ways::Shooting(settings)
    | Ways::ToError(_, settings)) = ways;
    let shooting = |settings: &Settings| {
        let request = Request {
            settings: *settings,
            gpu,
            faults,
        };
        compare(scene, &request, watch)
    };
    let to_error = |to: &Asked| asked::compare(scene, *to, settings, (gpu, faults), watch);
    let truth = Truth::new(scene, settings.meshing.texels, watch)?;
    let truth = truth.as_ref();
    Ok(match ways {
        Ways::Shooting(settings) => alone(against(shooting(settings)?, truth, Way::Asked)),
        Ways::ToError(to, _) => alone(against(to_error(to)?, truth, Way::Asked)),
        Ways::Both { paper, asked } => Judged {
            as_solved: Some(against(to_error(asked)?, truth, Way::Solve)),
            first: against(shooting(paper)?, truth, Way::Paper),
        },
    })
}

fn alone(first: Comparison) -> Judged {
    Judged {
        first,
        as_solved: None,
    }
}

/// The runs of `c` held against the truth.
fn against(mut c: Comparison, truth: Option<&Truth>, way: Way) -> Comparison {
    c.way = way;
    c.truth = truth.map(|truth| truth.told.clone());
    c.error = [&c.cpu, &c.gpu].map(|run| truth.map(|truth| truth.error(&c.mesh, &run.field)));
    c
}
