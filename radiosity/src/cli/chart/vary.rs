//! `radiosity chart --vary`, and the earlier command `converge`.

use super::{CHARTED_SCENES, ChartInputs, PAPER_ROOM};
use crate::cli::Outcome;
use crate::cli::console::message;
use crate::cli::progress::{Progress, handle_interrupts, is_interrupted};
use crate::cli::solver::open_gpu_or_twin;
use crate::studies::chart::plot::svg_file;
use crate::studies::chart::vary::measure::SweepSetup;
use crate::studies::chart::vary::sweeps::{
    EPSILON_SWEEP, ITEM_BUFFER_SWEEP, PATCH_SWEEP, SAMPLE_SWEEP, Sweep, TEXEL_SWEEP,
};
use crate::studies::chart::vary::{ConvergenceStudy, MeasuredSweep, convergence_json, item_buffer, page};
use clap::ValueEnum;
use common::Result;
use common::cover::sampled_mesh;
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::Meshing;
use common::solution::write_file;
use gpu::Gpu;
use oracle::solve::progress::ProgressMonitor;
use std::time::Instant;

/// Pixels per side of the item buffers in the table.
const ITEM_BUFFER_SIZES: [u32; 3] = [256, 512, 1024];

/// `--vary` of a chart.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum VariedOption {
    /// Texels per side of a face
    Texels,
    /// Patches per side of a face
    #[value(alias = "cells")]
    Patches,
    /// Visibility samples of a link
    Samples,
    /// Pixels of the item buffer, and its visibility against rays
    ItemBuffer,
    /// Unshot power at which a solve stops
    Epsilon,
    /// Each of them in turn
    All,
}

impl VariedOption {
    fn sweeps(self) -> Vec<Sweep> {
        let all = [
            (Self::Texels, TEXEL_SWEEP),
            (Self::Patches, PATCH_SWEEP),
            (Self::Samples, SAMPLE_SWEEP),
            (Self::ItemBuffer, ITEM_BUFFER_SWEEP),
            (Self::Epsilon, EPSILON_SWEEP),
        ];
        let chosen = all
            .into_iter()
            .filter(|(option, _)| [*option, Self::All].contains(&self));
        chosen.map(|(_, sweep)| sweep).collect()
    }
}

/// Runs the earlier command: every option varied, written as `converge.html` and `converge.json`.
pub fn run_converge(inputs: &ChartInputs) -> Result<Outcome> {
    message!("note: `radiosity converge` is `radiosity chart --vary all` now, or one option of it");
    run(inputs, VariedOption::All, "converge")
}

