//! The open part of each texel: its area without the footprints of the bodies that stand on it.
//!
//! A footprint's outline consists of the lines in which faces meet the texel's plane, so a texel is
//! cut along these, and each piece is open or covered as a whole. Covered means that every ray over
//! its hemisphere meets a back first, or nothing past a front that touches; of fronts that lie on each
//! other the first of the file is the open one. A face that only hangs near by covers nothing: rays along the
//! plane pass beneath it.

use super::pair::Patch;
use crate::occlusion::occluders::Occluders;
use crate::occlusion::polygon::{Plane, Polygon};
use crate::occlusion::shaft::TOUCH;
use common::constants::{CONTACT, MISS, OUTLINE};
use common::escape::directions;
use common::intersect::intersect;
use common::mesh::{Mesh, Texel};
use common::rays::Rays;
use common::scene::Scene;
use common::texel;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Pieces at most: beyond, a piece is what its centroid is.
const PIECES: usize = 64;
/// Rays along the plane, evenly around.
const AROUND: u32 = 32;
/// They rise by this share of their way: what they miss beneath a face lets less than its square,
/// 1e−6, of a hemisphere's light in.
const RISE: f32 = 1e-3;

/// A texel as the matrix sees it.
#[derive(Clone, Debug)]
pub struct Element {
    /// Its face.
    pub face: u32,
    /// Area in squared mesh units.
    pub area: f64,
    /// The open share of the area.
    pub open: f64,
    /// The open part, in patches of at most four corners.
    pub patches: Vec<Patch>,
}

/// The elements of all texels, in the mesh's order.
pub fn elements(scene: &Scene, mesh: &Mesh, occluders: &Occluders, rays: &Rays) -> Vec<Element> {
    let all = Elements::new(scene, mesh, occluders, rays);
    mesh.texels.par_iter().map(|texel| all.of(texel)).collect()
}

/// The open share of each texel that can be seen; of one that bodies cover altogether, 1: nobody asks.
pub fn shares(scene: &Scene, mesh: &Mesh, occluders: &Occluders, rays: &Rays) -> Vec<f64> {
    let all = Elements::new(scene, mesh, occluders, rays);
    let share = |texel: &Texel| match all.of_cut(texel) {
        Some(element) if element.open > 0.0 => element.open,
        _ => 1.0,
    };
    mesh.texels.par_iter().map(share).collect()
}

/// The texels of which bodies cover a part, or all.
pub fn feet(scene: &Scene, mesh: &Mesh, occluders: &Occluders, rays: &Rays) -> Vec<(u32, Element)> {
    let all = Elements::new(scene, mesh, occluders, rays);
    let stands = |texel: &Texel| !all.covers[texel.face as usize].lines.is_empty();
    (0..mesh.texels.len() as u32)
        .into_par_iter()
        .filter(|k| stands(&mesh.texels[*k as usize]))
        .map(|k| (k, all.of(&mesh.texels[k as usize])))
        .filter(|(_, element)| element.open < 1.0)
        .collect()
}

/// What elements are made of.
struct Elements<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    occluders: &'a Occluders,
    rays: &'a Rays,
    directions: Vec<Vec3>,
    covers: Vec<Cover>,
}

impl<'a> Elements<'a> {
    fn new(scene: &'a Scene, mesh: &'a Mesh, occluders: &'a Occluders, rays: &'a Rays) -> Self {
        let mut directions = directions();
        directions.extend(along_the_plane());
        let covers = (0..mesh.faces.len()).into_par_iter();
        Self {
            scene,
            mesh,
            occluders,
            rays,
            directions,
            covers: covers.map(|f| Cover::new(occluders, f)).collect(),
        }
    }

    fn whole(&self, texel: &Texel) -> Patch {
        let (face, own) = (&self.scene.faces[texel.face as usize], texel.face as usize);
        let outline = texel::outline(face, self.mesh.faces[own].resolution, texel.index);
        let local = |p: &DVec3| self.mesh.local(*p);
        let corners: Vec<DVec3> = outline.corners().iter().map(local).collect();
        Patch::new(Polygon::new(&corners), self.occluders.faces[own].plane)
    }

