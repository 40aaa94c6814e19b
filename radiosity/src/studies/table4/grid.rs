//! Solves the grid of Table 4: every image on each combination of texels and item buffer.

use super::{RowPicture, Table4, Table4Row, TableImage, printed_figures};
use crate::relight::composite::{Composite, render_composite};
use crate::relight::{RelitScene, files};
use crate::report::picture::Exposure;
use crate::report::view::camera::Camera;
use crate::studies::PIXEL_HEMISPHERE;
use common::energy::EnergyBalance;
use common::form_factor::FormFactor;
use common::rays::Rays;
use common::relight::RelightMethod;
use common::scene::Scene;
use common::settings::{ItemBufferSettings, Lookup, Meshing, Schedule, Settings, Transport, Visibility};
use common::shooting::RadiosityField;
use common::{Error, Result};
use gpu::Gpu;
use oracle::diff::difference::compare_fields;
use oracle::relight::stage::RelightStage;
use oracle::relight::task::{RelightTask, capture_empty_room};
use oracle::solve::progress::{PhaseCallback, ProgressMonitor};
use oracle::solve::solved::RelightReport;
use oracle::solve::solved::Solved;
use oracle::solve::solver::SolverChoice;
use oracle::solve::task::SolveTask;

/// Share of unshot power at which the paper may have stopped.
const PAPER_EPSILON: f64 = 0.05;
/// Unshot share of truth and captured room: a hundredth of the smallest error in the table.
const EXACT_EPSILON: f64 = 1e-4;
/// Width and height of a picture, pixels.
pub const PICTURE_SIZE: [u32; 2] = [400, 400];

/// Scene, device and progress callback of the measurements.
pub struct Table4Grid<'a> {
    /// The scene, the room's faces first.
    pub scene: &'a Scene,
    /// Number of the room's faces.
    pub room: usize,
    /// GPU; none: the CPU's scalar item buffer.
    pub gpu: Option<&'a Gpu>,
    /// Progress callback, which may stop the work.
    pub show: PhaseCallback<'a>,
}

