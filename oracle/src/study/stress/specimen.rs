//! The scene of a case from outside, a little aslant, with its edges and the plates' face.

use super::Specimen;
use crate::show::number::{count, number};
use crate::show::picture::Exposure;
use crate::show::view::camera::Camera;
use crate::show::view::render::{Hit, View};
use crate::show::view::surface::Surface;
use common::mesh::MeshFace;
use common::rays::Rays;
use glam::Vec3;
use maud::{Markup, html};
use std::fmt::Write;

/// Pixels a side.
const SIZE: u32 = 440;
/// Edges of scenes of more faces than this are not drawn.
const OUTLINED: usize = 150;

/// The picture with its caption.
pub fn view(specimen: &Specimen, parameter: &str) -> Markup {
    let (scene, mesh) = (&specimen.scene, &specimen.mesh);
    let rays = Rays::new(mesh);
    let camera = Camera::aslant(mesh, &rays, specimen.face);
    let surface = Surface::new(scene, mesh);
    let seen = View::new(&camera, &surface, &rays, SIZE);
    let field = surface.interpolate(&specimen.field.irradiance);
    let radiosity = |hit: &Hit| field.radiosity(&hit.stencil);
    let dark = |hit: &&Hit| mesh.texels[hit.stencil.texel as usize].emission == Vec3::ZERO;
    let bright = |hit: &Hit| (radiosity(hit).max_element(), 1.0);
    let exposure = if seen.hits().filter(dark).any(|hit| bright(hit).0 > 0.0) {
        Exposure::of(seen.hits().filter(dark).map(bright))
    } else {
        Exposure::of(seen.hits().map(bright))
    };
    let picture = seen.shade(|hit| exposure.display(radiosity(hit)));
    let faces = if mesh.faces.len() <= OUTLINED {
        &mesh.faces[..]
    } else {
        &[]
    };
    let chosen = mesh.faces.get(specimen.face as usize);
    let name = scene.faces.get(specimen.face as usize).map(|f| &f.name);
    html! {
        figure {
            svg.specimen viewBox=(format!("0 0 {SIZE} {SIZE}")) role="img" aria-label="The scene from outside" {
                image href=(picture.data_uri()) width=(SIZE) height=(SIZE) {}
                path.edges d=(outlines(faces, &camera)) {}
                @if let Some(face) = chosen { path.chosen d=(outlines(std::slice::from_ref(face), &camera)) {} }
            }
            figcaption {
                b { "The specimen" } " at " (super::outcome::value(specimen.value)) " (" (parameter) "): "
                (count(scene.faces.len() as u64)) @if scene.faces.len() == 1 { " face" } @else { " faces" }
                ", white is " (number(f64::from(exposure.white))) " W/m²; backs are looked through."
                @if let Some(name) = name { " The plates are of “" (name) "”, outlined." }
            }
        }
    }
}

/// Outlines as SVG path data.
fn outlines(faces: &[MeshFace], camera: &Camera) -> String {
    let mut path = String::new();
    for face in faces {
        let points = face.corners.map(|corner| camera.project(corner));
        let half = SIZE as f32 / 2.0;
        for (k, point) in points.into_iter().flatten().enumerate() {
            let letter = if k == 0 { 'M' } else { 'L' };
            let (x, y) = (half * (1.0 + point.x), half * (1.0 - point.y));
            // Writing to a string does not fail.
            let _ = write!(path, "{letter}{x:.1} {y:.1}");
        }
        if !path.is_empty() {
            path.push('Z');
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{room, specimen, triangle};
    use super::*;

    #[test]
    fn all_outlines_are_in_the_picture() {
        for scene in [room(), triangle()] {
            let specimen = specimen(scene, 0);
            let rays = Rays::new(&specimen.mesh);
            let camera = Camera::aslant(&specimen.mesh, &rays, 0);
            let corners = specimen.mesh.faces.iter().flat_map(|f| f.corners);
            for corner in corners {
                let seen = camera.project(corner).unwrap();
                assert!(seen.abs().max_element() <= 1.0, "{seen}");
            }
            let drawn = view(&specimen, "gap").into_string();
            assert!(drawn.contains("class=\"chosen\" d=\"M"));
        }
    }
}
