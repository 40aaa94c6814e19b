//! The scene as the solvers see it, in f32: faces, cells that shoot (the patches of the radiosity
//! literature) and texels that receive (its elements).
//!
//! Moved to the origin and scaled by a power of two into [−1, 1]³, so that neither the unit of
//! length nor the distance from the origin changes a result. Texels of one cell are contiguous:
//! texel t of the solver is pixel `texels[t].pixel` of the atlas.

use crate::constants::FAR;
use crate::error::{Error, Result};
pub use crate::face::MeshFace;
use crate::form_factor::Shooter;
use crate::overlap::{Overlaps, overlaps};
use crate::sampling;
use crate::scene::{Face, Scene, Shape};
use crate::texel::{self, Cells};
pub use crate::texel::{Texel, TexelKind};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::Range;

/// More texels than this are refused: at 200 bytes each they would need 13 GB.
pub const MAX_TEXELS: u64 = 1 << 26;

/// Half extents that are solved: the squares of areas, fourth powers, stay normal numbers in f64, those
/// of faces of 1e−20 of the extent as well.
const EXTENTS: Range<f64> = 1e-50..1e50;

/// What shoots, a patch: a face, or one of its K×K cells.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Its face.
    pub face: u32,
    /// Its first texel.
    pub first: u32,
    /// How many texels follow.
    pub count: u32,
    /// The share of its points on which no body stands.
    pub open: f32,
    /// The same before the objects came.
    pub open_before: f32,
    /// Geometry.
    pub shooter: Shooter,
}

impl Cell {
    /// Its texels.
    pub fn texels(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// A point in which a cell is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where.
    pub position: Vec3,
    /// The area that it stands for over the mean.
    pub weight: f32,
    /// What stands on it.
    pub cover: Cover,
}

/// What stands on a point: it shines and receives only where it is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cover {
    /// Nothing.
    Open,
    /// An object put into the room.
    Object,
    /// A body of the room.
    Room,
}

