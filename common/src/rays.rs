//! Visibility by rays from points of the shooter to points of the texel, through an obvhs BVH of faces.

use crate::bvh::Bvh;
use crate::constants::{CONTACT, END, MISS, OUTLINE, RAY_REACH};
use crate::intersect::{intersect, touches};
use crate::mesh::{Mesh, MeshFace};
use glam::{Vec3, Vec3A};
use obvhs::ray::{Ray, RayHit};
use std::cell::Cell;

/// No face.
pub const NOBODY: u32 = u32::MAX;

/// Faces that block.
pub struct Rays {
    bvh: Bvh,
    faces: Vec<MeshFace>,
    room: u32,
}

/// What lies between two points. Twin of the constants in `gpu/src/shaders/types.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sight {
    /// A face of the room: neither saw the other before the objects came.
    Blocked,
    /// Objects only.
    Hidden,
    /// Nothing.
    Clear,
}

impl Rays {
    /// Builds the BVH over the faces that have an area.
    pub fn new(mesh: &Mesh) -> Self {
        Self {
            bvh: Bvh::new(mesh),
            faces: mesh.faces.clone(),
            room: mesh.room,
        }
    }

    /// The sheets that a ray between two faces may touch: its ends.
    fn blocks(
        &self,
        primitive: usize,
        ray: &Ray,
        points: [Vec3; 2],
        ends: [u32; 2],
    ) -> Option<(u32, f32)> {
        let k = self.bvh.faces[primitive];
        self.meets(k, ray, points, ends).map(|t| (k, t))
    }

    /// Where on the ray face `k` blocks it.
    fn meets(&self, k: u32, ray: &Ray, points: [Vec3; 2], ends: [u32; 2]) -> Option<f32> {
        let face = &self.faces[k as usize];
        if face.sheet == ends[0] || face.sheet == ends[1] {
            return None;
        }
        let hit = intersect(face, ray.origin.into(), ray.direction.into());
        (hit.between(RAY_REACH) && !points.iter().any(|p| touches(face, *p))).then_some(hit.t)
    }

    /// Whether nothing lies between `from` on face `ends[0]` and `to` on face `ends[1]`.
    pub fn visible(&self, from: Vec3, to: Vec3, ends: [u32; 2]) -> bool {
        let ends = ends.map(|k| self.faces[k as usize].sheet);
        self.bvh
            .tree
            .ray_traverse_miss(segment(from, to), |ray, primitive| {
                self.blocks(primitive, ray, [from, to], ends)
                    .map_or(MISS, |(_, t)| t)
            })
    }

    /// What lies between `from` on face `ends[0]` and `to` on face `ends[1]`: one traversal that
    /// objects do not end where it is asked to go `through` them, so that nothing is seen now that
    /// was not seen before them.
    pub fn sight(&self, from: Vec3, to: Vec3, ends: [u32; 2], through: bool) -> Sight {
        self.sight_past(from, to, ends, through, &Cell::new(NOBODY))
    }

    /// The same. The face that ended the `last` ray is asked first: it often ends its neighbours.
    pub fn sight_past(
        &self,
        from: Vec3,
        to: Vec3,
        ends: [u32; 2],
        through: bool,
        last: &Cell<u32>,
    ) -> Sight {
        let ends = ends.map(|k| self.faces[k as usize].sheet);
        let ray = segment(from, to);
        let known = last.get();
        let ends_it = known != NOBODY && (!through || known < self.room);
        if ends_it && self.meets(known, &ray, [from, to], ends).is_some() {
            return Sight::Blocked;
        }
        let hidden = Cell::new(false);
        let free = self.bvh.tree.ray_traverse_miss(ray, |ray, primitive| {
            match self.blocks(primitive, ray, [from, to], ends) {
                Some((k, t)) if !through || k < self.room => {
                    last.set(k);
                    t
                }
                Some(_) => {
                    hidden.set(true);
                    MISS
                }
                None => MISS,
            }
        });
        match (free, hidden.get()) {
            (false, _) => Sight::Blocked,
            (true, true) => Sight::Hidden,
            (true, false) => Sight::Clear,
        }
    }

