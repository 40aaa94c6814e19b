//! The solvers' form of a scene, in f32: faces, patches that shoot, and texels that receive (the elements
//! of the radiosity literature).
//!
//! The scene is moved to the origin and scaled by a power of two into [−1, 1]³. So the distance from the origin costs
//! no precision in f32, and a unit of length that differs by a power of two changes no bit of a result; another unit
//! changes roundings. Texels of one patch are contiguous: texel t of the solver is pixel `texels[t].pixel` of the atlas.

use crate::constants::FAR_DISTANCE_RADII;
use crate::error::{Error, Result};
pub use crate::face::MeshFace;
use crate::form_factor::Shooter;
use crate::overlap::{Overlaps, find_overlaps};
use crate::sampling;
use crate::scene::{Scene, Shape};
use crate::sheets::join_sheets;
use crate::texel::{self, PatchGrid};
pub use crate::texel::{Texel, TexelKind};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Maximum number of texels of a mesh: at 200 bytes each they need 13 GB.
pub const MAX_TEXELS: u64 = 1 << 26;

/// Half extents of solvable scenes, scene units: the squares of areas, fourth powers, stay normal numbers
/// in f64, also for faces of 1e−20 of the extent.
const SOLVABLE_HALF_EXTENTS: Range<f64> = 1e-50..1e50;

/// A patch, which shoots: one of the K×K parts of a face.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Its face.
    pub face: u32,
    /// Its first texel.
    pub first: u32,
    /// Number of its texels.
    pub count: u32,
    /// Share of its sample points that no body covers.
    pub open_share: f32,
    /// Share of its sample points that no body of the room covers: `open_share` without the objects.
    pub room_open_share: f32,
    /// Geometry.
    pub shooter: Shooter,
}

impl Patch {
    /// Returns the indices of its texels.
    pub fn texels(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// A sample point on a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchPoint {
    /// Position in the mesh's unit.
    pub position: Vec3,
    /// Area that it represents, over the mean.
    pub weight: f32,
    /// Body that covers it.
    pub cover: Cover,
}

/// Body that covers a point. Only an open point shines and receives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cover {
    /// No body.
    Open,
    /// An object that was put into the room.
    Object,
    /// A body of the room.
    Room,
}

/// Faces, patches and texels of a scene.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Faces, in the scene's order.
    pub faces: Vec<MeshFace>,
    /// Number of faces of the room; the faces after them are objects that were put into it. All faces
    /// where nothing is relit.
    pub room_faces: u32,
    /// Shooters, grouped by face.
    pub patches: Vec<Patch>,
    /// Receivers, grouped by patch.
    pub texels: Vec<Texel>,
    /// Sample points per patch.
    pub samples: u32,
    /// Sample points of all patches, `samples` per patch.
    pub patch_points: Vec<PatchPoint>,
    /// Atlas width and height in pixels.
    pub atlas: [u32; 2],
    /// Scene units per mesh unit, a power of two.
    pub unit: f64,
    /// The mesh's origin in the scene.
    pub origin: DVec3,
    /// Pairs of fronts that lie on each other (see [`crate::overlap`]).
    pub overlaps: Vec<[u32; 2]>,
}

impl Mesh {
    /// Makes a mesh with N×N texels and K×K patches on every face.
    ///
    /// Errors: as of [`Mesh::new`].
    pub fn uniform(scene: &Scene, texels: u32, patches: u32) -> Result<Self> {
        Self::new(scene, &vec![[texels, texels]; scene.faces.len()], patches)
    }

    /// Makes a mesh with `resolutions[f]` texels (equal sides on a triangle) and K×K patches on face f.
    ///
    /// Errors: a scene without faces or of an extent that cannot be solved; a resolution of 0, or of unequal sides on a
    /// triangle; more than [`MAX_TEXELS`] texels.
    pub fn new(scene: &Scene, resolutions: &[[u32; 2]], k: u32) -> Result<Self> {
        check_resolutions(scene, resolutions)?;
        Self::within_bounds(scene, resolutions, k, scene_bounds(scene)?)
    }

