//! The process that compares with mutants: it answers a line of JSON for each, and may hang, panic or be killed.

use common::{Error, Result};
use gpu::{Gpu, ShaderFile, ShaderStage};
use oracle::compare::divergence::find_first_divergence;
use oracle::compare::parting::Factor;
use oracle::compare::presets::{SceneRequest, compare_presets};
use oracle::solve::progress::without_progress;
use serde::{Deserialize, Serialize};
use std::io::BufRead;
use std::path::Path;
use std::time::Duration;

/// Longest time of a call to the device, below the time that any trial may take.
const MAX_CALL_TIME: Duration = Duration::from_secs(8);

/// A comparison that is asked for.
#[derive(Serialize, Deserialize)]
pub struct TrialRequest {
    /// Number of the trial.
    pub trial: usize,
    /// Names of shaders, and the texts that take their places.
    pub files: Vec<(String, String)>,
}

/// Result of a comparison.
#[derive(Default, Serialize, Deserialize)]
pub struct TrialReply {
    /// Names of those shaders that were run.
    pub used: Vec<String>,
    /// Name of a shader that does not end.
    pub stuck: Option<String>,
    /// Names of the criteria that do not hold.
    pub broken: Vec<String>,
    /// Names of the stages to which the first divergence leads, if one is found.
    pub divergent_stages: Vec<String>,
    /// The error with which it ended, if it did.
    pub error: Option<String>,
}

/// Answers requests until the input ends or the device fails, which fails all later work. If a call to the device does not
/// return, the process ends with an answer that names the shader.
///
/// Errors: a request is none, or the answer cannot be written.
pub fn answer_requests(
    gpu: &Gpu,
    trials: &[SceneRequest],
    input: impl BufRead,
    write_line: impl Fn(&str) -> Result<()> + Copy + Send + 'static,
) -> Result<()> {
    gpu.call_clock.watch_calls(MAX_CALL_TIME, move |stage| {
        let reply = TrialReply {
            stuck: stage.map(str::to_owned),
            error: Some("it takes too long".into()),
            ..TrialReply::default()
        };
        // Without an answer the other process waits until its own limit.
        let _ = serde_json::to_string(&reply).map(|text| write_line(&text));
        std::process::exit(0);
    });
    let fault = |text: String| Error::Fault(format!("a request of a trial: {text}"));
    for line in input.lines() {
        let line = line.map_err(|error| fault(error.to_string()))?;
        let request: TrialRequest = serde_json::from_str(&line).map_err(|error| fault(error.to_string()))?;
        let trial = trials.get(request.trial).ok_or_else(|| fault(line))?;
        let reply = run_trial(gpu, trial, &request.files)?;
        let text = serde_json::to_string(&reply).map_err(|error| fault(error.to_string()))?;
        write_line(&text)?;
        if gpu.has_failed() {
            break;
        }
    }
    Ok(())
}

fn run_trial(gpu: &Gpu, trial: &SceneRequest, files: &[(String, String)]) -> Result<TrialReply> {
    let make_file = |(name, text): &(String, String)| {
        let path = format!("{name}.wgsl");
        Ok(ShaderFile::new(
            ShaderStage::find(name)?.name,
            Path::new(&path),
            text.clone(),
        ))
    };
    let files: Vec<ShaderFile> = files.iter().map(make_file).collect::<Result<_>>()?;
    let gpu = gpu.clone().with_shader_files(files);
    let mut reply = TrialReply::default();
    if let Err(error) = judge_trial(&gpu, trial, &mut reply) {
        reply.error = Some(error.to_string());
    }
    reply.used = gpu.used_shaders().map(str::to_owned).collect();
    Ok(reply)
}

/// Notes the criteria of the first comparison that finds a difference, and the stages to which its first divergence leads.
fn judge_trial(gpu: &Gpu, trial: &SceneRequest, reply: &mut TrialReply) -> Result<()> {
    let compared = compare_presets(&trial.scene, &trial.selection, gpu, &[], &without_progress())?;
    let Some(comparison) = compared.iter_comparisons().find(|c| c.criteria.iter().any(|c| !c.pass)) else {
        return Ok(());
    };
    let broken = comparison.criteria.iter().filter(|criterion| !criterion.pass);
    reply.broken = broken.map(|criterion| criterion.name.clone()).collect();
    let divergence = find_first_divergence(comparison, (gpu, &[]), &without_progress())?;
    let Some(parting) = divergence.parting else {
        return Ok(());
    };
    reply.divergent_stages = match (parting.stage, parting.factor) {
        (Some(stage), _) => vec![stage],
        (None, factor) => Factor::stages(factor).iter().map(ToString::to_string).collect(),
    };
    Ok(())
}
