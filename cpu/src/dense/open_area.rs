//! The open part of each texel: its area without the footprints of the bodies that stand on it.
//!
//! A footprint's outline consists of the lines in which faces meet the texel's plane, so a texel is cut along these, and
//! each piece is open or covered as a whole. Covered means that none of the rays over its hemisphere meets a front first,
//! and some meet a back, or nothing past a front that touches. A piece is like its neighbour if no line parts them: then a
//! few rays suffice. Where a front and a back coincide, as where a body stands against a wall, a ray decides nothing. A
//! piece under a front that [precedes](common::mesh::MeshFace::precedes) the texel's is covered. A face that hangs close
//! above the texel covers nothing: rays along the plane pass beneath it.

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
use std::collections::HashSet;
use std::f32::consts::TAU;

/// Maximum number of pieces per texel; further lines do not cut, and a piece is judged by its centroid.
const MAX_PIECES: usize = 64;
/// Number of rays along the plane, evenly around.
const GRAZING_DIRECTION_COUNT: u32 = 32;
/// Slope of these rays over the plane: a gap that they miss admits less than its square, 1e−6, of a hemisphere's light.
const GRAZING_SLOPE: f32 = 1e-3;
/// Distance behind a point at which a ray along the plane crosses a face that touches the point.
const MAX_TOUCH_DISTANCE: f32 = CONTACT_DISTANCE / GRAZING_SLOPE;

/// Number of neighbouring texels that are judged in turn.
const RUN_LENGTH: usize = 64;
/// Stride over the steep directions in which rays show that a piece is like its neighbour: 64 of them, in turn others.
const NEIGHBOUR_STRIDE: usize = 16;
/// Stride over the steep directions, prime to their number and near the golden section of it.
const DIRECTION_STRIDE: usize = 633;

/// A texel with its open part.
#[derive(Clone, Debug)]
pub struct Element {
    /// Number of the face.
    pub face: u32,
    /// Area in squared mesh units.
    pub area: f64,
    /// Open share of the area.
    pub open: f64,
    /// Share of the area under fronts that precede the face, which hide it from no one: it receives and shines nothing.
    pub under_fronts: f64,
    /// The open part, in pieces of at most four corners.
    pub pieces: Vec<SurfacePiece>,
}

/// Returns the elements of all texels, in the mesh's order.
pub fn open_elements(scene: &Scene, mesh: &Mesh, occluders: &Occluders, rays: &Rays) -> Vec<Element> {
    let all = ElementBuilder::new(scene, mesh, occluders, rays);
    all.filter_texels(|_, texel, judged| Some(all.open_element(texel, judged)))
}

/// Returns the open share of each texel; 1 for a wholly covered texel, whose share has no effect.
pub fn nonzero_open_shares(scene: &Scene, mesh: &Mesh, occluders: &Occluders, rays: &Rays) -> Vec<f64> {
    let all = ElementBuilder::new(scene, mesh, occluders, rays);
    all.filter_texels(|_, texel, judged| match all.cut_element(texel, judged) {
        Some(element) if element.open > 0.0 => Some(element.open),
        _ => Some(1.0),
    })
}

/// Returns the texels that bodies cover partly or wholly.
pub fn covered_elements(scene: &Scene, mesh: &Mesh, occluders: &Occluders, rays: &Rays) -> Vec<(u32, Element)> {
    let all = ElementBuilder::new(scene, mesh, occluders, rays);
    all.filter_texels(|k, texel, judged| {
        let stands = !all.covers[texel.face as usize].lines.is_empty();
        let element = stands.then(|| all.open_element(texel, judged));
        Some((k, element.filter(|element| element.open < 1.0)?))
    })
}

/// A piece that rays in all directions have judged: none of them met a front first.
struct JudgedPiece {
    face: u32,
    centre: DVec3,
    covered: bool,
    /// Number of pieces that were judged like it.
    followers: usize,
}

/// Makes elements.
struct ElementBuilder<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    occluders: &'a Occluders,
    rays: &'a Rays,
    /// Directions over the hemisphere.
    steep: Vec<Vec3>,
    /// Directions along the plane.
    grazing: Vec<Vec3>,
    covers: Vec<CoveringLines>,
}

