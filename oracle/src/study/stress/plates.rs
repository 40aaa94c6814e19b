//! One face of each answer, texel by texel: what it reflects, and how that differs from the truth.

use super::{Plate, Specimen};
use crate::show::number::{number, percent};
use crate::show::page::{colour_bar, figure};
use crate::show::picture::{Exposure, Picture, diverging, encode, luminance, rms};
use common::scene::{Face, Shape};
use common::texel::triangle_index;
use glam::DVec3;
use maud::{Markup, html};

/// The false colours go from −this to +this, in every case.
const RANGE: f64 = 0.2;
/// Pixels a side of a triangle's picture, at least: its texels are no squares.
const TRIANGLE: u32 = 192;

/// All plates of a specimen.
pub fn plates(specimen: &Specimen) -> Markup {
    let Some(tone) = Tone::new(specimen) else {
        return html! {};
    };
    html! {
        div.plates style=(format!("--aspect:{:.3}", aspect(tone.face))) {
            @for plate in &specimen.plates { (tone.plate(plate)) }
        }
        p.small {
            "Above: B − E of each texel of “" (tone.face.name) "”, as seen in its texture (corner 0 is the upper left"
            @if tone.face.shape == Shape::Triangle { " and corner 1 the upper right" }
            "); white is " (number(f64::from(tone.exposure.white))) " W/m² on all. Below: its luminance minus the truth's, relative to "
            @if tone.dark { "white, since the truth is dark" } @else { "the rms of the truth on this face" }
            "; the figure is the rms of that. Magenta would be “not a number”. " (colour_bar(RANGE))
        }
    }
}

/// Width over height, kept from extremes.
fn aspect(face: &Face) -> f64 {
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

/// What all plates of a face have in common.
struct Tone<'a> {
    face: &'a Face,
    truth: &'a Plate,
    exposure: Exposure,
    /// What 1 is in the false colours, W/m².
    unit: f64,
    /// Whether the truth reflects nothing.
    dark: bool,
}

impl<'a> Tone<'a> {
    fn new(specimen: &'a Specimen) -> Option<Self> {
        let face = specimen.scene.faces.get(specimen.face as usize)?;
        let truth = specimen.plates.first()?;
        let rms = rms(truth.values.iter().map(|v| (light(v), 1.0)));
        let dark = rms == 0.0 || !rms.is_finite();
        let bright = |plate: &Plate| {
            let values = plate.values.iter();
            let all: Vec<_> = values.map(|v| (v.as_vec3().max_element(), 1.0)).collect();
            Exposure::of(all.into_iter())
        };
        let exposure = if dark {
            // Where no light may be, any light shows.
            let lit = |plate: &&Plate| plate.values.iter().any(|v| v.max_element() > 0.0);
            let others = specimen.plates.iter().skip(1).filter(lit);
            others
                .map(bright)
                .fold(Exposure::linear(0.0), |a, b| Exposure {
                    white: a.white.max(b.white),
                    ..a
                })
        } else {
            bright(truth)
        };
        let white = if exposure.white > 0.0 {
            exposure.white
        } else {
            1.0
        };
        Some(Self {
            face,
            truth,
            exposure: Exposure::linear(white),
            unit: if dark { f64::from(white) } else { rms },
            dark,
        })
    }

    fn plate(&self, plate: &Plate) -> Markup {
        let truth = std::ptr::eq(plate, self.truth);
        let alt = format!("{}: one face, texel by texel", plate.label);
        let difference = |at: [f64; 2]| {
            let [a, b] = [plate, self.truth].map(|p| self.at(p, at));
            light(&(a - b)) / self.unit
        };
        html! {
            div.plate {
                (figure("pixels", &self.values(plate), &alt, html! { b { (plate.label) } }))
                @if !truth {
                    @let picture = self.picture(plate, |at| diverging(difference(at) / RANGE));
                    (figure("pixels", &picture, "the difference from the truth", html! {
                        "Δ " (percent(rms(self.points(plate).into_iter().map(|at| (difference(at), 1.0)))))
                    }))
                }
            }
        }
    }