    fn of(&self, texel: &Texel) -> Element {
        let whole = self.whole(texel);
        // A texel without area lies under an earlier face as a whole, or is a line.
        let mut element = Element {
            face: texel.face,
            area: if texel.area > 0.0 { whole.area } else { 0.0 },
            open: 0.0,
            patches: Vec::new(),
        };
        if element.area > 0.0 && whole.plane.normal != DVec3::ZERO {
            let cover = &self.covers[texel.face as usize];
            let covered = |patch: &Patch| {
                cover.covered(
                    self.mesh,
                    self.occluders,
                    self.rays,
                    &self.directions,
                    patch,
                )
            };
            element.find_open(whole, &cover.lines, covered);
        }
        element
    }

    /// The element, if a line cuts it.
    fn of_cut(&self, texel: &Texel) -> Option<Element> {
        let lines = &self.covers[texel.face as usize].lines;
        if lines.is_empty() {
            return None;
        }
        let whole = self.whole(texel).polygon;
        let cut = lines.iter().any(|line| line.cut(&whole).len() > 1);
        cut.then(|| self.of(texel))
    }
}

/// Directions that pass beneath what hangs near by, in a face's frame. A lamp half a millimetre
/// below a ceiling hides all others from a point a centimetre behind its edge.
fn along_the_plane() -> impl Iterator<Item = Vec3> {
    (0..AROUND).map(|k| {
        let (s, c) = ((k as f32 + 0.5) * TAU / AROUND as f32).sin_cos();
        Vec3::new(c, s, RISE)
    })
}

impl Element {
    fn find_open(&mut self, whole: Patch, lines: &[Line], covered: impl Fn(&Patch) -> bool) {
        let mut pieces = vec![whole.polygon];
        for line in lines {
            if pieces.len() >= PIECES {
                break;
            }
            pieces = pieces.iter().flat_map(|piece| line.cut(piece)).collect();
        }
        let mut open: Vec<Patch> = pieces
            .iter()
            .flat_map(Polygon::quads)
            .map(|[a, b, c, d]| {
                let corners = [a, b, c, d];
                let count = if c == d { 3 } else { 4 };
                Patch::new(Polygon::new(&corners[..count]), whole.plane)
            })
            .filter(|patch| patch.area > 0.0)
            .collect();
        let count = open.len();
        open.retain(|patch| !covered(patch));
        if open.len() == count {
            // Nothing stands here: what cut the texel was a sheet, or passed beside it.
            open = vec![whole];
        }
        self.open = (open.iter().map(|patch| patch.area).sum::<f64>() / whole.area).min(1.0);
        self.patches = open;
    }
}

/// Where other faces meet a face's plane.
struct Cover {
    face: usize,
    lines: Vec<Line>,
    /// Earlier fronts in the same plane.
    earlier: Vec<u32>,
}

impl Cover {
    fn new(occluders: &Occluders, face: usize) -> Self {
        let own = &occluders.faces[face];
        let mut cover = Self {
            face,
            lines: Vec::new(),
            earlier: Vec::new(),
        };
        // What lies beside the face cuts none of its texels.
        for k in occluders.beside(&own.polygon) {
            let (k, other) = (k as usize, &occluders.faces[k as usize]);
            let flat = own.plane.normal == DVec3::ZERO || other.plane.normal == DVec3::ZERO;
            if other.sheet == own.sheet || flat {
                continue;
            }
            let [low, high] = other.polygon.heights(&own.plane);
            if low > TOUCH || high < -TOUCH {
                continue;
            }
            let coplanar = low >= -TOUCH && high <= TOUCH;
            if coplanar && own.plane.normal.dot(other.plane.normal) > 0.0 {
                if k > face {
                    continue;
                }
                cover.earlier.push(k as u32);
            }
            if coplanar {
                let edges = other
                    .polygon
                    .edges()
                    .map(|[a, b]| Line::new(a, b, &own.plane));
                cover.lines.extend(edges.flatten());
            } else if high > TOUCH {
                cover.lines.extend(meeting(&other.polygon, &own.plane));
            }
        }
        cover
    }