impl<'a> ElementBuilder<'a> {
    fn new(scene: &'a Scene, mesh: &'a Mesh, occluders: &'a Occluders, rays: &'a Rays) -> Self {
        let directions = escape_directions();
        // One that meets a front decides: neighbours, which often meet the same face, follow late.
        let steep = (0..directions.len()).map(|k| directions[k * DIRECTION_STRIDE % directions.len()]);
        let covers = (0..mesh.faces.len()).into_par_iter();
        Self {
            scene,
            mesh,
            occluders,
            rays,
            steep: steep.collect(),
            grazing: grazing_directions().collect(),
            covers: covers.map(|f| CoveringLines::new(mesh, occluders, f)).collect(),
        }
    }

    /// Returns what `find` finds at the texels, in their order. It keeps the last piece that rays in all directions have
    /// judged.
    fn filter_texels<T: Send>(
        &self,
        find: impl Fn(u32, &Texel, &mut Option<JudgedPiece>) -> Option<T> + Sync,
    ) -> Vec<T> {
        let find = &find;
        let runs = self.mesh.texels.par_chunks(RUN_LENGTH).enumerate();
        let found = runs.flat_map_iter(|(run, texels)| {
            let mut judged = None;
            let numbered = ((run * RUN_LENGTH) as u32..).zip(texels);
            numbered.filter_map(move |(k, texel)| find(k, texel, &mut judged))
        });
        found.collect()
    }

    fn whole_piece(&self, texel: &Texel) -> SurfacePiece {
        let (face, own) = (&self.scene.faces[texel.face as usize], texel.face as usize);
        let outline = texel::texel_outline(face, self.mesh.faces[own].resolution, texel.index);
        let local = |p: &DVec3| self.mesh.local_point(*p);
        let corners: Vec<DVec3> = outline.corners().iter().map(local).collect();
        SurfacePiece::new(ConvexPolygon::new(&corners), self.occluders.faces[own].plane)
    }

    fn open_element(&self, texel: &Texel, judged: &mut Option<JudgedPiece>) -> Element {
        let whole = self.whole_piece(texel);
        // A texel without area lies under preceding fronts as a whole, or is a line.
        let mut element = Element {
            face: texel.face,
            area: if texel.area > 0.0 { whole.area } else { 0.0 },
            open: 0.0,
            under_fronts: if texel.area > 0.0 { 0.0 } else { 1.0 },
            pieces: Vec::new(),
        };
        if element.area > 0.0 && whole.plane.normal != DVec3::ZERO {
            let cover = &self.covers[texel.face as usize];
            let under_fronts = |piece: &SurfacePiece| cover.is_under_fronts(self.occluders, piece);
            let under_body = |piece: &SurfacePiece| self.is_under_body(cover, piece, judged);
            element.find_open(whole, &cover.lines, under_fronts, under_body);
        }
        element
    }

    /// Returns the element of a texel that a line cuts; none otherwise.
    fn cut_element(&self, texel: &Texel, judged: &mut Option<JudgedPiece>) -> Option<Element> {
        let lines = &self.covers[texel.face as usize].lines;
        if lines.is_empty() {
            return None;
        }
        let whole = self.whole_piece(texel).polygon;
        let cut = lines.iter().any(|line| line.cuts(&whole));
        cut.then(|| self.open_element(texel, judged))
    }

    /// Returns true if light neither reaches nor leaves the piece, which lies under no preceding front.
    fn is_under_body(&self, cover: &CoveringLines, piece: &SurfacePiece, judged: &mut Option<JudgedPiece>) -> bool {
        let (face, origin) = (cover.face as u32, piece.centre.as_vec3());
        let count_backs = |directions: &mut dyn Iterator<Item = &Vec3>| self.count_backs(face, origin, directions);
        let is_near = |near: &JudgedPiece| {
            let divides = |line: &CutLine| line.divides(near.centre, piece.centre);
            near.face == face && !cover.lines.iter().any(divides)
        };
        if let Some(near) = judged.as_mut().filter(|near| is_near(near)) {
            near.followers += 1;
            let first = near.followers % NEIGHBOUR_STRIDE;
            let some = self.steep.iter().skip(first).step_by(NEIGHBOUR_STRIDE);
            match count_backs(&mut some.chain(&self.grazing)) {
                Some(backs) if near.covered || backs == 0 => return near.covered,
                Some(_) => (),
                None => {
                    *judged = None;
                    return false;
                }
            }
        }
        let Some(backs) = count_backs(&mut self.steep.iter().chain(&self.grazing)) else {
            return false;
        };
        *judged = Some(JudgedPiece {
            face,
            centre: piece.centre,
            covered: backs > 0,
            followers: 0,
        });
        backs > 0
    }

