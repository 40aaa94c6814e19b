//! Pictures of a specimen: an oblique view of its scene from outside, and the plates, which show B − E of
//! one face of each answer texel by texel and the difference from the truth.

use super::{Plate, Specimen, format_value};
use crate::report::document::{Annotation, Blocks, Figure, Text, bold_text, colour_bar, plain_text};
use crate::report::format::{format_count, format_number, format_percent};
use crate::report::picture::{Exposure, RgbaPicture, diverging_colour, encode_srgb, luminance, weighted_rms};
use crate::report::view::camera::Camera;
use crate::report::view::interpolation::InterpolationSurface;
use crate::report::view::render::{ViewHit, ViewHits};
use common::mesh::MeshFace;
use common::rays::Rays;
use common::scene::Shape;
use glam::{DVec3, Vec3};
use std::fmt::Write;

/// Pixels per side.
const PICTURE_SIZE: u32 = 440;
/// Most faces of a scene whose edges are drawn.
const MAX_OUTLINED_FACES: usize = 150;
/// Range of the false colours, ± this relative difference.
const DIFFERENCE_RANGE: f64 = 0.2;

/// Returns the oblique view with its caption.
pub fn draw_specimen(specimen: &Specimen, parameter: &str) -> Figure {
    let (scene, mesh) = (&specimen.scene, &specimen.mesh);
    let rays = Rays::new(mesh);
    let camera = Camera::oblique_view(mesh, &rays, specimen.face);
    let surface = InterpolationSurface::new(scene, mesh);
    let seen = ViewHits::new(&camera, &surface, &rays, PICTURE_SIZE);
    let field = surface.interpolate(&specimen.field.irradiance);
    let radiosity = |hit: &ViewHit| field.radiosity_at(&hit.stencil);
    let is_dark = |hit: &&ViewHit| mesh.texels[hit.stencil.texel as usize].emission == Vec3::ZERO;
    let bright = |hit: &ViewHit| (radiosity(hit).max_element(), 1.0);
    let mut exposure = Exposure::from_percentile(seen.iter_hits().filter(is_dark).map(bright));
    if exposure.white <= 0.0 {
        exposure = Exposure::from_percentile(seen.iter_hits().map(bright));
    }
    let picture = seen.shade_hits(|hit| exposure.display_light(radiosity(hit)));
    let is_outlined = mesh.faces.len() <= MAX_OUTLINED_FACES;
    let chosen = &mesh.faces[specimen.face as usize];
    let outlines = [
        Annotation::Path(
            "edges",
            outline_path(if is_outlined { &mesh.faces } else { &[] }, &camera),
        ),
        Annotation::Path("chosen", outline_path(std::slice::from_ref(chosen), &camera)),
    ];
    let (size, count) = ([PICTURE_SIZE; 2], format_count(scene.faces.len() as u64));
    let white = format_number(f64::from(exposure.white));
    let name = &scene.faces[specimen.face as usize].name;
    let caption = bold_text("The scene")
        + format!(
            " at {} ({parameter}); faces: {count}; white is {white} W/m²; ",
            format_value(specimen.value)
        )
        + format!("backs are looked through. The plates are of “{name}”, outlined.");
    Figure::from_annotated(&picture.data_uri(), "The scene from outside", size, &outlines, caption)
}

/// Returns the faces' outlines as SVG path data.
fn outline_path(faces: &[MeshFace], camera: &Camera) -> String {
    let half = PICTURE_SIZE as f32 / 2.0;
    let mut path = String::new();
    for face in faces {
        let points = face.corners.map(|corner| camera.project_point(corner));
        for (k, point) in points.into_iter().flatten().enumerate() {
            let letter = if k == 0 { 'M' } else { 'L' };
            // Writing to a string does not fail.
            let _ = write!(
                path,
                "{letter}{:.1} {:.1}",
                half * (1.0 + point.x),
                half * (1.0 - point.y)
            );
        }
        path += if path.is_empty() { "" } else { "Z" };
    }
    path
}

