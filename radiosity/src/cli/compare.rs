//! `radiosity compare`: solves scenes on CPU and GPU and reports every difference.

use super::Outcome;
use super::bundled::bundled_scene;
use super::bundled_comparisons::bundled_comparisons;
use super::console::message;
use super::lights::LightOptions;
use super::options::{CommonOptions, PassOptions, ShootingOptions, parse_error};
use super::progress::{Progress, handle_interrupts, is_interrupted};
use super::shader::{ShaderOptions, end_on_stuck_device};
use super::solve::{JobMethod, SceneJob, scene_settings, solve_scene};
use super::watch::run_on_changes;
use crate::report::comparison as report;
use clap::{Args, Command, FromArgMatches};
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::solution::{prepare_folder, write_files};
use common::{Error, Result};
use gpu::Gpu;
use oracle::compare::comparison::{Comparison, SceneComparison};
use oracle::compare::divergence::find_first_divergence;
use oracle::compare::parting::FirstDivergence;
use oracle::compare::presets::{PresetSelection, SceneRequest, compare_presets};
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solver::{ErrorTarget, SolverKind};
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Arguments of `compare`.
#[derive(Args)]
pub struct CompareArguments {
    /// .obj, .gltf or .glb files
    #[arg(required_unless_present = "all")]
    scenes: Vec<PathBuf>,
    /// Compare bundled scenes by all visibilities, projections, lookups and form factors: every shader runs
    #[arg(long, conflicts_with_all = ["scenes", "error", "LightOptions", "ShootingOptions", "PassOptions", "quality"])]
    all: bool,
    /// Folder for report.html and report.json
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Compare only solves to this error, 0.2 to 10 %
    #[arg(long, value_name = "P%", value_parser = parse_error,
        conflicts_with_all = ["quality", "ShootingOptions", "PassOptions"])]
    error: Option<f64>,
    #[command(flatten)]
    shaders: ShaderOptions,
    /// Compare again when a scene or a shader file changes, until Ctrl-C
    #[arg(long)]
    watch: bool,
    /// Name the shot, texel and factor in which the solvers part; the report does so whenever they disagree
    #[arg(long)]
    first_divergence: bool,
    #[command(flatten)]
    lights: LightOptions,
    #[command(flatten)]
    shooting: ShootingOptions,
    #[command(flatten)]
    passes: PassOptions,
    #[command(flatten)]
    common: CommonOptions,
}

/// Compares the solvers; with `--watch` again after each change of a file.
pub fn run(arguments: &CompareArguments) -> Result<Outcome> {
    if !arguments.watch {
        return compare_once(arguments);
    }
    let files = || {
        // A folder that cannot be read is an error of the run.
        let shaders = arguments.shaders.stage_paths().unwrap_or_default();
        let shaders = shaders.into_iter().map(|(_, path)| path);
        shaders.chain(arguments.scenes.clone()).collect()
    };
    Ok(run_on_changes(files, || compare_once(arguments)))
}

