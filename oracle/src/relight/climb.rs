//! A relight to an error: what the objects change is solved step by step, and the room with it where it is a
//! scene. Where the objects' shadows show, the room's texels are as small as a shadow's foot.

use super::room::Values;
use super::stage::Stage;
use crate::judge::diff::reflected::offsets;
use crate::solve::change::Change;
use crate::solve::climb::POINTS;
use crate::solve::ladder::{Stepped, ascend, told};
use crate::solve::sides::{averaged, count, first, second, squares, width};
use crate::solve::solved::{Recovered, Solved};
use crate::solve::solver::Asked;
use crate::solve::step::{Step, narrowed, onto};
use crate::solve::watch::Watch;
use common::cover::sample;
use common::mesh::Mesh;
use common::relight::surface::Surface;
use common::scene::{Face, Scene};
use common::settings::Settings;
use common::texel;
use common::{Error, Result};
use cpu::hierarchy::account;
use cpu::hierarchy::find::Way;
use cpu::hierarchy::relight::{Known, irradiance, relight};
use cpu::hierarchy::solve::{Goal, Outcome, solve_by};
use cpu::hierarchy::state::open;
use glam::{Vec3, Vec4};
use std::f64::consts::SQRT_2;

/// A change within a texel that is this share of the RMS of the reflected light can be seen.
const VISIBLE: f64 = 0.02;
/// An object's extent over the width of the texels on which its shadow is seen.
const FOOT: f64 = 50.0;
/// Texels a side of a face at most.
const SIDE: u32 = 512;
/// And in all.
const ALL: u64 = 1 << 19;

/// What a step comes to.
pub struct Relit {
    step: Step,
    /// B₀ and B of each texel.
    before: Vec<Vec3>,
    radiosity: Vec<Vec3>,
    /// Texels that were found to emit.
    emitters: usize,
}

impl AsRef<Step> for Relit {
    fn as_ref(&self) -> &Step {
        &self.step
    }
}

/// A relight, and whether all of it is solved again instead of what changes.
struct Climb<'a> {
    stage: &'a Stage,
    again: bool,
    texels: Option<u32>,
    /// Who finds links.
    way: Way<'a>,
    watch: &'a Watch<'a>,
}

/// The room as it was captured, on the texels of a step.
struct Captured {
    values: Values,
    /// H₀, the mean over each texel's area, and the open share of that.
    irradiance: Vec<Vec3>,
    open: Vec<f32>,
}

/// Relights `stage`, with links found this `way`, until two answers differ by less than `asked` has it; `again`: by solving everything
/// again.
///
/// Errors: a captured face of W×H texels; [`Error::Interrupted`] before the first step is done.
pub fn climb(
    stage: &Stage,
    again: bool,
    settings: &Settings,
    asked: Asked,
    way: Way,
    watch: &Watch,
) -> Result<Solved> {
    if let Some([w, h]) = stage.resolutions.iter().find(|[w, h]| w != h) {
        return Err(Error::Usage(format!(
            "the room was captured on {w}×{h} texels a face, and N×N are solved to an error: give an option of shooting, --epsilon 0.001"
        )));
    }
    let climb = Climb {
        stage,
        again,
        texels: asked.texels,
        way,
        watch,
    };
    let (relit, moved) = ascend(&climb, asked.error)?;
    let Relit {
        step,
        before,
        radiosity,
        emitters,
    } = climb.shown_on(relit)?;
    let mut mesh = step.mesh;
    sample(&mut mesh, POINTS);
    account::uncover(&mut mesh, &step.outcome);
    let mut run = account::run(&mesh, &step.outcome);
    // B₀ + ρΔH and not E + ρH: what does not change keeps its bits.
    run.field.radiosity = wide(&radiosity);
    let of_objects = |cell: u32| mesh.is_object(mesh.cells[cell as usize].face);
    let object_shots = run.shots.iter().filter(|s| of_objects(s.cell)).count();
    let told = Recovered {
        before: wide(&before),
        emitters,
        complete: true,
        map_shots: run.shots.len() - object_shots,
        object_shots,
    };
    Ok(Solved {
        settings: *settings,
        mesh,
        run,
        one_by_one: false,
        matrix: None,
        moved: Some(moved),
        relit: Some(told),
    })
}

