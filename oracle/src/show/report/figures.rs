//! The pictures and charts of one scene's comparison.

use super::charts;
use crate::judge::comparison::{Comparison, ItemBufferPicture};
use crate::show::picture::{
    Exposure, atlas, decode, diverging, face_colour, item_buffer, luminance, range, rms,
};
use crate::show::preview::exposure;
use crate::show::view::camera::Camera;
use crate::show::view::quality::Quality;
use crate::show::view::render::{Hit, View};
use crate::show::view::surface::{Interpolant, Surface};
use common::rays::Rays;
use common::settings::Iteration;
use common::shooting::{Field, Run};
use glam::{Vec3, Vec4};

/// Pixels a side of a rendered view.
const VIEW: u32 = 560;
/// Every how manieth sample decides the range of the false colours.
const STRIDE: usize = 5;

/// Sources of `img` elements (and SVG elements), with what their captions say.
pub struct Figures {
    /// The free runs through the camera: CPU, GPU.
    pub views: [String; 2],
    /// Free runs' and lockstep's difference through the camera.
    pub differences: [String; 2],
    /// The false colours go from −range to +range.
    pub range: f64,
    /// rms of the CPU's reflected luminance, W/m².
    pub rms: f64,
    /// The views' and atlases' exposure.
    pub exposure: Exposure,
    /// All texels: CPU, GPU.
    pub atlases: [String; 2],
    /// A shot's item buffer; none where nothing is shot.
    pub item_buffer: Option<Buffer>,
    /// How far each texel may be off, and the end of its range.
    pub off: Option<(String, f64)>,
    /// Unshot power against shots.
    pub convergence: Option<String>,
    /// Mismatches by distance.
    pub histogram: Option<String>,
    /// The interpolation of the CPU's view.
    pub quality: Quality,
    /// Where the camera stands.
    pub camera: Camera,
}

/// A shot's item buffer.
pub struct Buffer {
    /// It, and the scene in the same colours.
    pub pictures: [String; 2],
    /// Name and number of the face that shot.
    pub shooter: String,
    /// Which cell.
    pub cell: u32,
    /// Pixels a side.
    pub size: u32,
}

impl Figures {
    /// Draws everything.
    pub fn new(c: &Comparison) -> Self {
        let rays = Rays::new(&c.mesh);
        let camera = Camera::automatic(&c.mesh, &rays);
        let surface = Surface::new(&c.scene, &c.mesh);
        let view = View::new(&camera, &surface, &rays, VIEW);
        let cpu = surface.interpolate(&c.cpu.field.irradiance);
        let exposure = exposure(&view, &cpu);
        let (differences, range, rms) = differences(c, &view, &surface);
        Self {
            views: [&cpu, &surface.interpolate(&c.gpu.field.irradiance)].map(|field| {
                view.shade(|hit| exposure.display(field.radiosity(&hit.stencil)))
                    .data_uri()
            }),
            differences,
            range,
            rms,
            exposure,
            atlases: [&c.cpu, &c.gpu]
                .map(|run| atlas(&c.mesh, &run.field.radiosity, exposure).data_uri()),
            item_buffer: c.item_buffer.as_ref().map(|shot| buffer(c, shot, &view)),
            off: c.off.as_ref().map(|off| off_by_texel(&view, off, rms)),
            convergence: singly(c)
                .then(|| charts::convergence(&c.cpu, &c.gpu, c.settings.schedule.epsilon))
                .flatten(),
            histogram: charts::mismatches(&c.pairs.histogram),
            quality: Quality::new(&cpu),
            camera,
        }
    }
}

fn off_by_texel(view: &View, off: &[f32], rms: f64) -> (String, f64) {
    let at = |hit: &Hit| match off.get(hit.stencil.texel as usize) {
        Some(off) if rms > 0.0 => f64::from(*off) / rms,
        _ => 0.0,
    };
    let range = range(view.hits().step_by(STRIDE).map(at));
    let picture = view.shade(|hit| decode(diverging(at(hit) / range)));
    (picture.data_uri(), range)
}

fn buffer(c: &Comparison, shot: &ItemBufferPicture, view: &View) -> Buffer {
    let cell = c.mesh.cells.get(shot.cell as usize);
    let shooter = cell.map_or(0, |cell| cell.face);
    let face = c.scene.faces.get(shooter as usize);
    let name = face.map_or("", |face| &face.name);
    Buffer {
        pictures: [
            item_buffer(&shot.ids, shot.size).data_uri(),
            view.shade(|hit| face_colours(hit, shooter)).data_uri(),
        ],
        shooter: format!("face {shooter} “{name}”"),
        cell: shot.cell,
        size: shot.size,
    }
}

/// Whether one cell shot after the other: only then is there a log to draw.
pub fn singly(c: &Comparison) -> bool {
    c.asked.is_none() && c.settings.schedule.iteration == Iteration::Southwell
}

/// The shooter itself is white.
fn face_colours(hit: &Hit, shooter: u32) -> Vec3 {
    if hit.face == shooter {
        Vec3::ONE
    } else {
        decode(face_colour(hit.face))
    }
}

/// Signed difference of the reflected luminance through the camera, its range, and what 1 is.
fn differences(c: &Comparison, view: &View, surface: &Surface) -> ([String; 2], f64, f64) {
    let rms = unit(c);
    // Lockstep is the CPU's log on the GPU, or the GPU's decisions on the CPU.
    let lockstep = match c.asked {
        Some(_) => [&c.gpu, &c.lockstep],
        None => [&c.lockstep, &c.cpu],
    };
    let fields = [[&c.gpu, &c.cpu], lockstep]
        .map(|[run, from]| surface.interpolate(&minus(run, &from.field)));
    let at = |field: &Interpolant, hit: &Hit| {
        let reflectance = c.mesh.texels[hit.stencil.texel as usize].reflectance;
        let difference = reflectance * field.value(&hit.stencil).as_vec3();
        let size = f64::from(luminance(difference));
        if size == 0.0 { 0.0 } else { size / rms }
    };
    let range = range(
        fields
            .iter()
            .flat_map(|field| view.hits().step_by(STRIDE).map(|hit| at(field, hit))),
    );
    let pictures = fields.each_ref().map(|field| {
        view.shade(|hit| decode(diverging(at(field, hit) / range)))
            .data_uri()
    });
    (pictures, range, rms)
}

fn minus(run: &Run, from: &Field) -> Vec<Vec4> {
    run.field
        .irradiance
        .iter()
        .zip(&from.irradiance)
        .map(|(a, b)| a - b)
        .collect()
}

/// Of the luminance of the CPU's ρH.
fn unit(c: &Comparison) -> f64 {
    let texels = c.mesh.texels.iter().zip(&c.cpu.field.irradiance);
    rms(texels.map(|(texel, irradiance)| {
        let reflected = texel.reflectance * irradiance.truncate();
        (f64::from(luminance(reflected)), f64::from(texel.area))
    }))
}
