//! A case, run: every value, every method, both solvers.

use super::measure::{Seen, Tried, try_on};
use super::methods::{self, DEFAULT, Method};
use super::outcome::sides;
use super::trial::{Case, Trial};
use super::truth::Truths;
use super::{Plate, Row, Side, Specimen, Study, Verdict, limits};
use crate::solve::watch::Watch;
use common::Result;
use common::texel::count;
use glam::DVec3;
use gpu::Gpu;

/// So far beyond the limit of failing, an answer is as wrong as can be seen.
const MOST: f64 = 10.0;

/// Who asks, and on what.
pub struct Run<'a> {
    /// The GPU, if there is one.
    pub gpu: Option<&'a Gpu>,
    /// Whether to stop.
    pub stop: &'a dyn Fn() -> bool,
}

impl Run<'_> {
    /// Runs a case; none of its rows is half done, but some may be missing after a stop.
    pub fn case(&self, case: &Case, watch: &Watch) -> Result<Study> {
        let mut study = Study {
            about: case.about,
            rows: Vec::new(),
            specimen: None,
        };
        let (mut worst, mut truths) = (f64::NEG_INFINITY, Truths::default());
        for (done, value) in case.values.iter().enumerate() {
            // Whether to stop the methods ask themselves, more often.
            let _ = watch.count(case.about.parameter, done as u64, case.values.len() as u64);
            let Some((rows, specimen)) = self.value(case, *value, &mut truths)? else {
                break;
            };
            let here = failure(case.about.measure, &rows);
            if specimen.is_some() && here > worst {
                (study.specimen, worst) = (specimen, here);
            }
            study.rows.extend(rows);
        }
        Ok(study)
    }

    /// All methods at one value; none after a stop.
    fn value(
        &self,
        case: &Case,
        value: f64,
        truths: &mut Truths,
    ) -> Result<Option<(Vec<Row>, Option<Specimen>)>> {
        let trial = (case.build)(value)?;
        let empty = trial.scene.faces.is_empty();
        let truth = if empty {
            Vec::new()
        } else {
            truths.of(&trial)?
        };
        Ok(self.tried(case, value, trial, &truth))
    }

    /// All methods on one trial, whose truth is known; none after a stop.
    pub fn tried(
        &self,
        case: &Case,
        value: f64,
        trial: Trial,
        truth: &[DVec3],
    ) -> Option<(Vec<Row>, Option<Specimen>)> {
        let mut rows = Vec::new();
        let mut gallery = Gallery::default();
        for method in methods::of(trial.suite) {
            let cpu = try_on(&trial, &method, None, truth, self.stop)?;
            let gpu = match self.gpu.filter(|_| method.on_gpu()) {
                None => None,
                gpu => Some(try_on(&trial, &method, gpu, truth, self.stop)?),
            };
            let sides = (cpu.side.clone(), gpu.as_ref().map(|t| t.side.clone()));
            rows.push(row(case, value, &method, sides));
            gallery.keep(&method, "CPU", cpu);
            if let Some(gpu) = gpu {
                gallery.keep(&method, "GPU", gpu);
            }
        }
        let is_safe = |row: &Row| row.method != DEFAULT || row.verdict == Verdict::Safe;
        let safe = rows.iter().all(is_safe);
        let specimen = gallery.specimen(trial, value, truth, safe);
        Some((rows, specimen))
    }
}

/// How much of a failure there is to be seen at one value, so that this is what the pictures show: by how
/// many factors e the answers are beyond the limit together. The default's count as much as all the others';
/// a refusal has no picture.
fn failure(measure: &str, rows: &[Row]) -> f64 {
    let [safe, fails] = limits(measure);
    let beyond = |side: &Side| match side.error {
        Some(error) if error.is_finite() => (error / safe).clamp(1.0, MOST * fails / safe).ln(),
        Some(_) => (MOST * fails / safe).ln(),
        None => 0.0,
    };
    let of = |row: &Row| sides(row).map(|(_, side)| beyond(side)).sum::<f64>();
    let own = |row: &Row| {
        if row.method == DEFAULT {
            rows.len() as f64
        } else {
            1.0
        }
    };
    rows.iter().map(|row| own(row) * of(row)).sum()
}

