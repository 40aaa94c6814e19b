//! The faces that may block, and those of them that enter a shaft: an obvhs BVH2 of faces, walked
//! with the shaft's planes.

use crate::occlusion::polygon::{Plane, Polygon};
use crate::occlusion::shaft::{Shaft, TOUCH, WIDER};
use common::mesh::Mesh;
use common::scene::Scene;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::PlocBuilder;
use std::cell::{Cell, RefCell};

/// A face, one-sided for light, opaque from both sides.
pub struct Occluder {
    /// Outline.
    pub polygon: Polygon,
    /// Front plane, unit normal; zero on a face without area.
    pub plane: Plane,
    /// Its sheet (see [`common::mesh::MeshFace::sheet`]).
    pub sheet: u32,
}

/// All faces of a scene, in the mesh's unit.
pub struct Occluders {
    /// In the scene's order.
    pub faces: Vec<Occluder>,
    bvh: Bvh2,
    /// The face of each primitive of the BVH.
    index: Vec<u32>,
}

impl Occluders {
    /// The faces of `scene`, which `mesh` holds in f32.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Self {
        Self::of(
            mesh,
            scene
                .faces
                .iter()
                .zip(&mesh.faces)
                .map(|(face, small)| {
                    let corners: Vec<DVec3> =
                        face.outline().iter().map(|p| mesh.local(*p)).collect();
                    let normal = face.vector_area().normalize_or_zero();
                    Occluder {
                        polygon: Polygon::new(&corners),
                        plane: Plane::through(corners[0], normal),
                        sheet: small.sheet,
                    }
                })
                .collect(),
            |_| true,
        )
    }

    /// The faces as the solvers have them.
    pub fn rounded(mesh: &Mesh) -> Self {
        Self::some(mesh, |_| true)
    }

    /// The same of what was put into a room.
    pub fn objects(mesh: &Mesh) -> Self {
        Self::some(mesh, |k| mesh.is_object(k))
    }

    fn some(mesh: &Mesh, blocks: impl Fn(u32) -> bool) -> Self {
        Self::of(
            mesh,
            mesh.faces
                .iter()
                .map(|face| {
                    let corners = face.corners.map(|c| c.as_dvec3());
                    let count = if face.corners[2] == face.corners[3] {
                        3
                    } else {
                        4
                    };
                    Occluder {
                        polygon: Polygon::new(&corners[..count]),
                        plane: Plane {
                            normal: face.plane.truncate().as_dvec3(),
                            offset: f64::from(face.plane.w),
                        },
                        sheet: face.sheet,
                    }
                })
                .collect(),
            blocks,
        )
    }

    /// What lies under another front as a whole blocks nothing that this one does not.
    fn of(mesh: &Mesh, faces: Vec<Occluder>, which: impl Fn(u32) -> bool) -> Self {
        let blocks = |k: usize| faces[k].plane.normal != DVec3::ZERO && !mesh.faces[k].is_buried();
        let index: Vec<u32> = (0..faces.len() as u32)
            .filter(|k| which(*k) && blocks(*k as usize))
            .collect();
        let boxes: Vec<Aabb> = index
            .iter()
            .map(|k| bounds(&faces[*k as usize].polygon))
            .collect();
        Self {
            bvh: build(&boxes),
            faces,
            index,
        }
    }

    /// Appends the faces that enter `shaft`, but for the sheets of its ends.
    pub fn entering(&self, shaft: &Shaft, ends: [u32; 2], found: &mut Vec<u32>) {
        let outside = |aabb: &Aabb| shaft.misses_box(wide(aabb.min), wide(aabb.max), TOUCH);
        self.visit(outside, |k| {
            let face = &self.faces[k as usize];
            if !ends.contains(&face.sheet) && !shaft.misses(&face.polygon, &face.plane) {
                found.push(k);
            }
        });
        // The tree's order is no property of the scene.
        found.sort_unstable();
    }

    /// The faces that may stop a ray in `shaft`, but for the sheets of its ends; none where they are more than
    /// `most`.
    pub fn stopping(&self, shaft: &Shaft, ends: [u32; 2], most: usize) -> Option<Vec<u32>> {
        let found = RefCell::new(Vec::new());
        let outside = |aabb: &Aabb| {
            found.borrow().len() > most || shaft.misses_box(wide(aabb.min), wide(aabb.max), -WIDER)
        };
        self.visit(outside, |k| {
            let face = &self.faces[k as usize];
            if !ends.contains(&face.sheet) && !shaft.clears(&face.polygon, &face.plane) {
                found.borrow_mut().push(k);
            }
        });
        let mut found = found.into_inner();
        // The tree's order is no property of the scene.
        found.sort_unstable();
        (found.len() <= most).then_some(found)
    }

    /// The faces whose boxes meet that of `polygon`, by number.
    pub fn beside(&self, polygon: &Polygon) -> Vec<u32> {
        let own = bounds(polygon);
        let apart = |aabb: &Aabb| aabb.min.cmpgt(own.max).any() || aabb.max.cmplt(own.min).any();
        let mut found = Vec::new();
        self.visit(apart, |k| {
            if !apart(&bounds(&self.faces[k as usize].polygon)) {
                found.push(k);
            }
        });
        // The tree's order is no property of the scene.
        found.sort_unstable();
        found
    }

    /// Whether a face may lie between two balls, given by centre and radius.
    pub fn between(&self, from: (Vec3, f32), to: (Vec3, f32)) -> bool {
        let found = Cell::new(false);
        let outside = |aabb: &Aabb| {
            let centre = (aabb.min + aabb.max) * 0.5;
            let radius = (aabb.max - aabb.min).length() * 0.5;
            found.get() || beside(from, to, centre.into()) > radius
        };
        self.visit(outside, |_| found.set(true));
        found.get()
    }

    /// Every face whose boxes do not lie `outside`, and perhaps more.
    fn visit(&self, outside: impl Fn(&Aabb) -> bool, mut found: impl FnMut(u32)) {
        if self.index.is_empty() {
            return;
        }
        let mut stack = vec![0usize];
        while let Some(node) = stack.pop().map(|k| &self.bvh.nodes[k]) {
            if outside(node.aabb()) {
                continue;
            }
            let first = node.first_index as usize;
            if !node.is_leaf() {
                stack.extend([first, first + 1]);
                continue;
            }
            for primitive in first..first + node.prim_count as usize {
                found(self.index[self.bvh.primitive_indices[primitive] as usize]);
            }
        }
    }

    /// Whether one of `faces` alone hides the shaft's ends from each other.
    pub fn one_hides(&self, shaft: &Shaft, faces: &[u32]) -> bool {
        faces.iter().any(|k| {
            let face = &self.faces[*k as usize];
            shaft.hidden_by(&face.polygon, &face.plane)
        })
    }
}

