//! KHR_lights_punctual: a light without a surface becomes a small lamp of the same power. [`super`] adds them after all
//! meshes.

use super::document::GltfDocument;
use crate::error::{Error, Result};
use crate::import::builder::Builder;
use crate::import::lamp::{icosahedron_faces, lamp_radius};
use crate::import::material::{ImportedMaterial, InputVertex};
use crate::import::polygon::vector_area;
use crate::import::surface::{diffuse_surface, is_solvable_emission};
use crate::scene::Face;
use crate::sky::Sun;
use glam::{DMat4, DVec3};
use gltf::json::Index;
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Spot, Type};
use gltf::json::validation::Checked;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// Adds a lamp for each light (its index and its node's transform), and notes.
///
/// Errors: a light does not exist, has no direction, or is too bright.
pub fn add_lamps(builder: &mut Builder, path: &Path, document: &GltfDocument, lights: &[(usize, DMat4)]) -> Result<()> {
    let faces = builder.faces.iter().chain(&builder.pieces);
    let points = lights.iter().map(|(_, world)| world.w_axis.truncate());
    let radius = lamp_radius(faces.flat_map(Face::outline).copied().chain(points));
    let (mut names, mut spots, mut suns) = (Vec::new(), Vec::new(), Vec::new());
    for (number, world) in lights {
        let place = format!("light {number}");
        let fail = |message: &str| Error::bad_input(path, &place, message);
        let light = document.root.get(Index::<Light>::new(*number as u32));
        let light = light.ok_or_else(|| fail("does not exist"))?;
        let colour = DVec3::from(light.color.map(f64::from)) * f64::from(light.intensity);
        let name = light.name.clone().unwrap_or_else(|| place.clone());
        if matches!(light.type_, Checked::Valid(Type::Directional)) {
            let back = world.transform_vector3(DVec3::Z).try_normalize();
            let sun = Sun {
                direction: back.ok_or_else(|| fail("has no direction"))?,
                irradiance: colour.as_vec3(),
            };
            if !is_solvable_emission(sun.irradiance) {
                return Err(fail("has an intensity that cannot be solved: use another unit"));
            }
            builder.suns.push(sun);
            suns.push(name);
            continue;
        }
        let (outlines, power) = build_lamp(light, *world, radius).map_err(fail)?;
        let area: f64 = outlines.iter().map(|side| vector_area(side).length()).sum();
        // Power is π L times the area.
        let radiance = colour * power / (PI * area);
        let names_of = ["", "of its intensity"];
        diffuse_surface(DVec3::ZERO, radiance, names_of).map_err(|message| fail(&message))?;
        let factors = [DVec3::ZERO, radiance];
        let material = ImportedMaterial::from_factors(path, &name, factors, names_of);
        for corners in &outlines {
            let vertex = |position: &DVec3| InputVertex {
                position: *position,
                ..InputVertex::default()
            };
            let corners: Vec<InputVertex> = corners.iter().map(vertex).collect();
            builder.add_face(&name, &corners, false, Some(&material), || place.clone())?;
        }
        if matches!(light.type_, Checked::Valid(Type::Spot)) {
            spots.push(name.clone());
        }
        names.push(name);
    }
    let [names, spots, suns] = [names, spots, suns].map(|names| names.join(", "));
    if !suns.is_empty() {
        builder.add_note(format!(
            "directional lights are suns of 0.53°, a lux taken as 1 W/m²: {suns}"
        ));
    }
    if !names.is_empty() {
        builder.add_note(format!(
            "lights without a surface are lamps of radius {radius:.2e} and the same power, a candela taken as 1 W/sr: {names}"
        ));
    }
    if !spots.is_empty() {
        builder.add_note(format!(
            "spots are squares that face their way, without a cone: {spots}"
        ));
    }
    Ok(())
}

/// Returns the outlines of a lamp's faces, and its power at intensity 1.
fn build_lamp(light: &Light, world: DMat4, radius: f64) -> std::result::Result<(Vec<Vec<DVec3>>, f64), &'static str> {
    let (at, forward) = (world.w_axis.truncate(), world.transform_vector3(-DVec3::Z));
    match light.type_ {
        Checked::Valid(Type::Point) => {
            let sides = icosahedron_faces(at, radius).into_iter();
            Ok((sides.map(Into::into).collect(), 4.0 * PI))
        }
        Checked::Valid(Type::Spot) => {
            let power = light.spot.as_ref().map_or(0.0, spot_power);
            Ok((vec![square_outline(at, forward, radius)], power))
        }
        _ => Err("is of no known type"),
    }
}

/// Returns a square whose front faces along `way`.
fn square_outline(at: DVec3, way: DVec3, radius: f64) -> Vec<DVec3> {
    let way = way.try_normalize().unwrap_or(-DVec3::Z);
    let u = way.any_orthonormal_vector();
    let v = way.cross(u);
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[a, b]| at + radius * (a * u + b * v))
        .to_vec()
}

/// Returns a spot's power at intensity 1: full intensity within the inner angle, and between the angles the
/// square of the extension's linear falloff over the cosine.
fn spot_power(spot: &Spot) -> f64 {
    let [inner, outer] = [spot.inner_cone_angle, spot.outer_cone_angle].map(|angle| f64::from(angle).cos());
    TAU * (1.0 - inner + (inner - outer) / 3.0)
}