/// Side by side, each judged by the measure of the case; the worse one speaks for both.
pub fn row(case: &Case, value: f64, method: &Method, (cpu, gpu): (Side, Option<Side>)) -> Row {
    let judged = |side: Side| Side {
        verdict: Verdict::of(case.about.measure, side.error),
        ..side
    };
    let (cpu, gpu) = (judged(cpu), gpu.map(judged));
    let rank = |side: &Side| side.error.unwrap_or(f64::INFINITY);
    let worse = gpu
        .as_ref()
        .filter(|g| rank(g) > rank(&cpu))
        .unwrap_or(&cpu);
    Row {
        case: case.about.name,
        parameter: case.about.parameter,
        value,
        method: method.name,
        error: worse.error,
        warned: worse.warned(),
        verdict: worse.verdict,
        cpu,
        gpu,
    }
}

/// The answers at one value.
#[derive(Default)]
struct Gallery {
    answers: Vec<(String, Seen)>,
}

impl Gallery {
    fn keep(&mut self, method: &Method, solver: &str, tried: Tried) {
        if let Some(answer) = tried.answer {
            self.answers
                .push((format!("{} {solver}", method.name), answer));
        }
    }

    /// The face on which the default is most off or, where it is off nowhere to speak of, all
    /// answers together, as everybody has it.
    fn specimen(self, trial: Trial, value: f64, truth: &[DVec3], safe: bool) -> Option<Specimen> {
        let shown = self
            .answers
            .iter()
            .find(|(label, _)| label.starts_with(DEFAULT))
            .or(self.answers.first())?;
        let per_face = count([trial.texels; 2]) as usize;
        let part = |values: &[DVec3], face: usize| -> Vec<DVec3> {
            let range = face * per_face..(face + 1) * per_face;
            values.get(range).unwrap_or_default().to_vec()
        };
        let off = |seen: &Seen, face: usize| -> f64 {
            let pairs = part(&seen.values, face).into_iter();
            let error = pairs.zip(part(truth, face));
            let square: f64 = error.map(|(a, b)| (a - b).length_squared()).sum();
            square * trial.scene.faces[face].area()
        };
        let judged: Vec<usize> = (0..trial.scene.faces.len())
            .filter(|k| trial.judges(*k))
            .collect();
        let rank: Vec<f64> = if safe {
            let all = |k: &usize| self.answers.iter().map(|(_, seen)| off(seen, *k)).sum();
            judged.iter().map(all).collect()
        } else {
            judged.iter().map(|k| off(&shown.1, *k)).collect()
        };
        let most = (0..judged.len()).max_by(|a, b| rank[*a].total_cmp(&rank[*b]))?;
        let face = judged[most];
        let plate = |label: &str, values: &[DVec3]| Plate {
            label: label.to_owned(),
            resolution: [trial.texels; 2],
            values: part(values, face),
        };
        let mut plates = vec![plate("truth", truth)];
        plates.extend(self.answers.iter().map(|(l, seen)| plate(l, &seen.values)));
        let (mesh, field) = (shown.1.mesh.clone(), shown.1.field.clone());
        Some(Specimen {
            value,
            scene: trial.scene,
            mesh,
            field,
            face: face as u32,
            plates,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{row, side};
    use super::super::{LEAK, RELATIVE};
    use super::*;

    fn others(default: f64, other: f64) -> f64 {
        let mut rows = vec![row(1.0, side(Some(default), ""), None); 3];
        for (row, error) in rows[1..].iter_mut().zip([other; 2]) {
            row.method = "matrix";
            row.cpu = side(Some(error), "");
        }
        failure(RELATIVE, &rows)
    }

    #[test]
    fn the_worst_failure_is_shown_and_not_the_first() {
        // Half of the methods break at once; what is to be seen comes later.
        assert!(others(0.01, 0.5) > others(0.01, 0.03));
        assert!(others(0.05, 0.5) > others(0.01, 0.5));
        assert!(others(0.3, 0.01) > others(0.01, 0.3));
        assert_eq!(others(0.01, 0.02), 0.0);
        // As wrong as can be: no number is worse than another.
        assert_eq!(others(0.01, f64::NAN), others(0.01, 1e9));
        let refused = [row(1.0, side(None, ""), None)];
        assert_eq!(failure(RELATIVE, &refused), 0.0);
        let tight = [row(1.0, side(Some(0.0), ""), None)];
        assert_eq!(failure(LEAK, &tight), 0.0);
    }
}
