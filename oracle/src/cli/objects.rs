//! `--object FILE [--scale S] [--place X,Y,Z] [--reflectance R,G,B]`, any number of times: what
//! follows an object is about that object; a reflectance before the first is the room's.

use clap::{Arg, ArgAction, ArgMatches, Command, FromArgMatches};
use common::Result;
use common::import::{ImportOptions, load};
use common::scene::Scene;
use glam::{DVec3, Vec3};
use std::path::PathBuf;

/// An object as it is put into the room.
#[derive(Clone, Debug)]
pub struct Object {
    /// Its mesh.
    pub file: PathBuf,
    /// Lengths are multiplied by this first.
    pub scale: f64,
    /// Then it is moved.
    pub place: DVec3,
    /// ρ of all its faces, instead of the file's.
    pub reflectance: Option<Vec3>,
}

/// All of them, and what was said before the first.
#[derive(Clone, Debug, Default)]
pub struct Objects {
    /// In the order given.
    pub objects: Vec<Object>,
    /// ρ of the room.
    pub room_reflectance: Option<Vec3>,
}

impl Object {
    /// Reads it, in its place.
    pub fn load(&self, options: &ImportOptions) -> Result<Scene> {
        let options = ImportOptions {
            reflectance: self.reflectance,
            ..*options
        };
        let mut scene = load(&self.file, &options)?;
        for face in &mut scene.faces {
            face.corners = face.corners.map(|p| p * self.scale + self.place);
        }
        Ok(scene)
    }
}

impl clap::Args for Objects {
    fn augment_args(command: Command) -> Command {
        let option = |name: &'static str, value: &'static str, help: &'static str| {
            Arg::new(name)
                .long(name)
                .value_name(value)
                .help(help)
                .action(ArgAction::Append)
                .allow_hyphen_values(true)
        };
        command
            .arg(
                option(
                    "object",
                    "FILE",
                    "An .obj, .gltf or .glb put into the room; may be repeated",
                )
                .allow_hyphen_values(false)
                .value_parser(clap::value_parser!(PathBuf)),
            )
            .arg(
                option(
                    "scale",
                    "S",
                    "Multiplies the lengths of the object before it [default: 1]",
                )
                .value_parser(scale),
            )
            .arg(
                option(
                    "place",
                    "X,Y,Z",
                    "Moves the object before it [default: 0,0,0]",
                )
                .value_parser(triple),
            )
            .arg(
                option(
                    "reflectance",
                    "R,G,B",
                    "Reflectance of the object before it; before the first object, of the room",
                )
                .value_parser(reflectance),
            )
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Objects {
    fn from_arg_matches(matches: &ArgMatches) -> std::result::Result<Self, clap::Error> {
        let mut all = Self::default();
        let files = valued::<PathBuf>(matches, "object");
        let starts: Vec<usize> = files.iter().map(|(at, _)| *at).collect();
        all.objects = files
            .into_iter()
            .map(|(_, file)| Object {
                file,
                scale: 1.0,
                place: DVec3::ZERO,
                reflectance: None,
            })
            .collect();
        let owner = |at: usize| starts.partition_point(|start| *start < at).checked_sub(1);
        let stray = |name: &str| {
            let message = format!("--{name} must follow the --object that it belongs to");
            clap::Error::raw(clap::error::ErrorKind::ArgumentConflict, message)
        };
        for (at, value) in valued::<f64>(matches, "scale") {
            all.objects[owner(at).ok_or_else(|| stray("scale"))?].scale = value;
        }
        for (at, value) in valued::<DVec3>(matches, "place") {
            all.objects[owner(at).ok_or_else(|| stray("place"))?].place = value;
        }
        for (at, value) in valued::<Vec3>(matches, "reflectance") {
            match owner(at) {
                Some(object) => all.objects[object].reflectance = Some(value),
                None => all.room_reflectance = Some(value),
            }
        }
        Ok(all)
    }

    fn update_from_arg_matches(
        &mut self,
        matches: &ArgMatches,
    ) -> std::result::Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Every value of an option, with its place on the command line.
fn valued<T: Clone + Send + Sync + 'static>(matches: &ArgMatches, name: &str) -> Vec<(usize, T)> {
    let places = matches.indices_of(name).into_iter().flatten();
    let values = matches.get_many::<T>(name).into_iter().flatten().cloned();
    places.zip(values).collect()
}

fn numbers<const N: usize>(text: &str) -> std::result::Result<[f64; N], String> {
    let parts: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse::<f64>())
        .collect::<std::result::Result<_, _>>()
        .map_err(|_| format!("{text}: give {N} numbers separated by commas"))?;
    let all: [f64; N] = parts
        .try_into()
        .map_err(|_| format!("{text}: give {N} numbers separated by commas"))?;
    if all.iter().all(|x| x.is_finite()) {
        Ok(all)
    } else {
        Err(format!("{text} is not finite"))
    }
}

/// X,Y,Z.
pub fn triple(text: &str) -> std::result::Result<DVec3, String> {
    numbers::<3>(text).map(DVec3::from)
}

/// EX,EY,EZ,TX,TY,TZ,FOV: eye, target, vertical field of view in degrees.
pub fn camera(text: &str) -> std::result::Result<[f64; 7], String> {
    let all = numbers::<7>(text)?;
    if !(0.0 < all[6] && all[6] < 180.0) {
        return Err(format!(
            "{text}: the field of view must lie in 0 < FOV < 180"
        ));
    }
    if all[..3] == all[3..6] {
        return Err(format!("{text}: the camera looks at its own position"));
    }
    Ok(all)
}

fn scale(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err(format!("{text} is not above 0")),
    }
}

/// R,G,B.
pub fn reflectance(text: &str) -> std::result::Result<Vec3, String> {
    let value = triple(text)?.as_vec3();
    if value.cmpge(Vec3::ZERO).all() && value.cmplt(Vec3::ONE).all() {
        Ok(value)
    } else {
        Err(format!("{text} is not in 0 ≤ ρ < 1"))
    }
}
