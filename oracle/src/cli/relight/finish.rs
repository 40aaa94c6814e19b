//! What `relight` writes.

use super::{Arguments, MethodOption};
use crate::cli::Outcome;
use crate::cli::objects::Object;
use crate::cli::solve::{around, judged, pending, wrote};
use crate::cli::tell::{self, say};
use crate::relight::camera::{camera_at, camera_for};
use crate::relight::page::{Report, html};
use crate::relight::pictures::Pictures;
use crate::relight::stage::Stage;
use crate::relight::thumbnail::thumbnail;
use crate::relight::{Backdrop, Relit as Seen, SIZE, composite, files};
use crate::show::picture::Exposure;
use crate::show::view::camera::Camera;
use crate::solve::solved::{Recovered, Solved};
use crate::solve::watch::Watch;
use crate::solve::{Answer, Question};
use clap::ValueEnum;
use common::energy::Energy;
use common::solution::pending::Pending;
use common::solution::{Seconds, Solution};
use common::{Error, Result};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};

/// What a relight writes.
const FILES: &str = "composite.png, preview.png, view.html, report.html, composite.exr, background.exr, lightmap.exr and result.json";
/// Pixels of the panorama in the report.
const THUMBNAIL: u32 = 512;

/// Pictures and files, and what is said at the end.
pub fn write(
    arguments: &Arguments,
    stage: &Stage,
    question: &Question,
    answered: &Answer,
    watch: &Watch,
) -> Result<Outcome> {
    let (done, out) = (&answered.solved, &arguments.out);
    let relit = done.relit.as_ref();
    let relit = relit.ok_or_else(|| Error::Fault("a relight knows no room".into()))?;
    let seen = seen(stage, done, relit);
    let radiance = |d: DVec3| match &stage.captured.panorama {
        Some((panorama, _)) => panorama.radiance(d),
        None => Vec3::ZERO,
    };
    let backdrop: Option<Backdrop> = stage.captured.panorama.is_some().then_some(&radiance);
    let camera = camera(arguments, &seen);
    let picture = watch.of("composite", || {
        composite::composite(&seen, &camera, SIZE, backdrop)
    });
    let exposure = files::exposure(&picture).opened(arguments.exposure, arguments.curve.into());
    let energy = Energy::new(&done.mesh, &done.run.field, &done.run.shots);
    let mut notes = stage.notes.clone();
    notes.extend(said(stage, done, relit));
    for note in &answered.notes {
        say!("note: {note}");
        notes.push(note.clone());
    }
    let seconds = Seconds {
        load: watch.seconds(&["load"]),
        prepare: watch.seconds(&["capture", "prepare", "recover"]),
        solve: watch.seconds(&["relight"]),
    };
    let solution = Solution {
        relit: Some(description(
            arguments, stage, done, relit, &picture, exposure,
        )),
        ..answered.solution(question, &notes, seconds)
    };
    watch.of("write", || -> Result<()> {
        solution.write(out)?;
        files::write(out, &picture, exposure)
    })?;
    // Through the same camera as the composite: one that shows the objects.
    let (around, pictures) = watch.of("view", || {
        rayon::join(
            || around(&solution, Some(camera)).seen(),
            || Pictures::new(&seen, &picture, exposure),
        )
    });
    let around = around?;
    let files_of = arguments.objects.objects.iter();
    let objects: Vec<String> = files_of.map(|o| o.file.display().to_string()).collect();
    let phases = watch.phases();
    let report = Report {
        room: &arguments.room.display().to_string(),
        objects: &objects,
        settings: &listed(arguments, &solution),
        relit: &seen,
        composite: &picture,
        pictures: &pictures,
        camera,
        energy: Some(&energy),
        map_shots: relit.map_shots as u32,
        object_shots: relit.object_shots as u32,
        converged: done.run.converged,
        negative_texels: relit.negative_texels(&done.run),
        seconds: &phases,
        warnings: &answered.warnings,
        notes: &notes,
        thumbnail: backdrop.map(|backdrop| thumbnail(backdrop, THUMBNAIL)),
        around: &around.element.0,
    };
    let mut files = Pending::default();
    pending(&around, out, &mut files)?;
    files.add(&out.join("report.html"), html(&report).as_bytes())?;
    files.finish()?;
    if !arguments.common.quiet {
        summary(&solution, &phases, arguments);
    }
    if arguments.json {
        tell::json(&solution.summary())?;
    }
    Ok(judged(&solution, arguments.strict))
}

