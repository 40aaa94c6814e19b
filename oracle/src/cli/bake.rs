//! `--gltf` and `--uv`: the scene with its light, for other programs.

use super::options::Common;
use super::tell::say;
use crate::show::around::Seen;
use crate::show::bake::bake;
use crate::show::bake::charts::Charts;
use clap::{Args, ValueEnum};
use common::import::ImportOptions;
use common::scene::Scene;
use common::solution::pending::Pending;
use common::solution::{Solution, prepare};
use common::{Error, Result};
use std::path::{Path, PathBuf};

/// What is baked, and how it is laid out.
#[derive(Args, Default)]
pub struct Bake {
    /// Write the scene with its light as a texture (TEXCOORD_1), and that light as FILE.exr
    #[arg(long, value_name = "FILE.glb")]
    gltf: Option<PathBuf>,
    /// Where that light lies: on charts packed anew, or kept on the scene's own TEXCOORD_1 [default: pack]
    #[arg(
        long,
        value_enum,
        value_name = "pack|keep",
        hide_possible_values = true,
        requires = "gltf"
    )]
    uv: Option<Uv>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Uv {
    Pack,
    Keep,
}

impl Bake {
    fn keeps(&self) -> bool {
        self.uv == Some(Uv::Keep)
    }

    /// How the scene is to be read.
    pub fn import(&self, common: &Common) -> Result<ImportOptions> {
        let given = [
            (common.join_quads, "--join-quads"),
            (common.two_sided, "--two-sided"),
        ];
        if let Some((_, option)) = given.iter().find(|(given, _)| *given && self.keeps()) {
            let text = format!(
                "--uv keep lays light on the file's own triangles, one side of each: leave {option} out"
            );
            return Err(Error::Usage(text));
        }
        Ok(ImportOptions {
            charts: self.keeps(),
            ..common.import()
        })
    }

    /// The scene's own charts, if they are to be kept.
    ///
    /// Errors: light cannot be laid there.
    pub fn charts(&self, scene: &Scene) -> Result<Option<Charts>> {
        self.keeps().then(|| Charts::new(scene)).transpose()
    }

    /// Whether the file may be written, if there is to be one: what is not checked before a solve is found out
    /// after it.
    pub fn check(&self) -> Result<()> {
        let Some(path) = &self.gltf else {
            return Ok(());
        };
        if path.extension().is_none_or(|ending| ending != "glb") {
            let text = format!("--gltf writes {}: a name that ends in .glb", path.display());
            return Err(Error::Usage(text));
        }
        let folder = path.parent().filter(|dir| !dir.as_os_str().is_empty());
        prepare(folder.unwrap_or(Path::new(".")))
    }

    /// Adds the files, if they are asked for.
    pub fn add(
        &self,
        files: &mut Pending,
        (solution, charts): (&Solution, Option<&Charts>),
        seen: &Seen,
    ) -> Result<()> {
        let Some(path) = &self.gltf else {
            return Ok(());
        };
        let light = (solution.mesh, &solution.run.field);
        let baked = bake(solution.scene, charts, light, seen.preview.exposure)?;
        if let Some(note) = &baked.note {
            say!("note: {note}");
        }
        files.add(path, &baked.glb)?;
        files.add(&path.with_extension("exr"), &baked.exr)
    }
}
