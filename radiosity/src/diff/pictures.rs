//! Draws both results and their difference through one camera and as texel atlases.

use super::flip::{FlipResult, compare_flip};
use super::viewer::render_diff_viewer;
use crate::report::document::{Figure, bold_text, colour_bar};
use crate::report::format::format_number;
use crate::report::picture::{Exposure, diverging_colour, draw_atlas, draw_radiosity_atlas, luminance, weighted_rms};
use crate::report::view::camera::Camera;
use crate::report::view::interpolation::InterpolationSurface;
use crate::report::view::render::{ViewHit, ViewHits};
use common::Result;
use common::mesh::Mesh;
use common::rays::Rays;
use common::solution::StoredSolution;
use common::texel::first_texels;
use glam::{Vec3, Vec4};
use maud::Markup;
use oracle::diff::Diff;

/// Pixels per side of a rendered view.
const VIEW_SIDE: u32 = 560;
/// Every `STRIDE`th view sample enters the choice of exposure.
const SAMPLE_STRIDE: usize = 5;

/// Figures of a difference.
pub struct DiffPictures {
    /// Interactive viewer of A, B and A − B.
    pub viewer: Markup,
    /// True if any texel differs.
    pub differ: bool,
    /// FLIP between the views; none if it fails.
    pub flip: Option<FlipResult>,
    /// Views of A and B, and of their difference if there is one.
    pub views: Vec<Figure>,
    /// Texel atlases of A − B, if they differ, A and B.
    pub atlases: Vec<Figure>,
    /// Description of camera and exposure.
    pub remark: String,
}

impl DiffPictures {
    /// Draws all pictures with B's geometry; `names` are those of A and B in the viewer.
    ///
    /// Errors: the faces have no extent.
    pub fn new(a: &StoredSolution, b: &StoredSolution, diff: &Diff, names: [&str; 2]) -> Result<Self> {
        // One patch per face: no texel shoots here.
        let mesh = |resolutions: &[[u32; 2]]| Mesh::new(&b.scene, resolutions, 1);
        let (mesh_a, mesh_b) = (mesh(&a.resolutions)?, mesh(&b.resolutions)?);
        let common = mesh(&diff.pair.resolutions)?;
        let rays = Rays::new(&mesh_b);
        let camera = Camera::automatic_view(&mesh_b, &rays);
        let seen_b = RenderedResult::new(b, &mesh_b, (&camera, &rays), None);
        let exposure = seen_b.exposure;
        let seen_a = RenderedResult::new(a, &mesh_a, (&camera, &rays), Some(exposure));
        let flip = compare_flip(&seen_a.pixels, &seen_b.pixels, VIEW_SIDE).ok();
        let differ = diff.pair.a != diff.pair.b;

        let white = format_number(f64::from(exposure.white));
        let view = |name: &str, what: &str, seen: &RenderedResult| {
            let says = format!("{what} · radiosity. White is {white} W/m²; emitters clip.");
            let alt = format!("The scene as {name} has it");
            Figure::from_picture(&seen.view, &alt, bold_text(name) + says)
        };
        let mut views = vec![view("A", "", &seen_a), view("B", ", the reference", &seen_b)];
        let mut atlases = Vec::new();
        if differ {
            let [picture, atlas] = difference_figures(b, diff, &common, (&camera, &rays));
            views.push(picture);
            views.extend(flip.as_ref().map(flip_figure));
            atlases.push(atlas);
        }
        atlases.extend([("A", a, &mesh_a), ("B", b, &mesh_b)].map(|(name, stored, mesh)| {
            let values = in_texel_order(mesh, stored, &stored.radiosity);
            let atlas = draw_radiosity_atlas(mesh, &values, exposure);
            let says = " · radiosity of every texel, as it is stored.";
            Figure::from_texels(&atlas.data_uri(), &format!("Atlas of {name}"), bold_text(name) + says)
        }));
        let eye = camera.eye.to_array().map(|x| format_number(f64::from(x))).join(", ");
        Ok(Self {
            viewer: render_diff_viewer([a, b], diff, names, (camera, exposure))?,
            differ,
            flip,
            views,
            atlases,
            remark: format!(
                "All from one automatic camera (at {eye} in the mesh's unit; back faces are transparent). Both views \
                 share one exposure: the 90th percentile of B's reflected radiosity is at 80 % of white. Reflected \
                 radiosity is interpolated between texels."
            ),
        })
    }
}

