//! An answer to an error: solved hierarchically again and again, each time to half the error and on
//! texels half as large where that matters, until two answers differ by less than what is asked.
//!
//! What the last step changed, d, is taken for the error of the finer of the two. It is that of the
//! coarser less that of the finer; where a step halves the error the two are equal. Where it does not, d is
//! too small: so the first step is solved to the error that is asked for, and the answer to half of it; and
//! where changes fall more slowly than by halves, what is left follows from how they fall.

use super::change::Change;
use super::interrupt::interrupted;
use super::moved::Moved;
use super::near::beside;
use super::sides::{count, halved};
use super::step::Step;
use super::watch::Watch;
use common::mesh::MAX_TEXELS;
use common::scene::Scene;
use common::{Error, Result};
use std::ops::ControlFlow;

/// Steps at most.
const STEPS: u32 = 6;
/// No step is solved to less than this share of the error that is asked for: what still changes then is
/// for want of smaller texels.
const FINE: f64 = 0.25;
/// Texels of a step at most, of a large scene twice as many as are asked for.
const MOST: u64 = 1 << 20;
/// The share of the squared error that faces may still make up whose texels are not halved.
const LEFT: f64 = 0.25;

/// How a scene is solved step by step.
pub trait Stepped {
    /// What a step comes to.
    type Done: AsRef<Step>;

    /// All faces.
    fn scene(&self) -> &Scene;

    /// Solved to `goal` on so many texels a side of each face, with what the step before has found.
    ///
    /// Errors: [`Error::Interrupted`].
    fn step(&self, sides: Vec<u32>, goal: f64, last: Option<&Step>) -> Result<Self::Done>;

    /// Texels a side on which a face's light is asked for; none: they follow from the light.
    fn asked(&self, face: usize) -> Option<u32>;

    /// Texels of the first step.
    fn first(&self) -> Result<Vec<u32>>;

    /// Texels of the second.
    fn second(&self, first: &Self::Done) -> Result<Vec<u32>>;

    /// Whether the texels of a face may be halved.
    fn may(&self, face: usize) -> bool;

    /// Texels on which the light is shown, if others than those of the last step.
    fn shown(&self, last: &Self::Done, change: &Change, error: f64) -> Option<Vec<u32>>;
}

/// Solves until two answers differ by less than `error`. Interrupted, it is the last whole step.
///
/// Errors: [`Error::Interrupted`] before the first step is done.
pub fn ascend<S: Stepped>(stepped: &S, error: f64) -> Result<(S::Done, Moved)> {
    let scene = stepped.scene();
    let mut moved = Moved::default();
    let mut goal = error;
    let mut last = stepped.step(stepped.first()?, goal, None)?;
    let mut sides = stepped.second(&last)?;
    for k in 1..STEPS {
        let texels_now = count(&sides);
        let most = MOST.max(2 * last.as_ref().mesh.texels.len() as u64);
        if k > 1 && texels_now > most.min(MAX_TEXELS) {
            moved.ended = Some(format!("{texels_now} texels would be too many"));
            break;
        }
        goal = (0.5 * goal).max(FINE * error);
        let next = match stepped.step(sides.clone(), goal, Some(last.as_ref())) {
            Err(Error::Interrupted) => {
                moved.ended = Some("it was interrupted".into());
                break;
            }
            next => next?,
        };
        let asked = |f: usize| stepped.asked(f);
        let change = Change::new(scene, last.as_ref(), next.as_ref(), &asked);
        last = next;
        moved.changes.push(change.whole);
        let enough = moved.left().is_some_and(|left| left <= error);
        let left = LEFT * error * error;
        sides = halved(&last.as_ref().sides, &change.faces, left, |f, _| {
            stepped.may(f)
        });
        let before = &last.as_ref().sides;
        beside(&scene.faces, before, &mut sides, |f| stepped.may(f));
        if enough && let Some(shown) = stepped.shown(&last, &change, error) {
            last = stepped.step(shown, goal, Some(last.as_ref()))?;
        }
        moved.change = Some(change);
        if enough {
            break;
        }
    }
    moved.goal = goal;
    moved.links = last.as_ref().outcome.links;
    Ok((last, moved))
}

/// Tells how far a step has come; stops where that is asked for.
pub fn told<'a>(watch: &'a Watch, phase: &'a str) -> impl FnMut(f64) -> ControlFlow<()> + 'a {
    move |done| {
        if interrupted() {
            watch.stop();
            return ControlFlow::Break(());
        }
        watch.tell(phase, done)
    }
}
