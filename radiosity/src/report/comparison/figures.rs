//! Draws the pictures of one comparison, with their captions.

use crate::report::document::{Figure, bold_text, styled_text};
use crate::report::format::format_number;
use crate::report::picture::{compute_luminance, decode_srgb, draw_item_buffer, face_colour, weighted_rms};
use crate::report::view::camera::Camera;
use crate::report::view::interpolation::{CarriedLight, InterpolatedField, InterpolationSurface};
use crate::report::view::render::{ViewHit, ViewHits};
use crate::report::viewer::{SceneViewer, ViewerLayer};
use common::rays::Rays;
use common::settings::Visibility;
use glam::Vec3;
use maud::Markup;
use oracle::compare::comparison::{Comparison, ItemBufferPicture};

/// Pixels per side of a rendered view.
const VIEW_SIDE: u32 = 560;
/// Differences up to this, relative to the rms of reflected radiosity, count as 32-bit rounding (6·10⁻⁸ each).
const ROUNDING_TOLERANCE: f64 = 1e-6;

/// Pictures of a comparison, all from one camera.
pub struct ComparisonPictures {
    /// Interactive viewer of both solutions.
    pub viewer: Markup,
    /// Views of both solutions, and their difference, unless it is rounding.
    pub views: Vec<Figure>,
    /// True if the solutions are equal up to rounding; NaN does not count as alike.
    pub are_alike: bool,
    /// Item buffer of one shot, and the scene in its colours; empty without shots.
    pub item_buffer: Vec<Figure>,
    /// Description of camera and exposure.
    pub remark: String,
}

impl ComparisonPictures {
    /// Draws the free runs.
    pub fn new(c: &Comparison) -> Self {
        let rays = Rays::new(&c.mesh);
        let camera = Camera::automatic_view(&c.mesh, &rays);
        let surface = InterpolationSurface::new(&c.scene, &c.mesh);
        let hits = ViewHits::new(&camera, &surface, &rays, VIEW_SIDE);
        let [cpu, gpu] = [&c.cpu, &c.gpu].map(|run| surface.interpolate_irradiance(&run.field.irradiance));
        let exposure = hits.choose_exposure(&cpu);
        let texels = c.mesh.texels.iter().zip(&c.cpu.field.irradiance);
        let rms = weighted_rms(texels.map(|(texel, irradiance)| {
            let reflected = texel.reflectance * irradiance.truncate();
            (f64::from(compute_luminance(reflected)), f64::from(texel.area))
        }));
        let relative = |value: f64| if value == 0.0 { 0.0 } else { value / rms };

        let view = |name: &str, class: &str, light: &InterpolatedField| {
            let alt = format!("The scene as the {name} solved it");
            let source = hits.expose_light(light, exposure).data_uri();
            Figure::from_picture(&source, &alt, styled_text(class, name) + " · radiosity; emitters clip.")
        };
        let mut views = vec![view("CPU", "cpu", &cpu), view("GPU", "gpu", &gpu)];
        let differences = [&c.free_difference, &c.lockstep_difference];
        let are_alike = differences.iter().all(|d| d.max_relative <= ROUNDING_TOLERANCE);
        if !are_alike {
            let caption = bold_text("GPU − CPU")
                + format!(
                    " · luminance of reflected radiosity, each solved on its own, relative to its rms on the CPU ({} \
                     W/m²); clipped beyond the range.",
                    format_number(rms)
                );
            views.push(hits.false_colour_figure("Difference in false colours", caption, |hit| {
                let reflectance = c.mesh.texels[hit.stencil.texel as usize].reflectance;
                let difference = gpu.stencil_value(&hit.stencil) - cpu.stencil_value(&hit.stencil);
                relative(f64::from(compute_luminance(reflectance * difference.as_vec3())))
            }));
        }
        let viewer = SceneViewer {
            scene: &c.scene,
            surface: &surface,
            layers: [("GPU", &c.gpu), ("CPU", &c.cpu)]
                .map(|(name, run)| ViewerLayer {
                    name,
                    mesh: &c.mesh,
                    field: Some(&run.field),
                })
                .into(),
            irradiance: true,
            carried: CarriedLight::Irradiance,
            texel_errors: c.error_map.as_deref(),
            camera,
            exposure,
        };
        Self {
            viewer: viewer.render_element(),
            are_alike,
            item_buffer: c
                .item_buffer
                .iter()
                .flat_map(|shot| item_buffer_figures(c, &hits, shot))
                .collect(),
            remark: camera.describe_views("the CPU's", exposure.white),
            views,
        }
    }
}

/// Draws an item buffer, and the scene in its colours.
fn item_buffer_figures(c: &Comparison, hits: &ViewHits, shot: &ItemBufferPicture) -> [Figure; 2] {
    let (patch, size) = (shot.patch, shot.size);
    let shooter = c.mesh.patches.get(patch as usize).map_or(0, |patch| patch.face);
    let name = c.scene.faces.get(shooter as usize).map_or("", |face| &face.name);
    let projection = match c.gpu_settings.transport.visibility {
        Visibility::Rays => "stereographic (for illustration: the GPU used rays)",
        drawn => drawn.name(),
    };
    let says = format!(
        " · view of face {shooter} “{name}” (patch {patch}), {size}×{size} pixels, projection {projection}. One colour \
         per face, black: nothing."
    );
    let colour = |hit: &ViewHit| match hit.face == shooter {
        true => Vec3::ONE,
        false => decode_srgb(face_colour(hit.face)),
    };
    let pictures = [draw_item_buffer(&shot.ids, size), hits.shade_hits(colour)];
    let captions = [
        bold_text("Item buffer") + says,
        bold_text("The same colours in the scene") + " · the front of the shooter is white.",
    ];
    let [buffer, scene] = pictures.map(|picture| picture.data_uri());
    let [of_buffer, of_scene] = captions;
    [
        Figure::from_picture(&buffer, "Item buffer in false colours", of_buffer),
        Figure::from_picture(&scene, "The scene in the item buffer's colours", of_scene),
    ]
}
