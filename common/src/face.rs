//! A face as the solvers see it: its planes, its frame, and its place in the atlas, in f32.

use crate::constants::{CONTACT, OUTLINE};
use crate::scene::Face;
use glam::{DVec3, Vec3, Vec4};

/// A face in the mesh's unit.
#[derive(Clone, Copy, Debug)]
pub struct MeshFace {
    /// Corners, counter-clockwise from the front; a triangle repeats its third.
    pub corners: [Vec3; 4],
    /// Unit front normal; zero on a face without area.
    pub normal: Vec3,
    /// Unit vector along the first edge; the frame is (tangent, normal × tangent, normal).
    pub tangent: Vec3,
    /// Front plane: unit normal and its product with a corner.
    pub plane: Vec4,
    /// Planes through the edges, inward: a point p of the plane is inside where m·p ≥ w for all
    /// four; (0, 0) for the edge that a triangle lacks.
    pub edges: [Vec4; 4],
    /// Faces at the same place are one sheet, named by the first; else the face itself.
    pub sheet: u32,
    /// Whether the sheet has two faces.
    pub two_sided: bool,
    /// Texels W×H (N×N on a triangle).
    pub resolution: [u32; 2],
    /// No point of a texel is farther from its centre.
    pub texel_radius: f32,
    /// The face's rectangle in the atlas: x, y, w, h in pixels.
    pub rect: [u32; 4],
}

impl MeshFace {
    /// Face number `index` of a scene, with its corners in the mesh's unit and its place in the atlas.
    pub(crate) fn new(
        face: &Face,
        index: u32,
        corners: [Vec3; 4],
        resolution: [u32; 2],
        rect: [u32; 4],
    ) -> Self {
        let normal = face.vector_area().normalize_or_zero();
        let along = longest_edge(face.outline());
        Self {
            corners,
            normal: normal.as_vec3(),
            plane: plane(normal, corners[0]),
            edges: edges(&corners, normal),
            sheet: face.partner.map_or(index, |partner| partner.min(index)),
            tangent: along
                .reject_from(normal.try_normalize().unwrap_or(DVec3::Z))
                .normalize_or_zero()
                .as_vec3(),
            two_sided: face.partner.is_some(),
            resolution,
            texel_radius: texel_radius(&corners, resolution),
            rect,
        }
    }

    /// Its corners in an order of their own, to tell faces at the same place by.
    pub fn place(&self) -> [[u32; 3]; 4] {
        // −0 is 0.
        let bits = |c: Vec3| (c + Vec3::ZERO).to_array().map(f32::to_bits);
        let mut corners = self.corners.map(bits);
        corners.sort_unstable();
        corners
    }

    /// Whether a point lies on it, its outline included.
    pub fn holds(&self, point: Vec3) -> bool {
        let above = |plane: &Vec4| plane.truncate().dot(point) - plane.w;
        above(&self.plane).abs() <= CONTACT && self.edges.iter().all(|edge| above(edge) >= -OUTLINE)
    }

    /// Whether some of its front can see some of the other's where nothing is between.
    pub fn faces(&self, other: &Self) -> bool {
        let above = |plane: Vec4, p: &Vec3| plane.truncate().dot(*p) > plane.w;
        let sees = |a: &Self, b: &Self| b.corners.iter().any(|p| above(a.plane, p));
        !self.is_buried() && !other.is_buried() && sees(self, other) && sees(other, self)
    }

    /// Whether it has no area, or lies under earlier fronts as a whole.
    pub fn is_buried(&self) -> bool {
        self.normal == Vec3::ZERO
    }

    /// Makes it one without area, which neither shoots, receives nor blocks.
    pub(crate) fn bury(&mut self) {
        self.corners = [self.corners[0]; 4];
        (self.normal, self.plane) = (Vec3::ZERO, Vec4::ZERO);
        (self.edges, self.texel_radius) = ([Vec4::ZERO; 4], 0.0);
    }
}

fn plane(normal: DVec3, point: Vec3) -> Vec4 {
    normal.extend(normal.dot(point.as_dvec3())).as_vec4()
}

fn edges(corners: &[Vec3; 4], normal: DVec3) -> [Vec4; 4] {
    std::array::from_fn(|k| {
        let along = (corners[(k + 1) % 4] - corners[k]).as_dvec3();
        plane(normal.cross(along).normalize_or_zero(), corners[k])
    })
}

/// A frame must not hang on a short first edge.
fn longest_edge(outline: &[DVec3]) -> DVec3 {
    let n = outline.len();
    (0..n)
        .map(|k| outline[(k + 1) % n] - outline[k])
        .reduce(|a, b| {
            if b.length_squared() > a.length_squared() {
                b
            } else {
                a
            }
        })
        .unwrap_or(DVec3::X)
}

/// Half the diagonal of the largest texel, at most; a triangle's are all alike.
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