    /// Returns how many of the rays meet a back first; none if one meets a front.
    fn count_backs(&self, face: u32, origin: Vec3, directions: &mut dyn Iterator<Item = &Vec3>) -> Option<u32> {
        let face = &self.mesh.faces[face as usize];
        let mut backs = 0;
        for direction in directions {
            match first_met(self.rays, face.sheet, origin, face.direction_in_frame(*direction)) {
                FirstMet::Front => return None,
                FirstMet::Back => backs += 1,
                FirstMet::Both => (),
            }
        }
        Some(backs)
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
    fn find_open(
        &mut self,
        whole: SurfacePiece,
        lines: &[CutLine],
        under_fronts: impl Fn(&SurfacePiece) -> bool,
        mut under_body: impl FnMut(&SurfacePiece) -> bool,
    ) {
        let lines: Vec<&CutLine> = lines.iter().filter(|line| line.cuts(&whole.polygon)).collect();
        let pieces = cut_piece(&whole, &lines);
        let count = pieces.len();
        let share = |pieces: &[SurfacePiece]| {
            let area: f64 = pieces.iter().map(|piece| piece.area).sum();
            (area / whole.area).min(1.0)
        };
        let (hidden, mut open): (Vec<_>, Vec<_>) = pieces.into_iter().partition(under_fronts);
        self.under_fronts = share(&hidden);
        open.retain(|piece| !under_body(piece));
        if open.len() == count {
            // No body stands here: a sheet cut the texel, or a line passed beside a body.
            open = vec![whole];
        }
        self.open = share(&open);
        self.pieces = open;
    }
}

/// Returns the parts, of at most four corners, into which `lines` cut a piece.
fn cut_piece(whole: &SurfacePiece, lines: &[&CutLine]) -> Vec<SurfacePiece> {
    if lines.is_empty() {
        return vec![*whole];
    }
    let mut pieces = vec![whole.polygon];
    for line in lines {
        if pieces.len() >= MAX_PIECES {
            break;
        }
        pieces = pieces.iter().flat_map(|piece| line.cut_piece(piece)).collect();
    }
    let quads = pieces.iter().flat_map(ConvexPolygon::quad_pieces);
    quads
        .map(|corners| SurfacePiece::new(ConvexPolygon::new(distinct_corners(&corners)), whole.plane))
        .filter(|piece| piece.area > 0.0)
        .collect()
}

/// The lines in which other faces meet a face's plane.
struct CoveringLines {
    face: usize,
    lines: Vec<CutLine>,
    /// Fronts in the same plane that precede the face.
    preceding: Vec<u32>,
}

impl CoveringLines {
    fn new(mesh: &Mesh, occluders: &Occluders, face: usize) -> Self {
        let own = &occluders.faces[face];
        // Edges of faces in the plane, and whether these face as it does.
        let mut edges: Vec<([DVec3; 2], bool)> = Vec::new();
        let mut cover = Self {
            face,
            lines: Vec::new(),
            preceding: Vec::new(),
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
            let faces_alike = own.plane.normal.dot(other.plane.normal) > 0.0;
            if coplanar && faces_alike {
                if mesh.faces[face].precedes(&mesh.faces[k]) {
                    continue;
                }
                cover.preceding.push(k as u32);
            }
            if coplanar {
                edges.extend(other.polygon.edges().map(|edge| (edge, faces_alike)));
            } else if high > TOUCH_DISTANCE {
                cover.lines.extend(intersection_line(&other.polygon, &own.plane));
            }
        }
        // A footprint goes on from face to face of one side of the plane; where it ends between them another face stands.
        let key = |[a, b]: [DVec3; 2], faces_alike: bool| ([a, b].map(|p| p.to_array().map(f64::to_bits)), faces_alike);
        let known: HashSet<_> = edges.iter().map(|(edge, alike)| key(*edge, *alike)).collect();
        let outlines = edges
            .into_iter()
            .filter(|([a, b], alike)| !known.contains(&key([*b, *a], *alike)));
        let lines = outlines.filter_map(|([a, b], _)| CutLine::new(a, b, &own.plane));
        cover.lines.extend(lines);
        cover
    }

