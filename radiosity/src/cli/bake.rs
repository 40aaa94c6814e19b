//! `--gltf` and `--uv`: writes the scene with its light as a texture, for other programs.

use super::console::message;
use super::options::CommonOptions;
use crate::report::gltf_export::export_lightmap;
use crate::report::gltf_export::uv_charts::UvCharts;
use crate::report::solution_view::RenderedView;
use clap::Args;
use common::import::ImportOptions;
use common::solution::Solution;
use common::solution::pending::PendingFiles;
use common::{Error, Result};
use std::path::{Path, PathBuf};

/// Options of baking.
#[derive(Args, Default)]
pub struct BakeOptions {
    /// Write the scene with its light as a texture (TEXCOORD_1), and that light as FILE.exr
    #[arg(long, value_name = "FILE.glb")]
    pub gltf: Option<PathBuf>,
    /// Charts of that texture: packed newly, or the scene's own TEXCOORD_1 kept [default: pack]
    #[arg(long, value_name = "pack|keep", value_parser = ["pack", "keep"], hide_possible_values = true, requires = "gltf")]
    uv: Option<String>,
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
        (solution, charts): (&Solution, Option<&UvCharts>),
        seen: &RenderedView,
    ) -> Result<()> {
        let Some((folder, [scene_name, light_name])) = self.output_files() else {
            return Ok(());
        };
        let light = (solution.mesh, &solution.run.field);
        let baked = export_lightmap(solution.scene, charts, light, seen.preview.exposure)?;
        if let Some(note) = &baked.note {
            message!("note: {note}");
        }
        files.add(folder, scene_name, baked.glb);
        files.add(folder, light_name, baked.exr);
        Ok(())
    }
}
