//! The bundled scenes as numbers, and as the text of their files.

mod cornell;
mod plates;
mod rooms;

use glam::DVec3;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Name and text of every file.
pub fn files() -> Vec<(String, String)> {
    [cornell::scenes(), rooms::scenes(), plates::scenes()]
        .concat()
        .iter()
        .flat_map(|scene| {
            [
                (format!("{}.obj", scene.name), scene.obj()),
                (format!("{}.mtl", scene.name), scene.mtl()),
            ]
        })
        .collect()
}

/// A scene and what its file says about it.
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
    const fn dull(name: &'static str, reflectance: [f64; 3]) -> Self {
        Self {
            name,
            reflectance,
            radiance: [0.0; 3],
        }
    }
}

fn part(name: &'static str, material: Material, faces: Vec<Vec<DVec3>>) -> Part {
    Part {
        name,
        material,
        faces,
    }
}

impl Scene {
    fn obj(&self) -> String {
        let mut text = format!(
            "# {}\n# Written by scenes/generate.rs.\nmtllib {}.mtl\n",
            self.about, self.name
        );
        let mut vertices = BTreeMap::new();
        for part in &self.parts {
            let mut faces = String::new();
            let _ = writeln!(text, "\ng {}", part.name);
            for face in &part.faces {
                faces.push('f');
                for corner in face {
                    let line = format!("v {}", triple(rounded(*corner).to_array()));
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

    fn mtl(&self) -> String {
        let mut text =
            "# Kd is reflectance, Ke emitted radiance in W/m2/sr. Written by scenes/generate.rs.\n"
                .to_owned();
        let materials: BTreeMap<_, _> = self
            .parts
            .iter()
            .map(|p| (p.material.name, p.material))
            .collect();
        for material in materials.values() {
            let Material {
                name,
                reflectance,
                radiance,
            } = *material;
            let _ = writeln!(
                text,
                "\nnewmtl {name}\nKd {}\nKe {}",
                triple(reflectance),
                triple(radiance)
            );
        }
        text
    }
}

fn triple([x, y, z]: [f64; 3]) -> String {
    format!("{x} {y} {z}")
}

/// Six decimals, so that no platform's sine shows.
fn rounded(p: DVec3) -> DVec3 {
    (p * 1e6).round() / 1e6 + 0.0
}

/// The parallelogram at `origin` spanned by `u` and `v`; its front is that of u × v.
fn quad(origin: DVec3, u: DVec3, v: DVec3) -> Vec<DVec3> {
    vec![origin, origin + u, origin + u + v, origin + v]
}

/// The parallelogram as n × n of them.
fn grid(origin: DVec3, u: DVec3, v: DVec3, n: u32) -> Vec<Vec<DVec3>> {
    let [u, v] = [u, v].map(|edge| edge / f64::from(n));
    let places = (0..n).flat_map(|j| (0..n).map(move |i| (f64::from(i), f64::from(j))));
    places
        .map(|(i, j)| quad(origin + u * i + v * j, u, v))
        .collect()
}

/// Walls of the unit cube, fronts inwards: floor, ceiling, left (x = 0), right, back (z = 0),
/// front.
fn unit_room() -> [(DVec3, DVec3, DVec3); 6] {
    let (x, y, z, o) = (DVec3::X, DVec3::Y, DVec3::Z, DVec3::ZERO);
    [
        (o, z, x),
        (y, x, z),
        (o, y, z),
        (x, z, y),
        (o, x, y),
        (z, y, x),
    ]
}

/// A closed box, fronts outwards: turned about its vertical axis, bottom face first.
fn block(centre: DVec3, size: DVec3, degrees: f64) -> Vec<Vec<DVec3>> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let corner = |p: DVec3| {
        let p = (p - 0.5) * size;
        centre + DVec3::new(cos * p.x + sin * p.z, p.y, cos * p.z - sin * p.x)
    };
    unit_room()
        .map(|(origin, u, v)| quad(origin, v, u).into_iter().map(corner).collect())
        .into()
}
