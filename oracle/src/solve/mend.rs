//! What a solve does about its own error: options that the user did not give are changed, and the
//! scene is solved again, where that is cheap. The new answer is kept if it is better by the estimate,
//! which shares nothing with the solver.

use super::Given;
use super::check::{Cause, Estimate};
use common::Result;
use common::constants::LINK_BYTES;
use common::mesh::{Mesh, MeshFace};
use common::scene::Shape;
use common::settings::{Iteration, Meshing, Settings, Visibility};
use common::texel::Cells;

/// An estimate beyond this is mended: half of what is warned about.
pub const MEND: f64 = 0.01;
/// (cell, texel, sample) triples and pixels of a solve that is thought cheap: a second on two cores.
pub const BUDGET: u64 = 1 << 28;
/// Finer cells and more samples helped if they left no more than this of the estimate.
const HELPED: f64 = 0.8;
/// Samples that are taken without being asked for.
const SAMPLES: u32 = 256;
/// Closure in doubt that scaling mends, as a share of the emitted power.
const CLOSURE: f64 = 0.01;

/// An answer, to be mended.
pub struct Attempt<T> {
    /// It.
    pub answer: T,
    /// With which options.
    pub settings: Settings,
    /// Faces and texels.
    pub size: Size,
    /// How far it may be off; none where nobody can tell: then it is left as it is.
    pub estimate: Option<Estimate>,
    /// What of the emitted power the form factors may have lost or made up (see
    /// [`super::warnings::closure_in_doubt`]).
    pub closure: f64,
    /// Whether conjugate gradients no longer gained: rows that make up light may have no limit at all.
    pub stagnated: bool,
    /// Whether it was shot to its end.
    pub converged: bool,
}

/// How large a scene is: a triangle has about half as many cells as a quad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Faces that are quads.
    pub quads: u64,
    /// Faces that are triangles.
    pub triangles: u64,
    /// Texels of all.
    pub texels: u64,
}

impl Size {
    /// Of `mesh`.
    pub fn of(mesh: &Mesh) -> Self {
        let triangle = |face: &&MeshFace| face.corners[2] == face.corners[3];
        let triangles = mesh.faces.iter().filter(triangle).count() as u64;
        Self {
            quads: mesh.faces.len() as u64 - triangles,
            triangles,
            texels: mesh.texels.len() as u64,
        }
    }

    fn cells(self, settings: &Settings) -> u64 {
        let resolution = [settings.meshing.texels; 2];
        let of = |shape| u64::from(Cells::new(shape, resolution, settings.meshing.cells).count());
        self.quads * of(Shape::Quad) + self.triangles * of(Shape::Triangle)
    }
}

/// What is changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Change {
    /// Rays take the item buffer's place.
    Rays,
    /// Form factors are scaled to the closure.
    Scaled,
    /// More cells and samples.
    Finer,
}

/// Mends `first` as long as that helps and is cheap; `again` is another answer, or none where it was
/// stopped. A line for each thing that was tried.
pub fn mended<T>(
    given: Given,
    first: Attempt<T>,
    mut again: impl FnMut(&Settings) -> Result<Option<Attempt<T>>>,
) -> Result<(Attempt<T>, Vec<String>)> {
    let (mut best, mut notes, mut tried) = (first, Vec::new(), Vec::new());
    while let Some((change, settings, what)) = next(given, &best, &tried) {
        let Some(found) = again(&settings)? else {
            break;
        };
        let [before, after] = [&best, &found].map(|a| a.estimate.as_ref().map(|e| e.error));
        let (Some(before), Some(after)) = (before, after) else {
            break;
        };
        let (was, is) = (100.0 * before, 100.0 * after);
        // What came to no end is no answer: where walls are that white no look can tell.
        let better = if best.converged == found.converged {
            after < before
        } else {
            found.converged
        };
        if change != Change::Finer || !better || after > HELPED * before {
            tried.push(change);
        }
        if better {
            notes.push(format!("mended: about {was:.1} % off, so {what}"));
            best = found;
        } else {
            notes.push(format!(
                "not mended: {what}, and it was about {is:.1} % off instead of {was:.1} %"
            ));
        }
    }
    Ok((best, notes))
}

