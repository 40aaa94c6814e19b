//! The open part of each texel: its area without the footprints of the bodies that stand on it.
//!
//! A footprint's outline consists of the lines in which faces meet the texel's plane, so a texel is cut along these, and
//! each piece is open or covered as a whole. Covered means that none of the rays over its hemisphere meets a front first,
//! and some meet a back, or nothing past a front that touches. Where a front and a back coincide, as where a body stands
//! against a wall, a ray decides nothing. Of fronts that lie on each other the first of the file is open. A face that hangs
//! close above the texel covers nothing: rays along the plane pass beneath it.

use super::exchange_area::SurfacePiece;
use crate::occlusion::occluders::Occluders;
use crate::occlusion::polygon::{ConvexPolygon, OrientedPlane};
use crate::occlusion::shaft::TOUCH_DISTANCE;
use common::constants::{CONTACT_DISTANCE, MISS_DISTANCE, OUTLINE_MARGIN};
use common::escape::escape_directions;
use common::intersect::intersect_face;
use common::mesh::{Mesh, Texel};
use common::polygon::distinct_corners;
use common::rays::Rays;
use common::scene::Scene;
use common::texel;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Maximum number of pieces per texel; further lines do not cut, and a piece is judged by its centroid.
const MAX_PIECES: usize = 64;
/// Number of rays along the plane, evenly around.
const GRAZING_DIRECTION_COUNT: u32 = 32;
/// Slope of these rays over the plane: a gap that they miss admits less than its square, 1e−6, of a hemisphere's light.
const GRAZING_SLOPE: f32 = 1e-3;
/// Distance behind a point at which a ray along the plane crosses a face that touches the point.
const MAX_TOUCH_DISTANCE: f32 = CONTACT_DISTANCE / GRAZING_SLOPE;

/// Stride over the directions, prime to their number and near the golden section of it.
const DIRECTION_STRIDE: usize = 653;

/// A texel with its open part.
#[derive(Clone, Debug)]
pub struct Element {
    /// Number of the face.
    pub face: u32,
    /// Area in squared mesh units.
    pub area: f64,
    /// Open share of the area.
    pub open: f64,
    /// The open part, in pieces of at most four corners.
    pub pieces: Vec<SurfacePiece>,
}

/// Returns the elements of all texels, in the mesh's order.
pub fn open_elements(scene: &Scene, mesh: &Mesh, occluders: &Occluders, rays: &Rays) -> Vec<Element> {
    let all = ElementBuilder::new(scene, mesh, occluders, rays);
    mesh.texels.par_iter().map(|texel| all.open_element(texel)).collect()
}

/// Returns the open share of each texel; 1 for a wholly covered texel, whose share has no effect.
pub fn nonzero_open_shares(scene: &Scene, mesh: &Mesh, occluders: &Occluders, rays: &Rays) -> Vec<f64> {
    let all = ElementBuilder::new(scene, mesh, occluders, rays);
    let share = |texel: &Texel| match all.cut_element(texel) {
        Some(element) if element.open > 0.0 => element.open,
        _ => 1.0,
    };
    mesh.texels.par_iter().map(share).collect()
}

/// Returns the texels that bodies cover partly or wholly.
pub fn covered_elements(scene: &Scene, mesh: &Mesh, occluders: &Occluders, rays: &Rays) -> Vec<(u32, Element)> {
    let all = ElementBuilder::new(scene, mesh, occluders, rays);
    let stands = |texel: &Texel| !all.covers[texel.face as usize].lines.is_empty();
    (0..mesh.texels.len() as u32)
        .into_par_iter()
        .filter(|k| stands(&mesh.texels[*k as usize]))
        .map(|k| (k, all.open_element(&mesh.texels[k as usize])))
        .filter(|(_, element)| element.open < 1.0)
        .collect()
}

/// Makes elements.
struct ElementBuilder<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    occluders: &'a Occluders,
    rays: &'a Rays,
    directions: Vec<Vec3>,
    covers: Vec<CoveringLines>,
}

impl<'a> ElementBuilder<'a> {
    fn new(scene: &'a Scene, mesh: &'a Mesh, occluders: &'a Occluders, rays: &'a Rays) -> Self {
        let all: Vec<Vec3> = escape_directions().into_iter().chain(grazing_directions()).collect();
        // One that meets a front decides: neighbours, which often meet the same face, follow late.
        let directions = (0..all.len()).map(|k| all[k * DIRECTION_STRIDE % all.len()]);
        let covers = (0..mesh.faces.len()).into_par_iter();
        Self {
            scene,
            mesh,
            occluders,
            rays,
            directions: directions.collect(),
            covers: covers.map(|f| CoveringLines::new(occluders, f)).collect(),
        }
    }

    fn whole_piece(&self, texel: &Texel) -> SurfacePiece {
        let (face, own) = (&self.scene.faces[texel.face as usize], texel.face as usize);
        let outline = texel::texel_outline(face, self.mesh.faces[own].resolution, texel.index);
        let local = |p: &DVec3| self.mesh.local_point(*p);
        let corners: Vec<DVec3> = outline.corners().iter().map(local).collect();
        SurfacePiece::new(ConvexPolygon::new(&corners), self.occluders.faces[own].plane)
    }