/// Faces, cells and texels of a scene.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Faces, in the scene's order.
    pub faces: Vec<MeshFace>,
    /// The first so many faces are the room, the others objects put into it; all of them where
    /// nothing is relit.
    pub room: u32,
    /// Shooters, grouped by face.
    pub cells: Vec<Cell>,
    /// Receivers, grouped by cell.
    pub texels: Vec<Texel>,
    /// Points per cell.
    pub samples: u32,
    /// Where each cell is looked at, `samples` a cell.
    pub points: Vec<Point>,
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
    /// Every face with N×N texels and K×K cells.
    pub fn uniform(scene: &Scene, texels: u32, cells: u32) -> Result<Self> {
        Self::new(scene, &vec![[texels, texels]; scene.faces.len()], cells)
    }

    /// Face k with `resolutions[k]` texels (equal sides on a triangle) and K×K cells.
    pub fn new(scene: &Scene, resolutions: &[[u32; 2]], k: u32) -> Result<Self> {
        check(scene, resolutions)?;
        let (centre, unit) = bounds(scene)?;
        let local = |p: DVec3| ((p - centre) / unit).as_vec3();
        let (rects, atlas) = pack(resolutions);
        let mut mesh = Self {
            faces: Vec::with_capacity(scene.faces.len()),
            room: scene.faces.len() as u32,
            cells: Vec::new(),
            texels: Vec::with_capacity(resolutions.iter().map(|r| texel::count(*r) as usize).sum()),
            samples: 1,
            points: Vec::new(),
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
            mesh.paint(scene);
        }
        mesh.join_coincident();
        mesh.bury_overlapped();
        mesh.points = mesh
            .cells
            .iter()
            .map(|cell| Point {
                position: cell.shooter.centre,
                weight: 1.0,
                cover: Cover::Open,
            })
            .collect();
        Ok(mesh)
    }

    /// Each texel's ρ and E where they vary: the means over it.
    fn paint(&mut self, scene: &Scene) {
        let faces = &self.faces;
        self.texels.par_iter_mut().for_each(|texel| {
            let face = &scene.faces[texel.face as usize];
            if face.paint.is_some() {
                let resolution = faces[texel.face as usize].resolution;
                let outline = texel::outline(face, resolution, texel.index);
                [texel.reflectance, texel.emission] = face.over(outline.corners());
            }
        });
    }

    /// Two faces with the same corners and opposite fronts are the two sides of one sheet, as a
    /// thin wall is often drawn: neither hides the other.
    fn join_coincident(&mut self) {
        let mut first: HashMap<[[u32; 3]; 4], usize> = HashMap::new();
        for k in 0..self.faces.len() {
            let key = self.faces[k].place();
            let Some(j) = first.get(&key).copied() else {
                first.insert(key, k);
                continue;
            };
            let opposite = self.faces[j].normal.dot(self.faces[k].normal) < 0.0;
            if opposite && !self.faces[j].two_sided && !self.faces[k].two_sided {
                self.faces[k].sheet = self.faces[j].sheet;
                self.faces[j].two_sided = true;
                self.faces[k].two_sided = true;
            }
        }
    }

    /// Cells that lie under earlier fronts as a whole are as cells without area: neither lit nor
    /// lighting. A face of no others is as one without area.
    fn bury_overlapped(&mut self) {
        let ranges = self.face_texels();
        let Overlaps { pairs, covered } = overlaps(&self.faces, &self.texels, &ranges);
        self.overlaps = pairs;
        if self.overlaps.is_empty() {
            return;
        }
        let mut open = vec![false; self.faces.len()];
        for cell in &mut self.cells {
            let texels = cell.texels();
            if !covered[texels.clone()].iter().all(|covered| *covered) {
                open[cell.face as usize] = true;
                continue;
            }
            (cell.shooter.area, cell.shooter.normal) = (0.0, Vec3::ZERO);
            self.texels[texels].iter_mut().for_each(|t| t.area = 0.0);
        }
        for (face, open) in self.faces.iter_mut().zip(open) {
            if !open {
                face.bury();
            }
        }
    }

    /// Each face's texels.
    fn face_texels(&self) -> Vec<Range<usize>> {
        let mut ranges = vec![0..0; self.faces.len()];
        for (k, texel) in self.texels.iter().enumerate() {
            let range = &mut ranges[texel.face as usize];
            if range.end == 0 {
                range.start = k;
            }
            range.end = k + 1;
        }
        ranges
    }

    fn add_texels(&mut self, scene: &Scene, f: usize, k: u32, local: &dyn Fn(DVec3) -> Vec3) {
        let (face, resolution, rect) = (
            &scene.faces[f],
            self.faces[f].resolution,
            self.faces[f].rect,
        );
        let cells = Cells::new(face.shape, resolution, k);
        let first_cell = self.cells.len();
        for c in 0..cells.count() {
            let outline = cells.outline(face, c);
            let (centre, corners) = (local(outline.centroid()), outline.padded().map(local));
            self.cells.push(Cell {
                face: f as u32,
                first: 0,
                count: 0,
                open: 1.0,
                open_before: 1.0,
                shooter: Shooter {
                    centre,
                    normal: self.faces[f].normal,
                    area: (outline.area() / (self.unit * self.unit)) as f32,
                    radius: corners
                        .map(|c| c.distance(centre))
                        .into_iter()
                        .fold(0.0, f32::max),
                    corners,
                },
            });
        }
        let mut order: Vec<u32> = (0..texel::count(resolution)).collect();
        order.sort_by_key(|index| cells.of_texel(*index));
        for index in order {
            let cell = &mut self.cells[first_cell + cells.of_texel(index) as usize];
            if cell.count == 0 {
                cell.first = self.texels.len() as u32;
            }
            cell.count += 1;
            let outline = texel::outline(face, resolution, index);
            let (x, y) = (rect[0] + index % rect[2], rect[1] + index / rect[2]);
            let (place, kind) = place(face.shape, resolution, index);
            self.texels.push(Texel {
                position: local(outline.centroid()),
                area: (outline.area() / (self.unit * self.unit)) as f32,
                face: f as u32,
                index,
                pixel: y * self.atlas[0] + x,
                place,
                kind,
                reflectance: face.reflectance,
                emission: face.emission,
            });
        }
    }

    /// Looks at each cell in `samples` points instead of its centre, all of them open.
    pub fn sample(&mut self, samples: u32) {
        self.samples = samples.max(1);
        if self.samples == 1 {
            return;
        }
        let mut points = Vec::with_capacity(self.cells.len() * self.samples as usize);
        for (k, cell) in (0..).zip(&self.cells) {
            for s in 0..self.samples {
                let uv = sampling::cell_uv(s, k);
                let point = sampling::outline_point(&cell.shooter.corners, uv);
                points.push(Point {
                    position: point.truncate(),
                    weight: point.w,
                    cover: Cover::Open,
                });
            }
        }
        self.points = points;
    }

    /// What stands on each of the points. What a cell shoots leaves from where it is open, not from
    /// where a body stands on it.
    pub fn cover(&mut self, covers: &[Cover]) {
        for (point, cover) in self.points.iter_mut().zip(covers) {
            point.cover = *cover;
        }
        let points = self.points.chunks(self.samples as usize);
        for (cell, points) in self.cells.iter_mut().zip(points) {
            let (mut all, mut lit, mut lit_before) = (0.0, 0.0, 0.0);
            for Point { weight, cover, .. } in points {
                all += weight;
                if *cover != Cover::Room {
                    lit_before += weight;
                }
                if *cover == Cover::Open {
                    lit += weight;
                }
            }
            // A cell without area has no share of itself.
            let share = |part: f32| if all > 0.0 { part / all } else { 0.0 };
            (cell.open, cell.open_before) = (share(lit), share(lit_before));
        }
    }

    /// The texels face after face, within a face row-major in its rectangle, as files have them.
    pub fn in_face_order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.texels.len()).collect();
        order.sort_by_key(|k| (self.texels[*k].face, self.texels[*k].index));
        order
    }

    /// Whether a face belongs to an object put into the room.
    pub fn is_object(&self, face: u32) -> bool {
        face >= self.room
    }

    /// A point of the scene in the mesh's unit, not yet rounded to f32.
    pub fn local(&self, point: DVec3) -> DVec3 {
        (point - self.origin) / self.unit
    }

    /// Mesh areas × this are scene areas.
    pub fn area_unit(&self) -> f64 {
        self.unit * self.unit
    }
}

