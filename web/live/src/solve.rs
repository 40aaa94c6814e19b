//! A solve that is recorded and rendered for the page.

use crate::browser_gpu::open_gpu;
use crate::case::{ExactComparison, OpenedCase};
use crate::change::change_scene;
use crate::request::{LiveRequest, LiveSolver, LiveView};
use crate::slice::{RecordedGpu, shoot_in_slices};
use common::capture::Panorama;
use common::capture::sky::panorama_sky;
use common::energy::EnergyBalance;
use common::import::{ImportOptions, add_lamp, load_scene, load_scene_file};
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Settings;
use common::shooting::{RadiosityField, SolveRun};
use common::solution::write::encode_lightmap;
use common::solution::{PhaseSeconds, Solution};
use common::{Error, Result};
use cpu::CpuSolver;
use glam::{DVec3, Vec3};
use gpu::{Gpu, GpuSolver};
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solved::Solved;
use oracle::solve::solver::SolverChoice;
use oracle::solve::task::{SolveTask, prepare_mesh};
use oracle::trace::ShotTrace;
use oracle::trace::recorder::{ShotRecord, ShotRecorder};
use radiosity::report::gltf_export::face_document::make_face_document;
use radiosity::report::gltf_export::{ExportCharts, export_lightmap};
use radiosity::report::solution_view::RenderedPreview;
use radiosity::report::trace::{TRACE_LIMITS, check_trace_limits, render_record};
use serde::Serialize;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Height of the lamp of a scene without light, as a share of the scene's.
const LAMP_HEIGHT: f64 = 0.8;
/// Its power per square of the scene's diagonal, W/m².
const LAMP_EXITANCE: f64 = 10.0;

/// A scene that the page shows, with its latest solve.
pub struct LiveScene {
    scene: Scene,
    /// The scene's file; none of a case.
    file: Option<PathBuf>,
    /// The case of the failure atlas whose scene it is.
    case: Option<OpenedCase>,
    /// True if the latest solve is of a changed scene.
    is_changed: bool,
    /// Latest solve.
    latest: Option<LatestSolve>,
    /// The browser's GPU, once it has solved.
    gpu: Option<Gpu>,
}

/// The latest solve of a scene.
pub struct LatestSolve {
    /// The scene, changed as it was requested.
    pub scene: Scene,
    /// The solve.
    pub solved: Solved,
    /// Camera and exposure of its picture.
    pub view: LiveView,
    /// The solver that ran.
    pub solver: LiveSolver,
}

/// A recorded solve.
#[derive(Debug, Serialize)]
pub struct LiveSolve {
    /// The record's element.
    pub html: String,
    /// Camera and exposure of its picture.
    pub view: LiveView,
    /// The solver that ran: `cpu` or `gpu`.
    pub solver: String,
    /// Name of the GPU's adapter, as the browser tells it; none of the CPU.
    pub adapter: Option<String>,
    /// Power that arrives from outside, summed over the channels, W; none if nothing shines there.
    pub outside: Option<f64>,
    /// Number of shots.
    pub shots: usize,
    /// True if it was stopped before its end.
    pub stopped: bool,
    /// Emitted, absorbed, escaped and unshot power, summed over the channels, W.
    pub power: LivePower,
    /// CRC-32 of the bits of radiosity, residual and irradiance in the mesh's texel order.
    pub checksum: String,
}

/// Powers of a solve, summed over the channels, W.
#[derive(Debug, Serialize)]
pub struct LivePower {
    /// Emitted.
    pub emitted: f64,
    /// Absorbed by the surfaces.
    pub absorbed: f64,
    /// Escaped from the scene.
    pub escaped: f64,
    /// Not yet shot.
    pub unshot: f64,
    /// Emitted less the others: light that the form factors have lost (+) or made (−).
    pub closure: f64,
}

