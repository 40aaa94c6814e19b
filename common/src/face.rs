//! A face as the solvers see it: its planes, its frame, and its place in the atlas, in f32.

use crate::constants::{CONTACT_DISTANCE, OUTLINE_MARGIN};
use crate::scene::Face;
use glam::{DVec3, Vec3, Vec4};

/// A face in the mesh's unit.
#[derive(Clone, Copy, Debug)]
pub struct MeshFace {
    /// Number in the scene.
    pub number: u32,
    /// True if it emits light.
    pub emits: bool,
    /// Corners, counter-clockwise from the front; a triangle repeats its third.
    pub corners: [Vec3; 4],
    /// Unit front normal; zero on a face without area.
    pub normal: Vec3,
    /// Unit vector along the first edge; the frame is (tangent, normal × tangent, normal).
    pub tangent: Vec3,
    /// Front plane: unit normal and its product with a corner.
    pub plane: Vec4,
    /// Planes through the edges, inward: a point p of the face's plane is inside if m·p ≥ w for all
    /// four; (0, 0) for the edge that a triangle lacks.
    pub edges: [Vec4; 4],
    /// Sheet that the face is a side of, or part of one: the lowest index of its faces.
    pub sheet: u32,
    /// True if the sheet has two sides.
    pub two_sided: bool,
    /// Texels W×H (N×N on a triangle).
    pub resolution: [u32; 2],
    /// Upper bound on the distance of a texel's points from its centre.
    pub texel_radius: f32,
    /// The face's rectangle in the atlas: x, y, w, h in pixels.
    pub rect: [u32; 4],
}

impl MeshFace {
    /// Makes face `index` of a scene from its corners in the mesh's unit and its rectangle in the atlas.
    pub(crate) fn new(face: &Face, index: u32, corners: [Vec3; 4], resolution: [u32; 2], rect: [u32; 4]) -> Self {
        let normal = face.vector_area().normalize_or_zero();
        let along = longest_edge(face.outline());
        let upwards = normal.try_normalize().unwrap_or(DVec3::Z);
        Self {
            number: index,
            emits: face.emission != Vec3::ZERO,
            corners,
            normal: normal.as_vec3(),
            plane: plane_through(normal, corners[0]),
            edges: edge_planes(&corners, normal),
            sheet: face.partner.map_or(index, |partner| partner.min(index)),
            tangent: along.reject_from(upwards).normalize_or_zero().as_vec3(),
            two_sided: face.partner.is_some(),
            resolution,
            texel_radius: texel_radius(&corners, resolution),
            rect,
        }
    }

    /// Returns the direction with the components `d` along the tangent, the bitangent and the normal.
    #[inline(always)]
    pub fn direction_in_frame(&self, d: Vec3) -> Vec3 {
        let bitangent = self.normal.cross(self.tangent);
        self.tangent * d.x + bitangent * d.y + self.normal * d.z
    }

    /// Returns whether the face is a triangle.
    pub fn is_triangle(&self) -> bool {
        self.corners[2] == self.corners[3]
    }

    /// Returns the corners' bits in ascending order: equal for faces with the same corners, whichever is the first.
    pub fn sorted_corner_bits(&self) -> [CornerBits; 4] {
        let mut corners = self.corners.map(corner_bits);
        // The corner that a triangle repeats comes last in any order.
        let count = if self.is_triangle() { 3 } else { 4 };
        corners[..count].sort_unstable();
        corners[3] = corners[count - 1];
        corners
    }

    /// Returns whether a point lies on the face, outline included.
    pub fn holds_point(&self, point: Vec3) -> bool {
        let above = |plane: &Vec4| plane.truncate().dot(point) - plane.w;
        above(&self.plane).abs() <= CONTACT_DISTANCE && self.edges.iter().all(|edge| above(edge) >= -OUTLINE_MARGIN)
    }

    /// Returns whether, of two fronts that lie on each other, this one is met: one that emits light before one that does not,
    /// as lamps are often modelled flush with a ceiling; else the first in the file.
    pub fn precedes(&self, other: &Self) -> bool {
        self.precedence() < other.precedence()
    }

    /// Returns the key by which faces [precede](Self::precedes) each other.
    pub(crate) fn precedence(&self) -> (bool, u32) {
        (!self.emits, self.number)
    }

    /// Returns whether some of its front faces some of the other's front.
    pub fn can_face(&self, other: &Self) -> bool {
        let above = |plane: Vec4, p: &Vec3| plane.truncate().dot(*p) > plane.w;
        let sees = |a: &Self, b: &Self| b.corners.iter().any(|p| above(a.plane, p));
        !self.is_buried() && !other.is_buried() && sees(self, other) && sees(other, self)
    }

    /// Returns whether the face has no area, or lies wholly under fronts that precede it.
    pub fn is_buried(&self) -> bool {
        self.normal == Vec3::ZERO
    }

    /// Removes the face's area, so that it neither shoots, receives nor occludes.
    pub(crate) fn remove_area(&mut self) {
        self.corners = [self.corners[0]; 4];
        (self.normal, self.plane) = (Vec3::ZERO, Vec4::ZERO);
        (self.edges, self.texel_radius) = ([Vec4::ZERO; 4], 0.0);
    }
}

/// Bits of a corner's coordinates.
pub(crate) type CornerBits = [u32; 3];

/// Returns the bits of a corner's coordinates: equal if these are.
pub(crate) fn corner_bits(corner: Vec3) -> CornerBits {
    // −0 is 0.
    (corner + Vec3::ZERO).to_array().map(f32::to_bits)
}

/// Returns the longest edge: a frame along a short first edge would be imprecise.
fn longest_edge(outline: &[DVec3]) -> DVec3 {
    let edges = outline.iter().zip(outline.iter().cycle().skip(1)).map(|(a, b)| *b - *a);
    let longest = edges.reduce(|a, b| if b.length_squared() > a.length_squared() { b } else { a });
    longest.unwrap_or(DVec3::X)
}

fn plane_through(normal: DVec3, point: Vec3) -> Vec4 {
    normal.extend(normal.dot(point.as_dvec3())).as_vec4()
}

fn edge_planes(corners: &[Vec3; 4], normal: DVec3) -> [Vec4; 4] {
    std::array::from_fn(|k| {
        let along = (corners[(k + 1) % 4] - corners[k]).as_dvec3();
        plane_through(normal.cross(along).normalize_or_zero(), corners[k])
    })
}

/// Returns an upper bound on half the diagonal of a texel; a triangle's texels are all alike.
fn texel_radius([a, b, c, d]: &[Vec3; 4], [w, h]: [u32; 2]) -> f32 {
    if c == d {
        let centre = (a + b + c) / 3.0;
        let radii = [a, b, c].map(|corner| corner.distance(centre));
        return radii.into_iter().fold(0.0, f32::max) / w as f32;
    }
    let along = a.distance(*b).max(d.distance(*c)) / w as f32;
    let across = a.distance(*d).max(b.distance(*c)) / h as f32;
    0.5 * (along + across)
}
