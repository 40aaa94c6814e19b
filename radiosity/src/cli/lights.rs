//! `--lamp`, `--sky` and `--sun`: light for scenes that have none, or too little.

use super::console::message;
use super::objects::parse_numbers;
use super::options::require_light;
use clap::Args;
use common::capture::Panorama;
use common::capture::sky::{even_sky, panorama_sky};
use common::import::{DOUBLE_SIDED, ImportOptions, add_lamp, load_scene};
use common::scene::Scene;
use common::sky::{Sky, Sun};
use common::{Error, Result};
use glam::{DVec3, Vec3};
use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::Arc;

/// Radiances of a sky that can be solved: their radiosity πL is that of a lamp.
const SKY_RADIANCES: RangeInclusive<f32> = 1e-12..=1e11;
/// Irradiances by a sun that can be solved: its radiosity is 47 000 times as much.
const SUN_IRRADIANCES: RangeInclusive<f64> = 1e-12..=1e7;

/// Options of light that is not in the scene's file.
#[derive(Args, Clone, Default)]
pub struct LightOptions {
    /// Add a small lamp at a point, of W watts in each channel; may be repeated
    #[arg(long, value_name = "X,Y,Z,W", value_parser = parse_lamp, allow_hyphen_values = true)]
    lamp: Vec<[f64; 4]>,
    /// Light from outside: the same radiance in all directions (W/m²/sr), or a panorama of it, y up, its centre along +z
    #[arg(long, value_name = "L|FILE", allow_hyphen_values = true)]
    sky: Option<String>,
    /// A sun of 0.53°: the direction towards it, and the irradiance of a plane that faces it (W/m²)
    #[arg(long, value_name = "X,Y,Z,E", value_parser = parse_sun, allow_hyphen_values = true)]
    sun: Option<Sun>,
}

impl LightOptions {
    /// Reads a scene and adds its light.
    ///
    /// Errors: the scene cannot be read, a lamp has no place, or there is no light.
    pub fn load_scene(&self, path: &Path, options: &ImportOptions) -> Result<Scene> {
        let mut scene = load_scene(path, options)?;
        self.add_light(path, &mut scene)?;
        Ok(scene)
    }

    /// Adds its light to the scene of the file `path`.
    ///
    /// Errors: a lamp has no place, or there is no light.
    pub fn add_light(&self, path: &Path, scene: &mut Scene) -> Result<()> {
        for (k, [x, y, z, power]) in self.lamp.iter().enumerate() {
            let name = format!("lamp {}", k + 1);
            let added = add_lamp(scene, &name, DVec3::new(*x, *y, *z), *power);
            added.map_err(|message| Error::Usage(format!("--lamp {x},{y},{z},{power}: {name} {message}")))?;
        }
        if self.sky.is_some() || self.sun.is_some() {
            let mut sky = match &self.sky {
                Some(given) => read_sky(given)?,
                None => Sky::default(),
            };
            sky.suns = scene
                .sky
                .iter()
                .flat_map(|own| own.suns.clone())
                .chain(self.sun)
                .collect();
            scene.sky = Some(Arc::new(sky));
        }
        require_light(path, scene)?;
        for note in scene.notes.iter_mut().filter(|note| note.contains(DOUBLE_SIDED)) {
            *note += "; --two-sided gives them fronts";
        }
        Ok(())
    }
}

/// Reads the value of `--sky`: a radiance, or the panorama of that name.
fn read_sky(given: &str) -> Result<Sky> {
    let Ok(radiance) = given.parse::<f32>() else {
        let panorama = Panorama::read(Path::new(given), None)?;
        panorama.notes.iter().for_each(|note| message!("note: {given}: {note}"));
        return panorama_sky(&panorama, given.into());
    };
    match SKY_RADIANCES.contains(&radiance) {
        true => Ok(even_sky(radiance)),
        false => Err(Error::Usage(format!(
            "--sky {given}: its radiance must be between 1e-12 and 1e11"
        ))),
    }
}

/// Parses X,Y,Z,E: a direction, and an irradiance.
fn parse_sun(text: &str) -> std::result::Result<Sun, String> {
    let [x, y, z, irradiance] = parse_numbers(text)?;
    let direction = DVec3::new(x, y, z).try_normalize();
    let direction = direction.ok_or_else(|| format!("{text}: the sun needs a direction"))?;
    match SUN_IRRADIANCES.contains(&irradiance) {
        true => Ok(Sun {
            direction,
            irradiance: Vec3::splat(irradiance as f32),
        }),
        false => Err(format!("{text}: its irradiance must be between 1e-12 and 1e7")),
    }
}

/// Parses X,Y,Z,W: a point, and watts above 0.
fn parse_lamp(text: &str) -> std::result::Result<[f64; 4], String> {
    let all = parse_numbers::<4>(text)?;
    match all[3] > 0.0 {
        true => Ok(all),
        false => Err(format!("{text}: a lamp's power must be above 0")),
    }
}
