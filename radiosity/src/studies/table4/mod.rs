//! Repeats the paper's Table 4 with its room, texels and item buffers: the whole scene solved
//! (reference), Table 2 (paper) and the signed form, each with its error against the full solution.
//!
//! Settings as in the paper: whole faces shoot from one point each, orthographic item buffer, one
//! pixel per texel. Shooting stops at 5 % unshot power, where the reference takes the paper's 320 to
//! 330 shots. [`page`] writes the results.

pub mod page;

use self::TableImage::{Mended, Paper, Reference, Signed, SignedEarly};
use crate::report::picture::RgbaPicture;
use crate::report::solution_view::RenderedPreview;
use crate::report::view::camera::Camera;
use common::energy::EnergyBalance;
use common::form_factor::FormFactor;
use common::relight::{MendedFlaws, RelightMethod};
use common::scene::Scene;
use common::settings::{ItemBufferProjection, ItemBufferSettings, Lookup, Settings, Visibility};
use common::shooting::RadiosityField;
use common::{Error, Result};
use glam::DVec3;
use gpu::Gpu;
use oracle::diff::difference::compare_fields;
use oracle::relight::stage::RelightStage;
use oracle::relight::task::{RelightTask, capture_empty_room};
use oracle::solve::progress::{PhaseCallback, ProgressMonitor};
use oracle::solve::solved::Solved;
use oracle::solve::solver::SolverChoice;
use oracle::solve::task::SolveTask;
use serde::Serialize;

/// Share of unshot power at which the paper may have stopped.
pub const PAPER_EPSILON: f64 = 0.05;
/// Unshot share of truth and captured room: a hundredth of the smallest error in the table.
const EXACT_EPSILON: f64 = 1e-4;
/// Texels per side of Figure 8's faces.
const SHADOW_TEXELS: [u32; 3] = [8, 16, 32];
/// Eye and target of Figure 8: the floor between the blocks.
const SHADOW_CAMERA: [DVec3; 2] = [DVec3::new(0.5, 0.75, 0.06), DVec3::new(0.6, 0.0, 0.62)];

/// Method of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TableImage {
    /// Whole scene by progressive refinement.
    Reference,
    /// Algorithm of Table 2.
    Paper,
    /// Table 2, darkening only by the light that the objects hide (V₀ − V).
    Mended,
    /// Signed residuals, stopped after 1.1 times the shots of Table 2.
    SignedEarly,
    /// Signed residuals.
    Signed,
}

impl TableImage {
    /// All images, in the table's order.
    pub const ALL: [Self; 5] = [Reference, Paper, Mended, SignedEarly, Signed];

    /// Returns the name on the page.
    pub fn name(self) -> &'static str {
        ["reference", "paper", "paper, V₀ − V", "signed, early", "signed"][self as usize]
    }

    /// Returns the relighting method; none: the whole scene is solved.
    fn relight_method(self) -> Option<RelightMethod> {
        let mended = |empty_room| {
            RelightMethod::Paper(MendedFlaws {
                empty_room,
                object_shadows: empty_room,
                ..MendedFlaws::default()
            })
        };
        match self {
            Reference => None,
            Paper => Some(mended(false)),
            Mended => Some(mended(true)),
            SignedEarly | Signed => Some(RelightMethod::Signed),
        }
    }
}

/// One line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Table4Row {
    /// Method of the row.
    pub image: TableImage,
    /// Texels per side of a face.
    pub texels: u32,
    /// Item-buffer pixels per side.
    pub item_buffer: u32,
    /// Seconds of visibility and shooting.
    pub seconds: f64,
    /// Number of shots.
    pub shots: usize,
    /// Shots of the room.
    pub map_shots: usize,
    /// Shots of the objects.
    pub object_shots: usize,
    /// Relative RMS error of B − E against the full solution on the same item buffers.
    pub error: f64,
    /// Relative RMS error against the full solution by rays.
    pub error_rays: f64,
    /// Imbalance of power over the emitted power.
    pub imbalance: f64,
    /// Number of negative texels.
    pub negative_texels: usize,
    /// The paper's seconds (2006) and shots.
    pub paper: Option<(f64, u32)>,
    /// The relit room.
    #[serde(skip)]
    pub picture: RgbaPicture,
}

/// Rows of the paper's Table 4: image, texels, item buffer, seconds, shots.
const PRINTED_ROWS: [(TableImage, u32, u32, f64, u32); 6] = [
    (Reference, 16, 1024, 34.0, 322),
    (Reference, 32, 1024, 41.0, 334),
    (Paper, 16, 256, 11.0, 182),
    (Paper, 16, 512, 13.0, 182),
    (Paper, 32, 512, 18.0, 185),
    (Paper, 32, 1024, 24.0, 185),
];

/// Returns seconds and shots of this row in the paper's Table 4.
pub fn printed_figures(image: TableImage, texels: u32, item_buffer: u32) -> Option<(f64, u32)> {
    let asked = (image, texels, item_buffer);
    let row = PRINTED_ROWS.iter().find(|row| (row.0, row.1, row.2) == asked)?;
    Some((row.3, row.4))
}

/// All measurements and pictures.
#[derive(Default, Serialize)]
pub struct Table4 {
    /// Name of the adapter.
    pub adapter: String,
    /// Number of faces.
    pub faces: usize,
    /// Number of the objects' faces.
    pub object_faces: usize,
    /// Rows of the table.
    pub rows: Vec<Table4Row>,
    /// Captions and pictures of Figure 8.
    #[serde(skip)]
    pub shadows: Vec<(String, RgbaPicture)>,
}

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