    /// Makes a mesh whose centre and half extent are `bounds`, though some faces lie beyond them.
    ///
    /// Errors: as of [`Mesh::new`], of resolutions.
    pub fn within_bounds(scene: &Scene, resolutions: &[[u32; 2]], k: u32, bounds: (DVec3, f64)) -> Result<Self> {
        check_resolutions(scene, resolutions)?;
        let (centre, unit) = bounds;
        let local = |p: DVec3| ((p - centre) / unit).as_vec3();
        let (rects, atlas) = pack_atlas(resolutions);
        let mut mesh = Self {
            faces: Vec::with_capacity(scene.faces.len()),
            room_faces: scene.faces.len() as u32,
            patches: Vec::new(),
            texels: Vec::with_capacity(resolutions.iter().map(|r| texel::texel_count(*r) as usize).sum()),
            samples: 1,
            patch_points: Vec::new(),
            atlas,
            unit,
            origin: centre,
            overlaps: Vec::new(),
        };
        for (f, face) in scene.faces.iter().enumerate() {
            let corners = face.corners.map(local);
            let face = MeshFace::new(face, f as u32, corners, resolutions[f], rects[f]);
            mesh.faces.push(face);
            mesh.add_texels(scene, f, k, &local);
        }
        if scene.is_painted() {
            mesh.average_paint(scene);
        }
        join_sheets(&mut mesh.faces);
        mesh.remove_overlapped();
        let centre = |patch: &Patch| PatchPoint {
            position: patch.shooter.centre,
            weight: 1.0,
            cover: Cover::Open,
        };
        mesh.patch_points = mesh.patches.iter().map(centre).collect();
        Ok(mesh)
    }

    /// Sets ρ and E of texels on painted faces to their means over the texel.
    fn average_paint(&mut self, scene: &Scene) {
        let faces = &self.faces;
        self.texels.par_iter_mut().for_each(|texel| {
            let face = &scene.faces[texel.face as usize];
            if face.paint.is_some() {
                let resolution = faces[texel.face as usize].resolution;
                let outline = texel::texel_outline(face, resolution, texel.index);
                [texel.reflectance, texel.emission] = face.mean_surface(outline.corners());
            }
        });
    }

    /// Removes the area of patches that lie wholly under fronts that precede theirs, so that they neither shoot nor
    /// receive. A face of no other patches loses its area too.
    fn remove_overlapped(&mut self) {
        let resolutions: Vec<[u32; 2]> = self.faces.iter().map(|face| face.resolution).collect();
        let first = texel::first_texels(&resolutions);
        let ranges: Vec<Range<usize>> = first.windows(2).map(|ends| ends[0]..ends[1]).collect();
        let Overlaps { pairs, covered } = find_overlaps(&self.faces, &self.texels, &ranges);
        self.overlaps = pairs;
        if self.overlaps.is_empty() {
            return;
        }
        let mut open = vec![false; self.faces.len()];
        for patch in &mut self.patches {
            let texels = patch.texels();
            if !covered[texels.clone()].iter().all(|covered| *covered) {
                open[patch.face as usize] = true;
                continue;
            }
            (patch.shooter.area, patch.shooter.normal) = (0.0, Vec3::ZERO);
            self.texels[texels].iter_mut().for_each(|t| t.area = 0.0);
        }
        for (face, open) in self.faces.iter_mut().zip(open) {
            if !open {
                face.remove_area();
            }
        }
    }