/// What to solve with next, and how to say it; none where nothing is to be mended, or nothing can be
/// that was not tried.
fn next<T>(
    given: Given,
    solved: &Attempt<T>,
    tried: &[Change],
) -> Option<(Change, Settings, String)> {
    let estimate = solved.estimate.as_ref()?;
    if mendable(estimate) <= MEND && !solved.stagnated {
        return None;
    }
    let (change, settings, mut what) = change(given, solved, estimate, tried)?;
    let settings = affordable(given, &settings, solved.size)?;
    if change != Change::Rays
        && settings.transport.visibility != solved.settings.transport.visibility
    {
        what += ", by rays";
    }
    Some((change, settings, what))
}

/// What of the error more cells and samples may take away: all but what whole texels make wrong.
fn mendable(estimate: &Estimate) -> f64 {
    let texels = part(estimate, Cause::Texels);
    (estimate.error.powi(2) - texels.powi(2)).max(0.0).sqrt()
}

/// What a cause explains.
fn part(estimate: &Estimate, cause: Cause) -> f64 {
    let found = estimate.parts.iter().find(|part| part.cause == cause);
    found.map_or(0.0, |part| part.error)
}

/// The change that takes away most, of those that were not tried.
fn change<T>(
    given: Given,
    solved: &Attempt<T>,
    estimate: &Estimate,
    tried: &[Change],
) -> Option<(Change, Settings, String)> {
    let settings = &solved.settings;
    let rays = settings.transport.visibility == Visibility::Rays || given.visibility;
    let hidden = part(estimate, Cause::Visibility) > part(estimate, Cause::Cells);
    if !rays && hidden && !tried.contains(&Change::Rays) {
        let settings = settings.by(Visibility::Rays);
        let what = "rays took the item buffer's place";
        return Some((Change::Rays, settings, what.into()));
    }
    let closed =
        given.form_factor || settings.transport.conserve || tried.contains(&Change::Scaled);
    if (solved.closure > CLOSURE || solved.stagnated) && !closed {
        let what = "form factors were scaled so that no light is lost or made up";
        return Some((Change::Scaled, scaled(settings), what.into()));
    }
    let finer = finer(given, settings);
    (finer != *settings && !tried.contains(&Change::Finer)).then(|| {
        let what = format!(
            "{0}×{0} cells and {1} samples",
            finer.meshing.cells, finer.meshing.samples
        );
        (Change::Finer, finer, what)
    })
}

/// Scaled rows are not reciprocal, and conjugate directions need that: at ρ ≥ 0.999 they fail.
fn scaled(settings: &Settings) -> Settings {
    let mut scaled = *settings;
    scaled.transport.conserve = true;
    if scaled.schedule.iteration == Iteration::Cg {
        scaled.schedule.iteration = Iteration::Chebyshev;
    }
    scaled
}

fn finer(given: Given, settings: &Settings) -> Settings {
    let mut finer = *settings;
    let Meshing {
        texels,
        cells,
        samples,
    } = &mut finer.meshing;
    if !given.cells {
        *cells = (2 * *cells).min(*texels);
    }
    if !given.samples {
        *samples = (4 * *samples).min(SAMPLES.max(*samples));
    }
    finer
}

/// The settings where they are cheap; by rays where an item buffer's pixels are not, and rays are.
fn affordable(given: Given, settings: &Settings, size: Size) -> Option<Settings> {
    let by_rays = settings.by(Visibility::Rays);
    let choices = [Some(*settings), (!given.visibility).then_some(by_rays)];
    let mut choices = choices.into_iter().flatten();
    choices.find(|settings| cost(settings, size) <= BUDGET)
}

/// All that may be solved to mend what was solved at `settings`, in turns.
pub fn steps(given: Given, settings: &Settings, size: Size) -> Vec<Settings> {
    let mut steps = Vec::new();
    let mut now = *settings;
    loop {
        let next = finer(given, &now);
        match affordable(given, &next, size) {
            Some(next) if next != now => {
                steps.push(next);
                now = next;
            }
            _ => return steps,
        }
    }
}