    /// Whether light neither reaches nor leaves the patch.
    fn covered(
        &self,
        mesh: &Mesh,
        occluders: &Occluders,
        rays: &Rays,
        directions: &[Vec3],
        patch: &Patch,
    ) -> bool {
        let inside = |k: &u32| {
            let face = &occluders.faces[*k as usize];
            face.polygon
                .edges()
                .all(|[a, b]| face.plane.normal.cross(b - a).dot(patch.centre - a) > 0.0)
        };
        if self.earlier.iter().any(inside) {
            return true;
        }
        let face = &mesh.faces[self.face];
        let bitangent = face.normal.cross(face.tangent);
        let origin = patch.centre.as_vec3();
        directions.iter().all(|d| {
            let direction = face.tangent * d.x + bitangent * d.y + face.normal * d.z;
            dark(rays, face.sheet, origin, direction)
        })
    }
}

/// Whether the ray meets a back before any front. What touches its origin is passed over: it may be
/// the other side of a thin wall; a body has more faces behind it. But past a front that touches there
/// must be light: else it is what a body stands on, seen from under the body.
fn dark(rays: &Rays, sheet: u32, origin: Vec3, direction: Vec3) -> bool {
    let (mut front, mut back, mut touches) = (MISS, MISS, false);
    rays.along(origin, direction, |_, face| {
        let hit = intersect(face, origin, direction);
        if face.sheet == sheet || hit.inside < -OUTLINE || hit.t < -4.0 * CONTACT {
            return;
        }
        if (hit.t * hit.facing).abs() <= CONTACT {
            touches |= hit.facing < 0.0;
            return;
        }
        let nearest = if hit.facing < 0.0 {
            &mut front
        } else {
            &mut back
        };
        *nearest = nearest.min(hit.t);
    });
    (back < MISS && back <= front) || (touches && front == MISS)
}

/// The line in which a face meets a plane.
fn meeting(polygon: &Polygon, plane: &Plane) -> Option<Line> {
    let mut points: Vec<DVec3> = Vec::new();
    for [a, b] in polygon.edges() {
        let (h, k) = (plane.height(a), plane.height(b));
        if h.abs() <= TOUCH {
            points.push(a);
        } else if k.abs() > TOUCH && h * k < 0.0 {
            points.push(a + (b - a) * (h / (h - k)));
        }
    }
    let first = *points.first()?;
    let last = points
        .iter()
        .max_by(|a, b| a.distance(first).total_cmp(&b.distance(first)))?;
    Line::new(first, *last, plane)
}

/// A segment in a face's plane.
struct Line {
    start: DVec3,
    direction: DVec3,
    length: f64,
    /// Through the segment, perpendicular to the face.
    side: Plane,
}

impl Line {
    fn new(a: DVec3, b: DVec3, plane: &Plane) -> Option<Self> {
        let direction = (b - a).reject_from(plane.normal).try_normalize()?;
        Some(Self {
            start: a,
            direction,
            length: a.distance(b),
            side: Plane::through(a, plane.normal.cross(direction)),
        })
    }

    /// The piece, or its two halves where the segment passes through its inside.
    fn cut(&self, piece: &Polygon) -> Vec<Polygon> {
        let [low, high] = piece.heights(&self.side);
        if low >= -TOUCH || high <= TOUCH {
            return vec![*piece];
        }
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        for [a, b] in piece.edges() {
            let (h, k) = (self.side.height(a), self.side.height(b));
            if h * k <= 0.0 && h != k {
                let s = self.direction.dot(a + (b - a) * (h / (h - k)) - self.start);
                (from, to) = (from.min(s), to.max(s));
            }
        }
        if to.min(self.length) - from.max(0.0) <= TOUCH {
            return vec![*piece];
        }
        let (above, below) = piece.split(&self.side);
        [above, below]
            .into_iter()
            .filter(|half| !half.is_empty())
            .collect()
    }
}
