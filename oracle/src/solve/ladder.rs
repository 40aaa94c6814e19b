//! An answer to an error: solved hierarchically again and again, each time to half the error and on
//! texels half as large where that matters, until two answers differ by less than what is asked.
//!
//! What the last step changed, d, is taken for the error of the finer of the two. It is that of the
//! coarser less that of the finer; where a step halves the error the two are equal. Where it does not, d is
//! too small: so the first step is solved to the error that is asked for, and the answer to half of it.

use super::interrupt::interrupted;
use super::solved::{Moved, Solved};
use super::watch::Watch;
use crate::judge::diff::reflected::offsets;
use crate::judge::resample::{average, pieces};
use common::cover::sample;
use common::mesh::{MAX_TEXELS, Mesh};
use common::scene::Scene;
use common::settings::Settings;
use common::{Error, Result};
use cpu::hierarchy::account;
use cpu::hierarchy::solve::{Goal, Outcome, solve};
use glam::{DVec3, Vec3};
use std::ops::ControlFlow;

/// Steps at most: the last is solved to a sixteenth of the error asked for.
const STEPS: u32 = 5;
/// Texels of a step at most, of a large scene twice as many as are asked for.
const MOST: u64 = 1 << 20;
/// The share of the squared error that faces may still make up whose texels are not halved.
const LEFT: f64 = 0.25;
/// Texels a side that the first step has at least, where all are no more than [`CHEAP`].
const FEW: u32 = 8;
/// See [`FEW`].
const CHEAP: u64 = 1 << 15;
/// Points of a face that tell what of its light escapes.
const POINTS: u32 = 16;

/// One step.
struct Step {
    /// Texels a side of each face.
    sides: Vec<u32>,
    mesh: Mesh,
    outcome: Outcome,
    /// ρH of each texel, in face order.
    reflected: Vec<DVec3>,
}

/// Solves `scene` on N×N texels a face until two answers differ by less than `error`. Interrupted, it
/// is the last whole step.
///
/// Errors: [`Error::Interrupted`] before the first step is done.
pub fn climb(scene: &Scene, settings: &Settings, error: f64, watch: &Watch) -> Result<Solved> {
    let n = settings.meshing.texels;
    let mut sides = vec![first(n, scene.faces.len() as u64); scene.faces.len()];
    let mut moved = Moved::default();
    let mut last = step(scene, sides.clone(), error, watch)?;
    sides.iter_mut().for_each(|side| *side *= 2);
    for k in 1..STEPS {
        let texels: u64 = sides.iter().map(|side| u64::from(*side).pow(2)).sum();
        if k > 1 && texels > MOST.max(2 * last.mesh.texels.len() as u64).min(MAX_TEXELS) {
            moved.ended = Some(format!("{texels} texels would be too many"));
            break;
        }
        let goal = error / f64::from(1 << k);
        let next = match step(scene, sides.clone(), goal, watch) {
            Err(Error::Interrupted) => {
                moved.ended = Some("it was interrupted".into());
                break;
            }
            next => next?,
        };
        let change = change(scene, &last, &next);
        moved.changes.push(change.whole);
        moved.faces = change.worst();
        sides = change.halved(&next.sides, error);
        last = next;
        if change.whole <= error {
            break;
        }
    }
    finish(scene, settings, last, moved)
}

/// Texels a side of the first step: half as many as are asked for. Two steps on a few texels may agree by
/// chance, so there are some more where that costs nothing.
fn first(asked: u32, faces: u64) -> u32 {
    let mut side = if asked.is_multiple_of(2) {
        asked / 2
    } else {
        asked
    };
    while side < FEW && faces * 4 * u64::from(side).pow(2) <= CHEAP {
        side *= 2;
    }
    side
}

fn step(scene: &Scene, sides: Vec<u32>, goal: f64, watch: &Watch) -> Result<Step> {
    let resolutions: Vec<[u32; 2]> = sides.iter().map(|side| [*side; 2]).collect();
    let mesh = watch.of("prepare", || Mesh::new(scene, &resolutions, 1))?;
    let phase = format!("solving to {:.2} %", 100.0 * goal);
    let outcome = watch.of("solve", || {
        solve(scene, &mesh, Goal::of(goal as f32), &mut |done| {
            if interrupted() {
                watch.stop();
                return ControlFlow::Break(());
            }
            watch.tell(&phase, done)
        })
    })?;
    let reflected = |k: usize| (mesh.texels[k].reflectance * outcome.irradiance[k]).as_dvec3();
    Ok(Step {
        reflected: mesh.in_face_order().into_iter().map(reflected).collect(),
        sides,
        mesh,
        outcome,
    })
}

