//! Options that change a scene as it is read, and the check that it has a light.

use super::objects::parse_reflectance;
use clap::Args;
use common::import::{ImportOptions, load_scene};
use common::scene::Scene;
use common::{Error, Result};
use glam::Vec3;
use std::path::Path;

/// Options that replace the file's materials.
#[derive(Args, Clone, Default)]
pub struct MaterialOptions {
    /// Reflectance of all faces instead of the file's
    #[arg(long, value_name = "R,G,B", value_parser = parse_reflectance)]
    reflectance: Option<Vec3>,
}

/// The option that accepts a scene without light.
#[derive(Args, Clone, Default)]
pub struct DarkOption {
    /// Accept a scene without any light: its radiosity is 0
    #[arg(long)]
    allow_dark: bool,
}

impl MaterialOptions {
    /// Reads a scene.
    ///
    /// Errors: it cannot be read, or no face emits.
    pub fn load_lit_scene(&self, path: &Path, options: ImportOptions) -> Result<Scene> {
        let scene = self.load_scene(path, options)?;
        require_light(path, &scene, "").map(|()| scene)
    }

    /// Reads a scene, which may be dark under `--allow-dark`.
    ///
    /// Errors: it cannot be read, or no face emits and that is not allowed.
    pub fn load_scene_unless_dark(&self, dark: &DarkOption, path: &Path, options: ImportOptions) -> Result<Scene> {
        let scene = self.load_scene(path, options)?;
        if !dark.allow_dark {
            require_light(path, &scene, "; --allow-dark solves it all the same")?;
        }
        Ok(scene)
    }

    /// Reads a scene with the materials replaced.
    pub fn load_scene(&self, path: &Path, options: ImportOptions) -> Result<Scene> {
        let options = ImportOptions {
            reflectance: self.reflectance,
            ..options
        };
        load_scene(path, &options)
    }

    /// Returns true if any of the options was given.
    pub fn is_given(&self) -> bool {
        self.reflectance.is_some()
    }
}

/// Requires that some face emits; `or` ends the message with another way out.
pub fn require_light(path: &Path, scene: &Scene, or: &str) -> Result<()> {
    if scene.faces.iter().any(|face| face.emission != Vec3::ZERO) {
        return Ok(());
    }
    let message = format!("no face emits light: give a material Ke (OBJ) or emissiveFactor (glTF){or}");
    Err(Error::bad_input(path, "", message))
}
