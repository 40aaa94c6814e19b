//! The scenes that commands are about: their reflectance, and whether there is light in them.

use super::objects::reflectance;
use clap::Args;
use common::import::{ImportOptions, load};
use common::scene::Scene;
use common::{Error, Result};
use glam::Vec3;
use std::path::Path;

/// What replaces the file's materials.
#[derive(Args, Clone, Default)]
pub struct Materials {
    /// Reflectance of all faces instead of the file's
    #[arg(long, value_name = "R,G,B", value_parser = reflectance)]
    reflectance: Option<Vec3>,
}

/// Whether a scene may be dark.
#[derive(Args, Clone, Default)]
pub struct Dark {
    /// Take a scene without any light as well: its answer is 0
    #[arg(long)]
    allow_dark: bool,
}

impl Materials {
    /// Reads a scene that has a light.
    pub fn lit(&self, path: &Path, options: ImportOptions) -> Result<Scene> {
        let scene = self.load(path, options)?;
        lit(path, &scene, "").map(|()| scene)
    }

    /// The same, or one that may be dark.
    pub fn lit_unless(&self, dark: &Dark, path: &Path, options: ImportOptions) -> Result<Scene> {
        let scene = self.load(path, options)?;
        if !dark.allow_dark {
            lit(path, &scene, "; --allow-dark solves it all the same")?;
        }
        Ok(scene)
    }

    /// Reads a scene.
    pub fn load(&self, path: &Path, options: ImportOptions) -> Result<Scene> {
        let options = ImportOptions {
            reflectance: self.reflectance,
            ..options
        };
        load(path, &options)
    }

    /// Whether anything is replaced.
    pub fn any(&self) -> bool {
        self.reflectance.is_some()
    }
}

/// Whether some face emits; `or` is what else can be done.
pub fn lit(path: &Path, scene: &Scene, or: &str) -> Result<()> {
    if scene.faces.iter().any(|face| face.emission != Vec3::ZERO) {
        return Ok(());
    }
    let message =
        format!("no face emits light: give a material Ke (OBJ) or emissiveFactor (glTF){or}");
    Err(Error::input(path, "", message))
}
