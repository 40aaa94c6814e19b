//! Visibility by rays between points of the shooter and points of the texel, through an obvhs BVH of faces.

use crate::bvh::Bvh;
use crate::constants::{CONTACT_DISTANCE, MISS_DISTANCE, OUTLINE_MARGIN, RAY_REACH, SEGMENT_END_FRACTION};
use crate::intersect::{Crossing, intersect_face, touches_plane};
use crate::mesh::{Mesh, MeshFace};
use glam::Vec3;
use obvhs::ray::{Ray, RayHit};
use std::cell::Cell;

/// Coordinate beyond which a point lies outside the scene, which is two units wide: it is the sky's.
const MAX_SCENE_COORDINATE: f32 = 2.0;

/// Index of no face.
pub const NO_FACE: u32 = u32::MAX;

/// Ray caster over the faces of a mesh.
pub struct Rays {
    bvh: Bvh,
    faces: Vec<MeshFace>,
    room: u32,
}

/// Visibility between two points. Twin of the constants in `gpu/src/shaders/types.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LineOfSight {
    /// Occluded by a face of the room, also without the objects.
    Blocked,
    /// Occluded by objects only.
    HiddenByObject,
    /// Not occluded.
    Clear,
}

/// The face that a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayEnd {
    /// The front of a face, at a ray parameter.
    Front(u32, f32),
    /// A back.
    Back,
    /// Nothing.
    Outside,
}

impl Rays {
    /// Builds the BVH over the faces that have an area.
    pub fn new(mesh: &Mesh) -> Self {
        Self {
            bvh: Bvh::new(mesh),
            faces: mesh.faces.clone(),
            room: mesh.room_faces,
        }
    }

    /// Builds the BVH over those of the room alone, without the objects.
    pub fn of_room(mesh: &Mesh) -> Self {
        let faces = mesh.faces[..mesh.room_faces as usize].to_vec();
        Self {
            bvh: Bvh::over(&faces),
            room: mesh.room_faces,
            faces,
        }
    }

    /// Returns the ray parameter at which face `k` blocks a ray between `points` on the sheets `ends`.
    fn blocks_segment(&self, k: u32, ray: &Ray, points: [Vec3; 2], ends: [u32; 2]) -> Option<f32> {
        let face = &self.faces[k as usize];
        if face.sheet == ends[0] || face.sheet == ends[1] {
            return None;
        }
        let hit = intersect_face(face, ray.origin.into(), ray.direction.into());
        (hit.stops_ray(RAY_REACH) && !points.iter().any(|p| touches_plane(face, *p))).then_some(hit.t)
    }

    /// Returns whether no face lies between `from` on face `ends[0]` and `to` on face `ends[1]`.
    pub fn is_visible(&self, from: Vec3, to: Vec3, ends: [u32; 2]) -> bool {
        self.find_sight(from, to, ends, false) == LineOfSight::Clear
    }

    /// Returns the visibility between `from` on face `ends[0]` and `to` on face `ends[1]`. With `through`
    /// the traversal continues through objects and distinguishes them from faces of the room; without it,
    /// every occluder is [`LineOfSight::Blocked`].
    pub fn find_sight(&self, from: Vec3, to: Vec3, ends: [u32; 2], through: bool) -> LineOfSight {
        self.find_sight_after(from, to, ends, through, &Cell::new(NO_FACE))
    }

    /// Returns the same. The face that blocked the `last` ray is tested first: it often blocks the next.
    pub fn find_sight_after(
        &self,
        from: Vec3,
        to: Vec3,
        ends: [u32; 2],
        through: bool,
        last: &Cell<u32>,
    ) -> LineOfSight {
        let ends = ends.map(|k| self.faces[k as usize].sheet);
        let [from, to] = start_near(from, to);
        let ray = segment_ray(from, to);
        let known = last.get();
        let ends_it = known != NO_FACE && (!through || known < self.room);
        if ends_it && self.blocks_segment(known, &ray, [from, to], ends).is_some() {
            return LineOfSight::Blocked;
        }
        let hidden = Cell::new(false);
        let free = self.bvh.tree.ray_traverse_miss(ray, |ray, primitive| {
            let k = self.bvh.faces[primitive];
            match self.blocks_segment(k, ray, [from, to], ends) {
                Some(t) if !through || k < self.room => {
                    last.set(k);
                    t
                }
                Some(_) => {
                    hidden.set(true);
                    MISS_DISTANCE
                }
                None => MISS_DISTANCE,
            }
        });
        match (free, hidden.get()) {
            (false, _) => LineOfSight::Blocked,
            (true, true) => LineOfSight::HiddenByObject,
            (true, false) => LineOfSight::Clear,
        }
    }

    /// Returns all faces between `from` on face `ends[0]` and `to` on face `ends[1]`.
    pub fn find_blockers(&self, from: Vec3, to: Vec3, ends: [u32; 2]) -> Vec<u32> {
        let ends = ends.map(|k| self.faces[k as usize].sheet);
        let mut blockers = Vec::new();
        let tree = &self.bvh.tree;
        tree.ray_traverse_anyhit(segment_ray(from, to), |ray, primitive| {
            let k = self.bvh.faces[primitive];
            if !blockers.contains(&k) && self.blocks_segment(k, ray, [from, to], ends).is_some() {
                blockers.push(k);
            }
        });
        blockers
    }

