//! Judges mutants, several at a time, each by the trials that run its shader until one finds it.

use super::equivalent::find_reason;
use super::judge::{Judge, TrialEnd};
use super::worker::{TrialReply, TrialRequest};
use super::{JudgedMutant, Mutant, MutantVerdict};
use common::{Error, Result};
use gpu::shader_mutants::give_same_modules;
use gpu::shaders::check_shader_files;
use gpu::{SHADER_STAGES, ShaderFile, ShaderStage};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::channel;
use std::thread;
use std::time::{Duration, Instant};

/// Time that any trial may take. A new process opens the device and compiles all pipelines, and lavapipe ends a loop
/// without an end after 65 536 turns, so that a shader with one ends late, but with a verdict.
const MIN_TRIAL_TIME: Duration = Duration::from_secs(60);
/// Time that a trial may take, of the time without a mutant.
const TRIAL_TIME_FACTOR: u32 = 6;
/// Prefix of the names of criteria of stages.
const STAGE_CRITERION: &str = "WGSL = twin: ";

/// What a trial does without mutants.
#[derive(Clone)]
struct HealthyTrial {
    used: Vec<String>,
    time_limit: Duration,
}

/// A run of mutants.
pub struct SabotageRun<'a> {
    /// Options of the trials.
    pub trials: &'a [String],
    /// Files in the place of the program's shaders.
    pub given: &'a [ShaderFile],
    /// Makes the command of the process that compares.
    pub command: &'a (dyn Fn() -> Command + Sync),
    /// Number of such processes at a time.
    pub processes: usize,
    /// Returns true to stop.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl SabotageRun<'_> {
    /// Judges the mutants, and gives each verdict to `take` as it comes, in no order.
    ///
    /// Errors: without mutants a trial finds a difference; a process cannot be started; `take` fails.
    pub fn judge_mutants(&self, mutants: &[&Mutant], take: &mut dyn FnMut(JudgedMutant) -> Result<()>) -> Result<()> {
        let healthy = self.run_healthy_trials()?;
        if healthy.len() < self.trials.len() {
            return Ok(());
        }
        let next = AtomicUsize::new(0);
        let (send, receive) = channel();
        thread::scope(|scope| {
            for _ in 0..self.processes {
                let (send, next, healthy) = (send.clone(), &next, &healthy);
                scope.spawn(move || {
                    let mut judge = Judge::new(self.command);
                    while let Some(mutant) = mutants.get(next.fetch_add(1, Ordering::Relaxed)) {
                        let judged = self.judge_mutant(&mut judge, healthy, mutant).transpose();
                        let Some(judged) = judged else { break };
                        // Nobody receives any more after an error.
                        if send.send(judged).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(send);
            receive.into_iter().try_for_each(|judged| take(judged?))
        })
    }

    /// Runs each trial without mutants; fewer than all after an interrupt.
    fn run_healthy_trials(&self) -> Result<Vec<HealthyTrial>> {
        let mut judge = Judge::new(self.command);
        let mut healthy = Vec::new();
        for (trial, options) in self.trials.iter().enumerate() {
            let request = TrialRequest {
                trial,
                files: self.files_with(SHADER_STAGES.map(|stage| (stage.name, stage.text)), &[]),
            };
            let start = Instant::now();
            let refuse = |text: String| {
                let text = format!("without a mutant, compare {options}: {text}");
                match self.given.first() {
                    Some(file) => Error::bad_input(&file.path, "", text),
                    None => Error::Device(text),
                }
            };
            match judge.run_trial(&request, 60 * MIN_TRIAL_TIME, self.stop)? {
                TrialEnd::Interrupted => break,
                TrialEnd::Late | TrialEnd::Crashed => return Err(refuse("does not end with an answer".into())),
                TrialEnd::Reply(TrialReply {
                    used, broken, error, ..
                }) => {
                    if let Some(text) = error.as_ref().or(broken.first()) {
                        return Err(refuse(format!("{text} does not hold")));
                    }
                    healthy.push(HealthyTrial {
                        used,
                        time_limit: MIN_TRIAL_TIME + TRIAL_TIME_FACTOR * start.elapsed(),
                    });
                }
            }
        }
        Ok(healthy)
    }

    /// Returns names and texts of files: these, in their place the given ones, and in the place of both `first`.
    fn files_with<'t>(
        &'t self,
        others: impl IntoIterator<Item = (&'t str, &'t str)>,
        first: &[(&'t str, &'t str)],
    ) -> Vec<(String, String)> {
        let given = self.given.iter().map(|file| (file.stage, file.text.as_str()));
        let mut files: Vec<(String, String)> = Vec::new();
        for (name, text) in first.iter().copied().chain(given).chain(others) {
            if files.iter().all(|(other, _)| other != name) {
                files.push((name.to_owned(), text.to_owned()));
            }
        }
        files
    }

    /// Judges a mutant; none after an interrupt.
    fn judge_mutant(
        &self,
        judge: &mut Judge,
        healthy: &[HealthyTrial],
        mutant: &Mutant,
    ) -> Result<Option<JudgedMutant>> {
        let start = Instant::now();
        let stage = ShaderStage::find(mutant.shader)?;
        let given = self.given.iter().find(|file| file.stage == mutant.shader);
        let text = given.map_or(stage.text, |file| file.text.as_str());
        let mutated = mutant.mutation.apply(text);
        let make_file = |text: &str| ShaderFile::new(stage.name, Path::new(stage.name), text.to_owned());
        let end = |verdict, reason: &str, own_stage, divergence_leads_here| {
            Ok(Some(JudgedMutant {
                key: mutant.key.clone(),
                shader: mutant.shader.to_owned(),
                file: mutant.file.clone(),
                line: mutant.line,
                line_text: mutant.line_text.clone(),
                operator: mutant.mutation.operator.name().to_owned(),
                original: mutant.original.clone(),
                mutated: mutant.mutation.replacement.clone(),
                verdict,
                reason: reason.to_owned(),
                own_stage,
                divergence_leads_here,
                seconds: start.elapsed().as_secs_f64(),
            }))
        };
        if let Some(reason) = find_reason(mutant) {
            return end(MutantVerdict::Equivalent, reason, false, None);
        }
        if let Err(error) = check_shader_files(&[make_file(&mutated)]) {
            return end(MutantVerdict::Invalid, &error.to_string(), false, None);
        }
        if give_same_modules(&make_file(text), &make_file(&mutated))? {
            return end(MutantVerdict::Equivalent, "naga's module is the same", false, None);
        }
        let runs_shader = |trial: &HealthyTrial| trial.used.iter().any(|used| used == mutant.shader);
        if !healthy.iter().any(runs_shader) {
            return end(MutantVerdict::NotRun, "no comparison runs the shader", false, None);
        }
        for (trial, run) in healthy.iter().enumerate().filter(|(_, run)| runs_shader(run)) {
            let files = self.files_with([], &[(mutant.shader, &mutated)]);
            let mut divergence_leads_here = None;
            let (reason, named) = match judge.run_trial(&TrialRequest { trial, files }, run.time_limit, self.stop)? {
                TrialEnd::Interrupted => return Ok(None),
                TrialEnd::Late => ("it takes too long".to_owned(), None),
                TrialEnd::Crashed => ("the program crashes".to_owned(), None),
                TrialEnd::Reply(TrialReply { stuck: Some(name), .. }) => {
                    (format!("the GPU does not finish {name}"), Some(name))
                }
                TrialEnd::Reply(TrialReply { error: Some(text), .. }) => (format!("error: {text}"), None),
                TrialEnd::Reply(TrialReply {
                    broken,
                    divergent_stages,
                    ..
                }) => {
                    let Some(criterion) = broken.into_iter().next() else {
                        continue;
                    };
                    let leads_here = divergent_stages.iter().any(|name| names_own_stage(&stage, name));
                    divergence_leads_here = Some(leads_here);
                    let named = criterion.strip_prefix(STAGE_CRITERION).map(str::to_owned);
                    (criterion, named)
                }
            };
            let own_stage = named.is_some_and(|name| names_own_stage(&stage, &name));
            return end(MutantVerdict::Killed, &reason, own_stage, divergence_leads_here);
        }
        end(MutantVerdict::Survived, "", false, None)
    }
}

/// Returns whether a name of a stage is the shader's, or one under which its faults are shown; of records any.
fn names_own_stage(stage: &ShaderStage, name: &str) -> bool {
    stage.verdict.is_empty() || stage.verdict.contains(&name) || stage.name == name
}