impl LiveScene {
    /// Opens a scene file, which must be in memory or in the file system, in the light of a panorama if one is given. A scene
    /// without light gets a lamp.
    ///
    /// Errors: those of [`load_scene`] and of [`Panorama::read`].
    pub fn open(name: &str, panorama: Option<&str>) -> Result<Self> {
        let mut scene = load_scene(Path::new(name), &ImportOptions::default())?;
        add_panorama(&mut scene, panorama)?;
        if scene.faces.iter().all(|face| face.emission == Vec3::ZERO) && scene.sky.is_none() {
            add_first_lamp(&mut scene)?;
        }
        Ok(Self {
            scene,
            file: Some(name.into()),
            case: None,
            is_changed: false,
            latest: None,
            gpu: None,
        })
    }

    /// Opens the scene of a case of the failure atlas at a value of its parameter, in the light of a panorama if one is given.
    ///
    /// Errors: those of [`OpenedCase::build`] and of [`Panorama::read`].
    pub fn open_case(name: &str, value: f64, panorama: Option<&str>) -> Result<Self> {
        let (case, mut scene) = OpenedCase::build(name, value)?;
        add_panorama(&mut scene, panorama)?;
        Ok(Self {
            scene,
            file: None,
            case: Some(case),
            is_changed: false,
            latest: None,
            gpu: None,
        })
    }

    /// Returns the case of the failure atlas whose scene it is.
    pub fn case(&self) -> Option<&OpenedCase> {
        self.case.as_ref()
    }

    /// Returns the scene as it was opened.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns the latest solve.
    ///
    /// Errors: [`Error::Usage`] if there is none.
    pub fn latest(&self) -> Result<&LatestSolve> {
        let latest = self.latest.as_ref();
        latest.ok_or_else(|| Error::Usage("nothing is solved yet".into()))
    }

    /// Solves the changed scene shot by shot, and renders the record. `progress` is that of the mesh. The shots are
    /// made in slices, after each of which `pause` is awaited with the progress, 0…1; a break of it ends the solve, and the
    /// record is that of the shots so far.
    ///
    /// Errors: the request's; those of the solve and of the device; [`Error::Interrupted`].
    pub async fn solve(
        &mut self,
        request: &LiveRequest,
        progress: &ProgressMonitor<'_>,
        mut pause: impl AsyncFnMut(f64) -> ControlFlow<()>,
    ) -> Result<LiveSolve> {
        let settings = request.to_settings()?;
        let scene = change_scene(&self.scene, &request.changes)?;
        let texels = scene.faces.len() as u64 * u64::from(request.texels).pow(2);
        check_trace_limits(&scene.name, scene.faces.len() as u64, texels)?;
        let mesh = prepare_mesh(&scene, &settings, progress)?;
        let mut stopped = false;
        let mut watch = async |share: f64| {
            let flow = pause(share).await;
            stopped |= flow.is_break();
            flow
        };
        let (run, trace) = match request.solver {
            LiveSolver::Cpu => shoot_on_cpu(&mesh, &settings, &mut watch).await?,
            LiveSolver::Gpu => self.shoot_on_gpu(&mesh, &settings, &mut watch).await?,
        };
        let mut solved = Solved::new(&settings, mesh, run);
        if stopped {
            // A comparison makes as many shots.
            solved.settings.schedule.max_shots = solved.run.shots.len() as u32;
        }
        let (mesh, run) = (&solved.mesh, &solved.run);
        if run.shots.is_empty() {
            return Err(Error::Usage(format!("{}: nothing shines: give it a lamp", scene.name)));
        }
        let view = request.view.unwrap_or_else(|| {
            let preview = RenderedPreview::new(&scene, mesh, &run.field, None);
            LiveView::new(preview.camera, preview.exposure)
        });
        let gpu = self.gpu.as_ref().filter(|_| request.solver == LiveSolver::Gpu);
        let solver = gpu.map_or(SolverChoice::Cpu, SolverChoice::Gpu).name();
        let adapter = gpu.map(|gpu| gpu.line.name.clone());
        let solution = Solution {
            scene: &scene,
            mesh,
            solver,
            adapter: adapter.as_deref(),
            settings: &settings,
            run,
            open: None,
            certificate: None,
            texel_error: None,
            warnings: &[],
            notes: &[],
            matrix: None,
            error: None,
            relit: None,
            seconds: PhaseSeconds::default(),
        };
        let html = render_record(&solution, &trace, view.to_parts());
        let live = LiveSolve {
            html,
            view,
            solver: solver.to_owned(),
            adapter,
            outside: scene.sky.as_ref().map(|_| outside_power(mesh)),
            shots: run.shots.len(),
            stopped,
            power: LivePower::of_balance(&EnergyBalance::new(mesh, &run.field, &run.shots)),
            checksum: field_checksum(&run.field),
        };
        self.latest = Some(LatestSolve {
            scene,
            solved,
            view,
            solver: request.solver,
        });
        self.is_changed = !request.changes.is_empty();
        Ok(live)
    }

