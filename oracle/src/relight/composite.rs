//! Differential rendering (Debevec 1998): what was captured, plus what the objects change in it,
//! and the objects themselves in front.

use super::surfaces::{Renders, surface};
use super::{Backdrop, Relit};
use crate::show::view::camera::Camera;
use crate::show::view::surface::{Ring, Stencil};
use common::mesh::Mesh;
use common::rays::Rays;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// View rays per side of a pixel: silhouettes have 17 steps.
const SUPERSAMPLING: u32 = 4;
/// An object's front that lies in a wall's plane is in front of it (mesh units).
const CONTACT: f32 = 1e-5;

/// Pictures of linear radiance, W/m²/sr, row by row from the upper left.
///
/// Colours are sums over a pixel's samples divided by their number: where some meet nothing, the
/// colour is premultiplied by its coverage, as EXR wants it.
#[derive(Clone, Debug, Default)]
pub struct Composite {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The room as it was captured, without objects.
    pub background: Vec<Vec3>,
    /// The room relit with the objects in it. Below 0 it is black: where the picture behind is
    /// darker than the room's model, a shadow can take more than is there (see `negative`).
    pub composite: Vec<Vec3>,
    /// What the objects change in the room, of what is seen; 0 where an object hides it.
    pub change: Vec<Vec3>,
    /// The objects alone, premultiplied by `mask`.
    pub objects: Vec<Vec3>,
    /// The share of each pixel that shows an object, 0…1.
    pub mask: Vec<f32>,
    /// The share that shows a surface or the backdrop: of the background, of the composite.
    pub coverage: [Vec<f32>; 2],
    /// The share that shows no light either, lamp or glowing object: what an exposure is chosen from.
    pub dark: [Vec<f32>; 2],
    /// Pixels of the composite that were below 0 in some channel.
    pub negative: usize,
}

/// Looks through `camera` (in the mesh's coordinates) with `size` = (w, h) pixels.
///
/// Backs are looked through. With a `backdrop` the background is what the eye saw of each point
/// of the room, so that the photograph stays on the walls when the camera leaves the eye; without
/// an eye it is taken for infinitely far. Rays that meet nothing show the backdrop in their own
/// direction, or are transparent.
pub fn composite(
    relit: &Relit,
    camera: &Camera,
    size: [u32; 2],
    backdrop: Option<Backdrop>,
) -> Composite {
    let surface = surface(relit);
    let lens = camera.lens();
    let scene = Seen {
        renders: Renders::over(relit, &surface, backdrop.is_some()),
        room: rays(relit.mesh, 0..relit.room),
        objects: rays(relit.mesh, relit.room..relit.mesh.faces.len()),
        first: relit.room as u32,
        camera: camera.eye,
        eye: relit.eye.map(|eye| relit.mesh.local(eye)),
        backdrop,
    };
    let count = u64::from(size[0]) * u64::from(size[1]);
    let pixels = (0..count).into_par_iter();
    let pixels: Vec<Pixel> = pixels.map(|k| scene.pixel(&lens, size, k)).collect();
    gather(size, &pixels)
}

/// The rays' faces; none if there are no faces with an area.
fn rays(mesh: &Mesh, faces: Range<usize>) -> Option<Rays> {
    let faces = mesh.faces.get(faces)?.to_vec();
    let any = faces.iter().any(|face| face.normal != Vec3::ZERO);
    any.then(|| {
        Rays::new(&Mesh {
            faces,
            cells: Vec::new(),
            texels: Vec::new(),
            points: Vec::new(),
            overlaps: Vec::new(),
            ..*mesh
        })
    })
}

/// Room and objects apart: what is behind an object is needed, too, and nothing of the background
/// may hang on the objects.
struct Seen<'a> {
    renders: Renders<'a>,
    room: Option<Rays>,
    objects: Option<Rays>,
    /// The objects' first face.
    first: u32,
    /// The camera's eye.
    camera: Vec3,
    /// The capture's eye in the mesh's coordinates.
    eye: Option<DVec3>,
    backdrop: Option<Backdrop<'a>>,
}

/// Sums over a pixel's samples.
#[derive(Clone, Copy, Default)]
struct Pixel {
    /// All of the background, and what no object hides of it.
    background: Vec3,
    open: Vec3,
    change: Vec3,
    objects: Vec3,
    /// Samples that show an object; a background; either; either of these two, but no light.
    hidden: u32,
    behind: u32,
    any: u32,
    dark: [u32; 2],
}