fn seen<'a>(stage: &'a Stage, done: &'a Solved, relit: &'a Recovered) -> Seen<'a> {
    Seen {
        scene: &stage.scene,
        mesh: &done.mesh,
        room: stage.room,
        before: &relit.before,
        after: &done.run.field,
        eye: stage.captured.panorama.as_ref().map(|(_, eye)| *eye),
    }
}

fn camera(arguments: &Arguments, seen: &Seen) -> Camera {
    match &arguments.camera {
        Some([ex, ey, ez, tx, ty, tz, fov]) => camera_at(
            seen.mesh,
            DVec3::new(*ex, *ey, *ez),
            DVec3::new(*tx, *ty, *tz),
            *fov,
        ),
        None => camera_for(seen),
    }
}

/// What result.json says beside what it says of a solve.
fn description(
    arguments: &Arguments,
    stage: &Stage,
    done: &Solved,
    relit: &Recovered,
    picture: &composite::Composite,
    exposure: Exposure,
) -> Value {
    let mended = arguments.mend.iter().filter_map(|f| f.to_possible_value());
    json!({
        "method": method_name(arguments.method),
        "mended": mended.map(|v| v.get_name().to_owned()).collect::<Vec<_>>(),
        "map_shots": relit.map_shots,
        "object_shots": relit.object_shots,
        "negative_texels": relit.negative_texels(&done.run),
        "negative_pixels": picture.negative,
        "emitting_texels": relit.emitters,
        "room": arguments.room.display().to_string(),
        "room_faces": stage.room,
        "objects": arguments.objects.objects.iter().map(described).collect::<Vec<_>>(),
        "eye": stage.captured.panorama.as_ref().map(|(_, eye)| eye.to_array()),
        "camera": arguments.camera,
        "exposure": {
            "stops": arguments.exposure,
            "white": exposure.white,
            "curve": exposure.curve.name(),
        },
    })
}

/// An object as it was put into the room.
fn described(object: &Object) -> Value {
    json!({
        "file": object.file.display().to_string(),
        "scale": object.scale,
        "place": object.place.to_array(),
        "reflectance": object.reflectance.map(|r| r.to_array()),
    })
}

/// The options in force, for people.
fn listed(arguments: &Arguments, solution: &Solution) -> Vec<(String, String)> {
    let mut all = vec![
        ("method".to_owned(), method_name(arguments.method)),
        (
            "solver".to_owned(),
            solution.adapter.unwrap_or("CPU").to_owned(),
        ),
    ];
    let settings = serde_json::to_value(solution.settings).unwrap_or_default();
    for (name, value) in settings.as_object().into_iter().flatten() {
        let text = value
            .as_str()
            .map_or_else(|| value.to_string(), str::to_owned);
        all.push((name.clone(), text));
    }
    all
}

fn method_name(method: MethodOption) -> String {
    let name = method.to_possible_value();
    name.map_or_else(String::new, |value| value.get_name().to_owned())
}

/// What the capture was found to be.
fn said(stage: &Stage, done: &Solved, relit: &Recovered) -> Vec<String> {
    let mut notes = Vec::new();
    if relit.emitters > 0 {
        let room = |t: &&common::mesh::Texel| (t.face as usize) < stage.room;
        let all = done.mesh.texels.iter().filter(room).count();
        notes.push(format!(
            "{} of {all} texels of the room emit: reflection alone does not explain their light",
            relit.emitters
        ));
    }
    if !relit.complete {
        notes.push(
            "stopped before all captured light was shot: raise --max-shots; what the walls reflect and emit is recovered from a part of it"
                .into(),
        );
    }
    if stage.captured.panorama.is_some() {
        notes.push(
            "the centre of the map looks along +z, +x is a quarter turn to its left, y is up"
                .into(),
        );
    }
    notes
}

fn summary(solution: &Solution, phases: &[(&str, f64)], arguments: &Arguments) {
    let energy = Energy::new(solution.mesh, &solution.run.field, &solution.run.shots);
    let phases: Vec<String> = phases
        .iter()
        .map(|(phase, seconds)| format!("{phase} {seconds:.2} s"))
        .collect();
    say!(
        "{}: {} faces, {} texels, {} shots on {}, {:.3} % unshot, imbalance {:.1e}; {}",
        solution.scene.name,
        solution.mesh.faces.len(),
        solution.mesh.texels.len(),
        solution.run.shots.len(),
        solution.adapter.unwrap_or("the CPU"),
        100.0 * solution.run.unshot_fraction(),
        energy.imbalance,
        phases.join(", "),
    );
    wrote(solution, FILES, &arguments.out);
}