/// Adds the plates of a specimen; none of a triangle, whose texels form no picture.
pub fn add_plates(blocks: &mut Blocks, specimen: &Specimen) {
    let face = &specimen.scene.faces[specimen.face as usize];
    let Some(truth) = specimen.plates.first().filter(|_| face.shape == Shape::Quad) else {
        return;
    };
    let rms = weighted_rms(truth.values.iter().map(|value| (value_luminance(value), 1.0)));
    let is_dark = rms == 0.0;
    // On a dark face any light is shown in full.
    let white = match is_dark {
        true => specimen.plates.iter().map(plate_white).fold(0.0, f32::max),
        false => plate_white(truth),
    };
    let exposure = Exposure::with_white(if white > 0.0 { white } else { 1.0 });
    let unit = if is_dark { f64::from(exposure.white) } else { rms };
    let texels = specimen.texels;
    let draw = |colour: &dyn Fn(usize) -> [u8; 3], alt: &str, caption: Text| {
        let pixel = |x, y| Some(colour((y * texels + x) as usize));
        let picture = RgbaPicture::from_pixels(texels, texels, pixel);
        Figure::from_texels(&picture.data_uri(), alt, caption)
    };
    let value_at = |plate: &Plate, k: usize| plate.values.get(k).copied().unwrap_or(DVec3::NAN);
    let cells = specimen.plates.iter().enumerate().map(|(k, plate)| {
        let shown = |k| encode_srgb(exposure.display_light(value_at(plate, k).as_vec3()));
        let alt = format!("{}: one face, texel by texel", plate.label);
        let mut cell = Blocks::default();
        cell.add_figure(&draw(&shown, &alt, bold_text(&plate.label)));
        if k > 0 {
            let difference = |k| value_luminance(&(value_at(plate, k) - value_at(truth, k))) / unit;
            let colour = |k| diverging_colour(difference(k) / DIFFERENCE_RANGE);
            let rms = weighted_rms((0..truth.values.len()).map(|k| (difference(k), 1.0)));
            let caption = plain_text("Δ ") + format_percent(rms);
            cell.add_figure(&draw(&colour, "the difference from the truth", caption));
        }
        cell
    });
    blocks.add_grid("plates", cells);
    let of = match is_dark {
        true => "white, since the truth is dark",
        false => "the rms of the truth on this face",
    };
    blocks.add_remark(
        plain_text(format!(
            "Above: B − E of each texel of “{}”, as seen in its texture; ",
            face.name
        )) + format!("white is {} W/m² on all. ", format_number(f64::from(exposure.white)))
            + format!("Below: its luminance minus the truth's, relative to {of}; the figure is the rms of that. ")
            + colour_bar(DIFFERENCE_RANGE),
    );
}

/// Returns the white that exposes a plate.
fn plate_white(plate: &Plate) -> f32 {
    let values = plate.values.iter().map(|v| (v.as_vec3().max_element(), 1.0));
    Exposure::from_percentile(values.collect::<Vec<_>>().into_iter()).white
}

/// Returns the luminance of a value.
fn value_luminance(value: &DVec3) -> f64 {
    f64::from(luminance(value.as_vec3()))
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{closed_room, make_specimen};
    use super::*;
    use maud::Render;

    fn plates_of(specimen: &Specimen) -> String {
        let mut blocks = Blocks::default();
        add_plates(&mut blocks, specimen);
        blocks.render().into_string()
    }

    #[test]
    fn outlines_lie_inside_the_picture() {
        let specimen = make_specimen(closed_room(), 0);
        let rays = Rays::new(&specimen.mesh);
        let camera = Camera::oblique_view(&specimen.mesh, &rays, 0);
        for corner in specimen.mesh.faces.iter().flat_map(|f| f.corners) {
            let seen = camera.project_point(corner).unwrap();
            assert!(seen.abs().max_element() <= 1.0, "{seen}");
        }
        let drawn = draw_specimen(&specimen, "gap").render().into_string();
        assert!(drawn.contains("class=\"chosen\" d=\"M"));
    }

    #[test]
    fn only_answers_have_a_difference_picture() {
        let mut specimen = make_specimen(closed_room(), 2);
        let wrong = specimen.plates[0].values.iter().map(|v| v * 1.05).collect();
        specimen.plates.truncate(1);
        specimen.plates.push(Plate {
            label: "<5 % & more>".into(),
            values: wrong,
        });
        let page = plates_of(&specimen);
        assert_eq!(page.matches("data:image/png").count(), 3);
        assert!(page.contains("Δ 5\u{202f}%"), "{}", page.len());
        assert!(page.contains("&lt;5 % &amp; more&gt;"));
        specimen.scene.faces[2].shape = Shape::Triangle;
        assert!(plates_of(&specimen).is_empty());
    }

    #[test]
    fn light_on_a_dark_face_is_visible() {
        let mut specimen = make_specimen(closed_room(), 2);
        specimen.plates[0].values.fill(DVec3::ZERO);
        assert!(plates_of(&specimen).contains("relative to white"));
        for plate in &mut specimen.plates {
            plate.values.fill(DVec3::ZERO);
        }
        assert!(plates_of(&specimen).contains("white is 1 W/m²"));
    }
}
