//! Pictures of a specimen: an oblique view of its scene from outside, and the plates, which show B − E of
//! one face of each answer texel by texel and the difference from the truth.

use super::{Plate, Specimen};
use crate::report::format::{format_count, format_number, format_percent};
use crate::report::page::{render_colour_bar, render_figure};
use crate::report::picture::{Exposure, RgbaPicture, diverging_colour, encode_srgb, luminance, weighted_rms};
use crate::report::view::camera::Camera;
use crate::report::view::interpolation::InterpolationSurface;
use crate::report::view::render::{ViewHit, ViewHits};
use common::mesh::MeshFace;
use common::rays::Rays;
use common::scene::{Face, Shape};
use common::texel::triangle_index;
use glam::{DVec3, Vec3};
use maud::{Markup, html};
use std::fmt::Write;

/// Pixels per side.
const PICTURE_SIZE: u32 = 440;
/// Most faces of a scene whose edges are drawn.
const MAX_OUTLINED_FACES: usize = 150;
/// Range of the false colours, ± this relative difference.
const DIFFERENCE_RANGE: f64 = 0.2;
/// Least pixels per side of a triangle's picture, whose texels are no squares.
const MIN_TRIANGLE_PIXELS: u32 = 192;

/// Returns the picture with its caption.
pub fn draw_specimen(specimen: &Specimen, parameter: &str) -> Markup {
    let (scene, mesh) = (&specimen.scene, &specimen.mesh);
    let rays = Rays::new(mesh);
    let camera = Camera::oblique_view(mesh, &rays, specimen.face);
    let surface = InterpolationSurface::new(scene, mesh);
    let seen = ViewHits::new(&camera, &surface, &rays, PICTURE_SIZE);
    let field = surface.interpolate(&specimen.field.irradiance);
    let radiosity = |hit: &ViewHit| field.radiosity_at(&hit.stencil);
    let dark = |hit: &&ViewHit| mesh.texels[hit.stencil.texel as usize].emission == Vec3::ZERO;
    let bright = |hit: &ViewHit| (radiosity(hit).max_element(), 1.0);
    let exposure = if seen.iter_hits().filter(dark).any(|hit| bright(hit).0 > 0.0) {
        Exposure::from_percentile(seen.iter_hits().filter(dark).map(bright))
    } else {
        Exposure::from_percentile(seen.iter_hits().map(bright))
    };
    let picture = seen.shade_hits(|hit| exposure.display_light(radiosity(hit)));
    let faces = if mesh.faces.len() <= MAX_OUTLINED_FACES {
        &mesh.faces[..]
    } else {
        &[]
    };
    let chosen = mesh.faces.get(specimen.face as usize);
    let name = scene.faces.get(specimen.face as usize).map(|f| &f.name);
    html! {
        figure {
            svg.specimen viewBox=(format!("0 0 {PICTURE_SIZE} {PICTURE_SIZE}")) role="img" aria-label="The scene from outside" {
                image href=(picture.data_uri()) width=(PICTURE_SIZE) height=(PICTURE_SIZE) {}
                path.edges d=(outline_path(faces, &camera)) {}
                @if let Some(face) = chosen { path.chosen d=(outline_path(std::slice::from_ref(face), &camera)) {} }
            }
            figcaption {
                b { "The specimen" } " at " (super::outcome::format_value(specimen.value)) " (" (parameter) "): "
                (format_count(scene.faces.len() as u64)) @if scene.faces.len() == 1 { " face" } @else { " faces" }
                ", white is " (format_number(f64::from(exposure.white))) " W/m²; backs are looked through."
                @if let Some(name) = name { " The plates are of “" (name) "”, outlined." }
            }
        }
    }
}

