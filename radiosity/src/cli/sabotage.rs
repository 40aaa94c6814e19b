//! `radiosity sabotage`: plants mistakes in the shaders and shows which the comparison finds.

use super::Outcome;
use super::bundled_comparisons::bundled_comparisons;
use super::compare::load_comparisons;
use super::console::{message, output};
use super::progress::{Progress, handle_interrupts, is_interrupted};
use super::shader::ShaderOptions;
use crate::studies::hashes::{hash_program, hash_value};
use crate::studies::sabotage::page::render_page;
use crate::studies::sabotage::run::SabotageRun;
use crate::studies::sabotage::score::{Score, summarise_verdicts};
use crate::studies::sabotage::selection::{draw_sample, list_mutants};
use crate::studies::sabotage::store::VerdictStore;
use crate::studies::sabotage::worker::answer_requests;
use crate::studies::sabotage::{JudgedMutant, Mutant, MutantVerdict};
use clap::Args;
use common::solution::{prepare_folder, write_files};
use common::{Error, Result};
use gpu::{Gpu, SHADER_STAGES, ShaderFile};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread::available_parallelism;

/// Default number of mutants: half an hour on two cores.
const DEFAULT_COUNT: usize = 600;
/// Arguments of `sabotage`.
#[derive(Args)]
pub struct SabotageArguments {
    #[command(flatten)]
    shaders: ShaderOptions,
    /// Number of mutants, drawn evenly from all shaders and kinds of mistakes
    #[arg(long, value_name = "N", default_value_t = DEFAULT_COUNT)]
    count: usize,
    /// Judge by this comparison, a scene and options of `compare`, not by the bundled ones; repeatable
    #[arg(long, value_name = "WORDS")]
    comparison: Vec<String>,
    /// Seed of the draw
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    /// Folder for sabotage.html, sabotage.json and the verdicts so far: the same command again goes on
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Answer requests of comparisons on stdin
    #[arg(long, hide = true)]
    judge: bool,
}

/// Judges mutants of the given shaders, or of all.
pub fn run(arguments: &SabotageArguments) -> Result<Outcome> {
    let out = &arguments.out;
    let comparisons = match arguments.comparison.is_empty() {
        true => bundled_comparisons(),
        false => arguments.comparison.clone(),
    };
    if arguments.judge {
        let gpu = Gpu::open(arguments.adapter.as_deref())?;
        let write_line = |line: &str| output!("{line}");
        return answer_requests(
            &gpu,
            &load_comparisons(&comparisons, out)?,
            std::io::stdin().lock(),
            write_line,
        )
        .map(|()| Outcome::Done);
    }
    let given = arguments.shaders.load_files()?;
    prepare_folder(out, &["sabotage.json", "sabotage.html"])?;
    handle_interrupts();
    let adapter = Gpu::open(arguments.adapter.as_deref())?.line.name;
    // The scenes are written before several processes read them.
    load_comparisons(&comparisons, out)?;
    let program = std::env::current_exe().map_err(|error| Error::Fault(error.to_string()))?;
    let all = list_mutants(
        &mutated_files(&given),
        &describe_context(&given, &comparisons, &adapter),
    )?;
    let existing = all.len();
    let mutants = draw_sample(all, arguments.count, arguments.seed);
    let store = VerdictStore::new(out);
    let known = store.read()?;
    let known = mutants.iter().filter_map(|mutant| known.get(&mutant.key).cloned());
    let mut judged: Vec<JudgedMutant> = known.collect();
    let open: Vec<&Mutant> = mutants
        .iter()
        .filter(|mutant| judged.iter().all(|known| known.key != mutant.key))
        .collect();
    message!(
        "{existing} mutants exist; {} are drawn, {} of them judged before",
        mutants.len(),
        judged.len()
    );
    let sabotage = SabotageRun {
        trials: &comparisons,
        given: &given,
        command: &|| judge_command(&program, arguments),
        processes: available_parallelism().map_or(1, usize::from).min(open.len()),
        stop: &is_interrupted,
    };
    let progress = Progress::new("sabotage");
    if !open.is_empty() {
        sabotage.judge_mutants(&open, &mut |mutant| {
            store.append(&mutant)?;
            judged.push(mutant);
            let _ = progress.show_phase("mutants", judged.len() as f64 / mutants.len() as f64);
            Ok(())
        })?;
    }
    progress.remove_bar();
    if judged.is_empty() && is_interrupted() {
        return Err(Error::Interrupted);
    }
    judged.sort_by(|a, b| (&a.shader, a.line, &a.key).cmp(&(&b.shader, b.line, &b.key)));
    let json = format!("{:#}\n", summarise_verdicts(&judged, existing));
    write_files(
        out,
        [
            ("sabotage.json", json),
            ("sabotage.html", render_page(&judged, existing)),
        ],
    )?;
    print_summary(&judged);
    if judged.len() < mutants.len() {
        message!("interrupted: the same command goes on");
    }
    message!("wrote {0}/sabotage.html and {0}/sabotage.json", out.display());
    let is_complete = judged.len() == mutants.len() && !Score::new(&judged).has_gap();
    Ok(if is_complete { Outcome::Done } else { Outcome::Disagree })
}

/// Returns the files to mutate: the given ones, or all of the program's.
fn mutated_files(given: &[ShaderFile]) -> Vec<ShaderFile> {
    if given.is_empty() {
        let own = SHADER_STAGES.map(|stage| {
            let path = format!("{}.wgsl", stage.name);
            ShaderFile::new(stage.name, Path::new(&path), stage.text.to_owned())
        });
        return own.into();
    }
    let copy = |file: &ShaderFile| ShaderFile::new(file.stage, &file.path, file.text.clone());
    given.iter().map(copy).collect()
}

/// Names what a verdict depends on beside the mutant: this build of the program, the other files, the comparisons,
/// and the adapter.
fn describe_context(given: &[ShaderFile], comparisons: &[String], adapter: &str) -> String {
    let files: Vec<[&str; 2]> = given.iter().map(|file| [file.stage, file.text.as_str()]).collect();
    let inputs = hash_value(&(files, comparisons));
    format!("{:x} {inputs:x} {adapter}", hash_program())
}

/// Returns the command of a process that compares.
fn judge_command(program: &Path, arguments: &SabotageArguments) -> Command {
    let mut command = Command::new(program);
    command.args(["sabotage", "--judge", "--out"]).arg(&arguments.out);
    for words in &arguments.comparison {
        command.args(["--comparison", words]);
    }
    if let Some(name) = &arguments.adapter {
        command.args(["--adapter", name]);
    }
    command
}

fn print_summary(judged: &[JudgedMutant]) {
    for mutant in judged {
        match mutant.verdict {
            MutantVerdict::Survived => message!("survived: {}", mutant.describe()),
            MutantVerdict::NotRun => message!("not run: {}", mutant.describe()),
            _ => {}
        }
    }
    let score = Score::new(judged);
    let share = score
        .killed_share()
        .map_or(String::new(), |share| format!("; score {:.1} %", 100.0 * share));
    message!("{}{share}", score.describe());
}