    /// Shoots on the GPU in slices, and records the shots.
    async fn shoot_on_gpu(
        &mut self,
        mesh: &Mesh,
        settings: &Settings,
        pause: &mut impl AsyncFnMut(f64) -> ControlFlow<()>,
    ) -> Result<(SolveRun, ShotTrace)> {
        // A device that fails is not used again.
        let gpu = match self.gpu.take() {
            Some(gpu) => gpu,
            None => open_gpu(&[]).await?,
        };
        let mut solver = GpuSolver::request(&gpu, mesh, &settings.transport, &[]).await?;
        let initial = solver.request_field().await?;
        let mut engine = RecordedGpu {
            power: solver.request_power().await?,
            record: ShotRecord::new(mesh, &settings.transport, TRACE_LIMITS, initial)?,
            solver,
        };
        let run = shoot_in_slices(&mut engine, &settings.schedule, pause).await?;
        self.gpu = Some(gpu);
        Ok((run, engine.record.into_trace()))
    }

    /// Encodes the texels of the latest solve as `lightmap.exr`.
    ///
    /// Errors: [`Error::Usage`] if there is none; those of [`encode_lightmap`].
    pub fn encode_lightmap(&self) -> Result<Vec<u8>> {
        let LatestSolve { scene, solved, .. } = self.latest()?;
        encode_lightmap(&solved.mesh, &solved.run.field, scene.is_painted())
    }

    /// Encodes the scene of the latest solve with its light as a texture, as binary glTF. The scene is its file as it is; of a
    /// case, a changed scene or a compressed file it is made of the faces, with one colour each.
    ///
    /// Errors: [`Error::Usage`] if nothing is solved yet; those of [`export_lightmap`].
    pub fn encode_glb(&self) -> Result<Vec<u8>> {
        let LatestSolve {
            scene, solved, view, ..
        } = self.latest()?;
        let own = self.file.as_ref().filter(|_| !self.is_changed);
        let own = own.map(|path| load_scene_file(path, &ImportOptions::default()));
        let file = match own.transpose()? {
            Some((_, file)) if !file.is_compressed() => file,
            _ => make_face_document(scene),
        };
        let light = (&solved.mesh, &solved.run.field);
        let (_, exposure) = view.to_parts();
        let baked = export_lightmap((scene, file), ExportCharts::Packed(None), light, exposure)?;
        Ok(baked.glb)
    }

    /// Returns whether the latest solve has the faces and the light of the case.
    fn is_as_built(&self) -> bool {
        !self.is_changed && self.scene.sky.is_none()
    }

    /// Compares the latest solve with the exact answer; none if there is none: of a file, of a changed scene, or where the
    /// failure atlas compares with another solver.
    ///
    /// Errors: those of [`OpenedCase::compare_with_exact`].
    pub fn compare_with_exact(&self) -> Result<Option<ExactComparison>> {
        match (&self.case, &self.latest) {
            (Some(case), Some(latest)) if self.is_as_built() => case.compare_with_exact(&latest.solved),
            _ => Ok(None),
        }
    }

