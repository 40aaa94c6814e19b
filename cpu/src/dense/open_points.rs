//! Points of the open parts of texels, drawn evenly: rays start there.

use super::open_area::{Element, covered_elements};
use crate::occlusion::occluders::Occluders;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::texel_point::{SampledOutline, texel_corners};
use glam::Vec3;
use std::collections::HashMap;

/// The open parts of all texels.
pub struct OpenParts {
    /// Open share of each texel.
    pub shares: Vec<f32>,
    /// Outlines of the open parts of the texels that bodies cover partly or wholly.
    outlines: HashMap<u32, Vec<SampledOutline>>,
}

impl OpenParts {
    /// Finds the open part of each texel of `mesh`.
    pub fn new(scene: &Scene, mesh: &Mesh, rays: &Rays) -> Self {
        let mut shares = vec![1.0; mesh.texels.len()];
        let mut outlines = HashMap::new();
        for (k, element) in covered_elements(scene, mesh, &Occluders::new(scene, mesh), rays) {
            shares[k as usize] = element.open as f32;
            outlines.insert(k, element.open_outlines());
        }
        Self { shares, outlines }
    }

    /// Returns the open parts of those texels that are `kept`; the others count as wholly covered.
    pub fn keep_texels(&self, kept: impl Fn(usize) -> bool) -> Self {
        let mut parts = Self {
            shares: self.shares.clone(),
            outlines: self.outlines.clone(),
        };
        for k in (0..self.shares.len()).filter(|k| !kept(*k)) {
            parts.shares[k] = 0.0;
            parts.outlines.insert(k as u32, Vec::new());
        }
        parts
    }

    /// Returns the outlines of the open part of texel `k`; none of a texel that is wholly covered.
    pub fn outlines_of(&self, mesh: &Mesh, k: usize) -> Vec<SampledOutline> {
        match self.outlines.get(&(k as u32)) {
            Some(outlines) => outlines.clone(),
            None => vec![SampledOutline::new(texel_corners(mesh, &mesh.texels[k]))],
        }
    }
}

impl Element {
    /// Returns the outlines of the open part.
    pub fn open_outlines(&self) -> Vec<SampledOutline> {
        let quads = self.pieces.iter().flat_map(|piece| piece.polygon.quad_pieces());
        quads
            .map(|quad| SampledOutline::new(quad.map(|p| p.as_vec3())))
            .collect()
    }
}

/// Maps u, v in 0…1 to a point of `outlines`; equal areas map to equal areas. There is none in no outlines.
pub fn draw_point(outlines: &[SampledOutline], [u, v]: [f32; 2]) -> Option<Vec3> {
    let all: f32 = outlines.iter().map(|part| part.area).sum();
    let mut rest = u * all;
    let last = outlines.len().checked_sub(1)?;
    for (k, part) in outlines.iter().enumerate() {
        if rest < part.area || k == last {
            let share = (rest / part.area.max(f32::MIN_POSITIVE)).min(1.0);
            return Some(part.point_at([share, v]));
        }
        rest -= part.area;
    }
    None
}
