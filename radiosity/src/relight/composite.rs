//! Differential rendering (Debevec 1998): the captured background, plus the objects' change of the room's light, with
//! the objects in front.

use super::radiance::{RelitRadiance, welded_surface};
use super::{Backdrop, RelitScene};
use crate::report::view::camera::Camera;
use crate::report::view::interpolation::{InterpolationStencil, KnotCache};
use common::mesh::Mesh;
use common::rays::Rays;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// View rays per side of a pixel: silhouettes get 17 levels.
const SAMPLES_PER_SIDE: usize = 4;
/// View rays per pixel.
const SAMPLES_PER_PIXEL: usize = SAMPLES_PER_SIDE * SAMPLES_PER_SIDE;
/// Sparse samples, one per row and column: their mean equals that of all samples where light is linear.
pub const SPARSE_SAMPLES: [usize; SAMPLES_PER_SIDE] = [1, 7, 8, 14];
/// Distance within which an object in a wall's plane counts as in front of it (mesh units).
const CONTACT_DISTANCE: f32 = 1e-5;

/// Pictures of linear radiance, W/m²/sr, row-major from the upper left.
///
/// Colours are means over all samples of a pixel, hence premultiplied by coverage, as EXR requires.
#[derive(Clone, Debug, Default)]
pub struct Composite {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Captured room without objects.
    pub background: Vec<Vec3>,
    /// Relit room with objects. Negative values are clamped to 0: where the photograph is darker than the room's
    /// model, a shadow can exceed it (see `negative`).
    pub composite: Vec<Vec3>,
    /// Change of the room's light by the objects; 0 where an object hides the room.
    pub change: Vec<Vec3>,
    /// Objects alone, premultiplied by `mask`.
    pub objects: Vec<Vec3>,
    /// Share of each pixel that shows an object, 0…1.
    pub mask: Vec<f32>,
    /// Share that shows a surface or the backdrop: in the background, in the composite.
    pub coverage: [Vec<f32>; 2],
    /// Share that shows neither nothing nor an emitter, used to choose the exposure: background, composite.
    pub dark: [Vec<f32>; 2],
    /// Number of composite pixels with a negative channel before clamping.
    pub negative: usize,
}

/// Renders through `camera` (in mesh coordinates) with `size` = (w, h) pixels.
///
/// Back faces are transparent. A `backdrop` is projected from the capture's eye onto the room, so that the photograph
/// stays on the walls when the camera leaves the eye; without an eye it is infinitely distant. Rays that hit nothing
/// show the backdrop in their own direction, or are transparent.
pub fn render_composite(relit: &RelitScene, camera: &Camera, size: [u32; 2], backdrop: Option<Backdrop>) -> Composite {
    let surface = welded_surface(relit);
    let lens = camera.ray_generator();
    let scene = CompositeScene {
        renders: RelitRadiance::new(relit, &surface, backdrop.is_some()),
        room: face_rays(relit.mesh, 0..relit.room),
        objects: face_rays(relit.mesh, relit.room..relit.mesh.faces.len()),
        first_object_face: relit.room as u32,
        camera: camera.eye,
        eye: relit.eye.map(|eye| relit.mesh.local_point(eye)),
        backdrop,
    };
    let pixels = scene.render_pixels(&lens, size);
    let colours = |of: fn(&PixelMeans) -> Vec3| pixels.iter().map(of).collect();
    let shares = |of: fn(&PixelMeans) -> f32| pixels.iter().map(of).collect();
    // Without objects only zeros are added: the composite equals the background bit for bit.
    let composite: Vec<Vec3> = colours(|p| p.visible_background + p.change + p.objects);
    Composite {
        size,
        background: colours(|p| p.background),
        negative: composite.iter().filter(|c| c.min_element() < 0.0).count(),
        composite: composite.into_iter().map(|c| c.max(Vec3::ZERO)).collect(),
        change: colours(|p| p.change),
        objects: colours(|p| p.objects),
        mask: shares(|p| p.mask),
        coverage: [shares(|p| p.coverage[0]), shares(|p| p.coverage[1])],
        dark: [shares(|p| p.dark[0]), shares(|p| p.dark[1])],
    }
}

/// Builds the ray tracer of some faces; none if no face has area.
fn face_rays(mesh: &Mesh, faces: Range<usize>) -> Option<Rays> {
    let faces = mesh.faces.get(faces)?.to_vec();
    let any = faces.iter().any(|face| face.normal != Vec3::ZERO);
    any.then(|| {
        Rays::new(&Mesh {
            faces,
            patches: Vec::new(),
            texels: Vec::new(),
            patch_points: Vec::new(),
            overlaps: Vec::new(),
            ..*mesh
        })
    })
}

/// Room and objects, traced separately: the background behind an object is needed and must not depend on the objects.
struct CompositeScene<'a> {
    renders: RelitRadiance<'a>,
    room: Option<Rays>,
    objects: Option<Rays>,
    /// First face of the objects.
    first_object_face: u32,
    /// Eye of the camera.
    camera: Vec3,
    /// Eye of the capture, in mesh coordinates.
    eye: Option<DVec3>,
    backdrop: Option<Backdrop<'a>>,
}

/// Means over a pixel's samples.
#[derive(Clone, Copy, Default)]
struct PixelMeans {
    /// Background, and its part that no object hides.
    background: Vec3,
    visible_background: Vec3,
    change: Vec3,
    objects: Vec3,
    /// Share that shows an object.
    mask: f32,
    /// Shares that show something, and something that does not emit: background, composite.
    coverage: [f32; 2],
    dark: [f32; 2],
}

