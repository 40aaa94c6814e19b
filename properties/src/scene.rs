//! A scene with its texels, and the scenes that have the same light.

use crate::faces::rotate_corners;
use common::cover;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use glam::{DVec3, Vec3};

/// A scene with its texels and patches.
#[derive(Clone, Debug)]
pub struct MeshedScene {
    /// Scene. Its faces have no textures ([`common::paint`]): each emits and reflects evenly.
    pub scene: Scene,
    /// Texels of each face: W×H on a quad, N×N on a triangle.
    pub resolutions: Vec<[u32; 2]>,
    /// Patches per side of a face.
    pub patches: u32,
}

impl MeshedScene {
    /// Meshes the scene.
    ///
    /// Errors: as of [`Mesh::new`].
    pub fn mesh(&self) -> common::Result<Mesh> {
        Mesh::new(&self.scene, &self.resolutions, self.patches)
    }

    /// Meshes the scene with `samples` points per patch.
    ///
    /// Errors: as of [`Mesh::new`].
    pub fn sampled_mesh(&self, samples: u32) -> common::Result<Mesh> {
        let mut mesh = self.mesh()?;
        cover::sample_covers(&mut mesh, samples);
        Ok(mesh)
    }

    /// Returns the scene in which face k emits `emission(k, face)`, W/m².
    pub fn with_emission(&self, emission: impl Fn(usize, &Face) -> Vec3) -> Self {
        self.with_faces(|k, face| face.emission = emission(k, face))
    }

    /// Returns the scene with face k changed by `change(k, face)`.
    pub fn with_faces(&self, change: impl Fn(usize, &mut Face)) -> Self {
        let mut other = self.clone();
        other
            .scene
            .faces
            .iter_mut()
            .enumerate()
            .for_each(|(k, face)| change(k, face));
        other
    }

    /// Returns the scene with all corners mapped by `to`.
    pub fn map_corners(&self, to: impl Fn(DVec3) -> DVec3) -> Self {
        self.with_faces(|_, face| face.corners = face.corners.map(&to))
    }

    /// Returns the mirror image at the plane through the origin with this unit normal, with fronts on the same side, and
    /// the map of its points.
    pub fn mirror(&self, normal: DVec3) -> (Self, impl Fn(DVec3) -> DVec3 + use<>) {
        let to = move |p: DVec3| p - 2.0 * normal * normal.dot(p);
        let mut image = self.map_corners(to);
        for (face, resolution) in image.scene.faces.iter_mut().zip(&mut image.resolutions) {
            *face = face.reversed();
            resolution.reverse();
        }
        (image, to)
    }

    /// Returns the scene with its faces in another order: `order` lists their indices.
    pub fn reorder_faces(&self, order: &[usize]) -> Self {
        let mut other = self.clone();
        other.scene.faces = order.iter().map(|k| self.scene.faces[*k].clone()).collect();
        other.resolutions = order.iter().map(|k| self.resolutions[*k]).collect();
        other
    }

    /// Returns the scene with the corners of face k rotated by `by[k]`; `by` repeats.
    pub fn rotate_first_corners(&self, by: &[u32]) -> Self {
        let mut other = self.clone();
        let faces = other.scene.faces.iter_mut().zip(&mut other.resolutions);
        for ((face, resolution), by) in faces.zip(by.iter().cycle()) {
            (*face, *resolution) = rotate_corners(face, *resolution, *by as usize % 12);
        }
        other
    }

    /// Returns the scene with 2×N texels on one face, and with that face split into two of 1×N; with 2² texels on a
    /// triangle, and with the triangle split into four of one. The face is `at` modulo their number, which is not 0.
    pub fn split_face(&self, at: usize) -> [Self; 2] {
        let mut one = self.clone();
        let at = at % self.scene.faces.len();
        let face = &self.scene.faces[at];
        let [a, b, c, d] = face.corners;
        let middle = |p: DVec3, q: DVec3| 0.5 * (p + q);
        let quad = face.outline().len() == 4;
        one.resolutions[at][0] = 2;
        if !quad {
            one.resolutions[at] = [2, 2];
        }
        let height = one.resolutions[at][1];
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        let (parts, resolution) = if quad {
            let cd = middle(c, d);
            (vec![[a, ab, cd, d], [ab, b, c, cd]], [1, height])
        } else {
            let parts = [[a, ab, ca], [ab, b, bc], [ab, bc, ca], [ca, bc, c]];
            (parts.map(|[a, b, c]| [a, b, c, c]).to_vec(), [1, 1])
        };
        let mut many = one.clone();
        for (k, corners) in parts.into_iter().enumerate() {
            let part = Face {
                corners,
                ..face.clone()
            };
            if k == 0 {
                (many.scene.faces[at], many.resolutions[at]) = (part, resolution);
            } else {
                many.scene.faces.push(part);
                many.resolutions.push(resolution);
            }
        }
        [one, many]
    }
}

/// Returns a permutation of `count` indices from random keys, of which there is at least one.
pub fn order_by_keys(count: usize, keys: &[u32]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|k| (keys[k % keys.len()].rotate_left((k / keys.len()) as u32), *k));
    order
}