/// How far `p` lies outside the hull of two balls.
fn beside((a, r): (Vec3, f32), (b, s): (Vec3, f32), p: Vec3) -> f32 {
    let (way, to) = (b - a, p - a);
    let length = way.length();
    // The least of |p − a − t·way/length| − radius(t), which is convex.
    let growth = (s - r) / length.max(1e-12);
    let at = if growth.abs() < 1.0 {
        let along = to.dot(way) / length;
        let aside = (to.length_squared() - along * along).max(0.0).sqrt();
        along + aside * growth / (1.0 - growth * growth).sqrt()
    } else if growth > 0.0 {
        length
    } else {
        0.0
    };
    let t = (at / length.max(1e-12)).clamp(0.0, 1.0);
    p.distance(a + way * t) - (r + (s - r) * t)
}

/// [`obvhs::bvh2::builder::build_bvh2`] of any depth: `walk` has a stack that grows.
fn build(boxes: &[Aabb]) -> Bvh2 {
    let parameters = BvhBuildParams::medium_build();
    let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
        parameters.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect::<Vec<_>>(),
        parameters.sort_precision,
        parameters.search_depth_threshold,
    );
    let ratio = parameters.reinsertion_batch_ratio;
    let after = ratio * parameters.post_collapse_reinsertion_batch_ratio_multiplier;
    let mut optimizer = ReinsertionOptimizer::default();
    optimizer.run(&mut bvh, ratio, None);
    let leaf = parameters.max_prims_per_leaf.clamp(1, 255);
    collapse(&mut bvh, leaf, parameters.collapse_traversal_cost);
    optimizer.run(&mut bvh, after, None);
    bvh
}

fn bounds(polygon: &Polygon) -> Aabb {
    let mut aabb = Aabb::empty();
    for corner in polygon.corners() {
        aabb.extend(corner.as_vec3().into());
    }
    // Room for the rounding to f32.
    let margin = Vec3A::splat(4.0 * f32::EPSILON);
    aabb.min -= margin;
    aabb.max += margin;
    aabb
}

fn wide(p: Vec3A) -> DVec3 {
    DVec3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z))
}