/// Returns the faces' outlines as SVG path data.
fn outline_path(faces: &[MeshFace], camera: &Camera) -> String {
    let mut path = String::new();
    for face in faces {
        let points = face.corners.map(|corner| camera.project_point(corner));
        let half = PICTURE_SIZE as f32 / 2.0;
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

/// Returns the plates of a specimen.
pub fn draw_plates(specimen: &Specimen) -> Markup {
    let Some(tone) = Tone::new(specimen) else {
        return html! {};
    };
    html! {
        div.plates style=(format!("--aspect:{:.3}", face_aspect(tone.face))) {
            @for plate in &specimen.plates { (tone.draw_plate(plate)) }
        }
        p.small {
            "Above: B − E of each texel of “" (tone.face.name) "”, as seen in its texture (corner 0 is the upper left"
            @if tone.face.shape == Shape::Triangle { " and corner 1 the upper right" }
            "); white is " (format_number(f64::from(tone.exposure.white))) " W/m² on all. Below: its luminance minus the truth's, relative to "
            @if tone.dark { "white, since the truth is dark" } @else { "the rms of the truth on this face" }
            "; the figure is the rms of that. Magenta would be “not a number”. " (render_colour_bar(DIFFERENCE_RANGE))
        }
    }
}

/// Returns width over height, limited to 0.5…2.
fn face_aspect(face: &Face) -> f64 {
    let [a, b, c, d] = face.corners;
    let height = match face.shape {
        Shape::Quad => (d - a).length().max((c - b).length()),
        Shape::Triangle => return 1.0,
    };
    let width = (b - a).length().max((c - d).length());
    let aspect = width / height;
    if aspect.is_finite() {
        aspect.clamp(0.5, 2.0)
    } else {
        1.0
    }
}

/// Exposure and scale shared by the plates of a face.
struct Tone<'a> {
    face: &'a Face,
    truth: &'a Plate,
    exposure: Exposure,
    /// Unit of the relative difference, W/m².
    unit: f64,
    /// True if the truth reflects nothing.
    dark: bool,
}

impl<'a> Tone<'a> {
    fn new(specimen: &'a Specimen) -> Option<Self> {
        let face = specimen.scene.faces.get(specimen.face as usize)?;
        let truth = specimen.plates.first()?;
        let rms = weighted_rms(truth.values.iter().map(|v| (value_luminance(v), 1.0)));
        let dark = rms == 0.0 || !rms.is_finite();
        let bright = |plate: &Plate| {
            let values = plate.values.iter();
            let all: Vec<_> = values.map(|v| (v.as_vec3().max_element(), 1.0)).collect();
            Exposure::from_percentile(all.into_iter())
        };
        let exposure = if dark {
            // Expose for the brightest answer, so that any leak is visible.
            let lit = |plate: &&Plate| plate.values.iter().any(|v| v.max_element() > 0.0);
            let others = specimen.plates.iter().skip(1).filter(lit);
            others.map(bright).fold(Exposure::with_white(0.0), |a, b| Exposure {
                white: a.white.max(b.white),
                ..a
            })
        } else {
            bright(truth)
        };
        let white = if exposure.white > 0.0 { exposure.white } else { 1.0 };
        Some(Self {
            face,
            truth,
            exposure: Exposure::with_white(white),
            unit: if dark { f64::from(white) } else { rms },
            dark,
        })
    }

    fn draw_plate(&self, plate: &Plate) -> Markup {
        let truth = std::ptr::eq(plate, self.truth);
        let alt = format!("{}: one face, texel by texel", plate.label);
        let difference = |at: [f64; 2]| {
            let [a, b] = [plate, self.truth].map(|p| self.value_at(p, at));
            value_luminance(&(a - b)) / self.unit
        };
        html! {
            div.plate {
                (render_figure("pixels", &self.draw_values(plate), &alt, html! { b { (plate.label) } }))
                @if !truth {
                    @let picture = self.draw_picture(plate, |at| diverging_colour(difference(at) / DIFFERENCE_RANGE));
                    (render_figure("pixels", &picture, "the difference from the truth", html! {
                        "Δ " (format_percent(weighted_rms(self.texel_centres(plate).into_iter().map(|at| (difference(at), 1.0)))))
                    }))
                }
            }
        }
    }

    fn draw_values(&self, plate: &Plate) -> String {
        self.draw_picture(plate, |at| {
            encode_srgb(self.exposure.display_light(self.value_at(plate, at).as_vec3()))
        })
    }

    /// Returns the resolution of the plate or of the truth, whichever is larger.
    fn common_resolution(&self, plate: &Plate) -> [u32; 2] {
        let [a, b] = [plate.resolution, self.truth.resolution];
        [a[0].max(b[0]).max(1), a[1].max(b[1]).max(1)]
    }

    /// Draws `colour` at each (u, v) of the face: one pixel per texel on quads, several on triangles.
    fn draw_picture(&self, plate: &Plate, colour: impl Fn([f64; 2]) -> [u8; 3]) -> String {
        let [w, h] = match (self.face.shape, self.common_resolution(plate)) {
            (Shape::Quad, size) => size,
            (Shape::Triangle, [n, _]) => [n * MIN_TRIANGLE_PIXELS.div_ceil(n); 2],
        };
        let at = |k: u32, n: u32| (f64::from(k) + 0.5) / f64::from(n);
        let on = |u: f64, v: f64| self.face.shape == Shape::Quad || u + v < 1.0;
        let pixel = |x: u32, y: u32| {
            let (u, v) = (at(x, w), at(y, h));
            on(u, v).then(|| colour([u, v]))
        };
        RgbaPicture::from_pixels(w, h, pixel).data_uri()
    }

    /// Returns the centres of the texels.
    fn texel_centres(&self, plate: &Plate) -> Vec<[f64; 2]> {
        let [w, h] = self.common_resolution(plate);
        let on = |at: &[f64; 2]| self.face.shape == Shape::Quad || at[0] + at[1] < 1.0;
        // A triangle's texels are two to a square: one point in the lower half, one in the upper.
        let parts: &[f64] = match self.face.shape {
            Shape::Quad => &[0.5],
            Shape::Triangle => &[1.0 / 3.0, 2.0 / 3.0],
        };
        let at = |k: u32, part: f64, n: u32| (f64::from(k) + part) / f64::from(n);
        let texels = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
        let points = texels.flat_map(|(x, y)| {
            let here = parts.iter();
            here.map(move |part| [at(x, *part, w), at(y, *part, h)])
        });
        points.filter(on).collect()
    }

    /// Returns the value of the texel at (u, v), or NaN if there is none.
    fn value_at(&self, plate: &Plate, at: [f64; 2]) -> DVec3 {
        let [w, h] = plate.resolution;
        let place = |t: f64, n: u32| (t * f64::from(n)).min(f64::from(n) - 1e-9).max(0.0);
        let (x, y) = (place(at[0], w), place(at[1], h));
        let (i, j) = (x as u32, y as u32);
        let index = match self.face.shape {
            Shape::Quad => j * w + i,
            Shape::Triangle => triangle_index(w, i, j, x.fract() + y.fract() < 1.0),
        };
        let value = plate.values.get(index as usize);
        value.copied().unwrap_or(DVec3::NAN)
    }
}

/// Returns the luminance of a value.
fn value_luminance(value: &DVec3) -> f64 {
    f64::from(luminance(value.as_vec3()))
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{closed_room, make_specimen, triangle_pair};
    use super::*;

    #[test]
    fn outlines_lie_inside_the_picture() {
        for scene in [closed_room(), triangle_pair()] {
            let specimen = make_specimen(scene, 0);
            let rays = Rays::new(&specimen.mesh);
            let camera = Camera::oblique_view(&specimen.mesh, &rays, 0);
            let corners = specimen.mesh.faces.iter().flat_map(|f| f.corners);
            for corner in corners {
                let seen = camera.project_point(corner).unwrap();
                assert!(seen.abs().max_element() <= 1.0, "{seen}");
            }
            let drawn = draw_specimen(&specimen, "gap").into_string();
            assert!(drawn.contains("class=\"chosen\" d=\"M"));
        }
    }

    #[test]
    fn texels_of_a_triangle_are_found_at_their_centres() {
        let specimen = make_specimen(triangle_pair(), 0);
        let tone = Tone::new(&specimen).unwrap();
        let n = tone.truth.resolution[0];
        let plate = Plate {
            label: "numbers".into(),
            resolution: [n, n],
            values: (0..n * n).map(|k| DVec3::splat(f64::from(k))).collect(),
        };
        let points = tone.texel_centres(&plate);
        let mut seen: Vec<u32> = points.iter().map(|p| tone.value_at(&plate, *p).x as u32).collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..n * n).collect::<Vec<_>>());
        // Row 0 lies at the edge 0–1: its second texel is the first inverted one.
        let inside = 2.0 / 3.0 / f64::from(n);
        assert_eq!(tone.value_at(&plate, [inside, inside]).x, 1.0);
    }

    #[test]
    fn only_wrong_answers_have_a_difference_picture() {
        let mut specimen = make_specimen(closed_room(), 2);
        let wrong = specimen.plates[0].values.iter().map(|v| v * 1.05).collect();
        specimen.plates.truncate(1);
        specimen.plates.push(Plate {
            label: "<5 % & more>".into(),
            values: wrong,
            ..specimen.plates[0].clone()
        });
        let page = draw_plates(&specimen).into_string();
        assert_eq!(page.matches("data:image/png").count(), 3);
        assert!(page.contains("Δ 5\u{202f}%"), "{}", page.len());
        assert!(page.contains("&lt;5 % &amp; more&gt;"));
    }

    #[test]
    fn light_on_a_dark_face_is_visible() {
        let mut specimen = make_specimen(closed_room(), 2);
        let dark = vec![DVec3::ZERO; specimen.plates[0].values.len()];
        specimen.plates[0].values = dark;
        let tone = Tone::new(&specimen).unwrap();
        assert!(tone.dark && tone.exposure.white > 0.0 && tone.unit > 0.0);
        specimen.plates.clear();
        assert!(draw_plates(&specimen).into_string().is_empty());
    }
}