    fn add_texels(&mut self, scene: &Scene, f: usize, k: u32, local: &dyn Fn(DVec3) -> Vec3) {
        let (face, resolution, rect) = (&scene.faces[f], self.faces[f].resolution, self.faces[f].rect);
        let patches = PatchGrid::new(face.shape, resolution, k);
        let first_patch = self.patches.len();
        for c in 0..patches.patch_count() {
            let outline = patches.patch_outline(face, c);
            let (centre, corners) = (local(outline.centroid()), outline.padded_corners().map(local));
            self.patches.push(Patch {
                face: f as u32,
                first: 0,
                count: 0,
                open_share: 1.0,
                room_open_share: 1.0,
                shooter: Shooter {
                    centre,
                    normal: self.faces[f].normal,
                    area: (outline.area() / (self.unit * self.unit)) as f32,
                    radius: corners.map(|c| c.distance(centre)).into_iter().fold(0.0, f32::max),
                    corners,
                },
            });
        }
        let mut order: Vec<u32> = (0..texel::texel_count(resolution)).collect();
        order.sort_by_key(|index| patches.patch_of_texel(*index));
        for index in order {
            let patch = &mut self.patches[first_patch + patches.patch_of_texel(index) as usize];
            if patch.count == 0 {
                patch.first = self.texels.len() as u32;
            }
            patch.count += 1;
            let outline = texel::texel_outline(face, resolution, index);
            let (x, y) = (rect[0] + index % rect[2], rect[1] + index / rect[2]);
            let (place, kind) = texel_place(face.shape, resolution, index);
            self.texels.push(Texel {
                position: local(outline.centroid()),
                area: (outline.area() / (self.unit * self.unit)) as f32,
                face: f as u32,
                index,
                pixel: y * self.atlas[0] + x,
                lattice_corner: place,
                kind,
                reflectance: face.reflectance,
                emission: face.emission,
                sky: Vec3::ZERO,
            });
        }
    }

    /// Places `samples` sample points on each patch, all of them open. A single one stays at the centre, where
    /// [`Mesh::new`] places it.
    pub fn place_samples(&mut self, samples: u32) {
        self.samples = samples.max(1);
        if self.samples == 1 {
            return;
        }
        let samples = self.samples;
        let points = (0..).zip(&self.patches).flat_map(|(k, patch)| {
            (0..samples).map(move |s| {
                let point = sampling::outline_point(&patch.shooter.corners, sampling::patch_uv(s, k));
                PatchPoint {
                    position: point.truncate(),
                    weight: point.w,
                    cover: Cover::Open,
                }
            })
        });
        self.patch_points = points.collect();
    }

    /// Sets the cover of each sample point, and each patch's open shares: a patch shoots from its open points only.
    pub fn set_covers(&mut self, covers: &[Cover]) {
        for (point, cover) in self.patch_points.iter_mut().zip(covers) {
            point.cover = *cover;
        }
        let points = self.patch_points.chunks(self.samples as usize);
        for (patch, points) in self.patches.iter_mut().zip(points) {
            let (mut all, mut open, mut room_open) = (0.0, 0.0, 0.0);
            for PatchPoint { weight, cover, .. } in points {
                all += weight;
                if *cover != Cover::Room {
                    room_open += weight;
                }
                if *cover == Cover::Open {
                    open += weight;
                }
            }
            // A patch without area has no open share.
            let share = |part: f32| if all > 0.0 { part / all } else { 0.0 };
            (patch.open_share, patch.room_open_share) = (share(open), share(room_open));
        }
    }

    /// Returns the texels' indices in the order of files: face after face, within a face row-major.
    pub fn texels_in_face_order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.texels.len()).collect();
        order.sort_by_key(|k| (self.texels[*k].face, self.texels[*k].index));
        order
    }

    /// Returns for each face whether a front that precedes it lies on it.
    pub fn find_overlapped(&self) -> Vec<bool> {
        let mut overlapped = vec![false; self.faces.len()];
        for [_, under] in &self.overlaps {
            overlapped[*under as usize] = true;
        }
        overlapped
    }

    /// Returns whether a face belongs to an object that was put into the room.
    pub fn is_object(&self, face: u32) -> bool {
        face >= self.room_faces
    }

    /// Converts a point of the scene to the mesh's unit, without rounding to f32.
    pub fn local_point(&self, point: DVec3) -> DVec3 {
        (point - self.origin) / self.unit
    }

    /// Returns the scene area of a unit of mesh area.
    pub fn area_unit(&self) -> f64 {
        self.unit * self.unit
    }
}

