//! How far an answer to an error may be off: by what its last step changed, by light that was not shot, by
//! what links made up or lost, by rounding.

use super::change::Change;
use super::check::{Cause, Estimate, Evidence, NAMED, Part, Worse};
use super::left::{rounding, unspent};
use super::sides::{averaged, order};
use common::mesh::Mesh;
use common::scene::Face;
use common::shooting::Run;
use cpu::hierarchy::again::Left;
use glam::DVec3;

/// A change that is so much of the one before says nothing of what is left.
const SLOW: f64 = 0.75;
/// A face is named that is so many times as far off as the whole.
const WORSE: f64 = 10.0;

/// How a solve to an error went.
#[derive(Default)]
pub struct Moved {
    /// What each step changed, of the RMS of B − E.
    pub changes: Vec<f64>,
    /// The last of them.
    pub change: Option<Change>,
    /// What the last step leaves out, as far as texels that received again tell.
    pub left_out: Left,
    /// To which error it was solved.
    pub goal: f64,
    /// Its links.
    pub links: u64,
    /// Why it ended above what was asked.
    pub ended: Option<String>,
}

impl Moved {
    /// What is left after the last change d: as much as that, or d·q/(1 − q) where changes fall more slowly,
    /// each q of the one before; none after a single step.
    pub fn left(&self) -> Option<f64> {
        Some(self.changes.last()? * self.grown())
    }

    /// What is left, of the last change.
    fn grown(&self) -> f64 {
        let mut last = self.changes.iter().rev();
        let (Some(last), Some(before)) = (last.next(), last.next()) else {
            return 1.0;
        };
        let fall = (last / before).min(SLOW);
        (fall / (1.0 - fall)).max(1.0)
    }

    /// All that is left of `run` as an error; `made_up` is what links made up or lost.
    pub fn estimate(&self, mesh: &Mesh, run: &Run, made_up: f64) -> Option<Estimate> {
        let refinement = self.left()?;
        let faces = self.change.as_ref().map(Change::worst).unwrap_or_default();
        let part = |cause: Cause, error: f64, faces: Vec<u32>| Part {
            cause,
            error,
            faces,
        };
        let mut parts: Vec<Part> = self
            .causes()
            .iter()
            .map(|(cause, share)| part(*cause, refinement * share, faces.clone()))
            .collect();
        parts.extend([
            part(Cause::Iteration, unspent(mesh, run), Vec::new()),
            part(Cause::Closure, made_up, Vec::new()),
            part(Cause::Rounding, rounding(mesh, run), Vec::new()),
        ]);
        let square: f64 = parts.iter().map(|part| part.error.powi(2)).sum();
        let error = square.sqrt();
        Some(Estimate {
            error,
            upper: error,
            evidence: Evidence::Moved {
                changes: self.changes.clone(),
                worse: self.worse(error),
            },
            parts,
        })
    }

    /// Of what the refinement leaves, each cause's share: their squares add up to 1.
    fn causes(&self) -> Vec<(Cause, f64)> {
        let channel = self.change.as_ref().map_or(0, |change| change.channel);
        let left = &self.left_out;
        let causes = [
            (Cause::Sources, left.sources),
            (Cause::Visibility, left.visibility),
            (Cause::Receivers, left.receivers),
            (Cause::Propagation, left.propagation),
            (Cause::Texels, left.texels),
        ];
        let all: f64 = causes.iter().map(|(_, square)| square[channel]).sum();
        if all > 0.0 {
            let share = |(cause, square): (Cause, DVec3)| (cause, (square[channel] / all).sqrt());
            causes.map(share).to_vec()
        } else {
            vec![(Cause::Refinement, 1.0)]
        }
    }

    /// The faces that are more than [`WORSE`] times as far off as `error`, each of its own light; those of
    /// the most light first.
    fn worse(&self, error: f64) -> Vec<Worse> {
        let Some(change) = &self.change else {
            return Vec::new();
        };
        let of = |face: u32| Worse {
            face,
            error: self.grown() * change.own(face),
        };
        let faces = order(&change.faces).into_iter().map(of);
        let worse = faces.filter(|own| own.error > WORSE * error);
        worse.take(NAMED).collect()
    }

    /// How far each texel of `mesh` may be off for want of refinement, W/m²; none after a single step.
    pub fn map(&self, faces: &[Face], mesh: &Mesh) -> Option<Vec<f32>> {
        let change = self.change.as_ref()?;
        let grown = self.grown();
        let mut map = vec![0.0; mesh.texels.len()];
        let mut order = mesh.in_face_order().into_iter();
        let mut first = 0;
        for ((face, side), to) in faces.iter().zip(&change.sides).zip(&mesh.faces) {
            let end = first + (*side as usize).pow(2);
            let own = averaged(&change.squares[first..end], face, *side, to.resolution[0]);
            for (d, k) in own.iter().zip(&mut order) {
                map[k] = (grown * d.max_element().sqrt()) as f32;
            }
            first = end;
        }
        Some(map)
    }

    /// What is to be said where less than `asked` was reached, of an estimate.
    pub fn short_of(&self, asked: f64, estimate: Option<&Estimate>) -> Option<String> {
        let reached = estimate.map(|estimate| estimate.error);
        if reached.is_some_and(|error| error <= asked) {
            return None;
        }
        let told = reached.map_or("nobody knows".into(), |error| {
            format!("about {:.2} %", 100.0 * error)
        });
        let why = self.ended.as_deref().unwrap_or(match self.left() {
            Some(left) if left <= asked => {
                "the rest is unshot, made up or lost by links, or rounding"
            }
            _ => "it was solved as often as is done",
        });
        Some(format!(
            "an error of {:.2} % was asked, and {told} was reached: {why}",
            100.0 * asked
        ))
    }
}
