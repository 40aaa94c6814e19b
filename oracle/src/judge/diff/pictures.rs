//! Both results and their difference, seen through one camera and texel by texel.

use super::Diff;
use super::around::around;
use super::flip::{Flip, flip};
use super::reflected::offsets;
use crate::show::picture::{Exposure, atlas, atlas_of, decode, diverging, luminance, range, rms};
use crate::show::view::camera::Camera;
use crate::show::view::render::{Hit, View};
use crate::show::view::surface::Surface;
use common::Result;
use common::mesh::Mesh;
use common::rays::Rays;
use common::solution::Stored;
use glam::{Vec3, Vec4};
use maud::Markup;

/// Pixels a side of a rendered view.
const VIEW: u32 = 560;
/// Every how manieth sample decides exposure and the range of the false colours.
const STRIDE: usize = 5;

/// Sources of `img` elements, with what their captions say.
pub struct Pictures {
    /// A and B through the camera.
    pub views: [String; 2],
    /// A and B to look around in, and A − B.
    pub around: Markup,
    /// Whether any texel differs: where none does, there is nothing to draw of a difference.
    pub differ: bool,
    /// A − B through the camera.
    pub difference: String,
    /// FLIP between the views; none when it cannot be had.
    pub flip: Option<Flip>,
    /// All texels of A and B.
    pub atlases: [String; 2],
    /// All texels of A − B on the common grid.
    pub atlas_difference: String,
    /// The false colours go from −range to +range.
    pub range: f64,
    /// rms of B's reflected luminance, W/m².
    pub rms: f64,
    /// The exposure of views and atlases.
    pub exposure: Exposure,
    /// Where the camera stands.
    pub camera: Camera,
}

impl Pictures {
    /// Draws everything; geometry is B's, and `names` are A's and B's in the viewer.
    ///
    /// Errors: the faces have no extent.
    pub fn new(a: &Stored, b: &Stored, diff: &Diff, names: [&str; 2]) -> Result<Self> {
        // One cell a face: which texels shoot together does not matter here.
        let mesh = |resolutions: &[[u32; 2]]| Mesh::new(&b.scene, resolutions, 1);
        let (mesh_a, mesh_b) = (mesh(&a.resolutions)?, mesh(&b.resolutions)?);
        let common = mesh(&diff.pair.resolutions)?;
        let rays = Rays::new(&mesh_b);
        let camera = Camera::automatic(&mesh_b, &rays);
        let eye = Eye { camera, rays };
        let seen_b = Seen::new(b, &mesh_b, &eye, None);
        let exposure = seen_b.exposure;
        let seen_a = Seen::new(a, &mesh_a, &eye, Some(exposure));
        let rms = unit(diff);
        let (difference, range) = difference(b, diff, &common, &eye, rms);
        let sizes = order(&common, &diff.pair.resolutions);
        Ok(Self {
            around: around([a, b], diff, names, (camera, exposure))?,
            differ: diff.pair.a != diff.pair.b,
            difference,
            flip: flip(&seen_a.pixels, &seen_b.pixels, VIEW).ok(),
            atlas_difference: atlas_of(&common, |k| {
                diverging(relative(diff, sizes[k], rms) / range)
            })
            .data_uri(),
            views: [seen_a.view, seen_b.view],
            atlases: [(a, &mesh_a), (b, &mesh_b)].map(|(stored, mesh)| {
                let values = in_order(mesh, stored, &stored.radiosity);
                atlas(mesh, &values, exposure).data_uri()
            }),
            range,
            rms,
            exposure,
            camera,
        })
    }
}

/// Where all views are taken from.
struct Eye {
    camera: Camera,
    rays: Rays,
}

/// One result through the camera.
struct Seen {
    exposure: Exposure,
    /// Radiosity of each pixel, W/m², not clipped.
    pixels: Vec<Option<Vec3>>,
    view: String,
}

impl Seen {
    fn new(stored: &Stored, mesh: &Mesh, eye: &Eye, exposure: Option<Exposure>) -> Self {
        let surface = Surface::new(&stored.scene, mesh);
        let view = View::new(&eye.camera, &surface, &eye.rays, VIEW);
        let reflected: Vec<Vec3> = stored.reflected().iter().map(|v| v.as_vec3()).collect();
        let field = surface.interpolate(&in_order(mesh, stored, &reflected));
        let emission = in_order(mesh, stored, &stored.emission);
        let emission = |hit: &Hit| emission[hit.stencil.texel as usize].truncate();
        let radiosity = |hit: &Hit| emission(hit) + field.value(&hit.stencil).as_vec3();
        let exposure = exposure.unwrap_or_else(|| {
            let dark = view
                .hits()
                .step_by(STRIDE)
                .filter(|hit| emission(hit) == Vec3::ZERO);
            Exposure::of(dark.map(|hit| (radiosity(hit).max_element(), 1.0)))
        });
        let display = |hit: &Hit| exposure.display(radiosity(hit));
        Self {
            pixels: view.mean(radiosity),
            view: view.shade(display).data_uri(),
            exposure,
        }
    }
}

/// The entry of each of the mesh's texels in a list that counts face after face.
fn order(mesh: &Mesh, resolutions: &[[u32; 2]]) -> Vec<usize> {
    let first = offsets(resolutions);
    let texels = mesh.texels.iter();
    texels
        .map(|t| first[t.face as usize] + t.index as usize)
        .collect()
}

fn in_order(mesh: &Mesh, stored: &Stored, values: &[Vec3]) -> Vec<Vec4> {
    let order = order(mesh, &stored.resolutions);
    order.into_iter().map(|k| values[k].extend(0.0)).collect()
}

/// Signed difference of the reflected luminance through the camera, and its range.
fn difference(b: &Stored, diff: &Diff, mesh: &Mesh, eye: &Eye, rms: f64) -> (String, f64) {
    let surface = Surface::new(&b.scene, mesh);
    let view = View::new(&eye.camera, &surface, &eye.rays, VIEW);
    let order = order(mesh, &diff.pair.resolutions);
    let texels: Vec<Vec4> = order
        .iter()
        .map(|k| Vec3::splat(relative(diff, *k, rms) as f32).extend(0.0))
        .collect();
    let field = surface.interpolate(&texels);
    let at = |hit: &Hit| field.value(&hit.stencil).x;
    let range = range(view.hits().step_by(STRIDE).map(at));
    let picture = view.shade(|hit| decode(diverging(at(hit) / range)));
    (picture.data_uri(), range)
}

/// Luminance of a − b at an entry of the common grid, relative to `rms`.
fn relative(diff: &Diff, k: usize, rms: f64) -> f64 {
    let size = f64::from(luminance((diff.pair.a[k] - diff.pair.b[k]).as_vec3()));
    if size == 0.0 { 0.0 } else { size / rms }
}

/// Of the luminance of B's reflected part.
fn unit(diff: &Diff) -> f64 {
    let texels = diff.pair.areas.iter().zip(&diff.pair.b);
    rms(texels.map(|(area, value)| (f64::from(luminance(value.as_vec3())), *area)))
}