fn texel_place(shape: Shape, [w, h]: [u32; 2], index: u32) -> ([u32; 2], TexelKind) {
    match shape {
        Shape::Quad => ([index % w, index / w], TexelKind::Quad),
        Shape::Triangle => {
            let (i, j, upright) = texel::triangle_position(h, index);
            (
                [i, j],
                if upright {
                    TexelKind::Upright
                } else {
                    TexelKind::Inverted
                },
            )
        }
    }
}

/// Returns the mean of values by their areas; 0 without area.
pub(crate) fn area_mean(values: impl Iterator<Item = (Vec3, f32)>) -> DVec3 {
    let (mut sum, mut all) = (DVec3::ZERO, 0.0);
    for (value, area) in values {
        sum += value.as_dvec3() * f64::from(area);
        all += f64::from(area);
    }
    if all > 0.0 { sum / all } else { DVec3::ZERO }
}

/// Returns the distance from the centre of `patch` beyond which a texel of `face` is [`is_far`]: six texel
/// radii from the patch.
///
/// [`is_far`]: crate::form_factor::is_far
pub fn far_distance(patch: &Patch, face: &MeshFace) -> f32 {
    patch.shooter.radius + FAR_DISTANCE_RADII * face.texel_radius
}

fn check_resolutions(scene: &Scene, resolutions: &[[u32; 2]]) -> Result<()> {
    if scene.faces.is_empty() {
        return Err(Error::bad_input(&scene.name, "", "has no faces"));
    }
    let mut texels = 0u64;
    for (face, [w, h]) in scene.faces.iter().zip(resolutions) {
        if *w == 0 || *h == 0 || (face.shape == Shape::Triangle && w != h) {
            return Err(Error::Usage(format!("{w}×{h} texels do not fit face {}", face.name)));
        }
        texels = texels.saturating_add(u64::from(*w) * u64::from(*h));
    }
    if texels > MAX_TEXELS {
        return Err(Error::Usage(format!(
            "{}: {} faces would have {texels} texels, and {MAX_TEXELS} is the maximum: use fewer texels per face",
            scene.name,
            scene.faces.len(),
        )));
    }
    Ok(())
}

/// Returns the centre and the power-of-two half extent of the faces.
///
/// Errors: an extent that cannot be solved.
pub(crate) fn scene_bounds(scene: &Scene) -> Result<(DVec3, f64)> {
    let [low, high] = scene.bounds();
    let half = (high - low).max_element() / 2.0;
    if !(half.is_normal() && SOLVABLE_HALF_EXTENTS.contains(&half)) {
        let [extent, start, end] =
            [half, SOLVABLE_HALF_EXTENTS.start, SOLVABLE_HALF_EXTENTS.end].map(|half| 2.0 * half);
        let message = format!(
            "extends over {extent:e}, which cannot be solved ({start:e} to {end:e} can): use another unit of length"
        );
        return Err(Error::bad_input(&scene.name, "", message));
    }
    Ok(((low + high) / 2.0, half.log2().ceil().exp2()))
}

/// Packs the faces' rectangles in rows, in face order, into an atlas about as high as wide. Returns the
/// rectangles and the atlas's size.
fn pack_atlas(resolutions: &[[u32; 2]]) -> (Vec<[u32; 4]>, [u32; 2]) {
    let area: u64 = resolutions.iter().map(|r| u64::from(texel::texel_count(*r))).sum();
    let widest = resolutions.iter().map(|r| r[0]).max().unwrap_or(1);
    let limit = widest.max((area as f64).sqrt().ceil() as u32);
    let (mut x, mut y, mut row, mut width) = (0, 0, 0, 0);
    let mut rects = Vec::with_capacity(resolutions.len());
    for [w, h] in resolutions {
        if x + w > limit {
            (x, y, row) = (0, y + row, 0);
        }
        rects.push([x, y, *w, *h]);
        x += w;
        row = row.max(*h);
        width = width.max(x);
    }
    (rects, [width, y + row])
}
