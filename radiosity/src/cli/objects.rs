//! `--object FILE [--scale S] [--turn DEG] [--place X,Y,Z] [--reflectance R,G,B]`, any number of times: the options after
//! an object apply to it; a turn or a reflectance before the first object is the room's.

use super::options::parse_number;
use clap::{Arg, ArgAction, ArgMatches, Command, FromArgMatches};
use common::Result;
use common::import::{ImportOptions, load_scene};
use common::scene::Scene;
use glam::{DVec3, Vec3};
use std::path::PathBuf;

/// An object to put into the room.
#[derive(Clone, Debug)]
pub struct PlacedObject {
    /// Scene file.
    pub file: PathBuf,
    /// Factor of its lengths, applied before `place`.
    pub scale: f64,
    /// Turn about the vertical axis y through its origin, degrees counter-clockwise as seen from above, before `place`.
    pub turn: f64,
    /// Translation, in the room's unit.
    pub place: DVec3,
    /// Reflectance of all its faces instead of the file's.
    pub reflectance: Option<Vec3>,
}

/// All objects of a relight.
#[derive(Clone, Debug, Default)]
pub struct ObjectOptions {
    /// In the order given.
    pub objects: Vec<PlacedObject>,
    /// Reflectance of the room.
    pub room_reflectance: Option<Vec3>,
    /// Turn of the room's panorama, degrees.
    pub room_turn: Option<f64>,
}

impl PlacedObject {
    /// Reads the object, scaled, turned and moved.
    pub fn load_scene(&self, options: &ImportOptions) -> Result<Scene> {
        let options = ImportOptions {
            reflectance: self.reflectance,
            ..*options
        };
        let mut scene = load_scene(&self.file, &options)?;
        for face in &mut scene.faces {
            face.corners = face.corners.map(|p| self.turn_point(p * self.scale) + self.place);
            let normals = face.corner_normals.as_mut().into_iter().flatten();
            normals.for_each(|normal| *normal = self.turn_point(normal.as_dvec3()).as_vec3());
        }
        Ok(scene)
    }

    fn turn_point(&self, p: DVec3) -> DVec3 {
        if self.turn == 0.0 {
            p
        } else {
            p.rotate_y(self.turn.to_radians())
        }
    }
}

impl clap::Args for ObjectOptions {
    fn augment_args(command: Command) -> Command {
        let option = |name: &'static str, value: &'static str, help: &'static str| {
            let arg = Arg::new(name).long(name).value_name(value).help(help);
            arg.action(ArgAction::Append).allow_hyphen_values(name != "object")
        };
        let file = "An .obj, .gltf or .glb put into the room; may be repeated";
        let scale = "Multiplies the lengths of the object before it [default: 1]";
        let place = "Moves the object before it [default: 0,0,0]";
        let turn = "Turns the object before it about y, counter-clockwise from above [default: 0]; before the first object, the panorama";
        let reflectance = "Reflectance of the object before it; before the first object, of the room";
        command
            .arg(option("object", "FILE", file).value_parser(clap::value_parser!(PathBuf)))
            .arg(option("scale", "S", scale).value_parser(parse_scale))
            .arg(option("turn", "DEG", turn).value_parser(parse_turn))
            .arg(option("place", "X,Y,Z", place).value_parser(parse_point))
            .arg(option("reflectance", "R,G,B", reflectance).value_parser(parse_reflectance))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for ObjectOptions {
    fn from_arg_matches(matches: &ArgMatches) -> std::result::Result<Self, clap::Error> {
        let mut all = Self::default();
        let files = indexed_values::<PathBuf>(matches, "object");
        let starts: Vec<usize> = files.iter().map(|(at, _)| *at).collect();
        all.objects = files
            .into_iter()
            .map(|(_, file)| PlacedObject {
                file,
                scale: 1.0,
                turn: 0.0,
                place: DVec3::ZERO,
                reflectance: None,
            })
            .collect();
        let owner = |at: usize| starts.partition_point(|start| *start < at).checked_sub(1);
        let stray = |name: &str| {
            let message = format!("--{name} must follow the --object that it belongs to");
            clap::Error::raw(clap::error::ErrorKind::ArgumentConflict, message)
        };
        for (at, value) in indexed_values::<f64>(matches, "scale") {
            all.objects[owner(at).ok_or_else(|| stray("scale"))?].scale = value;
        }
        for (at, value) in indexed_values::<f64>(matches, "turn") {
            match owner(at) {
                Some(object) => all.objects[object].turn = value,
                None => all.room_turn = Some(value),
            }
        }
        for (at, value) in indexed_values::<DVec3>(matches, "place") {
            all.objects[owner(at).ok_or_else(|| stray("place"))?].place = value;
        }
        for (at, value) in indexed_values::<Vec3>(matches, "reflectance") {
            match owner(at) {
                Some(object) => all.objects[object].reflectance = Some(value),
                None => all.room_reflectance = Some(value),
            }
        }
        Ok(all)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> std::result::Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Returns every value of an option with its index on the command line.
fn indexed_values<T: Clone + Send + Sync + 'static>(matches: &ArgMatches, name: &str) -> Vec<(usize, T)> {
    let places = matches.indices_of(name).into_iter().flatten();
    let values = matches.get_many::<T>(name).into_iter().flatten().cloned();
    places.zip(values).collect()
}

/// Parses N finite numbers separated by commas.
pub fn parse_numbers<const N: usize>(text: &str) -> std::result::Result<[f64; N], String> {
    let parts = text.split(',').map(|part| part.trim().parse::<f64>().ok());
    let parts: Option<Vec<f64>> = parts.collect();
    let all = parts.and_then(|parts| <[f64; N]>::try_from(parts).ok());
    let all = all.ok_or_else(|| format!("{text}: give {N} numbers separated by commas"))?;
    if all.iter().all(|x| x.is_finite()) {
        Ok(all)
    } else {
        Err(format!("{text} is not finite"))
    }
}

/// Parses X,Y,Z.
pub fn parse_point(text: &str) -> std::result::Result<DVec3, String> {
    parse_numbers::<3>(text).map(DVec3::from)
}

/// Parses EX,EY,EZ,TX,TY,TZ,FOV: eye, target, vertical field of view in degrees.
pub fn parse_camera(text: &str) -> std::result::Result<[f64; 7], String> {
    let all = parse_numbers::<7>(text)?;
    if !(0.0 < all[6] && all[6] < 180.0) {
        return Err(format!("{text}: the field of view must lie in 0 < FOV < 180"));
    }
    if all[..3] == all[3..6] {
        return Err(format!("{text}: the camera looks at its own position"));
    }
    Ok(all)
}

fn parse_scale(text: &str) -> std::result::Result<f64, String> {
    parse_number(text, |x| x.is_finite() && x > 0.0, "above 0")
}

fn parse_turn(text: &str) -> std::result::Result<f64, String> {
    parse_number(text, f64::is_finite, "a number of degrees")
}

/// Parses R,G,B, each in 0 ≤ ρ < 1.
fn parse_reflectance(text: &str) -> std::result::Result<Vec3, String> {
    let value = parse_point(text)?.as_vec3();
    if value.cmpge(Vec3::ZERO).all() && value.cmplt(Vec3::ONE).all() {
        Ok(value)
    } else {
        Err(format!("{text} is not in 0 ≤ ρ < 1"))
    }
}