    /// Visits the faces that the ray from `origin`, or from just behind it, along the unit vector `direction` may meet;
    /// a thin triangle more than once. `visit` returns the distance beyond which no face matters.
    pub fn visit_faces_along(&self, origin: Vec3, direction: Vec3, mut visit: impl FnMut(u32, &MeshFace) -> f32) {
        let shift = 4.0 * CONTACT_DISTANCE;
        let ray = make_ray(origin - direction * shift, direction / RAY_REACH, f32::MAX);
        self.bvh.tree.ray_traverse(ray, &mut RayHit::none(), |_, primitive| {
            let k = self.bvh.faces[primitive];
            // Once more the shift, for rounding.
            (visit(k, &self.faces[k as usize]) + 2.0 * shift) * RAY_REACH
        });
    }

    /// Returns the nearest face along the ray from `origin`, a point of a face of `sheet`, and its ray parameter; none if the
    /// ray meets nothing, or a back first.
    pub fn nearest_face(&self, origin: Vec3, direction: Vec3, sheet: u32) -> Option<(u32, f32)> {
        match self.trace_ray(origin, direction, sheet) {
            RayEnd::Front(face, t) => Some((face, t)),
            RayEnd::Back | RayEnd::Outside => None,
        }
    }

    /// Returns what the ray from `origin`, a point of a face of `sheet`, meets first. Faces that touch the origin are
    /// skipped: a body that stands there has more faces behind them. Where a front and a back coincide the front is
    /// met: they are a sheet's two sides, subdivided differently. Of coincident fronts that one is met
    /// which precedes the others (see [`MeshFace::precedes`]).
    pub fn trace_ray(&self, origin: Vec3, direction: Vec3, sheet: u32) -> RayEnd {
        let reach = 8.0 / RAY_REACH;
        let mut nearest = RayHit::none();
        // The nearest front with its ray parameter and cosine; the ray parameter of the nearest back.
        let (mut lit, mut dark): (Option<(u32, f32, f32)>, _) = (None, f32::INFINITY);
        let ray = make_ray(origin, direction * reach, RAY_REACH);
        self.bvh.tree.ray_traverse(ray, &mut nearest, |ray, primitive| {
            let k = self.bvh.faces[primitive];
            let face = &self.faces[k as usize];
            let hit = intersect_face(face, ray.origin.into(), ray.direction.into());
            let touches = (hit.t * hit.facing).abs() <= CONTACT_DISTANCE;
            let front = hit.facing < 0.0;
            // Of a sheet's two sides the ray meets only the front.
            let passed = face.sheet == sheet || touches || (face.two_sided && !front);
            if passed || hit.t <= 0.0 || hit.inside < -OUTLINE_MARGIN {
                return MISS_DISTANCE;
            }
            if !front {
                dark = dark.min(hit.t);
            } else if lit.is_none_or(|(other, t, _)| self.is_met_before([k, other], &hit, t)) {
                lit = Some((k, hit.t, -hit.facing));
            }
            // The ray continues to faces that coincide with this one.
            hit.t + CONTACT_DISTANCE / hit.facing.abs()
        });
        match lit {
            Some((k, t, steep)) if (t - dark) * steep <= CONTACT_DISTANCE => RayEnd::Front(k, t * reach),
            None if dark == f32::INFINITY => RayEnd::Outside,
            _ => RayEnd::Back,
        }
    }

    /// Returns the nearest front along a view ray, and its ray parameter; backs are transparent.
    pub fn nearest_front(&self, origin: Vec3, direction: Vec3) -> Option<(u32, f32)> {
        let (mut nearest, mut met) = (RayHit::none(), None);
        let ray = make_ray(origin, direction, f32::MAX);
        self.bvh.tree.ray_traverse(ray, &mut nearest, |ray, primitive| {
            let k = self.bvh.faces[primitive];
            let hit = intersect_face(&self.faces[k as usize], ray.origin.into(), ray.direction.into());
            let is_met = hit.facing < 0.0 && hit.t > 0.0 && hit.inside >= -OUTLINE_MARGIN;
            if !is_met {
                return MISS_DISTANCE;
            }
            if met.is_none_or(|(other, t)| self.is_met_before([k, other], &hit, t)) {
                met = Some((k, hit.t));
            }
            hit.t + CONTACT_DISTANCE / hit.facing.abs()
        });
        met
    }

    /// Returns whether a ray that meets front `k` by `hit` meets it before front `other`, which it meets at `t`.
    fn is_met_before(&self, [k, other]: [u32; 2], hit: &Crossing, t: f32) -> bool {
        let ahead = (hit.t - t) * hit.facing;
        let precedes = || self.faces[k as usize].precedes(&self.faces[other as usize]);
        ahead > CONTACT_DISTANCE || (ahead >= -CONTACT_DISTANCE && precedes())
    }
}

/// Returns the ends of a segment in the order in which it is traced: of a point of the sky coordinates are coarser than the
/// outlines' margin, and the ray starts at the other end.
#[inline(always)]
pub fn start_near(from: Vec3, to: Vec3) -> [Vec3; 2] {
    if from.abs().max_element() > MAX_SCENE_COORDINATE {
        [to, from]
    } else {
        [from, to]
    }
}

fn segment_ray(from: Vec3, to: Vec3) -> Ray {
    make_ray(from, (to - from) / RAY_REACH, SEGMENT_END_FRACTION * RAY_REACH)
}

/// Makes a ray. `Ray::new` clamps the inverses of small components; here every component is small.
fn make_ray(origin: Vec3, direction: Vec3, tmax: f32) -> Ray {
    Ray {
        origin: origin.into(),
        direction: direction.into(),
        inv_direction: direction.map(safe_inverse).into(),
        tmin: 0.0,
        tmax,
    }
}

/// Returns 1/x, finite for every x. −0 counts as positive, as in a tree's choice of octants.
pub fn safe_inverse(x: f32) -> f32 {
    if x.abs() < 1e-30 {
        return if x < 0.0 { -1e30 } else { 1e30 };
    }
    1.0 / x
}