impl Stepped for Climb<'_> {
    type Done = Relit;

    fn scene(&self) -> &Scene {
        &self.stage.scene
    }

    fn step(&self, sides: Vec<u32>, goal: f64, last: Option<&Step>) -> Result<Relit> {
        let faces = &self.stage.scene.faces;
        let off = last.map_or(Vec::new(), |last| last.off(faces, &sides, goal));
        let phase = format!("relighting to {:.2} %", 100.0 * goal);
        let goal = Goal::of(goal as f32);
        let captured = self.watch.of("capture", || self.captured(&sides, goal))?;
        let stage = self.stage;
        let mut mesh = Mesh::new(&stage.scene, &squares(&sides), 1)?;
        mesh.room = stage.room as u32;
        let room = captured.values.on(&mut mesh, stage.reflectance);
        let irradiance = spread(&captured.irradiance, mesh.texels.len());
        let surface = Surface::of(&mesh, &room, &wide(&irradiance));
        for (k, texel) in mesh.texels.iter_mut().enumerate() {
            texel.reflectance = surface.reflectance[k];
            texel.emission = surface.emission[k];
        }
        let before: Vec<Vec3> = room.radiosity.iter().map(|b| b.truncate()).collect();
        let (outcome, change) = self.watch.of("relight", || {
            let mut told = told(self.watch, &phase);
            if self.again {
                let outcome = solve_by(&stage.scene, &mesh, &off, goal, self.way, &mut told)?;
                return Ok::<_, Error>((outcome, None));
            }
            let mut share = captured.open.clone();
            share.resize(mesh.texels.len(), 1.0);
            let open_only =
                |h: &Vec3, open: &f32| if *open > 0.0 { *h / *open } else { Vec3::ZERO };
            let received: Vec<Vec3> = irradiance
                .iter()
                .zip(&share)
                .map(|(h, open)| open_only(h, open))
                .collect();
            let shone: Vec<Vec3> = (0..mesh.texels.len())
                .map(|k| surface.emission[k] + surface.reflectance[k] * received[k])
                .collect();
            let known = Known {
                radiosity: &shone,
                irradiance: &received,
                open: &share,
            };
            let asked = (goal, self.way);
            let found = relight(&stage.scene, &mesh, &known, &off, asked, &mut told)?;
            let whole = irradiance.iter().zip(&found.irradiance);
            let outcome = Outcome {
                irradiance: whole.map(|(h, change)| *h + *change).collect(),
                ..found
            };
            Ok((outcome, Some(found.irradiance)))
        })?;
        let radiosity = |(k, texel): (usize, &common::mesh::Texel)| match &change {
            Some(change) if !mesh.is_object(texel.face) => {
                before[k] + texel.reflectance * change[k]
            }
            _ => texel.emission + texel.reflectance * outcome.irradiance[k],
        };
        let radiosity: Vec<Vec3> = mesh.texels.iter().enumerate().map(radiosity).collect();
        Ok(Relit {
            before,
            emitters: surface.emitters.len(),
            step: Step::new(sides, mesh, outcome).shining(&radiosity),
            radiosity,
        })
    }

    fn asked(&self, face: usize) -> Option<u32> {
        self.texels.map(|_| self.stage.resolutions[face][0])
    }

    fn first(&self) -> Result<Vec<u32>> {
        let (stage, whole) = (self.stage, &self.stage.scene);
        let mut sides = first(whole, &|f| self.asked(f), width(whole)?);
        if stage.captured.values.is_some() {
            for (side, captured) in sides.iter_mut().zip(&stage.captured.resolutions) {
                *side = captured[0];
            }
        }
        Ok(sides)
    }

    fn second(&self, first: &Relit) -> Result<Vec<u32>> {
        let whole = &self.stage.scene;
        let mut sides = second(whole, &|f| self.asked(f), width(whole)?, &first.step.sides);
        for (f, side) in sides.iter_mut().enumerate() {
            if !self.may(f) {
                *side = first.step.sides[f];
            }
        }
        if self.texels.is_none() {
            for (side, foot) in sides.iter_mut().zip(self.feet(first)) {
                *side = (*side).max(foot);
            }
        }
        Ok(sides)
    }

    /// What was captured knows no smaller texels.
    fn may(&self, face: usize) -> bool {
        face >= self.stage.room || self.stage.captured.values.is_none()
    }

    fn shown(&self, _: &Relit, _: &Change, _: f64) -> Option<Vec<u32>> {
        None
    }
}