/// What a step changed, of the RMS of B − E, in the worst channel.
struct Change {
    whole: f64,
    /// Squared, by face; they add up to the whole.
    faces: Vec<f64>,
}

fn change(scene: &Scene, before: &Step, after: &Step) -> Change {
    let firsts = [before, after].map(|step| offsets(&squares(&step.sides)));
    let (mut squares, mut light) = (Vec::with_capacity(scene.faces.len()), DVec3::ZERO);
    for (f, face) in scene.faces.iter().enumerate() {
        let side = before.sides[f].min(after.sides[f]);
        let [a, b] = [(before, &firsts[0]), (after, &firsts[1])].map(|(step, first)| {
            let own = &step.reflected[first[f]..first[f + 1]];
            averaged(own, face, step.sides[f], side)
        });
        let area = face.area() / f64::from(side).powi(2);
        let mut own = DVec3::ZERO;
        for (a, b) in a.iter().zip(&b) {
            own += area * (b - a).powf(2.0);
            light += area * *b * *b;
        }
        squares.push(own);
    }
    let share = |c: usize| {
        let all: f64 = squares.iter().map(|own| own[c]).sum();
        if all == 0.0 { 0.0 } else { all / light[c] }
    };
    let worst = (0..3)
        .max_by(|a, b| share(*a).total_cmp(&share(*b)))
        .unwrap_or(0);
    let scale = if light[worst] > 0.0 {
        1.0 / light[worst]
    } else {
        0.0
    };
    Change {
        whole: share(worst).sqrt(),
        faces: squares.iter().map(|own| own[worst] * scale).collect(),
    }
}

impl Change {
    fn order(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.faces.len() as u32).collect();
        order.sort_by(|a, b| self.faces[*b as usize].total_cmp(&self.faces[*a as usize]));
        order
    }

    /// The faces that changed most.
    fn worst(&self) -> Vec<u32> {
        let mut order = self.order();
        order.retain(|f| self.faces[*f as usize] > 0.0);
        order.truncate(super::check::NAMED);
        order
    }

    /// Texels half as large where the rest would still be off by too much.
    fn halved(&self, sides: &[u32], error: f64) -> Vec<u32> {
        let mut sides = sides.to_vec();
        let mut rest: f64 = self.faces.iter().sum();
        for f in self.order() {
            if rest <= LEFT * error * error {
                break;
            }
            rest -= self.faces[f as usize];
            sides[f as usize] *= 2;
        }
        sides
    }
}

/// The answer on the texels that were asked for.
fn finish(scene: &Scene, settings: &Settings, step: Step, moved: Moved) -> Result<Solved> {
    let mut mesh = Mesh::uniform(scene, settings.meshing.texels, 1)?;
    sample(&mut mesh, POINTS);
    let order = step.mesh.in_face_order();
    let first = offsets(&squares(&step.sides));
    let onto = |values: &dyn Fn(usize) -> DVec3| -> Vec<DVec3> {
        let ordered: Vec<DVec3> = order.iter().map(|k| values(*k)).collect();
        let mut all = vec![DVec3::ZERO; mesh.texels.len()];
        let mut places = mesh.in_face_order().into_iter();
        for (f, face) in scene.faces.iter().enumerate() {
            let own = &ordered[first[f]..first[f + 1]];
            for value in averaged(own, face, step.sides[f], settings.meshing.texels) {
                if let Some(k) = places.next() {
                    all[k] = value;
                }
            }
        }
        all
    };
    let light = |values: &[Vec3]| -> Vec<Vec3> {
        onto(&|k| values[k].as_dvec3())
            .iter()
            .map(|v| v.as_vec3())
            .collect()
    };
    let open = onto(&|k| DVec3::splat(f64::from(step.outcome.open[k])));
    let outcome = Outcome {
        irradiance: light(&step.outcome.irradiance),
        residual: light(&step.outcome.residual),
        open: open.iter().map(|open| open.x as f32).collect(),
        links: step.outcome.links,
        passes: step.outcome.passes,
    };
    account::uncover(&mut mesh, &outcome);
    let run = account::run(&mesh, &outcome);
    Ok(Solved {
        settings: *settings,
        mesh,
        run,
        one_by_one: false,
        matrix: None,
        moved: Some(moved),
        relit: None,
    })
}

fn squares(sides: &[u32]) -> Vec<[u32; 2]> {
    sides.iter().map(|side| [*side; 2]).collect()
}

fn averaged(values: &[DVec3], face: &common::scene::Face, from: u32, to: u32) -> Vec<DVec3> {
    if from == to {
        return values.to_vec();
    }
    average(values, &pieces(face, [from; 2], [to; 2]), [to; 2])
}