/// Returns the paper's settings on these texels.
fn paper_settings(texels: u32, visibility: Visibility) -> Settings {
    Settings {
        meshing: Meshing {
            texels,
            patches: 1,
            samples: 1,
        },
        transport: Transport {
            visibility,
            form_factor: FormFactor::Disc,
            ..Transport::default()
        },
        schedule: Schedule {
            epsilon: PAPER_EPSILON,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

/// Returns the corrected orthographic item buffer with one-pixel lookup, as in the paper.
fn hemisphere_buffer(size: u32) -> Visibility {
    Visibility::ItemBuffer(ItemBufferSettings {
        projection: PIXEL_HEMISPHERE,
        size,
        lookup: Lookup::Exact,
    })
}

impl Table4Grid<'_> {
    /// Relights by `method`, or solves the whole scene if it is none.
    fn relight_stage(
        &self,
        stage: &RelightStage,
        method: Option<RelightMethod>,
        settings: &Settings,
        watch: &ProgressMonitor,
    ) -> Result<Solved> {
        let task = RelightTask { stage, method };
        task.solve_once(
            settings,
            SolverChoice::for_transport(self.gpu, &settings.transport),
            watch,
        )
    }

    /// Returns the scene on N×N texels with its room captured by `settings`.
    fn capture_room(&self, texels: u32, settings: &Settings) -> Result<RelightStage> {
        let mut stage = RelightStage::new(self.scene, self.room, texels);
        let solver = SolverChoice::for_transport(self.gpu, &settings.transport);
        stage.captured.values = Some(capture_empty_room(
            &stage,
            settings,
            solver,
            &ProgressMonitor::new(self.show),
        )?);
        Ok(stage)
    }

    /// Solves the whole scene by rays on N×N texels. Errors: the solve fails.
    pub fn solve_by_rays(&self, texels: u32) -> Result<RadiosityField> {
        let mut settings = paper_settings(texels, Visibility::Rays);
        settings.schedule.epsilon = EXACT_EPSILON;
        let stage = self.capture_room(texels, &settings)?;
        let done = self.relight_stage(&stage, None, &settings, &ProgressMonitor::new(self.show))?;
        Ok(renamed_field(&done, "rays"))
    }

    /// Measures every image on these texels and item buffer and adds it to the table. Errors: a solve
    /// fails.
    pub fn measure_images(
        &self,
        table: &mut Table4,
        texels: u32,
        item_buffer: u32,
        rays: &RadiosityField,
    ) -> Result<()> {
        let settings = paper_settings(texels, hemisphere_buffer(item_buffer));
        let mut exact = settings;
        exact.schedule.epsilon = EXACT_EPSILON;
        let stage = self.capture_room(texels, &exact)?;
        let full = self.relight_stage(&stage, None, &exact, &ProgressMonitor::new(self.show))?;
        let truth = renamed_field(&full, "full");
        let mut printed_shots = 0;
        for image in TableImage::ALL {
            let settings = Settings {
                schedule: Schedule {
                    max_shots: match image {
                        TableImage::SignedEarly => printed_shots + printed_shots / 10,
                        _ => settings.schedule.max_shots,
                    },
                    ..settings.schedule
                },
                ..settings
            };
            let watch = ProgressMonitor::new(self.show);
            let done = self.relight_stage(&stage, image.relight_method(), &settings, &watch)?;
            if watch.is_stopped() {
                return Ok(());
            }
            let relit = recovered_room(&done)?;
            if image == TableImage::Paper {
                printed_shots = done.run.shots.len() as u32;
            }
            let field = renamed_field(&done, image.name());
            table.rows.push(Table4Row {
                image,
                texels,
                item_buffer,
                seconds: watch.phase_seconds(&["relight"]),
                shots: done.run.shots.len(),
                map_shots: relit.map_shots,
                object_shots: relit.object_shots,
                error: compare_fields(&done.mesh, &field, &truth).relative_rms,
                error_rays: compare_fields(&done.mesh, &field, rays).relative_rms,
                imbalance: EnergyBalance::new(&done.mesh, &done.run.field, &done.run.shots).imbalance,
                negative_texels: relit.negative_texels(&done.run),
                paper: printed_figures(image, texels, item_buffer),
            });
            let seen = render_view(&stage, &done, None)?;
            table.shown.push(RowPicture {
                row: table.rows.len() - 1,
                picture: files::tone_map_picture(
                    PICTURE_SIZE,
                    &seen.composite,
                    &seen.coverage[1],
                    background_exposure(&seen),
                ),
            });
        }
        Ok(())
    }

    /// Relights by `image` on N×N texels, for a picture. Errors: the solve fails.
    pub fn relight_for_picture(&self, texels: u32, image: TableImage) -> Result<(RelightStage, Solved)> {
        let settings = paper_settings(texels, hemisphere_buffer(1024));
        let mut exact = settings;
        exact.schedule.epsilon = 1e-2;
        let stage = self.capture_room(texels, &exact)?;
        let done = self.relight_stage(
            &stage,
            image.relight_method(),
            &settings,
            &ProgressMonitor::new(self.show),
        )?;
        Ok((stage, done))
    }
}

/// Returns the room that a relight recovered. Errors: the solution is of no relight.
fn recovered_room(done: &Solved) -> Result<&RelightReport> {
    let relit = done.relight.as_ref();
    relit.ok_or_else(|| Error::Fault("a relight knows no room".into()))
}

/// Returns the field with `name` as its origin, since a comparison refuses two of one origin.
fn renamed_field(done: &Solved, name: &str) -> RadiosityField {
    RadiosityField {
        origin: name.to_owned(),
        ..done.run.field.clone()
    }
}

/// Renders the solution from `camera`, or from an automatic one. Errors: the solution is of no
/// relight.
pub fn render_view(stage: &RelightStage, done: &Solved, camera: Option<Camera>) -> Result<Composite> {
    let relit = RelitScene {
        scene: &stage.scene,
        mesh: &done.mesh,
        room: stage.room_faces,
        before: &recovered_room(done)?.before,
        after: &done.run.field,
        eye: None,
    };
    let camera = camera.unwrap_or_else(|| Camera::automatic_view(&done.mesh, &Rays::new(&done.mesh)));
    Ok(render_composite(&relit, &camera, PICTURE_SIZE, None))
}

/// Returns the exposure of a picture's background; one for the whole grid would be too dark for some.
pub fn background_exposure(seen: &Composite) -> Exposure {
    files::choose_exposure(seen)
}