impl Climb<'_> {
    /// The answer on the texels that were asked for: means over their areas.
    fn shown_on(&self, relit: Relit) -> Result<Relit> {
        let (faces, step) = (&self.stage.scene.faces, &relit.step);
        let sides: Vec<u32> = (0..faces.len())
            .map(|f| self.asked(f).unwrap_or(step.sides[f]))
            .collect();
        if sides == step.sides {
            return Ok(relit);
        }
        let mean =
            |of: &dyn Fn(usize) -> Vec3| narrowed(onto(faces, step, &sides, &|k| of(k).as_dvec3()));
        let mut mesh = Mesh::new(&self.stage.scene, &squares(&sides), 1)?;
        mesh.room = self.stage.room as u32;
        let reflectance = mean(&|k| step.mesh.texels[k].reflectance);
        let emission = mean(&|k| step.mesh.texels[k].emission);
        for (k, texel) in mesh.texels.iter_mut().enumerate() {
            (texel.reflectance, texel.emission) = (reflectance[k], emission[k]);
        }
        let open = mean(&|k| Vec3::splat(step.outcome.open[k]));
        let outcome = Outcome {
            irradiance: mean(&|k| step.outcome.irradiance[k]),
            residual: mean(&|k| step.outcome.residual[k]),
            open: open.iter().map(|open| open.x).collect(),
            off: Vec::new(),
            ..step.outcome
        };
        Ok(Relit {
            before: mean(&|k| relit.before[k]),
            radiosity: mean(&|k| relit.radiosity[k]),
            emitters: relit.emitters,
            step: Step::new(sides, mesh, outcome),
        })
    }

    /// The room on so many texels a side.
    fn captured(&self, sides: &[u32], goal: Goal) -> Result<Captured> {
        let stage = self.stage;
        let scene = &stage.captured.scene;
        let sides = &sides[..stage.room];
        let mesh = Mesh::new(scene, &squares(sides), 1)?;
        let mut told = told(self.watch, "capture");
        let Some(values) = &stage.captured.values else {
            let found = solve_by(scene, &mesh, &[], goal, self.way, &mut told)?;
            let texels = mesh.texels.iter().zip(&found.irradiance);
            return Ok(Captured {
                values: Values {
                    radiosity: texels
                        .map(|(t, h)| t.emission + t.reflectance * *h)
                        .collect(),
                    residual: None,
                    reflectance: Some(mesh.texels.iter().map(|t| t.reflectance).collect()),
                    emission: Some(mesh.texels.iter().map(|t| t.emission).collect()),
                },
                irradiance: found.irradiance,
                open: found.open,
            });
        };
        let values = values.onto(&scene.faces, &stage.captured.resolutions, sides);
        let known = (&values.reflectance, &values.emission, stage.reflectance);
        let (open, irradiance) = match known {
            (Some(rho), Some(emission), None) => {
                let received = |k: usize| {
                    let reflected = values.radiosity[k] - emission[k];
                    Vec3::select(rho[k].cmpgt(Vec3::ZERO), reflected / rho[k], Vec3::ZERO)
                };
                let received = (0..rho.len()).map(received).collect();
                (open(scene, &mesh), received)
            }
            _ => {
                let found =
                    irradiance(scene, &mesh, &values.radiosity, (goal, self.way), &mut told)?;
                (open(scene, &mesh), found)
            }
        };
        Ok(Captured {
            values,
            irradiance,
            open,
        })
    }

    /// Texels a side on which what objects change does not vary visibly, or that are as small as a shadow's
    /// foot; 0 where there is nothing to see.
    fn feet(&self, first: &Relit) -> Vec<u32> {
        let (stage, step) = (self.stage, &first.step);
        let starts = offsets(&squares(&step.sides));
        let (mut square, mut area) = (0.0, 0.0);
        for (texel, light) in step.mesh.texels.iter().zip(&step.reflected) {
            square += f64::from(texel.area) * light.max_element().powi(2);
            area += f64::from(texel.area);
        }
        let visible = VISIBLE * (square / area).sqrt();
        let width = extent(&stage.scene.faces[stage.room..]) / FOOT;
        let mut sides = vec![0; step.sides.len()];
        let mut all = count(&step.sides);
        for (f, face) in stage.scene.faces.iter().enumerate().take(stage.room) {
            let own = starts[f]..starts[f + 1];
            let changes = own.map(|k| (first.radiosity[k] - first.before[k]).abs().max_element());
            if f64::from(changes.fold(0.0, f32::max)) < visible {
                continue;
            }
            let long = face.corners.iter().enumerate();
            let long = long.map(|(k, c)| c.distance(face.corners[(k + 1) % 4]));
            let long = long.fold(0.0, f64::max);
            let mut side = step.sides[f];
            // As near to that width as halves come.
            while long / f64::from(side) > SQRT_2 * width && 2 * side <= SIDE {
                let more = 3 * u64::from(side) * u64::from(side);
                if all + more > ALL {
                    break;
                }
                all += more;
                side *= 2;
            }
            sides[f] = side;
        }
        sides
    }
}

