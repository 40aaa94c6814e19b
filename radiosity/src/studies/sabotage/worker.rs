//! The process that compares with mutants: it answers a line of JSON for each, and may hang, panic or be killed.

use common::{Error, Result};
use gpu::{Gpu, ShaderFile, ShaderStage};
use oracle::compare::comparison::Comparison;
use oracle::compare::hierarchical::compare_hierarchical;
use oracle::compare::presets::{PresetSelection, SceneRequest};
use oracle::compare::{ComparisonRequest, compare_shooting};
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
    let (broken, error) = match compare_once(&gpu, trial) {
        Ok(comparison) => {
            let broken = comparison.criteria.into_iter().filter(|criterion| !criterion.pass);
            (broken.map(|criterion| criterion.name).collect(), None)
        }
        Err(error) => (Vec::new(), Some(error.to_string())),
    };
    Ok(TrialReply {
        used: gpu.used_shaders().map(str::to_owned).collect(),
        stuck: None,
        broken,
        error,
    })
}

fn compare_once(gpu: &Gpu, trial: &SceneRequest) -> Result<Comparison> {
    match &trial.selection {
        PresetSelection::ToError(target, settings) => {
            compare_hierarchical(&trial.scene, *target, settings, (gpu, &[]), &without_progress())
        }
        PresetSelection::Shooting(settings) | PresetSelection::PaperAndDefault { paper: settings, .. } => {
            let request = ComparisonRequest {
                settings: *settings,
                gpu,
                faults: &[],
            };
            compare_shooting(&trial.scene, &request, &without_progress())
        }
    }
}