/// Returns the paper's settings, with a corrected orthographic item buffer and one-pixel lookup; none: by rays.
pub fn paper_settings(texels: u32, item_buffer: Option<u32>, epsilon: f64) -> Settings {
    let mut settings = Settings::default();
    let meshing = &mut settings.meshing;
    (meshing.texels, meshing.patches, meshing.samples) = (texels, 1, 1);
    settings.transport.form_factor = FormFactor::Disc;
    settings.transport.visibility = item_buffer.map_or(Visibility::Rays, |size| {
        Visibility::ItemBuffer(ItemBufferSettings {
            projection: ItemBufferProjection::Hemisphere,
            size,
            lookup: Lookup::Exact,
        })
    });
    settings.schedule.epsilon = epsilon;
    settings
}

impl Table4Grid<'_> {
    /// Relights as `image` does, or solves the whole scene.
    fn relight_stage(&self, stage: &RelightStage, image: TableImage, settings: &Settings) -> Result<(Solved, f64)> {
        let monitor = ProgressMonitor::new(self.show);
        let solver = SolverChoice::for_transport(self.gpu, &settings.transport);
        let method = image.relight_method();
        let done = RelightTask {
            stage,
            method,
            trace: None,
        }
        .solve_once(settings, solver, &monitor)?;
        match monitor.is_stopped() {
            true => Err(Error::Interrupted),
            false => Ok((done, monitor.phase_seconds(&["relight"]))),
        }
    }

    /// Returns the scene with its room captured by `settings`.
    fn capture_room(&self, settings: &Settings) -> Result<RelightStage> {
        let mut stage = RelightStage::new(self.scene, self.room, settings.meshing.texels);
        let solver = SolverChoice::for_transport(self.gpu, &settings.transport);
        let monitor = ProgressMonitor::new(self.show);
        stage.captured.values = Some(capture_empty_room(&stage, settings, solver, &monitor)?);
        Ok(stage)
    }

    /// Solves the whole scene by rays on N×N texels. Errors: the solve fails or is stopped.
    pub fn solve_by_rays(&self, texels: u32) -> Result<RadiosityField> {
        let settings = paper_settings(texels, None, EXACT_EPSILON);
        let stage = self.capture_room(&settings)?;
        let (done, _) = self.relight_stage(&stage, Reference, &settings)?;
        Ok(renamed_field(&done, "rays"))
    }

    /// Measures every image on these texels and item buffer. Errors: a solve fails or is stopped.
    pub fn measure_images(&self, texels: u32, item_buffer: u32, rays: &RadiosityField) -> Result<Vec<Table4Row>> {
        let exact = paper_settings(texels, Some(item_buffer), EXACT_EPSILON);
        let stage = self.capture_room(&exact)?;
        let (full, _) = self.relight_stage(&stage, Reference, &exact)?;
        let truth = renamed_field(&full, "full");
        let mut rows: Vec<Table4Row> = Vec::new();
        for image in TableImage::ALL {
            let mut settings = paper_settings(texels, Some(item_buffer), PAPER_EPSILON);
            if image == SignedEarly {
                let printed = rows.iter().find(|row| row.image == Paper);
                let shots = printed.map_or(0, |row| row.shots as u32);
                settings.schedule.max_shots = shots + shots / 10;
            }
            let (done, seconds) = self.relight_stage(&stage, image, &settings)?;
            let relit = done.relight.as_ref();
            let relit = relit.ok_or_else(|| Error::Fault("a relight knows no room".into()))?;
            let field = renamed_field(&done, image.name());
            rows.push(Table4Row {
                image,
                texels,
                item_buffer,
                seconds,
                shots: done.run.shots.len(),
                map_shots: relit.map_shots,
                object_shots: relit.object_shots,
                error: compare_fields(&done.mesh, &field, &truth).relative_rms,
                error_rays: compare_fields(&done.mesh, &field, rays).relative_rms,
                imbalance: EnergyBalance::new(&done.mesh, &done.run.field, &done.run.shots).imbalance,
                negative_texels: relit.negative_texels(&done.run),
                paper: printed_figures(image, texels, item_buffer),
                picture: draw_scene(&stage, &done, None),
            });
        }
        Ok(rows)
    }

    /// Draws Figure 8: shadows against texel resolution. Errors: a solve fails or is stopped.
    pub fn draw_shadows(&self) -> Result<Vec<(String, RgbaPicture)>> {
        let draw = |texels| {
            let stage = self.capture_room(&paper_settings(texels, Some(1024), 1e-2))?;
            let settings = paper_settings(texels, Some(1024), PAPER_EPSILON);
            let (done, _) = self.relight_stage(&stage, Signed, &settings)?;
            let [eye, target] = SHADOW_CAMERA.map(|p| done.mesh.local_point(p).as_vec3());
            let caption = format!("{texels}² texels per face, {} in all", done.mesh.texels.len());
            Ok((caption, draw_scene(&stage, &done, Some(Camera::new(eye, target, 50.0)))))
        };
        SHADOW_TEXELS.into_iter().map(draw).collect()
    }
}

/// Returns the field with `name` as its origin, since a comparison refuses two of one origin.
fn renamed_field(done: &Solved, name: &str) -> RadiosityField {
    RadiosityField {
        origin: name.to_owned(),
        ..done.run.field.clone()
    }
}

fn draw_scene(stage: &RelightStage, done: &Solved, camera: Option<Camera>) -> RgbaPicture {
    RenderedPreview::new(&stage.scene, &done.mesh, &done.run.field, camera).picture
}
