//! `radiosity shader`: prints a shader of the program. The options of `compare` that put files in the place of shaders.

use super::console::{check_stdout, output};
use super::{Outcome, report_error};
use clap::Args;
use common::{Error, Result};
use gpu::{Gpu, SHADER_STAGES, ShaderFile, ShaderStage};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Longest time of a call to the device with shaders of the user's. Lavapipe ends a loop after 65 536 turns: a call with one may
/// take many seconds and return, and a comparison makes many.
const MAX_CALL_TIME: Duration = Duration::from_secs(10);

/// Arguments of `shader`.
#[derive(Args)]
pub struct ShaderArguments {
    /// The stage; without it all are listed
    stage: Option<String>,
}

/// Prints the WGSL of a stage, or a line on each.
pub fn run(arguments: &ShaderArguments) -> Result<Outcome> {
    match &arguments.stage {
        Some(name) => {
            let text = ShaderStage::find(name)?.text;
            check_stdout(std::io::stdout().lock().write_all(text.as_bytes()))?;
        }
        None => {
            for stage in SHADER_STAGES {
                let (summary, twin, names) = (stage.summary(), stage.twin(), stage.verdict_names());
                output!("{:18} {summary} · {twin} · in the verdict: {names}", stage.name)?;
            }
        }
    }
    Ok(Outcome::Done)
}

/// Options that put files in the place of shaders.
#[derive(Args, Clone, Default)]
pub struct ShaderOptions {
    /// Put FILE in the place of this shader of the GPU's; repeatable. `radiosity shader` lists them
    #[arg(long = "shader", value_name = "STAGE=FILE.wgsl", value_parser = parse_shader)]
    files: Vec<(String, PathBuf)>,
    /// Put each .wgsl file of DIR in the place of the shader of its name
    #[arg(long = "shaders", value_name = "DIR")]
    folder: Option<PathBuf>,
}

impl ShaderOptions {
    /// Returns the stage and the path of each file.
    ///
    /// Errors: [`Error::Usage`] of a stage with two files; [`Error::Input`] of a folder without any.
    pub fn stage_paths(&self) -> Result<Vec<(String, PathBuf)>> {
        let mut files = self.files.clone();
        if let Some(folder) = &self.folder {
            files.extend(shaders_in(folder)?);
        }
        for (k, (stage, _)) in files.iter().enumerate() {
            if files[..k].iter().any(|(other, _)| other == stage) {
                return Err(Error::Usage(format!("two files are given for the shader {stage}")));
            }
        }
        Ok(files)
    }

    /// Reads the files and compiles them.
    ///
    /// Errors: as of [`Self::stage_paths`]; of a file that cannot be read, or is no WGSL.
    pub fn load_files(&self) -> Result<Vec<ShaderFile>> {
        let paths = self.stage_paths()?;
        let files = paths.iter().map(|(stage, path)| ShaderFile::read(stage, path));
        let files: Vec<ShaderFile> = files.collect::<Result<_>>()?;
        gpu::shaders::check_shader_files(&files)?;
        Ok(files)
    }
}

/// Ends the program with an error when a call to the device takes too long.
pub fn end_on_stuck_device(gpu: &Gpu) {
    let make_error = gpu.error_maker();
    gpu.call_clock.watch_calls(MAX_CALL_TIME, move |stage| {
        let (stage, seconds) = (stage.unwrap_or("its work"), MAX_CALL_TIME.as_secs());
        report_error(&make_error(&format!(
            "the GPU has not finished {stage} for {seconds} seconds: a loop, or a number of workgroups, may have no end"
        )));
        std::process::exit(2);
    });
}

fn parse_shader(value: &str) -> std::result::Result<(String, PathBuf), String> {
    match value.split_once('=') {
        Some((stage, file)) if !file.is_empty() => Ok((stage.to_owned(), file.into())),
        _ => Err("STAGE=FILE.wgsl is needed, such as deposit=mine.wgsl".into()),
    }
}

/// Returns the stage and the path of each .wgsl file in a folder.
fn shaders_in(folder: &Path) -> Result<Vec<(String, PathBuf)>> {
    let refuse = |reason: String| Error::bad_input(folder, "", reason);
    let entries = std::fs::read_dir(folder).map_err(|error| refuse(format!("cannot be read: {error}")))?;
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "wgsl"));
    paths.sort_unstable();
    if paths.is_empty() {
        return Err(refuse("has no .wgsl file".into()));
    }
    let name = |path: &PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(paths.into_iter().map(|path| (name(&path), path)).collect())
}