    fn open_element(&self, texel: &Texel) -> Element {
        let whole = self.whole_piece(texel);
        // A texel without area lies under an earlier face as a whole, or is a line.
        let mut element = Element {
            face: texel.face,
            area: if texel.area > 0.0 { whole.area } else { 0.0 },
            open: 0.0,
            pieces: Vec::new(),
        };
        if element.area > 0.0 && whole.plane.normal != DVec3::ZERO {
            let cover = &self.covers[texel.face as usize];
            let covered =
                |piece: &SurfacePiece| cover.is_covered(self.mesh, self.occluders, self.rays, &self.directions, piece);
            element.find_open(whole, &cover.lines, covered);
        }
        element
    }

    /// Returns the element of a texel that a line cuts; none otherwise.
    fn cut_element(&self, texel: &Texel) -> Option<Element> {
        let lines = &self.covers[texel.face as usize].lines;
        if lines.is_empty() {
            return None;
        }
        let whole = self.whole_piece(texel).polygon;
        let cut = lines.iter().any(|line| line.cuts(&whole));
        cut.then(|| self.open_element(texel))
    }
}

/// Returns directions that pass beneath close faces, in a face's frame. A lamp half a millimetre below a ceiling hides
/// all steeper directions from a point a centimetre behind its edge.
fn grazing_directions() -> impl Iterator<Item = Vec3> {
    (0..GRAZING_DIRECTION_COUNT).map(|k| {
        let (s, c) = ((k as f32 + 0.5) * TAU / GRAZING_DIRECTION_COUNT as f32).sin_cos();
        Vec3::new(c, s, GRAZING_SLOPE)
    })
}

impl Element {
    fn find_open(&mut self, whole: SurfacePiece, lines: &[CutLine], covered: impl Fn(&SurfacePiece) -> bool) {
        let lines: Vec<&CutLine> = lines.iter().filter(|line| line.cuts(&whole.polygon)).collect();
        if lines.is_empty() {
            if !covered(&whole) {
                (self.open, self.pieces) = (1.0, vec![whole]);
            }
            return;
        }
        let mut pieces = vec![whole.polygon];
        for line in lines {
            if pieces.len() >= MAX_PIECES {
                break;
            }
            pieces = pieces.iter().flat_map(|piece| line.cut_piece(piece)).collect();
        }
        let mut open: Vec<SurfacePiece> = pieces
            .iter()
            .flat_map(ConvexPolygon::quad_pieces)
            .map(|corners| SurfacePiece::new(ConvexPolygon::new(distinct_corners(&corners)), whole.plane))
            .filter(|piece| piece.area > 0.0)
            .collect();
        let count = open.len();
        open.retain(|piece| !covered(piece));
        if open.len() == count {
            // No body stands here: a sheet cut the texel, or a line passed beside a body.
            open = vec![whole];
        }
        self.open = (open.iter().map(|piece| piece.area).sum::<f64>() / whole.area).min(1.0);
        self.pieces = open;
    }
}

/// The lines in which other faces meet a face's plane.
struct CoveringLines {
    face: usize,
    lines: Vec<CutLine>,
    /// Earlier fronts in the same plane.
    earlier: Vec<u32>,
}

impl CoveringLines {
    fn new(occluders: &Occluders, face: usize) -> Self {
        let own = &occluders.faces[face];
        let mut cover = Self {
            face,
            lines: Vec::new(),
            earlier: Vec::new(),
        };
        // Faces whose boxes do not overlap cut none of its texels.
        for k in occluders.faces_near(&own.polygon) {
            let (k, other) = (k as usize, &occluders.faces[k as usize]);
            let flat = own.plane.normal == DVec3::ZERO || other.plane.normal == DVec3::ZERO;
            if other.sheet == own.sheet || flat {
                continue;
            }
            let [low, high] = other.polygon.height_range(&own.plane);
            if low > TOUCH_DISTANCE || high < -TOUCH_DISTANCE {
                continue;
            }
            let coplanar = low >= -TOUCH_DISTANCE && high <= TOUCH_DISTANCE;
            if coplanar && own.plane.normal.dot(other.plane.normal) > 0.0 {
                if k > face {
                    continue;
                }
                cover.earlier.push(k as u32);
            }
            if coplanar {
                let edges = other.polygon.edges().map(|[a, b]| CutLine::new(a, b, &own.plane));
                cover.lines.extend(edges.flatten());
            } else if high > TOUCH_DISTANCE {
                cover.lines.extend(intersection_line(&other.polygon, &own.plane));
            }
        }
        cover
    }

