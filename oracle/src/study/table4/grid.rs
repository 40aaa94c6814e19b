//! One cell of the grid: the same texels and item buffer for every image.

use super::{Image, Row, Shown, Table, printed};
use crate::judge::compare::difference::difference;
use crate::relight::composite::{Composite, composite};
use crate::relight::stage::Stage;
use crate::relight::work::{Relighting, capture};
use crate::relight::{Relit, files};
use crate::show::picture::Exposure;
use crate::show::view::camera::Camera;
use crate::solve::solved::Recovered;
use crate::solve::solved::Solved;
use crate::solve::solver::Solver;
use crate::solve::task::Task;
use crate::solve::watch::{Show, Watch};
use common::energy::Energy;
use common::form_factor::FormFactor;
use common::rays::Rays;
use common::relight::Method;
use common::scene::Scene;
use common::settings::{
    Drawing, Lookup, Meshing, Projection, Raster, Schedule, Settings, Transport, Visibility,
};
use common::shooting::Field;
use common::{Error, Result};
use gpu::Gpu;

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
    /// Told how far it is; may break.
    pub show: Show<'a>,
}

/// As the paper did it, on these texels.
fn settings(texels: u32, visibility: Visibility) -> Settings {
    Settings {
        meshing: Meshing {
            texels,
            cells: 1,
            samples: 1,
        },
        transport: Transport {
            visibility,
            form_factor: FormFactor::Disc,
            ..Transport::default()
        },
        schedule: Schedule {
            epsilon: STOP,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

/// The corrected orthographic item buffer, read as the paper read it.
fn hemisphere(size: u32) -> Visibility {
    Visibility::Drawn(Drawing {
        projection: Projection::Hemisphere(Raster::Pixel),
        size,
        lookup: Lookup::Exact,
    })
}

impl Grid<'_> {
    /// Solved once by `method`; none: everything again.
    fn relit(
        &self,
        stage: &Stage,
        method: Option<Method>,
        settings: &Settings,
        watch: &Watch,
    ) -> Result<Solved> {
        let task = Relighting { stage, method };
        task.once(
            settings,
            Solver::drawing(self.device, &settings.transport),
            watch,
        )
    }

    /// The scene on N×N texels, its room solved by `settings`.
    fn captured(&self, texels: u32, settings: &Settings) -> Result<Stage> {
        let mut stage = Stage::new(self.scene, self.room, texels);
        let solver = Solver::drawing(self.device, &settings.transport);
        stage.captured.values = Some(capture(&stage, settings, solver, &Watch::new(self.show))?);
        Ok(stage)
    }

    /// The full solution by rays, on N×N texels.
    pub fn by_rays(&self, texels: u32) -> Result<Field> {
        let mut settings = settings(texels, Visibility::Rays);
        settings.schedule.epsilon = EXACT;
        let stage = self.captured(texels, &settings)?;
        let done = self.relit(&stage, None, &settings, &Watch::new(self.show))?;
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
        let settings = settings(texels, hemisphere(item_buffer));
        let mut exact = settings;
        exact.schedule.epsilon = EXACT;
        let stage = self.captured(texels, &exact)?;
        let full = self.relit(&stage, None, &exact, &Watch::new(self.show))?;
        let truth = named(&full, "full");
        let mut printed_shots = 0;
        for image in Image::ALL {
            let settings = Settings {
                schedule: Schedule {
                    max_shots: match image {
                        Image::SignedEarly => printed_shots + printed_shots / 10,
                        _ => settings.schedule.max_shots,
                    },
                    ..settings.schedule
                },
                ..settings
            };
            let watch = Watch::new(self.show);
            let done = self.relit(&stage, image.method(), &settings, &watch)?;
            if watch.stopped() {
                return Ok(());
            }
            let relit = known(&done)?;
            if image == Image::Paper {
                printed_shots = done.run.shots.len() as u32;
            }
            let field = named(&done, image.name());
            table.rows.push(Row {
                image,
                texels,
                item_buffer,
                seconds: watch.seconds(&["relight"]),
                shots: done.run.shots.len(),
                map_shots: relit.map_shots,
                object_shots: relit.object_shots,
                error: difference(&done.mesh, &field, &truth).relative_rms,
                error_rays: difference(&done.mesh, &field, rays).relative_rms,
                imbalance: Energy::new(&done.mesh, &done.run.field, &done.run.shots).imbalance,
                negative_texels: relit.negative_texels(&done.run),
                paper: printed(image, texels, item_buffer),
            });
            let seen = look(&stage, &done, None)?;
            table.shown.push(Shown {
                row: table.rows.len() - 1,
                picture: files::picture(SIZE, &seen.composite, &seen.coverage[1], exposure(&seen)),
            });
        }
        Ok(())
    }

    /// One relight by `image` on N×N texels, for a picture.
    pub fn picture(&self, texels: u32, image: Image) -> Result<(Stage, Solved)> {
        let settings = settings(texels, hemisphere(1024));
        let mut exact = settings;
        exact.schedule.epsilon = 1e-2;
        let stage = self.captured(texels, &exact)?;
        let done = self.relit(&stage, image.method(), &settings, &Watch::new(self.show))?;
        Ok((stage, done))
    }
}

/// What a relight knows of its room.
fn known(done: &Solved) -> Result<&Recovered> {
    let relit = done.relit.as_ref();
    relit.ok_or_else(|| Error::Fault("a relight knows no room".into()))
}

/// The field under a name of its own: a comparison refuses two of one origin.
fn named(done: &Solved, name: &str) -> Field {
    Field {
        origin: name.to_owned(),
        ..done.run.field.clone()
    }
}

/// What a camera sees of it; the automatic one if none is given.
pub fn look(stage: &Stage, done: &Solved, camera: Option<Camera>) -> Result<Composite> {
    let relit = Relit {
        scene: &stage.scene,
        mesh: &done.mesh,
        room: stage.room,
        before: &known(done)?.before,
        after: &done.run.field,
        eye: None,
    };
    let camera = camera.unwrap_or_else(|| Camera::automatic(&done.mesh, &Rays::new(&done.mesh)));
    Ok(composite(&relit, &camera, SIZE, None))
}

/// One exposure for all of the grid would hide what is dark in one; each has its background's.
pub fn exposure(seen: &Composite) -> Exposure {
    files::exposure(seen)
}