/// View of one result.
struct RenderedResult {
    exposure: Exposure,
    /// Radiosity of each pixel, W/m², not clipped.
    pixels: Vec<Option<Vec3>>,
    view: String,
}

impl RenderedResult {
    fn new(stored: &StoredSolution, mesh: &Mesh, (camera, rays): (&Camera, &Rays), exposure: Option<Exposure>) -> Self {
        let surface = InterpolationSurface::new(&stored.scene, mesh);
        let hits = ViewHits::new(camera, &surface, rays, VIEW_SIDE);
        let reflected: Vec<Vec3> = stored.reflected_radiosity().iter().map(|v| v.as_vec3()).collect();
        let field = surface.interpolate(&in_texel_order(mesh, stored, &reflected));
        let emission = in_texel_order(mesh, stored, &stored.emission);
        let emission = |hit: &ViewHit| emission[hit.stencil.texel as usize].truncate();
        let radiosity = |hit: &ViewHit| emission(hit) + field.stencil_value(&hit.stencil).as_vec3();
        let exposure = exposure.unwrap_or_else(|| {
            let samples = hits.iter_hits().step_by(SAMPLE_STRIDE);
            let dark = samples.filter(|hit| emission(hit) == Vec3::ZERO);
            Exposure::from_percentile(dark.map(|hit| (radiosity(hit).max_element(), 1.0)))
        });
        Self {
            pixels: hits.pixel_means(radiosity),
            view: hits.shade_hits(|hit| exposure.display_light(radiosity(hit))).data_uri(),
            exposure,
        }
    }
}

/// Returns the index of each mesh texel in a list in face order.
fn texel_order(mesh: &Mesh, resolutions: &[[u32; 2]]) -> Vec<usize> {
    let first = first_texels(resolutions);
    let texels = mesh.texels.iter();
    texels.map(|t| first[t.face as usize] + t.index as usize).collect()
}

/// Converts values in face order to the mesh's texel order.
fn in_texel_order(mesh: &Mesh, stored: &StoredSolution, values: &[Vec3]) -> Vec<Vec4> {
    let order = texel_order(mesh, &stored.resolutions);
    order.into_iter().map(|k| values[k].extend(0.0)).collect()
}

/// Draws the signed difference of reflected luminance on the common texels: as a view and as an atlas.
fn difference_figures(b: &StoredSolution, diff: &Diff, mesh: &Mesh, (camera, rays): (&Camera, &Rays)) -> [Figure; 2] {
    let texels = diff.pair.areas.iter().zip(&diff.pair.b);
    let rms = weighted_rms(texels.map(|(area, value)| (f64::from(luminance(value.as_vec3())), *area)));
    let order = texel_order(mesh, &diff.pair.resolutions);
    let relative = |k: usize| {
        let size = f64::from(luminance((diff.pair.a[order[k]] - diff.pair.b[order[k]]).as_vec3()));
        if size == 0.0 { 0.0 } else { size / rms }
    };
    let surface = InterpolationSurface::new(&b.scene, mesh);
    let hits = ViewHits::new(camera, &surface, rays, VIEW_SIDE);
    let values: Vec<Vec4> = (0..order.len())
        .map(|k| Vec3::splat(relative(k) as f32).extend(0.0))
        .collect();
    let field = surface.interpolate(&values);
    let at = |hit: &ViewHit| field.stencil_value(&hit.stencil).x;
    let range = hits.false_colour_range(at);
    let picture = hits.draw_false_colours(range, at).data_uri();
    let atlas = draw_atlas(mesh, |k| diverging_colour(relative(k) / range)).data_uri();
    let says = format!(
        " · luminance of reflected radiosity, relative to its rms in B ({} W/m²); clipped beyond the range.",
        format_number(rms)
    );
    let of_atlas = " · every common texel, all faces side by side in file order; colours as above.";
    [
        Figure::from_picture(
            &picture,
            "Difference in false colours",
            bold_text("A − B") + says + colour_bar(range),
        ),
        Figure::from_texels(
            &atlas,
            "Atlas of the difference",
            bold_text("A − B") + of_atlas + colour_bar(range),
        ),
    ]
}

fn flip_figure(flip: &FlipResult) -> Figure {
    let says = format!(
        " · the visible difference between the alternating views, maximum over the exposures determined by B: black is \
         none (0), pale yellow maximal (1). Mean {}, largest {}.",
        format_number(flip.mean),
        format_number(flip.max)
    );
    Figure::from_picture(
        &flip.picture.data_uri(),
        "HDR-FLIP error map",
        bold_text("HDR-FLIP") + says,
    )
}
