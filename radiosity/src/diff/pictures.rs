//! Draws both results and their difference through one camera, and their interactive viewer.

use super::flip::compare_flip;
use crate::report::coarse_solution::{CoarseSolution, drawn_sizes};
use crate::report::document::{Figure, bold_text};
use crate::report::format::format_number;
use crate::report::picture::{Exposure, compute_luminance, weighted_rms};
use crate::report::view::camera::Camera;
use crate::report::view::interpolation::{CarriedLight, InterpolationSurface};
use crate::report::view::render::ViewHits;
use crate::report::viewer::{SceneViewer, ViewerLayer};
use common::Result;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::shooting::{RadiosityField, initial_field};
use common::solution::StoredSolution;
use glam::Vec3;
use maud::Markup;
use oracle::diff::Diff;

/// Pixels per side of a rendered view.
const VIEW_SIDE: u32 = 560;

/// Figures of a difference.
pub struct DiffPictures {
    /// Interactive viewer of A, B and A − B.
    pub viewer: Markup,
    /// True if any texel differs.
    pub differ: bool,
    /// HDR-FLIP between the views; none if it fails.
    pub flip: Option<f64>,
    /// Views of A and B, and of their difference if there is one.
    pub views: Vec<Figure>,
    /// Description of camera and exposure.
    pub remark: String,
}

impl DiffPictures {
    /// Draws all pictures with B's geometry; `names` are those of A and B in the viewer.
    ///
    /// Errors: the faces have no extent.
    pub fn new(a: &StoredSolution, b: &StoredSolution, diff: &Diff, names: [&str; 2]) -> Result<Self> {
        let [(mesh_a, field_a), (mesh_b, field_b)] = [stored_field(a, &b.scene)?, stored_field(b, &b.scene)?];
        // A scene too large for a page is shown on fewer texels than both have in common.
        let (sizes, _) = drawn_sizes(&diff.pair.resolutions);
        let common = [
            CoarseSolution::new(&b.scene, (&mesh_a, &field_a, [None, None]), &sizes)?,
            CoarseSolution::new(&b.scene, (&mesh_b, &field_b, [None, None]), &sizes)?,
        ];
        let surface = InterpolationSurface::new(&b.scene, &common[1].mesh);
        let rays = Rays::new(&mesh_b);
        let camera = Camera::automatic_view(&mesh_b, &rays);
        let seen_b = RenderedResult::new((&mesh_b, &field_b), &b.scene, (&camera, &rays), None);
        let exposure = seen_b.exposure;
        let seen_a = RenderedResult::new((&mesh_a, &field_a), &b.scene, (&camera, &rays), Some(exposure));
        let flip = compare_flip(&seen_a.pixels, &seen_b.pixels, VIEW_SIDE).ok();
        let differ = diff.pair.a != diff.pair.b;
        let view = |name: &str, what: &str, seen: &RenderedResult| {
            let says = format!("{what} · radiosity; emitters clip.");
            let alt = format!("The scene as {name} has it");
            Figure::from_picture(&seen.view, &alt, bold_text(name) + says)
        };
        let mut views = vec![view("A", "", &seen_a), view("B", ", the reference", &seen_b)];
        if differ {
            views.push(difference_figure(&common, &surface, diff, (&camera, &rays)));
        }
        let is_known = |stored: &StoredSolution| stored.others.contains_key("irradiance");
        let layers = names.into_iter().zip(&common).map(|(name, of)| ViewerLayer {
            name,
            mesh: &of.mesh,
            field: Some(&of.field),
        });
        let viewer = SceneViewer {
            scene: &b.scene,
            surface: &surface,
            layers: layers.collect(),
            irradiance: is_known(a) && is_known(b),
            carried: CarriedLight::Reflected,
            texel_errors: None,
            camera,
            exposure,
        };
        Ok(Self {
            viewer: viewer.render_element(),
            differ,
            flip,
            views,
            remark: camera.describe_views("B's", exposure.white),
        })
    }
}

/// Returns a result as mesh and field, with its own emission and reflectance on the geometry of `scene`.
fn stored_field(stored: &StoredSolution, scene: &Scene) -> Result<(Mesh, RadiosityField)> {
    // One patch per face: no texel shoots here.
    let mut mesh = Mesh::new(scene, &stored.resolutions, 1)?;
    let mut field = initial_field(&mesh, "");
    let [irradiance, reflectance] = ["irradiance", "reflectance"].map(|name| stored.others.get(name));
    for (k, texel) in mesh.texels_in_face_order().into_iter().enumerate() {
        field.radiosity[texel] = stored.radiosity[k].extend(0.0);
        field.irradiance[texel] = irradiance.map_or(Vec3::ZERO, |h| h[k]).extend(0.0);
        let own = &mut mesh.texels[texel];
        own.emission = stored.emission[k];
        let of_face = stored.scene.faces[own.face as usize].reflectance;
        own.reflectance = reflectance.map_or(of_face, |r| r[k]);
    }
    Ok((mesh, field))
}

/// View of one result.
struct RenderedResult {
    exposure: Exposure,
    /// Radiosity of each pixel, W/m², not clipped.
    pixels: Vec<Option<Vec3>>,
    view: String,
}

impl RenderedResult {
    fn new(
        (mesh, field): (&Mesh, &RadiosityField),
        scene: &Scene,
        (camera, rays): (&Camera, &Rays),
        exposure: Option<Exposure>,
    ) -> Self {
        let surface = InterpolationSurface::new(scene, mesh);
        let hits = ViewHits::new(camera, &surface, rays, VIEW_SIDE);
        // In a result of any origin B = E + ρH need not hold.
        let light = surface.interpolate_light(field, CarriedLight::Reflected);
        let exposure = exposure.unwrap_or_else(|| hits.choose_exposure(&light));
        Self {
            pixels: hits.pixel_means(|hit| light.radiosity_at(&hit.stencil)),
            view: hits.expose_light(&light, exposure).data_uri(),
            exposure,
        }
    }
}

/// Draws the signed difference of reflected luminance on the common texels.
fn difference_figure(
    common: &[CoarseSolution; 2],
    surface: &InterpolationSurface,
    diff: &Diff,
    (camera, rays): (&Camera, &Rays),
) -> Figure {
    let texels = diff.pair.areas.iter().zip(&diff.pair.b);
    let rms = weighted_rms(texels.map(|(area, value)| (f64::from(compute_luminance(value.as_vec3())), *area)));
    let hits = ViewHits::new(camera, surface, rays, VIEW_SIDE);
    let reflected = |of: &CoarseSolution| CarriedLight::Reflected.texel_values(&of.mesh, &of.field);
    let [a, b] = common
        .each_ref()
        .map(|of| surface.interpolate_irradiance(&reflected(of)));
    let says = format!(
        " · luminance of reflected radiosity, relative to its rms in B ({} W/m²); clipped beyond the range.",
        format_number(rms)
    );
    hits.false_colour_figure("Difference in false colours", bold_text("A − B") + says, |hit| {
        let difference = a.stencil_value(&hit.stencil) - b.stencil_value(&hit.stencil);
        let size = f64::from(compute_luminance(difference.as_vec3()));
        if size == 0.0 { 0.0 } else { size / rms }
    })
}