impl Values {
    /// The same on other texels, which are parts of these.
    fn onto(&self, faces: &[Face], from: &[[u32; 2]], to: &[u32]) -> Self {
        let starts: Vec<usize> = from
            .iter()
            .scan(0, |sum, r| {
                let own = *sum;
                *sum += texel::count(*r) as usize;
                Some(own)
            })
            .collect();
        let spread = |values: &Vec<Vec3>| -> Vec<Vec3> {
            let each = faces.iter().enumerate().flat_map(|(f, face)| {
                let own = &values[starts[f]..starts[f] + texel::count(from[f]) as usize];
                let wide: Vec<_> = own.iter().map(|v| v.as_dvec3()).collect();
                averaged(&wide, face, from[f][0], to[f])
            });
            each.map(|v| v.as_vec3()).collect()
        };
        Self {
            radiosity: spread(&self.radiosity),
            residual: None,
            reflectance: self.reflectance.as_ref().map(spread),
            emission: self.emission.as_ref().map(spread),
        }
    }
}

/// The longest side of the box around faces.
fn extent(faces: &[Face]) -> f64 {
    let corners = || faces.iter().flat_map(Face::outline);
    let high = corners().fold(glam::DVec3::NEG_INFINITY, |high, c| high.max(*c));
    let low = corners().fold(glam::DVec3::INFINITY, |low, c| low.min(*c));
    (high - low).max_element()
}

fn spread(values: &[Vec3], count: usize) -> Vec<Vec3> {
    let mut all = values.to_vec();
    all.resize(count, Vec3::ZERO);
    all
}

fn wide(values: &[Vec3]) -> Vec<Vec4> {
    values.iter().map(|v| v.extend(0.0)).collect()
}