fn place(shape: Shape, [w, h]: [u32; 2], index: u32) -> ([u32; 2], TexelKind) {
    match shape {
        Shape::Quad => ([index % w, index / w], TexelKind::Quad),
        Shape::Triangle => {
            let (i, j, upright) = texel::triangle_position(h, index);
            let kind = if upright {
                TexelKind::Upright
            } else {
                TexelKind::Inverted
            };
            ([i, j], kind)
        }
    }
}

/// Beyond this distance from the centre of `cell` a texel of `face` is [`far`]: it may be six times
/// its radius from the cell.
///
/// [`far`]: crate::form_factor::far
pub fn reach(cell: &Cell, face: &MeshFace) -> f32 {
    cell.shooter.radius + FAR * face.texel_radius
}

fn check(scene: &Scene, resolutions: &[[u32; 2]]) -> Result<()> {
    if scene.faces.is_empty() {
        return Err(Error::input(&scene.name, "", "has no faces"));
    }
    let mut texels = 0u64;
    for (face, [w, h]) in scene.faces.iter().zip(resolutions) {
        if *w == 0 || *h == 0 || (face.shape == Shape::Triangle && w != h) {
            return Err(Error::Usage(format!(
                "{w}×{h} texels do not fit face {}",
                face.name
            )));
        }
        texels += u64::from(*w) * u64::from(*h);
    }
    if texels > MAX_TEXELS {
        return Err(Error::Usage(format!(
            "{}: {} faces would have {texels} texels, and {MAX_TEXELS} is the most: ask for fewer texels a face",
            scene.name,
            scene.faces.len(),
        )));
    }
    Ok(())
}

/// Centre and power-of-two half extent of the faces, if that can be solved.
pub(crate) fn bounds(scene: &Scene) -> Result<(DVec3, f64)> {
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for corner in scene.faces.iter().flat_map(Face::outline) {
        low = low.min(*corner);
        high = high.max(*corner);
    }
    let half = (high - low).max_element() / 2.0;
    if !(half.is_normal() && EXTENTS.contains(&half)) {
        return Err(Error::input(
            &scene.name,
            "",
            format!(
                "extends over {:e}, which cannot be solved ({:e} to {:e} can): use another unit of length",
                2.0 * half,
                EXTENTS.start,
                EXTENTS.end
            ),
        ));
    }
    Ok(((low + high) / 2.0, half.log2().ceil().exp2()))
}

/// Rectangles in rows, in face order, in an atlas about as high as wide.
fn pack(resolutions: &[[u32; 2]]) -> (Vec<[u32; 4]>, [u32; 2]) {
    let area: u64 = resolutions
        .iter()
        .map(|r| u64::from(texel::count(*r)))
        .sum();
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