    fn values(&self, plate: &Plate) -> String {
        self.picture(plate, |at| {
            encode(self.exposure.display(self.at(plate, at).as_vec3()))
        })
    }

    /// Texels of the plate or of the truth, whichever has more.
    fn resolution(&self, plate: &Plate) -> [u32; 2] {
        let [a, b] = [plate.resolution, self.truth.resolution];
        [a[0].max(b[0]).max(1), a[1].max(b[1]).max(1)]
    }

    /// A colour at each (u, v) of the face: a pixel a texel on quads, many on triangles.
    fn picture(&self, plate: &Plate, colour: impl Fn([f64; 2]) -> [u8; 3]) -> String {
        let [w, h] = match (self.face.shape, self.resolution(plate)) {
            (Shape::Quad, size) => size,
            (Shape::Triangle, [n, _]) => [n * TRIANGLE.div_ceil(n); 2],
        };
        let at = |k: u32, n: u32| (f64::from(k) + 0.5) / f64::from(n);
        let on = |u: f64, v: f64| self.face.shape == Shape::Quad || u + v < 1.0;
        let pixel = |x: u32, y: u32| {
            let (u, v) = (at(x, w), at(y, h));
            on(u, v).then(|| colour([u, v]))
        };
        Picture::from_pixels(w, h, pixel).data_uri()
    }

    /// The middles of the texels.
    fn points(&self, plate: &Plate) -> Vec<[f64; 2]> {
        let [w, h] = self.resolution(plate);
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

    /// The value of the texel at (u, v); not a number where there is none.
    fn at(&self, plate: &Plate, at: [f64; 2]) -> DVec3 {
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

/// Luminance.
fn light(value: &DVec3) -> f64 {
    f64::from(luminance(value.as_vec3()))
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{room, specimen, triangle};
    use super::*;

    #[test]
    fn a_triangles_texels_are_found_where_they_lie() {
        let specimen = specimen(triangle(), 0);
        let tone = Tone::new(&specimen).unwrap();
        let n = tone.truth.resolution[0];
        let plate = Plate {
            label: "numbers".into(),
            resolution: [n, n],
            values: (0..n * n).map(|k| DVec3::splat(f64::from(k))).collect(),
        };
        let points = tone.points(&plate);
        let mut seen: Vec<u32> = points
            .iter()
            .map(|p| tone.at(&plate, *p).x as u32)
            .collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..n * n).collect::<Vec<_>>());
        // Row 0 lies at the edge 0–1: its second texel is the first inverted one.
        let inside = 2.0 / 3.0 / f64::from(n);
        assert_eq!(tone.at(&plate, [inside, inside]).x, 1.0);
    }

    #[test]
    fn the_truth_has_no_difference_and_a_wrong_answer_has() {
        let mut specimen = specimen(room(), 2);
        let wrong = specimen.plates[0].values.iter().map(|v| v * 1.05).collect();
        specimen.plates.truncate(1);
        specimen.plates.push(Plate {
            label: "<5 % & more>".into(),
            values: wrong,
            ..specimen.plates[0].clone()
        });
        let page = plates(&specimen).into_string();
        assert_eq!(page.matches("data:image/png").count(), 3);
        assert!(page.contains("Δ 5\u{202f}%"), "{}", page.len());
        assert!(page.contains("&lt;5 % &amp; more&gt;"));
    }

    #[test]
    fn light_on_a_dark_face_is_seen() {
        let mut specimen = specimen(room(), 2);
        let dark = vec![DVec3::ZERO; specimen.plates[0].values.len()];
        specimen.plates[0].values = dark;
        let tone = Tone::new(&specimen).unwrap();
        assert!(tone.dark && tone.exposure.white > 0.0 && tone.unit > 0.0);
        specimen.plates.clear();
        assert!(plates(&specimen).into_string().is_empty());
    }
}
