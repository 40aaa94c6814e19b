//! The command line: one module per command (`solve`, `shoot`, `compare`, `relight`, `merge`, `table4`, `diff`,
//! `check`, `chart`, `stress`, `sabotage`, `hardware`, `shader`, `adapters`, `completions`), and the options, output and progress that
//! they share. GUIDE.md lists the exit codes.

mod adapters;
mod bake;
mod bundled;
mod bundled_comparisons;
mod chart;
mod check;
mod compare;
mod completions;
mod console;
mod diff;
mod hardware;
mod help;
mod lights;
mod merge;
mod objects;
mod options;
mod plan;
mod progress;
mod relight;
mod sabotage;
mod shader;
mod signals;
mod solve;
mod solver;
mod spelling;
mod stress;
mod table4;
mod trace;
mod watch;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use common::text::escape_control;
use common::{Error, Result};
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

/// Progressive radiosity, solved by rays on the CPU and by a hemisphere item buffer on the GPU, with every
/// difference between the two explained. Without a command: `compare` on the bundled Cornell box, report in out/.
#[derive(Parser)]
#[command(name = "radiosity", version)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    /// No progress, no summary
    #[arg(long, global = true)]
    quiet: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Solve a scene to an error; writes preview.png, view.html, lightmap.exr and result.json
    Solve(Box<solve::SolveArguments>),
    /// Solve a scene by progressive refinement with the settings given; writes the same files
    Shoot(Box<solve::ShootArguments>),
    /// Solve scenes on CPU and GPU and explain every difference; writes report.html
    Compare(Box<compare::CompareArguments>),
    /// Put objects into a captured room; writes composite.png, report.html and what solve writes
    Relight(Box<relight::RelightArguments>),
    /// Merge bracketed photographs of one view into a radiance map; writes radiance.exr, merge.html
    Merge(merge::MergeArguments),
    /// Repeat the paper's Table 4, its columns beside ours; writes table4.html
    Table4(table4::Table4Arguments),
    /// Compare two results (directories of solve), the second taken as the truth; writes diff.html
    Diff(diff::DiffArguments),
    /// Judge a result of any origin: its light is gathered again and compared; writes check.html
    Check(check::CheckArguments),
    /// Plot speed against accuracy of every method, or error against one option; writes chart.html
    Chart(chart::ChartArguments),
    /// Run the failure atlas: scenes built to break each method; writes stress.html
    Stress(stress::StressArguments),
    /// Plant mistakes in the shaders and show which compare finds; writes sabotage.html
    Sabotage(sabotage::SabotageArguments),
    /// Check and time a GPU: every stage against its twin, the paper's shots; writes hardware.html
    Hardware(hardware::HardwareArguments),
    /// Print a shader of the program, to start your own from; without STAGE list them
    Shader(shader::ShaderArguments),
    /// List the GPU adapters found
    Adapters,
    /// Print a shell's completion script
    Completions(completions::CompletionsArguments),
}

/// The end of a command that wrote its results.
pub enum Outcome {
    /// Done, in agreement: exit code 0.
    Done,
    /// Done, and the solvers disagree or a tolerance is exceeded: exit code 1.
    Disagree,
}

/// Runs the program; errors are one `error:` line on stderr.
pub fn main() -> ExitCode {
    signals::survive_file_limit();
    let outcome = match parse_command_line(std::env::args_os().collect()) {
        Ok(arguments) => run_command(arguments),
        Err(error) => return report_usage_error(&error),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Disagree) => ExitCode::from(1),
        Err(error) => report_error(&error),
    }
}

fn run_command(arguments: Arguments) -> Result<Outcome> {
    match arguments.command {
        Some(Command::Solve(arguments)) => solve::run_solve(&arguments),
        Some(Command::Shoot(arguments)) => solve::run_shoot(&arguments),
        Some(Command::Compare(arguments)) => compare::run(&arguments),
        Some(Command::Relight(arguments)) => relight::run(&arguments),
        Some(Command::Merge(arguments)) => merge::run(&arguments),
        Some(Command::Table4(arguments)) => table4::run(&arguments),
        Some(Command::Diff(arguments)) => diff::run(&arguments),
        Some(Command::Check(arguments)) => check::run(&arguments),
        Some(Command::Chart(arguments)) => chart::run(&arguments),
        Some(Command::Stress(arguments)) => stress::run(&arguments),
        Some(Command::Sabotage(arguments)) => sabotage::run(&arguments),
        Some(Command::Hardware(arguments)) => hardware::run(&arguments),
        Some(Command::Shader(arguments)) => shader::run(&arguments),
        Some(Command::Adapters) => adapters::run(),
        Some(Command::Completions(arguments)) => completions::run(&arguments, build_parser()),
        None => {
            let scene = bundled::bundled_scene("cornell_box.obj", Path::new("out"))?;
            let demo = Arguments::try_parse_from(["radiosity".as_ref(), "compare".as_ref(), scene.as_os_str()]);
            run_command(demo.map_err(|error| Error::Fault(error.to_string()))?)
        }
    }
}

