//! Draws both results and their difference through one camera and as texel atlases.

use super::flip::{FlipResult, compare_flip};
use super::viewer::render_diff_viewer;
use crate::report::picture::{
    Exposure, decode_srgb, diverging_colour, draw_atlas, draw_radiosity_atlas, false_colour_range, luminance,
    weighted_rms,
};
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
/// Every `STRIDE`th view sample enters the choice of exposure and false-colour range.
const SAMPLE_STRIDE: usize = 5;

/// Pictures as sources of `img` elements, and the values that their captions state.
pub struct DiffPictures {
    /// Views of A and B.
    pub views: [String; 2],
    /// Interactive viewer of A, B and A − B.
    pub viewer: Markup,
    /// True if any texel differs.
    pub differ: bool,
    /// View of A − B.
    pub difference: String,
    /// FLIP between the views; none if it fails.
    pub flip: Option<FlipResult>,
    /// Texel atlases of A and B.
    pub atlases: [String; 2],
    /// Texel atlas of A − B on the common grid.
    pub atlas_difference: String,
    /// Half-width of the false-colour range.
    pub range: f64,
    /// RMS of B's reflected luminance, W/m².
    pub rms: f64,
    /// Exposure of views and atlases.
    pub exposure: Exposure,
    /// Camera of all views.
    pub camera: Camera,
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
        let eye = Viewpoint { camera, rays };
        let seen_b = RenderedResult::new(b, &mesh_b, &eye, None);
        let exposure = seen_b.exposure;
        let seen_a = RenderedResult::new(a, &mesh_a, &eye, Some(exposure));
        let rms = reflected_rms(diff);
        let (difference, range) = draw_difference(b, diff, &common, &eye, rms);
        let sizes = texel_order(&common, &diff.pair.resolutions);
        Ok(Self {
            viewer: render_diff_viewer([a, b], diff, names, (camera, exposure))?,
            differ: diff.pair.a != diff.pair.b,
            difference,
            flip: compare_flip(&seen_a.pixels, &seen_b.pixels, VIEW_SIDE).ok(),
            atlas_difference: draw_atlas(&common, |k| {
                diverging_colour(relative_difference(diff, sizes[k], rms) / range)
            })
            .data_uri(),
            views: [seen_a.view, seen_b.view],
            atlases: [(a, &mesh_a), (b, &mesh_b)].map(|(stored, mesh)| {
                let values = in_texel_order(mesh, stored, &stored.radiosity);
                draw_radiosity_atlas(mesh, &values, exposure).data_uri()
            }),
            range,
            rms,
            exposure,
            camera,
        })
    }
}

/// Camera of all views with its rays.
struct Viewpoint {
    camera: Camera,
    rays: Rays,
}

/// View of one result.
struct RenderedResult {
    exposure: Exposure,
    /// Radiosity of each pixel, W/m², not clipped.
    pixels: Vec<Option<Vec3>>,
    view: String,
}

impl RenderedResult {
    fn new(stored: &StoredSolution, mesh: &Mesh, eye: &Viewpoint, exposure: Option<Exposure>) -> Self {
        let surface = InterpolationSurface::new(&stored.scene, mesh);
        let view = ViewHits::new(&eye.camera, &surface, &eye.rays, VIEW_SIDE);
        let reflected: Vec<Vec3> = stored.reflected_radiosity().iter().map(|v| v.as_vec3()).collect();
        let field = surface.interpolate(&in_texel_order(mesh, stored, &reflected));
        let emission = in_texel_order(mesh, stored, &stored.emission);
        let emission = |hit: &ViewHit| emission[hit.stencil.texel as usize].truncate();
        let radiosity = |hit: &ViewHit| emission(hit) + field.stencil_value(&hit.stencil).as_vec3();
        let exposure = exposure.unwrap_or_else(|| {
            let dark = view
                .iter_hits()
                .step_by(SAMPLE_STRIDE)
                .filter(|hit| emission(hit) == Vec3::ZERO);
            Exposure::from_percentile(dark.map(|hit| (radiosity(hit).max_element(), 1.0)))
        });
        let display = |hit: &ViewHit| exposure.display_light(radiosity(hit));
        Self {
            pixels: view.pixel_means(radiosity),
            view: view.shade_hits(display).data_uri(),
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

/// Draws the signed difference of reflected luminance; returns the picture and its range.
fn draw_difference(b: &StoredSolution, diff: &Diff, mesh: &Mesh, eye: &Viewpoint, rms: f64) -> (String, f64) {
    let surface = InterpolationSurface::new(&b.scene, mesh);
    let view = ViewHits::new(&eye.camera, &surface, &eye.rays, VIEW_SIDE);
    let order = texel_order(mesh, &diff.pair.resolutions);
    let texels: Vec<Vec4> = order
        .iter()
        .map(|k| Vec3::splat(relative_difference(diff, *k, rms) as f32).extend(0.0))
        .collect();
    let field = surface.interpolate(&texels);
    let at = |hit: &ViewHit| field.stencil_value(&hit.stencil).x;
    let range = false_colour_range(view.iter_hits().step_by(SAMPLE_STRIDE).map(at));
    let picture = view.shade_hits(|hit| decode_srgb(diverging_colour(at(hit) / range)));
    (picture.data_uri(), range)
}

/// Returns the luminance of a − b at a texel of the common grid, relative to `rms`.
fn relative_difference(diff: &Diff, k: usize, rms: f64) -> f64 {
    let size = f64::from(luminance((diff.pair.a[k] - diff.pair.b[k]).as_vec3()));
    if size == 0.0 { 0.0 } else { size / rms }
}

/// Returns the RMS of the luminance of B's reflected part, W/m².
fn reflected_rms(diff: &Diff) -> f64 {
    let texels = diff.pair.areas.iter().zip(&diff.pair.b);
    weighted_rms(texels.map(|(area, value)| (f64::from(luminance(value.as_vec3())), *area)))
}
