//! A scene solved to an error. Where nobody says on how many texels, they follow from the light: they are
//! halved until what varies within them is a few times the error at most.

use super::change::Change;
use super::ladder::{Stepped, ascend, told};
use super::moved::Moved;
use super::sides::{FINEST, averaged, count, first, halved, second, squares, width};
use super::solved::Solved;
use super::solver::Asked;
use super::step::{Step, narrowed, onto};
use super::watch::Watch;
use crate::judge::diff::reflected::offsets;
use common::cover::sample;
use common::mesh::{Mesh, Texel};
use common::scene::Scene;
use common::settings::Settings;
use common::solution::{Code, Warning};
use common::{Error, Result};
use cpu::hierarchy::account;
use cpu::hierarchy::again::{Left, again};
use cpu::hierarchy::find::Way;
use cpu::hierarchy::solve::{Goal, Outcome, solve_by};
use glam::{DVec3, Vec3};

/// Texels vary within themselves by so many times the error at most, where they follow from the light.
const WITHIN: f64 = 4.0;
/// And are so many in all at most.
const FILLED: u64 = 1 << 17;
/// Points of a face that tell what of its light escapes.
pub const POINTS: u32 = 16;

/// A scene, and on which texels it is asked for.
struct Climb<'a> {
    scene: &'a Scene,
    texels: Option<u32>,
    /// Who finds links.
    way: Way<'a>,
    watch: &'a Watch<'a>,
}

/// Solves `scene`, with links found this `way`, until two answers differ by less than `asked` has it. Interrupted, it is the last whole
/// step.
///
/// Errors: [`common::Error::Interrupted`] before the first step is done.
pub fn climb(
    scene: &Scene,
    settings: &Settings,
    asked: Asked,
    way: Way,
    watch: &Watch,
) -> Result<Solved> {
    let climb = Climb {
        scene,
        texels: asked.texels,
        way,
        watch,
    };
    let (step, mut moved) = ascend(&climb, asked.error)?;
    climb.look_again(&step, &mut moved)?;
    let mut solved = finish(scene, settings, asked, step, moved)?;
    solved.run.field.origin = format!("hierarchy by {}", way.name());
    Ok(solved)
}

impl AsRef<Step> for Step {
    fn as_ref(&self) -> &Step {
        self
    }
}

impl Stepped for Climb<'_> {
    type Done = Step;

    fn scene(&self) -> &Scene {
        self.scene
    }

    fn step(&self, sides: Vec<u32>, goal: f64, last: Option<&Step>) -> Result<Step> {
        let mesh = self
            .watch
            .of("prepare", || Mesh::new(self.scene, &squares(&sides), 1))?;
        let phase = format!("solving to {:.2} %", 100.0 * goal);
        let off = last.map_or(Vec::new(), |last| last.off(&self.scene.faces, &sides, goal));
        let goal = Goal::of(goal as f32);
        let mut told = told(self.watch, &phase);
        let outcome = self.watch.of("solve", || {
            solve_by(self.scene, &mesh, &off, goal, self.way, &mut told)
        })?;
        Ok(Step::new(sides, mesh, outcome))
    }

    fn asked(&self, _: usize) -> Option<u32> {
        self.texels
    }

    fn first(&self) -> Result<Vec<u32>> {
        Ok(first(self.scene, &|f| self.asked(f), width(self.scene)?))
    }

    fn second(&self, first: &Step) -> Result<Vec<u32>> {
        let width = width(self.scene)?;
        Ok(second(self.scene, &|f| self.asked(f), width, &first.sides))
    }

    fn may(&self, _: usize) -> bool {
        true
    }

    fn shown(&self, last: &Step, change: &Change, error: f64) -> Option<Vec<u32>> {
        if self.texels.is_some() {
            return None;
        }
        let filled = filled(self.scene, last, change, error);
        (filled != last.sides && count(&filled) <= FILLED).then_some(filled)
    }
}

impl Climb<'_> {
    /// What the last step leaves out: of that texels receive again where it changed most. Interrupted, nobody
    /// knows.
    ///
    /// Errors: those of a step.
    fn look_again(&self, step: &Step, moved: &mut Moved) -> Result<()> {
        let Some(off) = moved.map(&self.scene.faces, &step.mesh) else {
            return Ok(());
        };
        let weigh = |(off, texel): (&f32, &Texel)| off * off * texel.area;
        let weight: Vec<f32> = off.iter().zip(&step.mesh.texels).map(weigh).collect();
        let goal = Goal::of(moved.goal as f32);
        let irradiance = &step.outcome.irradiance;
        let mut told = told(self.watch, "looking again");
        let looked = self.watch.of("check", || {
            again(self.scene, &step.mesh, irradiance, &weight, goal, &mut told)
        });
        moved.left_out = match looked {
            Err(Error::Interrupted) => Left::default(),
            looked => looked?,
        };
        Ok(())
    }
}