/// Compares the solvers on each scene and writes the report.
fn compare_once(arguments: &CompareArguments) -> Result<Outcome> {
    let CompareArguments { common, out, .. } = arguments;
    arguments.shooting.check_item_buffer(true)?;
    let mut requests = load_scenes(arguments)?;
    let shader_files = arguments.shaders.load_files()?;
    prepare_folder(out, &["report.json", "report.html"])?;
    if arguments.all {
        requests = load_comparisons(&bundled_comparisons(), out)?;
    }
    handle_interrupts();
    let gpu = match Gpu::open(common.adapter.as_deref()) {
        Ok(gpu) if shader_files.is_empty() => gpu,
        Ok(gpu) => {
            let gpu = gpu.with_shader_files(shader_files);
            end_on_stuck_device(&gpu);
            gpu
        }
        Err(error @ Error::NoAdapter(_)) if !arguments.all => return Err(solve_without_adapter(arguments, error)),
        Err(error) => return Err(error),
    };
    let unused_file = || {
        let file = gpu.unused_shader_file()?;
        let text = format!(
            "was not run: these options do not use the stage {}; with `compare --all` in place of a scene every stage runs",
            file.stage
        );
        Some(Error::bad_input(&file.path, "", text))
    };
    let mut comparisons = Vec::new();
    for SceneRequest { scene, selection } in &requests {
        let progress = Progress::new(&scene.name);
        let show = |phase: &str, done| progress.show_phase(phase, done);
        let watch = ProgressMonitor::new(&show);
        let judged = compare_presets(scene, selection, &gpu, &[], &watch).and_then(|mut judged| {
            // A verdict without the file would mislead; another scene may run it.
            if let Some(error) = unused_file().filter(|_| requests.len() == 1) {
                return Err(error);
            }
            for c in judged.solve_default.iter_mut().chain([&mut judged.first]) {
                c.notes.extend(gpu.describe_shader_files());
            }
            // The verdict does not wait for what explains it.
            progress.remove_bar();
            print_summary(&judged);
            let progress = Progress::new(&scene.name);
            let show = |phase: &str, done| progress.show_phase(phase, done);
            let watch = ProgressMonitor::new(&show);
            add_first_divergences(&mut judged, arguments.first_divergence, &gpu, &watch)?;
            Ok(judged)
        });
        progress.remove_bar();
        if is_interrupted() {
            message!(
                "interrupted: the report holds the {} scenes compared by then",
                comparisons.len()
            );
            return Ok(Outcome::Disagree);
        }
        let judged = judged?;
        if arguments.first_divergence {
            print_first_divergences(&judged);
        }
        comparisons.push(judged);
        // Written after every scene, so that an interrupted run keeps the scenes that are done.
        let json = format!("{:#}\n", report::report_json(&comparisons));
        let html = report::render_report(&comparisons, &[]);
        write_files(out, [("report.json", json), ("report.html", html)])?;
    }
    if let Some(error) = unused_file() {
        return Err(error);
    }
    message!("wrote {0}/report.html and {0}/report.json", out.display());
    Ok(if comparisons.iter().all(SceneComparison::all_agree) {
        Outcome::Done
    } else {
        Outcome::Disagree
    })
}

/// Reads the scenes, and chooses the settings of each.
fn load_scenes(arguments: &CompareArguments) -> Result<Vec<SceneRequest>> {
    let import = arguments.common.import_options();
    let load = |path: &PathBuf| arguments.lights.load_scene(path, &import);
    let scenes: Vec<Scene> = arguments.scenes.iter().map(load).collect::<Result<_>>()?;
    let choose = |scene: Scene| SceneRequest {
        selection: select_presets(arguments, &scene),
        scene,
    };
    Ok(scenes.into_iter().map(choose).collect())
}

/// Reads the scenes of comparisons, and their presets: each is the path of a scene, or the name of a bundled one, and
/// options. The scene is named by these words.
///
/// Errors: a bundled scene cannot be written to `out`; a scene cannot be read; an option is unknown.
pub fn load_comparisons(comparisons: &[String], out: &Path) -> Result<Vec<SceneRequest>> {
    let load = |words: &String| {
        let (name, options) = words.split_once(' ').unwrap_or((words, ""));
        let scene = match Path::new(name) {
            path if path.exists() => path.to_owned(),
            _ => bundled_scene(name, out)?,
        };
        let options = options.split_whitespace().map(Into::into);
        let mut request = read_comparison([scene.into_os_string()].into_iter().chain(options))?;
        request.scene.name.clone_from(words);
        Ok(request)
    };
    comparisons.iter().map(load).collect()
}

/// Returns the scene and the presets of a comparison with these words of the command line.
///
/// Errors: an option is unknown; the scene cannot be read.
fn read_comparison(words: impl Iterator<Item = OsString>) -> Result<SceneRequest> {
    let parser = CompareArguments::augment_args(Command::new("compare").no_binary_name(true));
    let parsed = parser.try_get_matches_from(words);
    let parsed = parsed.and_then(|matches| CompareArguments::from_arg_matches(&matches));
    let arguments = parsed.map_err(|error| Error::Usage(error.to_string()))?;
    let path = arguments.scenes.first().map(PathBuf::as_path).unwrap_or(Path::new(""));
    let scene = arguments.lights.load_scene(path, &arguments.common.import_options())?;
    let selection = select_presets(&arguments, &scene);
    Ok(SceneRequest { scene, selection })
}

