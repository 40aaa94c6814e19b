//! The command line: `solve`, `compare`, `relight`, `merge`, `table4`, `diff`, `check`, `converge`,
//! `chart`, `stress`, `plan`, `adapters`, `completions`; exit codes as in the README.

mod adapters;
mod bake;
mod bundled;
mod chart;
mod check;
mod compare;
mod completions;
mod converge;
mod diff;
mod help;
mod merge;
mod objects;
mod options;
mod plan;
mod progress;
mod relight;
mod repeat;
mod scene;
mod signals;
mod solve;
mod solver;
mod stress;
mod table4;
mod tell;

use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use common::Error;
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

/// Progressive radiosity solved by rays on the CPU and by a hemisphere item buffer on the GPU,
/// and the difference explained. Without a command: `compare` on the bundled Cornell box,
/// report in out/.
#[derive(Parser)]
#[command(name = "radiosity", version)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Solve one scene; writes preview.png, view.html, lightmap.exr and result.json
    Solve(solve::Arguments),
    /// Solve scenes on CPU and GPU and explain every difference; writes report.html
    Compare(compare::Arguments),
    /// Put objects into a captured room; writes composite.png, report.html and what solve writes
    Relight(Box<relight::Arguments>),
    /// Merge bracketed photographs of one view into a radiance map; writes radiance.exr, merge.html
    Merge(merge::Arguments),
    /// Repeat the paper's Table 4, its columns beside ours; writes table4.html
    Table4(table4::Arguments),
    /// Compare two results (directories of solve), the second one as the truth; writes diff.html
    Diff(diff::Arguments),
    /// Judge a result of any origin by its own light, gathered anew; writes check.html
    Check(check::Arguments),
    /// Measure how the error falls and the time grows with each parameter; writes converge.html
    Converge(converge::Arguments),
    /// Plot speed against accuracy, every method on CPU and GPU; writes chart.html
    Chart(chart::Arguments),
    /// Run the failure atlas: scenes built to break each method; writes stress.html
    Stress(stress::Arguments),
    /// Estimate what a solve will take: texels, memory, shots, time
    Plan(plan::Arguments),
    /// List the GPU adapters found
    Adapters(adapters::Arguments),
    /// Print what a shell needs to complete our commands and options
    Completions(completions::Arguments),
}

impl Command {
    /// The result whose settings it takes.
    fn settings(&self) -> Option<&Path> {
        match self {
            Self::Solve(arguments) => arguments.settings.as_deref(),
            _ => None,
        }
    }
}

/// How a command ended.
pub enum Outcome {
    /// Done, in agreement.
    Done,
    /// Done, and the solvers disagree beyond their bounds, or what was found is an error by
    /// `--strict`.
    Disagree,
}

/// Runs the program; errors are one `error:` line on stderr.
pub fn main() -> ExitCode {
    signals::survive_file_limit();
    let arguments = match parsed() {
        Ok(arguments) => arguments,
        Err(error) => return usage(&error),
    };
    let outcome = match arguments.command {
        Some(Command::Solve(arguments)) => solve::run(&arguments),
        Some(Command::Compare(arguments)) => compare::run(&arguments),
        Some(Command::Relight(arguments)) => relight::run(&arguments),
        Some(Command::Merge(arguments)) => merge::run(&arguments),
        Some(Command::Table4(arguments)) => table4::run(&arguments),
        Some(Command::Diff(arguments)) => diff::run(&arguments),
        Some(Command::Check(arguments)) => check::run(&arguments),
        Some(Command::Converge(arguments)) => converge::run(&arguments),
        Some(Command::Chart(arguments)) => chart::run(&arguments),
        Some(Command::Stress(arguments)) => stress::run(&arguments),
        Some(Command::Plan(arguments)) => plan::run(&arguments),
        Some(Command::Adapters(arguments)) => adapters::run(&arguments),
        Some(Command::Completions(arguments)) => completions::run(&arguments, program()),
        None => compare::demo(),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Disagree) => ExitCode::from(1),
        Err(error) => failed(&error),
    }
}

/// Tells an error; its exit code.
fn failed(error: &Error) -> ExitCode {
    tell::error(&error.to_string());
    ExitCode::from(match error {
        Error::Input { .. } | Error::Usage(_) => 2,
        Error::NoAdapter(_) | Error::Device(_) => 3,
        Error::Write { .. } => 4,
        Error::Fault(_) => 1,
        // As a shell reports a program that Ctrl-C ended.
        Error::Interrupted => 130,
    })
}

/// The command line. Numbers may be negative everywhere: whether one may, its option knows better
/// than clap, which takes them for options.
fn program() -> clap::Command {
    let negative = |arg: clap::Arg| {
        let takes = arg.get_action().takes_values();
        arg.allow_negative_numbers(takes)
    };
    Arguments::command()
        .after_help(help::below(""))
        .mut_subcommands(|command| {
            let below = help::below(command.get_name());
            command.mut_args(negative).after_help(below)
        })
}

/// What was asked for.
fn parsed() -> std::result::Result<Arguments, clap::Error> {
    let given: Vec<OsString> = std::env::args_os().collect();
    let arguments = parse(program(), &given)?;
    let settings = arguments.command.as_ref().and_then(Command::settings);
    let Some(settings) = settings else {
        return Ok(arguments);
    };
    // What is given beside it follows, and the last one counts.
    let earlier = repeat::options(settings)?;
    let (command, rest) = given.split_at(2);
    let all = [command, &earlier, rest].concat();
    let repeated = parse(program().args_override_self(true), &all);
    repeated.map_err(|_| repeat::not_such(settings))
}

fn parse(
    mut program: clap::Command,
    given: &[OsString],
) -> std::result::Result<Arguments, clap::Error> {
    let matches = program.try_get_matches_from_mut(given)?;
    let quiet = |matches: &ArgMatches| matches!(matches.try_get_one("quiet"), Ok(Some(true)));
    if matches.subcommand().is_some_and(|(_, of)| quiet(of)) {
        tell::hush();
    }
    Arguments::from_arg_matches(&matches).map_err(|error| error.format(&mut program))
}

/// Help and version go out as they are; a usage error becomes one line.
fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        return match tell::printed(error.print()) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => failed(&error),
        };
    }
    let text = error.to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let ends = ["\nUsage:", "\nFor more information"];
    let end = ends.iter().filter_map(|end| text.find(end)).min();
    let lines = text[..end.unwrap_or(text.len())].lines();
    // `-- -x` would make a scene of a mistyped option.
    let wanted = lines.filter(|line| !line.trim_start().starts_with("tip: to pass"));
    let message = wanted.collect::<Vec<_>>().join(" ");
    tell::error(&format!("{message} (see radiosity --help)"));
    ExitCode::from(2)
}
