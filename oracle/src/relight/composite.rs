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
const SUPERSAMPLING: usize = 4;
/// All of a pixel.
const SAMPLES: usize = SUPERSAMPLING * SUPERSAMPLING;
/// One of each row and column: their mean is that of all where light is linear.
pub const FEW: [usize; SUPERSAMPLING] = [1, 7, 8, 14];
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
    gather(size, &scene.pixels(&lens, size))
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

/// A face that a view ray meets.
#[derive(Clone, Copy)]
struct Met {
    face: u32,
    point: DVec3,
    texel: u32,
}

/// What a view ray meets, of the room and of the objects before it.
struct Look {
    direction: Vec3,
    met: [Option<Met>; 2],
}

impl Seen<'_> {
    /// A few samples of each pixel, and all where these, or those of the pixels around, meet more than one face or a
    /// lamp's border.
    fn pixels(&self, lens: &(impl Fn(f32, f32) -> Vec3 + Sync), [w, h]: [u32; 2]) -> Vec<Pixel> {
        let looks = |k: usize, samples: &[usize]| -> Vec<Look> {
            let (x, y) = ((k % w as usize) as f32, (k / w as usize) as f32);
            let part = |s: usize| (s as f32 + 0.5) / SUPERSAMPLING as f32;
            let look = |s: &usize| {
                let right = 2.0 * (x + part(s % SUPERSAMPLING)) - w as f32;
                let down = 2.0 * (y + part(s / SUPERSAMPLING)) - h as f32;
                self.look(lens(right / h as f32, -down / h as f32))
            };
            samples.iter().map(look).collect()
        };
        let all: [usize; SAMPLES] = std::array::from_fn(|s| s);
        let count = w as usize * h as usize;
        let rings = || [Ring::default(), Ring::default()];
        let few = (0..count).into_par_iter().map_init(rings, |rings, k| {
            let looks = looks(k, &FEW);
            let first = looks[0].met;
            let even = looks.iter().all(|look| self.alike(look.met, first));
            (even.then_some(first), self.pixel(rings, &looks))
        });
        let few: Vec<(Option<[Option<Met>; 2]>, Pixel)> = few.collect();
        let pixels = (0..count).into_par_iter().map_init(rings, |rings, k| {
            let (met, pixel) = few[k];
            let even = |met: [Option<Met>; 2]| {
                around(k, [w as usize, h as usize])
                    .all(|other| few[other].0.is_some_and(|other| self.alike(met, other)))
            };
            match met.is_some_and(even) {
                true => pixel,
                false => self.pixel(rings, &looks(k, &all)),
            }
        });
        pixels.collect()
    }

    /// Whether two rays meet the same faces, where these emit the same.
    fn alike(&self, a: [Option<Met>; 2], b: [Option<Met>; 2]) -> bool {
        a.iter().zip(b).all(|(a, b)| match (a, b) {
            (Some(a), Some(b)) => a.face == b.face && self.renders.emit_alike(a.texel, b.texel),
            (a, b) => a.is_none() && b.is_none(),
        })
    }

    /// The samples stand for all. The `rings` are those of the room and of the objects.
    fn pixel(&self, rings: &mut [Ring; 2], looks: &[Look]) -> Pixel {
        let mut pixel = Pixel::default();
        for look in looks {
            self.add(&mut pixel, rings, look, (SAMPLES / looks.len()) as u32);
        }
        pixel
    }

    fn look(&self, direction: Vec3) -> Look {
        let origin = self.camera;
        let front = |rays: &Option<Rays>| rays.as_ref().and_then(|r| r.front(origin, direction));
        let (wall, object) = (front(&self.room), front(&self.objects));
        let reach = wall.map_or(f32::INFINITY, |(_, t)| t + CONTACT);
        let object = object.filter(|(_, t)| *t <= reach);
        let met = |first: u32, (face, t): (u32, f32)| {
            let (face, point) = (first + face, (origin + direction * t).as_dvec3());
            Met {
                face,
                point,
                texel: self.renders.texel(face, point),
            }
        };
        Look {
            direction,
            met: [
                wall.map(|hit| met(0, hit)),
                object.map(|hit| met(self.first, hit)),
            ],
        }
    }

    /// Adds a sample that stands for `times`.
    fn add(&self, pixel: &mut Pixel, rings: &mut [Ring; 2], look: &Look, times: u32) {
        let ([of_room, of_objects], [wall, object]) = (rings, look.met);
        let share = times as f32;
        let wall = wall.map(|met| {
            let stencil = self.renders.stencil(of_room, met.texel, met.point);
            (stencil, met.point)
        });
        let background = match (self.backdrop, &wall) {
            (Some(seen), wall) => {
                let point = wall.as_ref().map(|(_, point)| *point);
                Some(seen(self.towards(point, look.direction.as_dvec3())))
            }
            (None, Some((stencil, _))) => Some(self.renders.radiance(stencil)),
            (None, None) => None,
        };
        let light = wall.as_ref().is_some_and(|(s, _)| self.renders.is_light(s));
        let dark = |is_dark: bool| if is_dark { times } else { 0 };
        if let Some(background) = background {
            pixel.background += share * background;
            pixel.behind += times;
            pixel.dark[0] += dark(!light);
        }
        if let Some(met) = object {
            let stencil = self.renders.stencil(of_objects, met.texel, met.point);
            pixel.objects += share * self.renders.radiance(&stencil);
            pixel.hidden += times;
            pixel.dark[1] += dark(!self.renders.is_light(&stencil));
        } else {
            pixel.open += share * background.unwrap_or_default();
            pixel.dark[1] += dark(background.is_some() && !light);
            let seen = background.unwrap_or_default();
            let change = |(s, _): (Stencil, DVec3)| self.renders.change(&s, seen);
            pixel.change += share * wall.map_or(Vec3::ZERO, change);
        }
        pixel.any += dark(object.is_some() || background.is_some());
    }

    /// The direction in which the eye saw a point of the room; the view ray's own without either.
    fn towards(&self, point: Option<DVec3>, ray: DVec3) -> DVec3 {
        let sight = point.zip(self.eye).map(|(point, eye)| point - eye);
        sight
            .and_then(DVec3::try_normalize)
            .unwrap_or_else(|| ray.normalize_or(DVec3::Z))
    }
}

/// The pixels around pixel `k`.
fn around(k: usize, [w, h]: [usize; 2]) -> impl Iterator<Item = usize> {
    let (x, y) = (k % w, k / w);
    let (columns, rows) = (
        x.saturating_sub(1)..(x + 2).min(w),
        y.saturating_sub(1)..(y + 2).min(h),
    );
    rows.flat_map(move |y| columns.clone().map(move |x| y * w + x))
}

fn gather(size: [u32; 2], pixels: &[Pixel]) -> Composite {
    let samples = SAMPLES as f32;
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