    /// Returns true if light neither reaches nor leaves the piece.
    fn is_covered(
        &self,
        mesh: &Mesh,
        occluders: &Occluders,
        rays: &Rays,
        directions: &[Vec3],
        piece: &SurfacePiece,
    ) -> bool {
        let inside = |k: &u32| {
            let face = &occluders.faces[*k as usize];
            face.polygon
                .edges()
                .all(|[a, b]| face.plane.normal.cross(b - a).dot(piece.centre - a) > 0.0)
        };
        if self.earlier.iter().any(inside) {
            return true;
        }
        let face = &mesh.faces[self.face];
        let origin = piece.centre.as_vec3();
        let mut backs = 0;
        for direction in directions {
            match first_met(rays, face.sheet, origin, face.direction_in_frame(*direction)) {
                FirstMet::Front => return false,
                FirstMet::Back => backs += 1,
                FirstMet::Both => (),
            }
        }
        backs > 0
    }
}

/// What a ray from a point of a surface meets first.
#[derive(Clone, Copy, PartialEq)]
enum FirstMet {
    Front,
    /// A back; or nothing past a front that touches the point, which then lies under a body on the body's ground.
    Back,
    /// A front and a back that coincide: the two sides of a sheet, or a body against a wall.
    Both,
}

/// Returns what the ray meets first. Faces that touch its origin are skipped: one may be the other side of a thin wall,
/// and a body has more faces behind it. A ray that meets nothing is open, as if it met a front.
fn first_met(rays: &Rays, sheet: u32, origin: Vec3, direction: Vec3) -> FirstMet {
    // The ray parameters of the nearest front and back, and by how much those of faces that coincide differ.
    let ([mut front, mut back], mut contact, mut touches) = ([MISS_DISTANCE; 2], 0.0, false);
    rays.visit_faces_along(origin, direction, |_, face| {
        let hit = intersect_face(face, origin, direction);
        let passed = face.sheet == sheet || hit.inside < -OUTLINE_MARGIN || hit.t < -MAX_TOUCH_DISTANCE;
        if !passed && (hit.t * hit.facing).abs() <= CONTACT_DISTANCE {
            touches |= hit.facing < 0.0;
        } else if !passed && hit.t >= -4.0 * CONTACT_DISTANCE {
            if hit.t < front.min(back) {
                contact = CONTACT_DISTANCE / hit.facing.abs();
            }
            let nearest = if hit.facing < 0.0 { &mut front } else { &mut back };
            *nearest = nearest.min(hit.t);
        }
        front.min(back) + contact
    });
    match front == MISS_DISTANCE {
        true if back < MISS_DISTANCE || touches => FirstMet::Back,
        false if front > back + contact => FirstMet::Back,
        false if front >= back - contact => FirstMet::Both,
        _ => FirstMet::Front,
    }
}

/// Returns the line in which a face meets a plane.
fn intersection_line(polygon: &ConvexPolygon, plane: &OrientedPlane) -> Option<CutLine> {
    let mut points: Vec<DVec3> = Vec::new();
    for [a, b] in polygon.edges() {
        let (h, k) = (plane.height_of(a), plane.height_of(b));
        if h.abs() <= TOUCH_DISTANCE {
            points.push(a);
        } else if k.abs() > TOUCH_DISTANCE && h * k < 0.0 {
            points.push(a + (b - a) * (h / (h - k)));
        }
    }
    let first = *points.first()?;
    let last = points
        .iter()
        .max_by(|a, b| a.distance(first).total_cmp(&b.distance(first)))?;
    CutLine::new(first, *last, plane)
}

/// A segment in a face's plane.
struct CutLine {
    start: DVec3,
    direction: DVec3,
    length: f64,
    /// Plane through the segment, perpendicular to the face.
    side: OrientedPlane,
}

impl CutLine {
    fn new(a: DVec3, b: DVec3, plane: &OrientedPlane) -> Option<Self> {
        let direction = (b - a).reject_from(plane.normal).try_normalize()?;
        Some(Self {
            start: a,
            direction,
            length: a.distance(b),
            side: OrientedPlane::through_point(a, plane.normal.cross(direction)),
        })
    }

    /// Returns whether the segment passes through the inside of a piece.
    fn cuts(&self, piece: &ConvexPolygon) -> bool {
        let [low, high] = piece.height_range(&self.side);
        if low >= -TOUCH_DISTANCE || high <= TOUCH_DISTANCE {
            return false;
        }
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        for [a, b] in piece.edges() {
            let (h, k) = (self.side.height_of(a), self.side.height_of(b));
            if h * k <= 0.0 && h != k {
                let s = self.direction.dot(a + (b - a) * (h / (h - k)) - self.start);
                (from, to) = (from.min(s), to.max(s));
            }
        }
        to.min(self.length) - from.max(0.0) > TOUCH_DISTANCE
    }

    /// Returns the piece, or its two halves if the segment passes through its inside.
    fn cut_piece(&self, piece: &ConvexPolygon) -> Vec<ConvexPolygon> {
        if !self.cuts(piece) {
            return vec![*piece];
        }
        let (above, below) = piece.split_by(&self.side);
        [above, below].into_iter().filter(|half| !half.is_empty()).collect()
    }
}
