//! Models of the bundled scenes, and the text of their files.

mod cornell;
mod furnished;
mod glb;
mod plates;
mod rooms;

use glam::DVec3;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Returns the name and content of every generated file.
pub fn scene_files() -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<(String, Vec<u8>)> = [cornell::scenes(), rooms::scenes(), plates::scenes()]
        .concat()
        .iter()
        .flat_map(|scene| {
            [
                (format!("{}.obj", scene.name), scene.write_obj().into()),
                (format!("{}.mtl", scene.name), scene.write_mtl().into()),
            ]
        })
        .collect();
    let room = furnished::furnished_room();
    files.push((format!("{}.glb", room.name), room.write_glb()));
    files
}

/// A scene, with the comment in its file.
#[derive(Clone)]
struct Scene {
    name: &'static str,
    about: &'static str,
    parts: Vec<Part>,
}

/// Faces of one name and material.
#[derive(Clone)]
struct Part {
    name: &'static str,
    material: Material,
    faces: Vec<Vec<DVec3>>,
}

/// Reflectance ρ and emitted radiance L, W/m²/sr.
#[derive(Clone, Copy)]
struct Material {
    name: &'static str,
    reflectance: [f64; 3],
    radiance: [f64; 3],
}

impl Material {
    const fn reflecting(name: &'static str, reflectance: [f64; 3]) -> Self {
        Self::emitting(name, reflectance, [0.0; 3])
    }

    const fn emitting(name: &'static str, reflectance: [f64; 3], radiance: [f64; 3]) -> Self {
        Self {
            name,
            reflectance,
            radiance,
        }
    }
}

fn part(name: &'static str, material: Material, faces: Vec<Vec<DVec3>>) -> Part {
    Part { name, material, faces }
}

impl Scene {
    fn write_obj(&self) -> String {
        let (about, name) = (self.about, self.name);
        let mut text = format!("# {about}\n# Written by scenes/generate.rs.\nmtllib {name}.mtl\n");
        let mut vertices = BTreeMap::new();
        for part in &self.parts {
            let mut faces = String::new();
            let _ = writeln!(text, "\ng {}", part.name);
            for face in &part.faces {
                faces.push('f');
                for corner in face {
                    let line = format!("v {}", format_triple(round_coordinates(*corner).to_array()));
                    let next = vertices.len() + 1;
                    let index = *vertices.entry(line.clone()).or_insert(next);
                    if index == next {
                        let _ = writeln!(text, "{line}");
                    }
                    let _ = write!(faces, " {index}");
                }
                faces.push('\n');
            }
            let _ = write!(text, "usemtl {}\n{faces}", part.material.name);
        }
        text
    }

    fn write_mtl(&self) -> String {
        let mut text =
            "# Kd is reflectance, Ke emitted radiance in W/m2/sr. Written by scenes/generate.rs.\n".to_owned();
        let materials: BTreeMap<_, _> = self.parts.iter().map(|p| (p.material.name, p.material)).collect();
        for material in materials.values() {
            let [kd, ke] = [material.reflectance, material.radiance].map(format_triple);
            let _ = writeln!(text, "\nnewmtl {}\nKd {kd}\nKe {ke}", material.name);
        }
        text
    }
}

fn format_triple([x, y, z]: [f64; 3]) -> String {
    format!("{x} {y} {z}")
}

/// Rounds to six decimals, so that the files do not depend on a platform's sine.
fn round_coordinates(p: DVec3) -> DVec3 {
    (p * 1e6).round() / 1e6 + 0.0
}

/// Returns the parallelogram at `origin` spanned by `u` and `v`; its front is on the side of u × v.
fn parallelogram(origin: DVec3, u: DVec3, v: DVec3) -> Vec<DVec3> {
    vec![origin, origin + u, origin + u + v, origin + v]
}

/// Returns the parallelogram as n × n smaller ones.
fn parallelogram_grid(origin: DVec3, u: DVec3, v: DVec3, n: u32) -> Vec<Vec<DVec3>> {
    let [u, v] = [u, v].map(|edge| edge / f64::from(n));
    let places = (0..n).flat_map(|j| (0..n).map(move |i| (f64::from(i), f64::from(j))));
    places
        .map(|(i, j)| parallelogram(origin + u * i + v * j, u, v))
        .collect()
}

/// Returns the walls of the unit cube, fronts inwards: floor, ceiling, left (x = 0), right, back (z = 0), front.
fn unit_room() -> [(DVec3, DVec3, DVec3); 6] {
    let (x, y, z, o) = (DVec3::X, DVec3::Y, DVec3::Z, DVec3::ZERO);
    [(o, z, x), (y, x, z), (o, y, z), (x, z, y), (o, x, y), (z, y, x)]
}

/// Returns a closed box, fronts outwards, turned about its vertical axis, bottom face first.
fn turned_box(centre: DVec3, size: DVec3, degrees: f64) -> Vec<Vec<DVec3>> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let corner = |p: DVec3| {
        let p = (p - 0.5) * size;
        centre + DVec3::new(cos * p.x + sin * p.z, p.y, cos * p.z - sin * p.x)
    };
    unit_room()
        .map(|(origin, u, v)| parallelogram(origin, v, u).into_iter().map(corner).collect())
        .into()
}
