//! One cell of the grid: the same texels and item buffer for every image.

use super::{Image, Row, Shown, Table, printed};
use crate::judge::compare::difference::difference;
use crate::relight::composite::{Composite, composite};
use crate::relight::room::Captured;
use crate::relight::work::{Done, Phases, Stage, Work};
use crate::relight::{Relit, files};
use crate::show::picture::Exposure;
use crate::show::view::camera::Camera;
use common::Result;
use common::energy::Energy;
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::{Lookup, Raster, Settings, Visibility};
use common::shooting::Field;
use cpu::twin::rays::Rays;
use gpu::Gpu;
use std::cell::Cell;
use std::ops::ControlFlow;

/// Unshot power at which the paper may have stopped.
const STOP: f64 = 0.05;
/// The truth and the capture are shot this far: a hundredth of the smallest error in the table.
const EXACT: f64 = 1e-4;
/// Pixels of a picture.
pub const SIZE: [u32; 2] = [400, 400];

/// The scene, who solves it, and who watches.
pub struct Grid<'a> {
    /// The room's faces first.
    pub scene: &'a Scene,
    /// How many they are.
    pub room: usize,
    /// The GPU; none: the twin of its item buffer.
    pub device: Option<&'a Gpu>,
    /// Shows phase, shot and the power of its loop; breaks to stop.
    pub watch: &'a dyn Fn(&str, f64) -> ControlFlow<()>,
}

/// As the paper did it, on these texels and item buffer.
pub fn settings(texels: u32, item_buffer: u32, visibility: Visibility) -> Settings {
    Settings {
        texels,
        item_buffer,
        visibility,
        epsilon: STOP,
        raster: Raster::Pixel,
        lookup: Lookup::Exact,
        form_factor: FormFactor::Disc,
        cells: 1,
        samples: 1,
        ..Settings::default()
    }
}

impl Grid<'_> {
    /// The scene on N×N texels, not captured yet.
    pub fn stage(&self, texels: u32) -> Stage {
        let scene = Scene {
            faces: self.scene.faces[..self.room].to_vec(),
            ..self.scene.clone()
        };
        Stage {
            captured: Captured {
                resolutions: vec![[texels; 2]; self.room],
                scene,
                values: None,
                panorama: None,
                notes: Vec::new(),
            },
            scene: self.scene.clone(),
            room: self.room,
            resolutions: vec![[texels; 2]; self.scene.faces.len()],
            reflectance: None,
            notes: Vec::new(),
        }
    }

    fn work<'s>(&'s self, settings: &'s Settings) -> Work<'s> {
        Work {
            settings,
            device: (settings.visibility != Visibility::Rays)
                .then_some(self.device)
                .flatten(),
            watch: self.watch,
            stopped: Cell::new(false),
        }
    }

    /// The full solution by rays, on N×N texels.
    pub fn by_rays(&self, texels: u32) -> Result<Field> {
        let settings = Settings {
            epsilon: EXACT,
            ..settings(texels, 1024, Visibility::Rays)
        };
        let mut stage = self.stage(texels);
        let work = self.work(&settings);
        stage.captured.values = Some(work.capture(&stage)?);
        let done = work.relight(&stage, None, &mut Phases::default())?;
        Ok(named(&done, "rays"))
    }

    /// Adds every image on these texels and item buffer to the table.
    pub fn cell(
        &self,
        table: &mut Table,
        texels: u32,
        item_buffer: u32,
        rays: &Field,
    ) -> Result<()> {
        let settings = settings(texels, item_buffer, Visibility::Hemisphere);
        let exact = Settings {
            epsilon: EXACT,
            ..settings.clone()
        };
        let mut stage = self.stage(texels);
        stage.captured.values = Some(self.work(&exact).capture(&stage)?);
        let full = self
            .work(&exact)
            .relight(&stage, None, &mut Phases::default())?;
        let truth = named(&full, "full");
        let mut printed_shots = 0;
        for image in Image::ALL {
            let mut seconds = Phases::default();
            let settings = Settings {
                max_shots: match image {
                    Image::SignedEarly => printed_shots + printed_shots / 10,
                    _ => settings.max_shots,
                },
                ..settings.clone()
            };
            let work = self.work(&settings);
            let done = work.relight(&stage, image.method(), &mut seconds)?;
            if work.stopped.get() {
                return Ok(());
            }
            if image == Image::Paper {
                printed_shots = done.run.shots.len() as u32;
            }
            let field = named(&done, image.name());
            table.rows.push(Row {
                image,
                texels,
                item_buffer,
                seconds: seconds.get(&["relight"]),
                shots: done.run.shots.len(),
                map_shots: done.map_shots,
                object_shots: done.object_shots,
                error: difference(&done.mesh, &field, &truth).relative_rms,
                error_rays: difference(&done.mesh, &field, rays).relative_rms,
                imbalance: Energy::new(&done.mesh, &done.run.field, &done.run.shots).imbalance,
                negative_texels: done.negative_texels(),
                paper: printed(image, texels, item_buffer),
            });
            let seen = look(&stage, &done, None);
            table.shown.push(Shown {
                row: table.rows.len() - 1,
                picture: files::picture(SIZE, &seen.composite, &seen.coverage[1], exposure(&seen)),
            });
        }
        Ok(())
    }

    /// One relight by `image` on N×N texels, for a picture.
    pub fn picture(&self, texels: u32, image: Image) -> Result<(Stage, Done)> {
        let settings = settings(texels, 1024, Visibility::Hemisphere);
        let exact = Settings {
            epsilon: 1e-2,
            ..settings.clone()
        };
        let mut stage = self.stage(texels);
        stage.captured.values = Some(self.work(&exact).capture(&stage)?);
        let done = self
            .work(&settings)
            .relight(&stage, image.method(), &mut Phases::default())?;
        Ok((stage, done))
    }
}

/// The field under a name of its own: a comparison refuses two of one origin.
fn named(done: &Done, name: &str) -> Field {
    Field {
        origin: name.to_owned(),
        ..done.run.field.clone()
    }
}

/// What a camera sees of it; the automatic one if none is given.
pub fn look(stage: &Stage, done: &Done, camera: Option<Camera>) -> Composite {
    let relit = Relit {
        scene: &stage.scene,
        mesh: &done.mesh,
        room: stage.room,
        before: &done.before,
        after: &done.run.field,
        eye: None,
    };
    let camera = camera.unwrap_or_else(|| Camera::automatic(&done.mesh, &Rays::new(&done.mesh)));
    composite(&relit, &camera, SIZE, None)
}

/// One exposure for all of the grid would hide what is dark in one; each has its background's.
pub fn exposure(seen: &Composite) -> Exposure {
    files::exposure(seen)
}