impl Seen<'_> {
    fn pixel(&self, lens: impl Fn(f32, f32) -> Vec3, [w, h]: [u32; 2], k: u64) -> Pixel {
        let (x, y) = ((k % u64::from(w)) as f32, (k / u64::from(w)) as f32);
        let (width, height) = (w as f32, h as f32);
        let part = |s: u32| (s as f32 + 0.5) / SUPERSAMPLING as f32;
        let (mut pixel, mut rings) = (Pixel::default(), [Ring::default(), Ring::default()]);
        for s in 0..SUPERSAMPLING * SUPERSAMPLING {
            let right = 2.0 * (x + part(s % SUPERSAMPLING)) - width;
            let down = 2.0 * (y + part(s / SUPERSAMPLING)) - height;
            self.sample(&mut pixel, &mut rings, lens(right / height, -down / height));
        }
        pixel
    }

    /// The `rings` are those of the room and of the objects.
    fn sample(&self, pixel: &mut Pixel, rings: &mut [Ring; 2], direction: Vec3) {
        let origin = self.camera;
        let front = |rays: &Option<Rays>| rays.as_ref().and_then(|r| r.front(origin, direction));
        let (wall, object) = (front(&self.room), front(&self.objects));
        let reach = wall.map_or(f32::INFINITY, |(_, t)| t + CONTACT);
        let object = object.filter(|(_, t)| *t <= reach);
        let point = |t: f32| (origin + direction * t).as_dvec3();
        let [of_room, of_objects] = rings;
        let wall = wall.map(|(face, t)| {
            let stencil = self.renders.stencil(of_room, face, point(t));
            (stencil, point(t))
        });

        let background = match (self.backdrop, &wall) {
            (Some(seen), wall) => {
                let point = wall.as_ref().map(|(_, point)| *point);
                Some(seen(self.towards(point, direction.as_dvec3())))
            }
            (None, Some((stencil, _))) => Some(self.renders.radiance(stencil)),
            (None, None) => None,
        };
        let light = wall.as_ref().is_some_and(|(s, _)| self.renders.is_light(s));
        if let Some(background) = background {
            pixel.background += background;
            pixel.behind += 1;
            pixel.dark[0] += u32::from(!light);
        }
        if let Some((face, t)) = object {
            let stencil = self
                .renders
                .stencil(of_objects, self.first + face, point(t));
            pixel.objects += self.renders.radiance(&stencil);
            pixel.hidden += 1;
            pixel.dark[1] += u32::from(!self.renders.is_light(&stencil));
        } else {
            pixel.open += background.unwrap_or_default();
            pixel.dark[1] += u32::from(background.is_some() && !light);
            let seen = background.unwrap_or_default();
            let change = |(s, _): (Stencil, DVec3)| self.renders.change(&s, seen);
            pixel.change += wall.map_or(Vec3::ZERO, change);
        }
        pixel.any += u32::from(object.is_some() || background.is_some());
    }

    /// The direction in which the eye saw a point of the room; the view ray's own without either.
    fn towards(&self, point: Option<DVec3>, ray: DVec3) -> DVec3 {
        let sight = point.zip(self.eye).map(|(point, eye)| point - eye);
        sight
            .and_then(DVec3::try_normalize)
            .unwrap_or_else(|| ray.normalize_or(DVec3::Z))
    }
}

fn gather(size: [u32; 2], pixels: &[Pixel]) -> Composite {
    let samples = (SUPERSAMPLING * SUPERSAMPLING) as f32;
    let colours = |of: fn(&Pixel) -> Vec3| pixels.iter().map(|p| of(p) / samples).collect();
    let shares = |of: fn(&Pixel) -> u32| pixels.iter().map(|p| of(p) as f32 / samples).collect();
    // Without objects nothing but zeros is added: bit for bit the background.
    let composite: Vec<Vec3> = colours(|p| p.open + p.change + p.objects);
    Composite {
        size,
        background: colours(|p| p.background),
        negative: composite.iter().filter(|c| c.min_element() < 0.0).count(),
        composite: composite.into_iter().map(|c| c.max(Vec3::ZERO)).collect(),
        change: colours(|p| p.change),
        objects: colours(|p| p.objects),
        mask: shares(|p| p.hidden),
        coverage: [shares(|p| p.behind), shares(|p| p.any)],
        dark: [shares(|p| p.dark[0]), shares(|p| p.dark[1])],
    }
}