/// Returns the settings to compare: one preset if an option selects the method, else the paper's and the default.
fn select_presets(arguments: &CompareArguments, scene: &Scene) -> PresetSelection {
    let CompareArguments {
        common,
        shooting,
        passes,
        error,
        ..
    } = arguments;
    // Scenes of many faces have coarser defaults in either preset.
    let (solve, note) = scene_settings(scene, common, shooting, passes, true);
    if let Some(note) = note {
        message!("note: {}: {note}", scene.name);
    }
    let target = ErrorTarget {
        error: error.unwrap_or(common.quality_error()),
        texels: Some(solve.meshing.texels),
    };
    if error.is_some() || (common.quality.is_some() && !arguments.has_shooting_options()) {
        return PresetSelection::ToError(target, solve);
    }
    // Texels, ε, shots and pixels apply to any method.
    let of_method = ShootingOptions {
        epsilon: None,
        max_shots: None,
        item_buffer: None,
        ..shooting.clone()
    };
    let selected = of_method != ShootingOptions::default() || *passes != PassOptions::default();
    if common.quality.is_some() || selected {
        return PresetSelection::Shooting(solve);
    }
    let mut paper = solve;
    (paper.meshing.patches, paper.meshing.samples) = (1, 1);
    paper.schedule = paper.schedule.with_southwell();
    paper.transport.form_factor = FormFactor::Disc;
    PresetSelection::PaperAndDefault { paper, target }
}

impl CompareArguments {
    /// Returns true if an option of shooting is given.
    fn has_shooting_options(&self) -> bool {
        self.shooting != ShootingOptions::default() || self.passes != PassOptions::default()
    }
}

/// Solves each scene on the CPU into a folder of its own, for want of an adapter. Returns the command's error.
fn solve_without_adapter(arguments: &CompareArguments, error: Error) -> Error {
    message!("note: {error}; each scene is only solved, on the CPU");
    let target = arguments.error.unwrap_or(arguments.common.quality_error());
    let method = match arguments.has_shooting_options() {
        true => JobMethod::Shooting(&arguments.shooting, &arguments.passes),
        false => JobMethod::ToError(target),
    };
    let mut used = BTreeSet::new();
    for path in &arguments.scenes {
        let mut name = path.file_stem().unwrap_or(path.as_os_str()).to_owned();
        // Scenes of one name are in different folders.
        while !used.insert(name.clone()) {
            name.push("-again");
        }
        let job = SceneJob {
            scene: path.clone(),
            out: arguments.out.join(name),
            common: arguments.common.clone(),
            lights: arguments.lights.clone(),
            ..SceneJob::default()
        };
        if let Err(failure) = solve_scene(&job, SolverKind::Cpu, method) {
            return failure;
        }
    }
    error
}

/// Finds where the solvers part: where they disagree, or everywhere if the user `wants` it.
///
/// Errors: the user interrupts.
fn add_first_divergences(judged: &mut SceneComparison, wants: bool, gpu: &Gpu, watch: &ProgressMonitor) -> Result<()> {
    for c in judged.solve_default.iter_mut().chain([&mut judged.first]) {
        if wants || !c.solvers_agree() {
            c.first_divergence = Some(find_first_divergence(c, (gpu, &[]), watch)?);
        }
    }
    Ok(())
}

/// Prints where the solvers part, or that they do not.
fn print_first_divergences(judged: &SceneComparison) {
    for c in judged.iter_comparisons() {
        message!("{}, {}:", judged.first.scene.name, c.preset.name());
        for line in c.first_divergence.iter().flat_map(FirstDivergence::sentences) {
            message!("  {line}");
        }
    }
}

/// Prints the verdict and the error of both solvers: agreement is not accuracy.
fn print_summary(judged: &SceneComparison) {
    let name = &judged.first.scene.name;
    for c in judged.iter_comparisons() {
        let verdict = if c.solvers_agree() {
            "the solvers agree"
        } else {
            "THE SOLVERS DISAGREE"
        };
        message!("{name}, {}: {verdict}; {}", c.preset.name(), describe_accuracy(c));
        for criterion in c.criteria.iter().filter(|criterion| !criterion.pass) {
            message!(
                "  beyond its bound: {} = {:.3e} > {:.3e} ({})",
                criterion.name,
                criterion.value,
                criterion.bound,
                criterion.reason
            );
            if let Some(difference) = &criterion.difference {
                message!("    {difference}");
            }
        }
    }
}

fn describe_accuracy(c: &Comparison) -> String {
    match (&c.truth, c.truth_error) {
        (Some(truth), [Some(cpu), Some(gpu)]) => format!(
            "the answers are {:.1} % off on the CPU, {:.1} % on the GPU, against {} (itself off by less than {:.1} %)",
            100.0 * cpu,
            100.0 * gpu,
            truth.name,
            100.0 * truth.own_error,
        ),
        _ => "how far off the answers are is not known: there is no truth to judge by".into(),
    }
}