/// Triples and pixels of a solve of so many faces and texels; all there are where the links would
/// not be kept.
pub fn cost(settings: &Settings, size: Size) -> u64 {
    let (cells, texels) = (size.cells(settings), size.texels);
    let links = cells.saturating_mul(texels);
    if links.saturating_mul(4) > LINK_BYTES {
        return u64::MAX;
    }
    let pixels = match settings.transport.visibility {
        Visibility::Rays => 0,
        Visibility::Drawn(drawing) => drawing.pixels() * u64::from(drawing.projection.sides()),
    };
    let points = cells.saturating_mul(u64::from(settings.meshing.samples));
    points.saturating_mul(texels.saturating_add(pixels))
}

#[cfg(test)]
mod tests {
    use super::super::check::{Evidence, Part};
    use super::*;
    use common::settings::{Drawing, Schedule};

    /// At 16×16 texels.
    const CUBE: Size = Size {
        quads: 6,
        triangles: 0,
        texels: 6 * 256,
    };

    fn estimate(error: f64) -> Estimate {
        Estimate {
            error,
            upper: error,
            evidence: Evidence::Moved {
                changes: Vec::new(),
            },
            parts: vec![Part {
                cause: Cause::Cells,
                error,
                faces: vec![0],
            }],
        }
    }

    fn attempt(settings: &Settings, error: f64, closure: f64) -> Attempt<f64> {
        Attempt {
            answer: error,
            settings: *settings,
            size: CUBE,
            estimate: Some(estimate(error)),
            closure,
            stagnated: false,
            converged: true,
        }
    }

    fn normal() -> Settings {
        Settings {
            meshing: Meshing {
                samples: 4,
                ..Meshing::default()
            },
            schedule: Schedule {
                iteration: Iteration::Cg,
                ..Schedule::default()
            },
            ..Settings::default()
        }
    }

    #[test]
    fn a_change_that_harms_is_not_kept() {
        let first = attempt(&normal(), 0.042, 0.05);
        let (best, notes) = mended(Given::default(), first, |settings| {
            Ok(Some(attempt(
                settings,
                if settings.transport.conserve {
                    0.26
                } else {
                    0.008
                },
                0.05,
            )))
        })
        .unwrap();
        assert!(
            notes[0].starts_with("not mended: form factors"),
            "{notes:?}"
        );
        assert!(notes[1].starts_with("mended: about 4.2 %"), "{notes:?}");
        assert!(
            !best.settings.transport.conserve && best.settings.meshing.cells == 8,
            "{:?}",
            best.settings
        );
        assert_eq!(best.answer, 0.008);
    }

    #[test]
    fn what_does_not_help_is_not_done_again() {
        let mut solves = 0;
        let (best, notes) = mended(
            Given::default(),
            attempt(&normal(), 0.03, 0.0),
            |settings| {
                solves += 1;
                Ok(Some(attempt(settings, 0.03 * 0.9f64.powi(solves), 0.0)))
            },
        )
        .unwrap();
        assert_eq!((solves, notes.len()), (1, 1));
        assert!(best.answer < 0.03);
    }

    #[test]
    fn more_cells_are_no_cure_for_whole_texels() {
        let mut first = attempt(&normal(), 0.03, 0.0);
        first.estimate.as_mut().unwrap().parts.push(Part {
            cause: Cause::Texels,
            error: 0.029,
            faces: vec![0],
        });
        let again = |_: &Settings| -> Result<_> { panic!("solved again") };
        let (best, notes) = mended(Given::default(), first, again).unwrap();
        assert!(best.answer == 0.03 && notes.is_empty());
    }

    #[test]
    fn pixels_count() {
        let drawn = normal().by(Visibility::Drawn(Drawing::DEFAULT));
        let size = CUBE;
        assert!(cost(&drawn, size) > BUDGET && cost(&normal(), size) < BUDGET);
        let found = affordable(Given::default(), &drawn, size).unwrap();
        assert_eq!(found.transport.visibility, Visibility::Rays);
        let given = Given {
            visibility: true,
            ..Given::default()
        };
        assert_eq!(affordable(given, &drawn, size), None);
    }
}
