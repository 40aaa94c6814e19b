//! `radiosity hardware`: checks and times an adapter.

use super::Outcome;
use super::bundled::bundled_scene;
use super::bundled_comparisons::bundled_comparisons;
use super::chart::measure_draft;
use super::compare::load_comparisons;
use super::console::message;
use super::progress::{Progress, handle_interrupts};
use crate::studies::chart::page::titled_plots;
use crate::studies::chart::points::{SceneChart, chart_json};
use crate::studies::hardware::page::render_page;
use crate::studies::hardware::{HardwareReport, time_paper, time_stages};
use clap::Args;
use common::import::{ImportOptions, load_scene};
use common::solution::{prepare_folder, write_files};
use common::{Error, Result};
use gpu::Gpu;
use oracle::compare::presets::compare_presets;
use oracle::solve::progress::ProgressMonitor;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::{env, fs, process, slice};

/// Arguments of `hardware`.
#[derive(Args)]
pub struct HardwareArguments {
    /// Folder for hardware.html and hardware.json
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Checks the adapter and writes after each part.
pub fn run(arguments: &HardwareArguments) -> Result<Outcome> {
    let out = &arguments.out;
    let gpu = Gpu::open(arguments.adapter.as_deref())?;
    prepare_folder(out, &["hardware.json", "hardware.html"])?;
    handle_interrupts();
    let mut report = HardwareReport::new(&gpu.line);
    let measured = measure_adapter(&gpu, out, &mut report);
    match measured {
        Err(Error::Interrupted) if !report.comparisons.is_empty() => {
            message!("interrupted: the page holds what was measured by then");
        }
        measured => measured?,
    }
    message!("{}: {}", report.adapter, report.describe());
    if let Some(paper) = &report.paper {
        let rate = |shots: usize, seconds: f64| shots as f64 / seconds;
        message!(
            "the paper's room: {:.0} shots a second on the GPU, {:.0} on the CPU",
            rate(paper.shots, paper.gpu_seconds),
            rate(paper.cpu_shots, paper.cpu_seconds)
        );
    }
    message!("wrote {0}/hardware.html and {0}/hardware.json", out.display());
    Ok(if report.agrees() {
        Outcome::Done
    } else {
        Outcome::Disagree
    })
}

/// Adds to the report, and writes it after each part.
fn measure_adapter(gpu: &Gpu, out: &Path, report: &mut HardwareReport) -> Result<()> {
    for request in load_comparisons(&bundled_comparisons(), out)? {
        let progress = Progress::new(&request.scene.name);
        let show = |phase: &str, done| progress.show_phase(phase, done);
        let watch = ProgressMonitor::new(&show);
        let judged = compare_presets(&request.scene, &request.selection, gpu, &[], &watch);
        progress.remove_bar();
        report.add_comparison(&judged?);
        write_report(out, report, &[])?;
    }
    let load = |name| load_scene(&bundled_scene(name, out)?, &ImportOptions::default());
    let (paper_room, cornell_box) = (load("paper_room_objects.obj")?, load("cornell_box.obj")?);
    let progress = Progress::new("times");
    let show = |phase: &str, done| progress.show_phase(phase, done);
    report.stage_seconds = time_stages(&paper_room, gpu)?;
    report.paper = Some(time_paper(&paper_room, gpu, &show)?);
    write_report(out, report, &[])?;
    // A later run measures anew: what a chart keeps goes to a folder that is removed.
    let folder = env::temp_dir().join(format!("radiosity-hardware-{}", process::id()));
    fs::create_dir_all(&folder).map_err(|source| Error::Write {
        path: folder.clone(),
        source,
    })?;
    let chart = measure_draft(&cornell_box, gpu, &folder);
    progress.remove_bar();
    // The system empties its folder for temporary files, too.
    let _ = fs::remove_dir_all(&folder);
    let chart = chart?;
    report.chart = chart_json(slice::from_ref(&chart));
    write_report(out, report, &[chart])
}

fn write_report(out: &Path, report: &HardwareReport, charts: &[SceneChart]) -> Result<()> {
    let json = format!("{:#}\n", json!(report));
    let page = render_page(report, &titled_plots(charts));
    write_files(out, [("hardware.json", json), ("hardware.html", page)])
}