    /// Returns true if the piece lies under a preceding front of its plane.
    fn is_under_fronts(&self, occluders: &Occluders, piece: &SurfacePiece) -> bool {
        self.preceding.iter().any(|k| {
            let face = &occluders.faces[*k as usize];
            face.polygon
                .edges()
                .all(|[a, b]| face.plane.normal.cross(b - a).dot(piece.centre - a) > 0.0)
        })
    }
}

/// What a ray from a point of a surface meets first.
#[derive(Clone, Copy, PartialEq)]
enum FirstMet {
    Front,
    /// A back; or nothing past a front that touches the point, which then lies under a body on the body's ground.
    Back,
    /// A front and a back of different sheets that coincide: the two sides of a wall, or a body against a wall.
    Both,
}

/// Returns what the ray meets first. Faces that touch its origin are skipped: one may be the other side of a thin wall,
/// and a body has more faces behind it. Of a sheet's two sides the ray meets only the front. A ray that meets nothing is
/// open, as if it met a front.
fn first_met(rays: &Rays, sheet: u32, origin: Vec3, direction: Vec3) -> FirstMet {
    // The ray parameters of the nearest front and back, and by how much those of faces that coincide differ.
    let ([mut front, mut back], mut contact, mut touches) = ([MISS_DISTANCE; 2], 0.0, false);
    rays.visit_faces_along(origin, direction, |_, face| {
        let hit = intersect_face(face, origin, direction);
        let behind = face.two_sided && hit.facing >= 0.0;
        let passed = face.sheet == sheet || behind || hit.inside < -OUTLINE_MARGIN || hit.t < -MAX_TOUCH_DISTANCE;
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

    /// Returns whether the segment may pass between two points of the face.
    fn divides(&self, a: DVec3, b: DVec3) -> bool {
        let [h, k] = [a, b].map(|point| self.side.height_of(point));
        if h.min(k) > TOUCH_DISTANCE || h.max(k) < -TOUCH_DISTANCE {
            return false;
        }
        // Where the way between the points crosses the line, or all of it if a point touches the line.
        let crossed = (h * k < 0.0).then(|| a + (b - a) * (h / (h - k)));
        let [from, to] =
            [crossed.unwrap_or(a), crossed.unwrap_or(b)].map(|point| self.direction.dot(point - self.start));
        from.max(to) > -TOUCH_DISTANCE && from.min(to) < self.length + TOUCH_DISTANCE
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

#[cfg(test)]
mod tests {
    use super::{CutLine, ElementBuilder};
    use crate::occlusion::occluders::Occluders;
    use crate::occlusion::polygon::OrientedPlane;
    use common::mesh::Mesh;
    use common::rays::Rays;
    use common::scene::{Face, Scene};
    use glam::{DVec3, Vec3};

    /// Returns the faces of a box, inwards or outwards.
    fn box_faces(low: DVec3, high: DVec3, inwards: bool) -> Vec<Face> {
        let sides = [0, 1, 2]
            .into_iter()
            .flat_map(|axis| [false, true].map(|top| (axis, top)));
        let face = |(axis, top): (usize, bool)| {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            let mut corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]| {
                let mut corner = if top { high } else { low };
                corner[u] = [low, high][i][u];
                corner[v] = [low, high][j][v];
                corner
            });
            if top == inwards {
                corners.reverse();
            }
            Face::quad("side", corners, Vec3::ZERO, Vec3::splat(0.5))
        };
        sides.map(face).collect()
    }

    /// Returns the open shares of 24 × 24 texels on each face, judged after their neighbours, which must be as open as if
    /// each were judged alone.
    fn open_shares(faces: Vec<Face>) -> Vec<f64> {
        let scene = Scene {
            faces,
            ..Scene::default()
        };
        let mesh = Mesh::uniform(&scene, 24, 1).expect("a mesh");
        let (occluders, rays) = (Occluders::new(&scene, &mesh), Rays::new(&mesh));
        let all = ElementBuilder::new(&scene, &mesh, &occluders, &rays);
        let in_turn = all.filter_texels(|_, texel, judged| Some(all.open_element(texel, judged).open));
        let alone = mesh.texels.iter().map(|texel| all.open_element(texel, &mut None).open);
        assert_eq!(in_turn, alone.collect::<Vec<f64>>());
        in_turn
    }

    /// Two boxes that share a line on the floor of a room, whose walls are a sheet below and cut otherwise outside, so that no
    /// ray to them decides.
    #[test]
    fn neighbours_change_no_texel() {
        let mut faces = box_faces(DVec3::ZERO, DVec3::splat(2.0), true);
        faces.extend(box_faces(DVec3::ZERO, DVec3::new(2.0, 2.0, 1.0), false));
        faces.extend(box_faces(DVec3::new(0.0, 0.0, 1.0), DVec3::splat(2.0), false));
        let stands = |x: [f64; 2], z| box_faces(DVec3::new(x[0], 0.3, 0.0), DVec3::new(x[1], 1.1, z), false);
        faces.extend(stands([0.27, 1.0], 0.5));
        faces.extend(stands([1.0, 1.7], 0.7));
        let shares = open_shares(faces);
        let count = |holds: fn(f64) -> bool| shares.iter().filter(|open| holds(**open)).count();
        let [covered, parts, open] = [count(|o| o == 0.0), count(|o| o > 0.0 && o < 1.0), count(|o| o == 1.0)];
        assert!(covered > 100 && parts > 20 && open > 1000, "{covered}, {parts}, {open}");
    }

    /// A face that hangs so close above the floor that only rays along the floor pass beneath it, near its edges: no line
    /// parts what they reach from what they do not.
    #[test]
    fn neighbours_change_no_texel_under_a_close_face() {
        let square = |low: f64, high: f64, z: f64| {
            let corners = [[low, low], [high, low], [high, high], [low, high]].map(|[x, y]| DVec3::new(x, y, z));
            Face::quad("square", corners, Vec3::ZERO, Vec3::splat(0.5))
        };
        let shares = open_shares(vec![square(0.0, 1.0, 0.0), square(0.2, 0.8, 1e-4)]);
        let covered = shares[..24 * 24].iter().filter(|open| **open == 0.0).count();
        assert!(covered > 50 && covered < 150, "{covered}");
    }

    /// The foot of a box that stands on a floor covers the same, as one face or as four around its centre.
    #[test]
    fn faces_of_a_foot_part_no_texel() {
        let find_floor = |divide: bool| {
            let mut faces = box_faces(DVec3::ZERO, DVec3::splat(2.0), true);
            let floor = faces
                .iter()
                .position(|face| face.corners.iter().all(|corner| corner.z == 0.0));
            let mut body = box_faces(DVec3::new(0.31, 0.47, 0.0), DVec3::new(1.2, 1.3, 0.8), false);
            if divide {
                let foot = body
                    .iter()
                    .position(|face| face.corners.iter().all(|corner| corner.z == 0.0));
                let corners = body.remove(foot.expect("a foot")).corners;
                let centre = corners.iter().sum::<DVec3>() / 4.0;
                body.extend((0..4).map(|k| {
                    let part = [corners[k], corners[(k + 1) % 4], centre, centre];
                    Face::quad("foot", part, Vec3::ZERO, Vec3::splat(0.5))
                }));
            }
            faces.extend(body);
            let scene = Scene {
                faces,
                ..Scene::default()
            };
            let mesh = Mesh::uniform(&scene, 24, 1).expect("a mesh");
            let (occluders, rays) = (Occluders::new(&scene, &mesh), Rays::new(&mesh));
            let all = ElementBuilder::new(&scene, &mesh, &occluders, &rays);
            let floor = floor.expect("a floor");
            let own = mesh.texels.iter().filter(|texel| texel.face as usize == floor);
            let shares: Vec<f64> = own.map(|texel| all.open_element(texel, &mut None).open).collect();
            (all.covers[floor].lines.len(), shares)
        };
        let (whole, parts) = (find_floor(false), find_floor(true));
        assert!(whole.1.iter().any(|open| *open > 0.0 && *open < 1.0));
        assert_eq!(whole, parts);
    }

    /// A segment from (1, 0) to (3, 0) of the plane z = 0.
    #[test]
    fn segments_divide_points() {
        let point = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let plane = OrientedPlane::through_point(DVec3::ZERO, DVec3::Z);
        let line = CutLine::new(point(1.0, 0.0), point(3.0, 0.0), &plane).expect("a line");
        for (a, b, divided) in [
            // Across it, beyond its end, and on one side.
            (point(2.0, 1.0), point(2.0, -1.0), true),
            (point(2.0, 1.0), point(5.0, -1.0), false),
            (point(2.0, 1.0), point(2.5, 0.5), false),
            // Along it: over all of it, up to it, and beyond it.
            (point(0.0, 0.0), point(4.0, 0.0), true),
            (point(0.0, 0.0), point(1.5, 0.0), true),
            (point(4.0, 0.0), point(5.0, 0.0), false),
            // A point that touches it.
            (point(2.0, 0.0), point(2.0, 1.0), true),
        ] {
            assert_eq!(line.divides(a, b), divided, "{a} and {b}");
            assert_eq!(line.divides(b, a), divided, "{b} and {a}");
        }
    }
}
