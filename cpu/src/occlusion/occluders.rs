//! All possible occluders of a scene in an obvhs BVH2, which is traversed with the planes of a shaft.

use crate::occlusion::polygon::{ConvexPolygon, OrientedPlane};
use crate::occlusion::shaft::{OCCLUDER_MARGIN, Shaft, TOUCH_DISTANCE};
use common::bvh::{box_around, build_binary_tree};
use common::mesh::Mesh;
use common::polygon::distinct_corners;
use common::scene::Scene;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use std::cell::{Cell, RefCell};

/// A face, one-sided for light, opaque from both sides.
pub struct Occluder {
    /// Outline.
    pub polygon: ConvexPolygon,
    /// Front plane, unit normal; zero on a face without area.
    pub plane: OrientedPlane,
    /// Its sheet (see [`common::mesh::MeshFace::sheet`]).
    pub sheet: u32,
}

/// All faces of a scene, in mesh units.
pub struct Occluders {
    /// Faces in the scene's order.
    pub faces: Vec<Occluder>,
    bvh: Bvh2,
    /// The face of each primitive of the BVH.
    index: Vec<u32>,
}

impl Occluders {
    /// Takes the faces of `scene` in f64; `mesh` holds them in f32.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Self {
        Self::from_faces(
            mesh,
            scene
                .faces
                .iter()
                .zip(&mesh.faces)
                .map(|(face, small)| {
                    let corners: Vec<DVec3> = face.outline().iter().map(|p| mesh.local_point(*p)).collect();
                    let normal = face.vector_area().normalize_or_zero();
                    Occluder {
                        polygon: ConvexPolygon::new(&corners),
                        plane: OrientedPlane::through_point(corners[0], normal),
                        sheet: small.sheet,
                    }
                })
                .collect(),
            |_| true,
        )
    }

    /// Takes the faces of `mesh`, rounded to f32.
    pub fn from_mesh(mesh: &Mesh) -> Self {
        Self::from_filtered(mesh, |_| true)
    }

    /// Takes the faces of `mesh`; only objects occlude.
    pub fn from_objects(mesh: &Mesh) -> Self {
        Self::from_filtered(mesh, |k| mesh.is_object(k))
    }

    fn from_filtered(mesh: &Mesh, blocks: impl Fn(u32) -> bool) -> Self {
        Self::from_faces(
            mesh,
            mesh.faces
                .iter()
                .map(|face| Occluder {
                    polygon: ConvexPolygon::new(distinct_corners(&face.corners.map(|c| c.as_dvec3()))),
                    plane: OrientedPlane {
                        normal: face.plane.truncate().as_dvec3(),
                        offset: f64::from(face.plane.w),
                    },
                    sheet: face.sheet,
                })
                .collect(),
            blocks,
        )
    }

    /// Builds the BVH of the faces that fulfil `which`. A face that lies wholly under another front is left out.
    fn from_faces(mesh: &Mesh, faces: Vec<Occluder>, which: impl Fn(u32) -> bool) -> Self {
        let blocks = |k: usize| faces[k].plane.normal != DVec3::ZERO && !mesh.faces[k].is_buried();
        let index: Vec<u32> = (0..faces.len() as u32)
            .filter(|k| which(*k) && blocks(*k as usize))
            .collect();
        let boxes: Vec<Aabb> = index.iter().map(|k| polygon_box(&faces[*k as usize].polygon)).collect();
        Self {
            bvh: build_bvh(&boxes),
            faces,
            index,
        }
    }

    /// Appends the faces that enter `shaft`, except the sheets of its ends.
    pub fn faces_entering(&self, shaft: &Shaft, ends: [u32; 2], found: &mut Vec<u32>) {
        let outside = |aabb: &Aabb| shaft.misses_box(widen_to_f64(aabb.min), widen_to_f64(aabb.max), TOUCH_DISTANCE);
        self.visit_faces(outside, |k| {
            let face = &self.faces[k as usize];
            if !ends.contains(&face.sheet) && !shaft.misses_polygon(&face.polygon, &face.plane) {
                found.push(k);
            }
        });
        // The result must not depend on the order of the BVH.
        found.sort_unstable();
    }

    /// Returns the faces that may block a ray in `shaft`, except the sheets of its ends; none if there are more than
    /// `most`.
    pub fn faces_blocking_rays(&self, shaft: &Shaft, ends: [u32; 2], most: usize) -> Option<Vec<u32>> {
        let found = RefCell::new(Vec::new());
        let outside = |aabb: &Aabb| {
            found.borrow().len() > most
                || shaft.misses_box(widen_to_f64(aabb.min), widen_to_f64(aabb.max), -OCCLUDER_MARGIN)
        };
        self.visit_faces(outside, |k| {
            let face = &self.faces[k as usize];
            if !ends.contains(&face.sheet) && !shaft.blocks_no_ray(&face.polygon, &face.plane) {
                found.borrow_mut().push(k);
            }
        });
        let mut found = found.into_inner();
        // The result must not depend on the order of the BVH.
        found.sort_unstable();
        (found.len() <= most).then_some(found)
    }

    /// Returns the faces whose boxes overlap that of `polygon`, in rising order.
    pub fn faces_near(&self, polygon: &ConvexPolygon) -> Vec<u32> {
        let own = polygon_box(polygon);
        let apart = |aabb: &Aabb| aabb.min.cmpgt(own.max).any() || aabb.max.cmplt(own.min).any();
        let mut found = Vec::new();
        self.visit_faces(apart, |k| {
            if !apart(&polygon_box(&self.faces[k as usize].polygon)) {
                found.push(k);
            }
        });
        // The result must not depend on the order of the BVH.
        found.sort_unstable();
        found
    }

    /// Returns true if a face may lie between two balls, given by centre and radius.
    pub fn any_between(&self, from: (Vec3, f32), to: (Vec3, f32)) -> bool {
        let found = Cell::new(false);
        let outside = |aabb: &Aabb| {
            let centre = (aabb.min + aabb.max) * 0.5;
            let radius = (aabb.max - aabb.min).length() * 0.5;
            found.get() || distance_to_hull(from, to, centre.into()) > radius
        };
        self.visit_faces(outside, |_| found.set(true));
        found.get()
    }

    /// Visits every face whose boxes are not `outside`, and possibly more.
    fn visit_faces(&self, outside: impl Fn(&Aabb) -> bool, mut found: impl FnMut(u32)) {
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

    /// Returns true if one of `faces` alone hides the shaft's ends from each other.
    pub fn one_hides(&self, shaft: &Shaft, faces: &[u32]) -> bool {
        faces.iter().any(|k| {
            let face = &self.faces[*k as usize];
            shaft.hidden_by(&face.polygon, &face.plane)
        })
    }
}