    /// All faces that lie in between.
    pub fn blockers(&self, from: Vec3, to: Vec3, ends: [u32; 2]) -> Vec<u32> {
        let ends = ends.map(|k| self.faces[k as usize].sheet);
        let mut found = Vec::new();
        self.bvh
            .tree
            .ray_traverse_anyhit(segment(from, to), |ray, primitive| {
                let blocker = self.blocks(primitive, ray, [from, to], ends);
                found.extend(blocker.map(|(k, _)| k));
            });
        found
    }

    /// Every face that the ray from `origin` along `direction`, or from just behind it, may meet.
    pub fn along(&self, origin: Vec3, direction: Vec3, mut visit: impl FnMut(u32, &MeshFace)) {
        let behind = origin - direction * (4.0 * CONTACT);
        self.bvh.tree.ray_traverse_anyhit(
            ray(behind, direction / RAY_REACH, f32::MAX),
            |_, primitive| {
                let k = self.bvh.faces[primitive];
                visit(k, &self.faces[k as usize]);
            },
        );
    }

    /// The nearest face along the ray from `origin`, a point of a face of `sheet`, and its distance; none where
    /// nothing is met, or a back. What touches the origin is passed over: a body that stands there has more
    /// faces behind it. Where a front and a back coincide the front is met: they are a sheet's two
    /// sides, each cut its own way. Of fronts that coincide it is the first.
    pub fn nearest(&self, origin: Vec3, direction: Vec3, sheet: u32) -> Option<(u32, f32)> {
        let reach = 8.0 / RAY_REACH;
        let mut nearest = RayHit::none();
        // The nearest front, where, and how steeply it is met; where the nearest back.
        let (mut lit, mut dark): (Option<(u32, f32, f32)>, _) = (None, f32::INFINITY);
        self.bvh.tree.ray_traverse(
            ray(origin, direction * reach, RAY_REACH),
            &mut nearest,
            |ray, primitive| {
                let k = self.bvh.faces[primitive];
                let face = &self.faces[k as usize];
                let hit = intersect(face, ray.origin.into(), ray.direction.into());
                let touches = (hit.t * hit.facing).abs() <= CONTACT;
                let front = hit.facing < 0.0;
                // Of a sheet's two sides only the front is met.
                let passed = face.sheet == sheet || touches || (face.two_sided && !front);
                if passed || hit.t <= 0.0 || hit.inside < -OUTLINE {
                    return MISS;
                }
                if !front {
                    dark = dark.min(hit.t);
                } else if lit.is_none_or(|(other, t, _)| {
                    let ahead = (t - hit.t) * -hit.facing;
                    ahead > CONTACT || (ahead >= -CONTACT && k < other)
                }) {
                    lit = Some((k, hit.t, -hit.facing));
                }
                // What coincides with it is asked as well.
                hit.t + CONTACT / hit.facing.abs()
            },
        );
        let (k, t, steep) = lit?;
        ((t - dark) * steep <= CONTACT).then_some((k, t * reach))
    }

    /// The nearest front along a view ray, and its distance; backs are looked through.
    pub fn front(&self, origin: Vec3, direction: Vec3) -> Option<(u32, f32)> {
        let mut nearest: Option<(u32, f32)> = None;
        self.bvh
            .tree
            .ray_traverse_anyhit(ray(origin, direction, f32::MAX), |ray, primitive| {
                let k = self.bvh.faces[primitive];
                let hit = intersect(
                    &self.faces[k as usize],
                    ray.origin.into(),
                    ray.direction.into(),
                );
                if hit.facing < 0.0
                    && hit.t > 0.0
                    && hit.inside >= -OUTLINE
                    && nearest.is_none_or(|(_, best)| hit.t < best)
                {
                    nearest = Some((k, hit.t));
                }
            });
        nearest
    }
}

fn segment(from: Vec3, to: Vec3) -> Ray {
    ray(from, (to - from) / RAY_REACH, END * RAY_REACH)
}

/// `Ray::new` clamps the inverse of a small component; here every component is small.
fn ray(origin: Vec3, direction: Vec3, tmax: f32) -> Ray {
    let inverse = |x: f32| {
        if x.abs() < 1e-30 {
            1e30f32.copysign(x)
        } else {
            1.0 / x
        }
    };
    Ray {
        origin: origin.into(),
        direction: direction.into(),
        inv_direction: Vec3A::new(
            inverse(direction.x),
            inverse(direction.y),
            inverse(direction.z),
        ),
        tmin: 0.0,
        tmax,
    }
}