/// Prints an error and returns its exit code.
fn report_error(error: &Error) -> ExitCode {
    console::print_error(&error.to_string());
    if let Error::Shader { listing, .. } = error {
        console::print_error_lines(listing);
    }
    ExitCode::from(match error {
        Error::Input { .. } | Error::Shader { .. } | Error::Usage(_) => 2,
        Error::NoAdapter(_) | Error::Device(_) | Error::Stage { .. } => 3,
        Error::Write { .. } => 4,
        Error::Fault(_) => 1,
        // The code by which a shell reports a program that Ctrl-C ended.
        Error::Interrupted => 130,
    })
}

/// Builds the parser of the command line. Every value may begin with a minus sign: clap would read it as an
/// option, and each option's own parser refuses negative numbers with a better message.
fn build_parser() -> clap::Command {
    let negative = |arg: clap::Arg| {
        let takes = arg.get_action().takes_values();
        arg.allow_negative_numbers(takes)
    };
    Arguments::command()
        .after_help(help::help_footer(""))
        .mut_subcommands(|command| {
            // These commands print their result and nothing else: there `--quiet` changes nothing.
            let is_silent = ["adapters", "completions", "shader"].contains(&command.get_name());
            let quiet = clap::Arg::new("quiet").long("quiet").action(clap::ArgAction::SetTrue);
            let command = if is_silent {
                command.arg(quiet.hide(true))
            } else {
                command
            };
            let below = help::help_footer(command.get_name());
            command.mut_args(negative).after_help(below)
        })
}

/// Parses a command line, the first word of which is the program's name, and runs nothing.
///
/// Errors: what the program prints of it as its `error:` line.
pub fn check_command_line(given: Vec<OsString>) -> std::result::Result<(), String> {
    match parse_arguments(given) {
        Err(error) if error.use_stderr() => Err(describe_usage_error(&error)),
        _ => Ok(()),
    }
}

/// Parses the command line; prints a note on each earlier spelling.
fn parse_command_line(given: Vec<OsString>) -> std::result::Result<Arguments, clap::Error> {
    let (arguments, notes) = parse_arguments(given)?;
    if arguments.quiet {
        console::silence_notes();
    }
    for note in notes {
        console::message!("note: {note}");
    }
    Ok(arguments)
}

/// Parses a command line, in which earlier spellings are replaced; also returns a note on each of them.
fn parse_arguments(mut given: Vec<OsString>) -> std::result::Result<(Arguments, Vec<String>), clap::Error> {
    let notes = spelling::replace_earlier_spellings(&mut given)?;
    let mut program = build_parser();
    let matches = program.try_get_matches_from_mut(given)?;
    let arguments = Arguments::from_arg_matches(&matches).map_err(|error| error.format(&mut program))?;
    Ok((arguments, notes))
}

/// Prints help and version unchanged, a usage error as one line; returns the exit code.
fn report_usage_error(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        return match console::check_stdout(error.print()) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => report_error(&error),
        };
    }
    console::print_error(&describe_usage_error(error));
    ExitCode::from(2)
}

/// Returns a usage error as one line.
fn describe_usage_error(error: &clap::Error) -> String {
    let text = error.to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let ends = ["\nUsage:", "\nFor more information"];
    let end = ends.iter().filter_map(|end| text.find(end)).min();
    let lines = text[..end.unwrap_or(text.len())].lines();
    // clap's tip `-- -x` would make a mistyped option a scene.
    let wanted = lines.filter(|line| !line.trim_start().starts_with("tip: to pass"));
    let words: Vec<&str> = wanted.flat_map(str::split_whitespace).collect();
    escape_control(&format!("{} (see radiosity --help)", words.join(" ")))
}