/// The warnings, with advice that goes with an error that is asked for.
pub fn advised(mut warnings: Vec<Warning>) -> Vec<Warning> {
    for warning in &mut warnings {
        let advice = match warning.code {
            Code::Closure => ": ask for a lower --error",
            Code::Texels => ": what is near the faces it names is smaller than their texels",
            Code::Unshot => ": lower the reflectances",
            Code::Unlit => ": ask for more --texels",
            _ => continue,
        };
        if let Some((said, _)) = warning.message.rsplit_once(": ") {
            warning.message = format!("{said}{advice}");
        }
    }
    warnings
}

/// The answer on the texels that were asked for.
fn finish(
    scene: &Scene,
    settings: &Settings,
    asked: Asked,
    step: Step,
    moved: Moved,
) -> Result<Solved> {
    let to = |f: usize| asked.texels.unwrap_or(step.sides[f]);
    let sides: Vec<u32> = (0..scene.faces.len()).map(to).collect();
    let mut mesh = Mesh::new(scene, &squares(&sides), 1)?;
    sample(&mut mesh, POINTS);
    // A mesh has its texels in face order where each face is one cell.
    let light =
        |values: &[Vec3]| narrowed(onto(&scene.faces, &step, &sides, &|k| values[k].as_dvec3()));
    let open = |k: usize| DVec3::splat(f64::from(step.outcome.open[k]));
    let open = narrowed(onto(&scene.faces, &step, &sides, &open));
    let mut irradiance = light(&step.outcome.irradiance);
    weigh(scene, &step, &mesh, &mut irradiance);
    let outcome = Outcome {
        irradiance,
        residual: light(&step.outcome.residual),
        open: open.iter().map(|open| open.x).collect(),
        off: Vec::new(),
        links: step.outcome.links,
        passes: step.outcome.passes,
        spent: step.outcome.spent,
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

/// Where ρ varies within the texels that are asked for, H is weighed by it: so B = E + ρH is the mean over the
/// texel, with its mean ρ.
fn weigh(scene: &Scene, step: &Step, mesh: &Mesh, irradiance: &mut [Vec3]) {
    let (mut from, mut to) = (0, 0);
    for (f, face) in scene.faces.iter().enumerate() {
        let (many, few) = (step.sides[f], mesh.faces[f].resolution[0]);
        let [first, next] = [from, to];
        from += (many as usize).pow(2);
        to += (few as usize).pow(2);
        if face.paint.is_none() || many <= few {
            continue;
        }
        let reflected = averaged(&step.reflected[first..from], face, many, few);
        let texels = mesh.texels[next..to].iter();
        for ((h, texel), all) in irradiance[next..to].iter_mut().zip(texels).zip(reflected) {
            let rho = texel.reflectance;
            *h = Vec3::select(rho.cmpgt(Vec3::ZERO), all.as_vec3() / rho, *h);
        }
    }
}

/// Texels so small that the light varies little within them. Half of its square within four texels that
/// make up a larger one is taken for that within one of them: at a shadow's edge it is, of a slope less.
fn filled(scene: &Scene, step: &Step, change: &Change, error: f64) -> Vec<u32> {
    let first = offsets(&squares(&step.sides));
    let order = step.mesh.in_face_order();
    let mut within = Vec::with_capacity(scene.faces.len());
    for (f, face) in scene.faces.iter().enumerate() {
        let side = step.sides[f];
        let own = &step.reflected[first[f]..first[f + 1]];
        // Of what is painted the light counts, not the paint.
        let even: Vec<DVec3>;
        let own = match face.paint {
            Some(_) => {
                let rho = face.reflectance.as_dvec3();
                let texels = order[first[f]..first[f + 1]].iter();
                let light = texels.map(|k| rho * step.outcome.irradiance[*k].as_dvec3());
                even = light.collect();
                &even
            }
            None => own,
        };
        let mut sum = 0.0;
        if side.is_multiple_of(2) {
            let coarse = averaged(own, face, side, side / 2);
            let coarse = averaged(&coarse, face, side / 2, side);
            let off = |(a, b): (&DVec3, &DVec3)| (a - b)[change.channel].powi(2);
            sum = own.iter().zip(&coarse).map(off).sum();
        }
        within.push(0.5 * sum * change.scale * face.area() / f64::from(side).powi(2));
    }
    let left = (WITHIN * error).powi(2);
    halved(&step.sides, &within, left, |_, side| side < FINEST)
}
