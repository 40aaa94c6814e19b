//! `--gltf`, `--uv` and `--texels-per-metre`: writes the scene with its light as a texture, for other programs.

use super::console::message;
use super::lights::LightOptions;
use super::options::CommonOptions;
use crate::report::gltf_export::uv_charts::UvCharts;
use crate::report::gltf_export::{ExportCharts, export_lightmap};
use crate::report::solution_view::RenderedView;
use clap::Args;
use common::import::{ImportOptions, SceneFile, load_scene, load_scene_file};
use common::scene::Scene;
use common::solution::Solution;
use common::solution::pending::PendingFiles;
use common::{Error, Result};
use std::path::{Path, PathBuf};

/// Options of baking.
#[derive(Args, Default)]
pub struct BakeOptions {
    /// Write the scene as it is, with its light as a texture (TEXCOORD_1), and that light as FILE.exr
    #[arg(long, value_name = "FILE.glb")]
    pub gltf: Option<PathBuf>,
    /// Charts of that texture: packed newly, or the scene's own TEXCOORD_1 kept [default: pack]
    #[arg(long, value_name = "pack|keep", value_parser = ["pack", "keep"], hide_possible_values = true, requires = "gltf")]
    uv: Option<String>,
    /// Pixels of that texture per unit of length [default: finer than the solve's texels]
    #[arg(long, value_name = "N", value_parser = parse_density, requires = "gltf", conflicts_with = "uv")]
    texels_per_metre: Option<f64>,
}

fn parse_density(text: &str) -> std::result::Result<f64, String> {
    let density = text.parse().ok().filter(|n: &f64| n.is_finite() && *n > 0.0);
    density.ok_or_else(|| "a number above 0 is needed".into())
}

/// A scene with its charts and its file, as far as it is to be baked.
pub struct BakedScene {
    /// The scene.
    pub scene: Scene,
    /// The file's own charts, if they are kept.
    pub charts: Option<UvCharts>,
    /// The file, if it is written again.
    pub file: Option<SceneFile>,
}

impl BakeOptions {
    /// Returns the import options of a scene to be baked.
    ///
    /// Errors: the name does not end in .glb; an option of `common` contradicts `--uv keep`.
    pub fn import_options(&self, common: &CommonOptions) -> Result<ImportOptions> {
        if let Some(path) = &self.gltf
            && path.extension().is_none_or(|ending| ending != "glb")
        {
            let text = format!("--gltf writes {}: a name that ends in .glb", path.display());
            return Err(Error::Usage(text));
        }
        let charts = self.uv.as_deref() == Some("keep");
        let given = [(common.join_quads, "--join-quads"), (common.two_sided, "--two-sided")];
        if let Some((_, option)) = given.iter().find(|(given, _)| *given && charts) {
            let text =
                format!("--uv keep lays light on the file's own triangles, one side of each: leave {option} out");
            return Err(Error::Usage(text));
        }
        Ok(ImportOptions {
            charts,
            ..common.import_options()
        })
    }

    /// Loads a scene that has light, with its file and charts if `--gltf` needs them.
    ///
    /// Errors: those of [`load_scene`] and of [`UvCharts::new`]; no face emits light.
    pub fn load_scene(&self, path: &Path, import: &ImportOptions, lights: &LightOptions) -> Result<BakedScene> {
        let (mut scene, file) = match &self.gltf {
            Some(_) => load_scene_file(path, import).map(|(scene, file)| (scene, Some(file)))?,
            None => (load_scene(path, import)?, None),
        };
        if file.as_ref().is_some_and(SceneFile::is_compressed) {
            let text = "has meshes that Draco compressed, which --gltf cannot write: decode them first with \
                        `npx @gltf-transform/cli copy IN.glb OUT.glb`";
            return Err(Error::bad_input(path, "extensionsUsed", text));
        }
        lights.add_light(path, &mut scene)?;
        let charts = import.charts.then(|| UvCharts::new(&scene)).transpose()?;
        Ok(BakedScene { scene, charts, file })
    }

    /// Returns the folder and the names of the baked scene and its EXR if `--gltf` is given.
    pub fn output_files(&self) -> Option<(&Path, [String; 2])> {
        let path = self.gltf.as_deref()?;
        let names = [path.to_path_buf(), path.with_extension("exr")];
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let name = |path: PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Some((folder.unwrap_or(Path::new(".")), names.map(name)))
    }

    /// Adds the baked scene and its EXR to `files` if `--gltf` is given.
    ///
    /// Errors: those of [`export_lightmap`].
    pub fn add_files(
        &self,
        files: &mut PendingFiles,
        (solution, charts, file): (&Solution, Option<&UvCharts>, Option<SceneFile>),
        seen: &RenderedView,
    ) -> Result<()> {
        let (Some((folder, [scene_name, light_name])), Some(file)) = (self.output_files(), file) else {
            return Ok(());
        };
        let charts = charts.map_or(ExportCharts::Packed(self.texels_per_metre), ExportCharts::Own);
        let light = (solution.mesh, &solution.run.field);
        let baked = export_lightmap((solution.scene, file), charts, light, seen.preview.exposure)?;
        for note in &baked.notes {
            message!("note: {note}");
        }
        files.add(folder, scene_name, baked.glb);
        files.add(folder, light_name, baked.exr);
        Ok(())
    }
}