    /// Estimates the relative RMS error of the latest solve; none if there is none or it cannot be estimated.
    ///
    /// Errors: those of the estimate.
    pub fn estimate_error(&self) -> Result<Option<f64>> {
        let Some(LatestSolve { scene, solved, .. }) = &self.latest else {
            return Ok(None);
        };
        Ok(scene.estimate_error(solved)?.map(|estimate| estimate.error))
    }
}

/// Shoots on the CPU in slices, and records the shots.
async fn shoot_on_cpu(
    mesh: &Mesh,
    settings: &Settings,
    pause: &mut impl AsyncFnMut(f64) -> ControlFlow<()>,
) -> Result<(SolveRun, ShotTrace)> {
    let mut engine = CpuSolver::new(mesh, &settings.transport);
    let mut recorder = ShotRecorder::new(&mut engine, mesh, &settings.transport, TRACE_LIMITS)?;
    let run = shoot_in_slices(&mut recorder, &settings.schedule, pause).await?;
    Ok((run, recorder.into_trace()))
}

/// Puts the light of a panorama around a scene, whose suns stay.
fn add_panorama(scene: &mut Scene, name: Option<&str>) -> Result<()> {
    let Some(name) = name else {
        return Ok(());
    };
    let panorama = Panorama::read(Path::new(name), None)?;
    let mut sky = panorama_sky(&panorama, name.to_owned())?;
    sky.suns = scene.sky.iter().flat_map(|own| own.suns.clone()).collect();
    scene.sky = Some(Arc::new(sky));
    scene.notes.push(format!("The light of {name} comes from outside."));
    scene
        .notes
        .extend(panorama.notes.iter().map(|note| format!("{name}: {note}.")));
    Ok(())
}

/// Returns the power that the texels receive from outside, summed over the channels, W.
fn outside_power(mesh: &Mesh) -> f64 {
    let texels = mesh.texels.iter();
    let received = texels.map(|texel| f64::from(texel.area) * texel.sky.as_dvec3().element_sum());
    received.sum::<f64>() * mesh.area_unit()
}

/// Adds a lamp above the middle of a scene without light, and a note.
fn add_first_lamp(scene: &mut Scene) -> Result<()> {
    let corners = || scene.faces.iter().flat_map(|face| face.corners);
    let low = corners().fold(DVec3::INFINITY, DVec3::min);
    let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
    let middle = (low + high) / 2.0;
    let at = DVec3::new(middle.x, low.y + LAMP_HEIGHT * (high.y - low.y), middle.z);
    let power = LAMP_EXITANCE * (high - low).length_squared();
    let name = scene.name.clone();
    add_lamp(scene, "lamp", at, power)
        .map_err(|reason| Error::Usage(format!("{name} has no light, and a lamp {reason}")))?;
    scene.notes.push("It has no light: a lamp hangs in the middle.".into());
    Ok(())
}

impl LivePower {
    /// Sums the powers of a balance over the channels.
    pub fn of_balance(energy: &EnergyBalance) -> Self {
        let sum = |power: [f64; 3]| power.iter().sum::<f64>();
        Self {
            emitted: sum(energy.emitted),
            absorbed: sum(energy.absorbed),
            escaped: sum(energy.escaped),
            unshot: sum(energy.unshot),
            closure: sum(energy.closure),
        }
    }
}

/// Returns the CRC-32 of a field's bits: radiosity, residual and irradiance.
pub fn field_checksum(field: &RadiosityField) -> String {
    let parts = [&field.radiosity, &field.residual, &field.irradiance];
    let numbers = parts
        .into_iter()
        .flatten()
        .flat_map(|value| value.truncate().to_array());
    let bytes: Vec<u8> = numbers.flat_map(|x| x.to_bits().to_le_bytes()).collect();
    common::file::file_checksum(&bytes)
}