/// Hit of a view ray.
#[derive(Clone, Copy)]
struct SurfaceHit {
    face: u32,
    point: DVec3,
    texel: u32,
}

/// View ray with its hits: room, object in front of it.
struct ViewSample {
    direction: Vec3,
    hits: [Option<SurfaceHit>; 2],
}

impl CompositeScene<'_> {
    /// Renders all pixels with sparse samples, and with all samples where these hit more than one face or a lamp's
    /// border.
    fn render_pixels(&self, lens: &(impl Fn(f32, f32) -> Vec3 + Sync), [w, h]: [u32; 2]) -> Vec<PixelMeans> {
        let trace_samples = |k: usize, samples: &[usize]| -> Vec<ViewSample> {
            let (x, y) = ((k % w as usize) as f32, (k / w as usize) as f32);
            let part = |s: usize| (s as f32 + 0.5) / SAMPLES_PER_SIDE as f32;
            let sample = |s: &usize| {
                let right = 2.0 * (x + part(s % SAMPLES_PER_SIDE)) - w as f32;
                let down = 2.0 * (y + part(s / SAMPLES_PER_SIDE)) - h as f32;
                self.trace_sample(lens(right / h as f32, -down / h as f32))
            };
            samples.iter().map(sample).collect()
        };
        let all: [usize; SAMPLES_PER_PIXEL] = std::array::from_fn(|s| s);
        let rings = || [KnotCache::default(), KnotCache::default()];
        let pixels = (0..w as usize * h as usize)
            .into_par_iter()
            .map_init(rings, |rings, k| {
                let mut samples = trace_samples(k, &SPARSE_SAMPLES);
                if !samples
                    .iter()
                    .all(|sample| self.same_hits(sample.hits, samples[0].hits))
                {
                    samples = trace_samples(k, &all);
                }
                let mut pixel = PixelMeans::default();
                for sample in &samples {
                    self.add_sample(&mut pixel, rings, sample, 1.0 / samples.len() as f32);
                }
                pixel
            });
        pixels.collect()
    }

    /// Returns whether two rays hit the same faces with equal emission.
    fn same_hits(&self, a: [Option<SurfaceHit>; 2], b: [Option<SurfaceHit>; 2]) -> bool {
        a.iter().zip(b).all(|(a, b)| match (a, b) {
            (Some(a), Some(b)) => a.face == b.face && self.renders.emit_alike(a.texel, b.texel),
            (a, b) => a.is_none() && b.is_none(),
        })
    }

    /// Traces a view ray.
    fn trace_sample(&self, direction: Vec3) -> ViewSample {
        let origin = self.camera;
        let front = |rays: &Option<Rays>| rays.as_ref().and_then(|r| r.nearest_front(origin, direction));
        let (wall, object) = (front(&self.room), front(&self.objects));
        let reach = wall.map_or(f32::INFINITY, |(_, t)| t + CONTACT_DISTANCE);
        let object = object.filter(|(_, t)| *t <= reach);
        let met = |first: u32, (face, t): (u32, f32)| {
            let (face, point) = (first + face, (origin + direction * t).as_dvec3());
            SurfaceHit {
                face,
                point,
                texel: self.renders.texel_at(face, point),
            }
        };
        ViewSample {
            direction,
            hits: [
                wall.map(|hit| met(0, hit)),
                object.map(|hit| met(self.first_object_face, hit)),
            ],
        }
    }

    /// Adds a sample that is a `share` of the pixel.
    fn add_sample(&self, pixel: &mut PixelMeans, rings: &mut [KnotCache; 2], sample: &ViewSample, share: f32) {
        let ([of_room, of_objects], [wall, object]) = (rings, sample.hits);
        let wall = wall.map(|met| (self.renders.stencil_at(of_room, met.texel, met.point), met.point));
        let background = match (self.backdrop, &wall) {
            (Some(seen), wall) => {
                let point = wall.as_ref().map(|(_, point)| *point);
                Some(seen(self.backdrop_direction(point, sample.direction.as_dvec3())))
            }
            (None, Some((stencil, _))) => Some(self.renders.radiance_at(stencil)),
            (None, None) => None,
        };
        let light = wall.as_ref().is_some_and(|(s, _)| self.renders.is_light(s));
        let share_if = |counts: bool| if counts { share } else { 0.0 };
        let behind = [share_if(background.is_some()), share_if(background.is_some() && !light)];
        let seen = background.unwrap_or_default();
        pixel.background += share * seen;
        let [mut covered, mut dark] = behind;
        if let Some(met) = object {
            let stencil = self.renders.stencil_at(of_objects, met.texel, met.point);
            pixel.objects += share * self.renders.radiance_at(&stencil);
            pixel.mask += share;
            (covered, dark) = (share, share_if(!self.renders.is_light(&stencil)));
        } else {
            pixel.visible_background += share * seen;
            let change = |(s, _): (InterpolationStencil, DVec3)| self.renders.change_at(&s, seen);
            pixel.change += share * wall.map_or(Vec3::ZERO, change);
        }
        for (k, [all, unlit]) in [behind, [covered, dark]].into_iter().enumerate() {
            pixel.coverage[k] += all;
            pixel.dark[k] += unlit;
        }
    }

    /// Returns the direction from the capture's eye to a point of the room, or the view ray's own without either.
    fn backdrop_direction(&self, point: Option<DVec3>, ray: DVec3) -> DVec3 {
        let sight = point.zip(self.eye).map(|(point, eye)| point - eye);
        sight
            .and_then(DVec3::try_normalize)
            .unwrap_or_else(|| ray.normalize_or(DVec3::Z))
    }
}
