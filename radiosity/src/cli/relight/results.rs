//! Files and messages of `relight`.

use super::RelightArguments;
use crate::cli::console::message;
use crate::cli::objects::PlacedObject;
use crate::cli::solve::{encode_view, print_summary};
use crate::cli::trace::{TRACE_FILE, render_trace};
use crate::relight::camera::{automatic_camera, camera_at};
use crate::relight::page::{RelightPage, render_report};
use crate::relight::pictures::draw_figures;
use crate::relight::{Backdrop, COMPOSITE_SIZE, RelitScene, composite, files};
use crate::report::solution_view::RenderedView;
use common::energy::EnergyBalance;
use common::solution::pending::PendingFiles;
use common::solution::{PhaseSeconds, Solution};
use common::{Error, Result};
use glam::{DVec3, Vec3};
use oracle::relight::stage::RelightStage;
use oracle::relight::task::RelightTask;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solved::{RelightReport, Solved};
use oracle::solve::{SolveAnswer, SolveRequest};
use serde_json::{Value, json};

/// Files of a relight that a solve does not have.
pub const PICTURE_FILES: [&str; 4] = ["background.exr", "composite.exr", "composite.png", "report.html"];

/// Writes pictures, report and result, and prints the summary.
pub fn write_results(
    arguments: &RelightArguments,
    task: &RelightTask,
    question: &SolveRequest,
    answered: &SolveAnswer,
    watch: &ProgressMonitor,
) -> Result<()> {
    let stage = task.stage;
    let (done, out) = (&answered.solved, &arguments.out);
    let relit = done.relight.as_ref();
    let relit = relit.ok_or_else(|| Error::Fault("a relight knows no room".into()))?;
    let seen = RelitScene {
        scene: &stage.scene,
        mesh: &done.mesh,
        room: stage.room_faces,
        before: &relit.before,
        after: &done.run.field,
        open: done.open.as_deref(),
        eye: stage.captured.panorama.as_ref().map(|(_, eye)| *eye),
    };
    let radiance = |d: DVec3| match &stage.captured.panorama {
        Some((panorama, _)) => panorama.radiance(d),
        None => Vec3::ZERO,
    };
    let backdrop: Option<Backdrop> = stage.captured.panorama.is_some().then_some(&radiance);
    let camera = match &arguments.camera {
        Some([ex, ey, ez, tx, ty, tz, fov]) => {
            camera_at(seen.mesh, DVec3::new(*ex, *ey, *ez), DVec3::new(*tx, *ty, *tz), *fov)
        }
        None => automatic_camera(&seen),
    };
    let picture = watch.time_phase("composite", || {
        composite::render_composite(&seen, &camera, COMPOSITE_SIZE, backdrop)
    });
    let exposure = files::choose_exposure(&picture).with_shoulder();
    let energy = EnergyBalance::new(&done.mesh, &done.run.field, &done.run.shots);
    let mut notes = stage.notes.clone();
    notes.extend(capture_notes(arguments, stage, done, relit));
    for note in &answered.notes {
        message!("note: {note}");
        notes.push(note.clone());
    }
    let seconds = PhaseSeconds {
        load: watch.phase_seconds(&["load"]),
        prepare: watch.phase_seconds(&["capture", "prepare", "recover"]),
        solve: watch.phase_seconds(&["relight"]),
    };
    let solution = Solution {
        relit: Some(describe_relight(arguments, stage, done, relit)),
        ..answered.to_solution(question, &notes, seconds)
    };
    // The view starts at the composite's camera, which shows the objects.
    let draw = || {
        let png = files::encode_composite(&picture, exposure);
        (draw_figures(&picture, &png, exposure), png)
    };
    let (around, (radiance, (pictures, png))) = watch.time_phase("view", || {
        rayon::join(
            || RenderedView::new(&solution, Some(camera)),
            || rayon::join(|| files::encode_radiance(&picture), draw),
        )
    });
    let (around, radiance) = (around?, radiance?);
    let page = match task.trace {
        Some(slot) => render_trace(&solution, slot, &around)?,
        None => None,
    };
    let traced = page.as_ref().map_or("", |_| "trace.html, ");
    let files_of = arguments.objects.objects.iter();
    let objects: Vec<String> = files_of.map(|o| o.file.display().to_string()).collect();
    let report = |around: &RenderedView| {
        render_report(&RelightPage {
            room: &arguments.room.display().to_string(),
            objects: &objects,
            relit: &seen,
            composite: &picture,
            pictures: &pictures,
            energy: Some(&energy),
            map_shots: relit.map_shots as u32,
            object_shots: relit.object_shots as u32,
            converged: done.run.converged,
            negative_texels: relit.negative_texels(&done.run),
            warnings: &answered.warnings,
            notes: &notes,
            viewer: &around.element.0,
        })
    };
    let others = || {
        let mut others = radiance;
        others.push(("composite.png".into(), png));
        others.extend(page.map(|page| (TRACE_FILE.into(), page.into_bytes())));
        others.push(("report.html".into(), report(&around).into_bytes()));
        others.extend(encode_view(around));
        Ok(others)
    };
    let mut files = PendingFiles::default();
    solution.add_files(out, others, &mut files)?;
    files.write()?;
    print_summary(&solution, answered);
    message!(
        "wrote {traced}composite.png, preview.png, view.html, report.html, composite.exr, background.exr, lightmap.exr and result.json in {}",
        out.display()
    );
    Ok(())
}

/// Describes the entries that result.json has in addition to those of a solve.
fn describe_relight(arguments: &RelightArguments, stage: &RelightStage, done: &Solved, relit: &RelightReport) -> Value {
    let describe_object = |object: &PlacedObject| {
        json!({
            "file": object.file.display().to_string(),
            "scale": object.scale,
            "turn": object.turn,
            "place": object.place.to_array(),
            "reflectance": object.reflectance.map(|r| r.to_array()),
        })
    };
    json!({
        "method": arguments.method,
        "map_shots": relit.map_shots,
        "object_shots": relit.object_shots,
        "negative_texels": relit.negative_texels(&done.run),
        "room": arguments.room.display().to_string(),
        "room_faces": stage.room_faces,
        "objects": arguments.objects.objects.iter().map(describe_object).collect::<Vec<_>>(),
    })
}

/// Returns notes on the captured room.
fn capture_notes(
    arguments: &RelightArguments,
    stage: &RelightStage,
    done: &Solved,
    relit: &RelightReport,
) -> Vec<String> {
    let mut notes = Vec::new();
    if relit.emitters > 0 {
        let room = |t: &&common::mesh::Texel| (t.face as usize) < stage.room_faces;
        let all = done.mesh.texels.iter().filter(room).count();
        notes.push(format!(
            "{} of {all} texels of the room emit: they are brighter than what they can reflect",
            relit.emitters
        ));
    }
    if !relit.complete {
        notes.push(
            "stopped before all captured light was shot: raise --max-shots; reflectance and emission of the walls are recovered from a part of it"
                .into(),
        );
    }
    if stage.captured.panorama.is_some() {
        let turned = match arguments.objects.room_turn {
            Some(turn) => format!(", before it is turned by {turn}° about y"),
            None => String::new(),
        };
        notes.push(format!(
            "the centre of the map looks along +z, +x is a quarter turn to its left, y is up{turned}"
        ));
    }
    notes
}
