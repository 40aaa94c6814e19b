//! Content of `hardware.html`: stages right and wrong, comparisons, times, and the chart.

use super::{HardwareReport, StageCounts};
use crate::report::document::{
    Blocks, Figure, Row, Section, Table, VerdictTone, code_text, pass_mark, plain_text, render_document,
};
use crate::report::format::{format_count, format_duration, format_percent};
use crate::report::plot::Plot;

const PAGE_TEXT: &str = "Every stage of the GPU's solvers runs on the same input as its twin in Rust. A stage is right where \
    its values differ by no more than the roundings that its operations may make. Its table counts the comparisons in which \
    it is right, wrong and not run; the last column is the largest part of its bound that was reached. hardware.json has \
    all figures.";
const SOFTWARE_TEXT: &str = "This adapter runs on the CPU: its times say nothing about a GPU, and it hides races between \
    workgroups.";
const PAGE_STYLE: &str = "figure,figure.wide{max-width:none}";

/// Returns the page, with the plots of the chart.
pub fn render_page(report: &HardwareReport, plots: &[(String, Plot)]) -> String {
    let mut opening = Blocks::default();
    opening.add_remark(format!(
        "{} · {} · {} · version {}",
        report.adapter, report.backend, report.driver, report.program
    ));
    let (tone, word) = match report.agrees() {
        true => (VerdictTone::Good, "Right"),
        false => (VerdictTone::Bad, "Wrong"),
    };
    opening
        .add_verdict(tone, word, report.describe())
        .add_paragraph(PAGE_TEXT);
    if report.software {
        opening.add_warning(SOFTWARE_TEXT);
    }
    let mut stages = Blocks::default();
    stages.add_table(stage_table(report));
    let mut comparisons = Blocks::default();
    comparisons.add_table(comparison_table(report));
    let sections = [
        stages.into_section("stages", "Stages"),
        comparisons.into_section("comparisons", "Comparisons"),
        times_section(report),
        chart_section(plots),
    ];
    render_document("Radiosity: this GPU", &opening, &sections, PAGE_STYLE)
}

fn stage_table(report: &HardwareReport) -> Table {
    let all = report.comparisons.len();
    let row = |(name, count): (&str, StageCounts)| {
        let is_wrong = count.wrong > 0;
        let cells = [
            plain_text(name),
            pass_mark(!is_wrong),
            plain_text(format!(
                "{} · {} · {}",
                count.right,
                count.wrong,
                all - count.right - count.wrong
            )),
            plain_text(format_percent(count.nearest)),
        ];
        Row::new(cells).with_class_if(is_wrong, "bad")
    };
    let heads = "Stage;;#Right · wrong ·|not run;#Of its|bound";
    Table::new(heads, report.count_stages().into_iter().map(row))
}

fn comparison_table(report: &HardwareReport) -> Table {
    let row = |compared: &super::ComparedScene| {
        Row::new([
            code_text(&compared.options),
            pass_mark(compared.agrees),
            plain_text(compared.failing.join("; ")),
        ])
    };
    Table::new(
        "Scene and options;;~Beyond their bounds",
        report.comparisons.iter().map(row),
    )
}

fn times_section(report: &HardwareReport) -> Section {
    let mut body = Blocks::default();
    if let Some(paper) = &report.paper {
        let row = |solver: &str, shots: usize, seconds: f64| {
            Row::new([
                solver.to_owned(),
                format_count(shots as u64),
                format_duration(seconds),
                format!("{:.0}", shots as f64 / seconds),
            ])
        };
        body.add_remark(format!(
            "The paper's room, {} texels, whole faces, until 5 % of the power is unshot",
            format_count(paper.texels as u64)
        ))
        .add_table(Table::new(
            "Solver;#Shots;#Time;#Shots a second",
            [
                row("GPU, item buffers of 1024²", paper.shots, paper.gpu_seconds),
                row("CPU, rays", paper.cpu_shots, paper.cpu_seconds),
            ],
        ));
    }
    let stage = |timed: &super::StageSeconds| Row::new([timed.stage.to_owned(), format_duration(timed.seconds)]);
    body.add_remark("A shot in this scene, stage by stage")
        .add_table(Table::new("Stage;#Time", report.stage_seconds.iter().map(stage)));
    body.into_section("times", "Times")
}

fn chart_section(plots: &[(String, Plot)]) -> Section {
    let mut body = Blocks::default();
    let figures = plots
        .iter()
        .map(|(scene, plot)| Figure::from_plot(plot, "no point was measured", format!("{scene}: error against time")));
    body.add_figures(&figures.collect::<Vec<_>>());
    body.into_section("chart", "Speed against accuracy")
}
