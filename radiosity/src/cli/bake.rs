//! `--gltf` and `--uv`: writes the scene with its light as a texture, for other programs.

use super::console::message;
use super::options::CommonOptions;
use crate::report::gltf_export::export_lightmap;
use crate::report::gltf_export::uv_charts::UvCharts;
use crate::report::solution_view::RenderedView;
use clap::{Args, ValueEnum};
use common::import::ImportOptions;
use common::solution::Solution;
use common::solution::pending::PendingFiles;
use common::{Error, Result};
use std::path::PathBuf;

/// Options of baking.
#[derive(Args, Default)]
pub struct BakeOptions {
    /// Write the scene with its light as a texture (TEXCOORD_1), and that light as FILE.exr
    #[arg(long, value_name = "FILE.glb")]
    pub gltf: Option<PathBuf>,
    /// Charts of that texture: packed newly, or the scene's own TEXCOORD_1 kept [default: pack]
    #[arg(
        long,
        value_enum,
        value_name = "pack|keep",
        hide_possible_values = true,
        requires = "gltf"
    )]
    uv: Option<UvOption>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum UvOption {
    Pack,
    Keep,
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
        let charts = self.uv == Some(UvOption::Keep);
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

    /// Adds the baked scene and its EXR to `files` if `--gltf` is given.
    ///
    /// Errors: those of [`export_lightmap`]; a file cannot be written.
    pub fn add_files(
        &self,
        files: &mut PendingFiles,
        (solution, charts): (&Solution, Option<&UvCharts>),
        seen: &RenderedView,
    ) -> Result<()> {
        let Some(path) = &self.gltf else {
            return Ok(());
        };
        let light = (solution.mesh, &solution.run.field);
        let baked = export_lightmap(solution.scene, charts, light, seen.preview.exposure)?;
        if let Some(note) = &baked.note {
            message!("note: {note}");
        }
        files.add(path, &baked.glb)?;
        files.add(&path.with_extension("exr"), &baked.exr)
    }
}