/// Charts the error against `option` on every scene; writes the files named `stem` after each sweep.
pub fn run(inputs: &ChartInputs, option: VariedOption, stem: &str) -> Result<Outcome> {
    let bundled: Vec<&str> = CHARTED_SCENES.into_iter().filter(|name| *name != PAPER_ROOM).collect();
    let scenes = inputs.load_scenes(&bundled)?;
    let truth = inputs.read_given_truth(&scenes)?;
    let gpu = match inputs.require_gpu {
        true => Some(Gpu::open(inputs.adapter.as_deref())?),
        false => open_gpu_or_twin(inputs.adapter.as_deref())?,
    };
    let mut store = inputs.open_store()?;
    handle_interrupts();
    let start = Instant::now();
    let write = |studies: &[ConvergenceStudy]| write_report(inputs, stem, studies, start.elapsed().as_secs_f64());
    let mut studies: Vec<ConvergenceStudy> = Vec::new();
    for scene in &scenes {
        studies.push(ConvergenceStudy {
            scene: scene.name.clone(),
            faces: scene.faces.len(),
            adapter: gpu
                .as_ref()
                .map_or("the CPU's twin".into(), |gpu| gpu.line.name.clone()),
            sweeps: Vec::new(),
            item_buffers: Vec::new(),
        });
        let last = studies.len() - 1;
        let mut setup = SweepSetup::new(scene, gpu.as_ref(), truth.as_ref(), &mut store);
        for sweep in option.sweeps() {
            let progress = Progress::new(&scene.name, inputs.quiet);
            let show = |phase: &str, done| progress.show_phase(phase, done);
            let measured = setup.measure_sweep(&sweep, &ProgressMonitor::new(&show))?;
            progress.clear();
            let Some(measured) = measured else { break };
            print_summary(&scene.name, &measured);
            studies[last].sweeps.push(measured);
            // Written after every sweep, so that an interrupted run keeps the sweeps that are done.
            write(&studies)?;
            if is_interrupted() {
                break;
            }
        }
        let compared = [VariedOption::ItemBuffer, VariedOption::All].contains(&option);
        if let (Some(gpu), true, false) = (&gpu, compared, is_interrupted()) {
            studies[last].item_buffers = compare_item_buffers(scene, gpu, inputs.quiet)?;
        }
        if is_interrupted() {
            message!("interrupted: the report holds what was measured by then; the same command continues it");
            break;
        }
    }
    write(&studies)?;
    let svg = if stem == "chart" { ", .svg" } else { "" };
    message!("wrote {}/{stem}.html{svg} and .json", inputs.out.display());
    Ok(Outcome::Done)
}

/// Compares item buffers with rays: whole faces, centre to centre, like `compare`.
fn compare_item_buffers(scene: &Scene, gpu: &Gpu, quiet: bool) -> Result<Vec<item_buffer::ItemBufferRow>> {
    let meshing = Meshing {
        patches: 1,
        ..Meshing::default()
    };
    let mesh = sampled_mesh(scene, &meshing)?;
    let progress = Progress::new(&scene.name, quiet);
    let mut done = 0;
    let settings = item_buffer::TESTED_PROJECTIONS.len() * item_buffer::TESTED_LOOKUPS.len();
    let all = settings * ITEM_BUFFER_SIZES.len();
    item_buffer::measure_rows(gpu, &mesh, FormFactor::Polygon, &ITEM_BUFFER_SIZES, &mut |_| {
        done += 1;
        let share = f64::from(done) / all as f64;
        let _ = progress.show_phase("item buffers against rays", share);
    })
}

fn write_report(inputs: &ChartInputs, stem: &str, studies: &[ConvergenceStudy], seconds: f64) -> Result<()> {
    let file = |ending: &str| inputs.out.join(format!("{stem}.{ending}"));
    let text = format!("{:#}\n", convergence_json(studies, seconds));
    write_file(&file("json"), text.as_bytes())?;
    if stem == "chart" {
        write_file(&file("svg"), svg_file(&page::error_charts(studies)).as_bytes())?;
    }
    write_file(&file("html"), page::render_page(studies).as_bytes())
}

fn print_summary(scene: &str, sweep: &MeasuredSweep) {
    for curve in &sweep.curves {
        let errors: Vec<String> = curve.points.iter().map(|p| format!("{:.3}", 100.0 * p.error)).collect();
        let order = page::format_order(curve.order);
        message!(
            "{scene}: {}, {}: {} %, order {order}; {}",
            sweep.option,
            curve.label,
            errors.join(" "),
            curve.finding
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn option_varies_itself_and_all_varies_each_in_turn() {
        let options =
            |varied: VariedOption| -> Vec<&str> { varied.sweeps().iter().map(|sweep| sweep.option).collect() };
        let mut each = Vec::new();
        for varied in VariedOption::value_variants() {
            if *varied != VariedOption::All {
                assert_eq!(options(*varied).len(), 1);
                each.extend(options(*varied));
            }
        }
        assert_eq!(options(VariedOption::All), each);
        let expected = ["--texels", "--patches", "--samples", "--item-buffer", "--epsilon"];
        assert_eq!(each, expected);
    }
}