/// Returns the distance of `p` from the hull of two balls; negative inside.
fn distance_to_hull((a, r): (Vec3, f32), (b, s): (Vec3, f32), p: Vec3) -> f32 {
    let (way, to) = (b - a, p - a);
    let length = way.length();
    // The minimum of |p − a − t·way/length| − radius(t), which is convex.
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

/// [`obvhs::bvh2::builder::build_bvh2`] of any depth: the traversal's stack grows.
fn build_bvh(boxes: &[Aabb]) -> Bvh2 {
    let parameters = BvhBuildParams::medium_build();
    let mut bvh = build_binary_tree(boxes, &parameters);
    let leaf = parameters.max_prims_per_leaf.clamp(1, 255);
    collapse(&mut bvh, leaf, parameters.collapse_traversal_cost);
    let after = parameters.reinsertion_batch_ratio * parameters.post_collapse_reinsertion_batch_ratio_multiplier;
    ReinsertionOptimizer::default().run(&mut bvh, after, None);
    bvh
}

fn polygon_box(polygon: &ConvexPolygon) -> Aabb {
    // The margin allows for the rounding to f32.
    box_around(
        polygon.corners().iter().map(|corner| corner.as_vec3()),
        4.0 * f32::EPSILON,
    )
}

fn widen_to_f64(p: Vec3A) -> DVec3 {
    DVec3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z))
}
