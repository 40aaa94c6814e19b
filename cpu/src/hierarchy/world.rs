//! The scene as a hierarchical solve has it, and what it may leave out.

use crate::hierarchy::cluster::Clusters;
use crate::hierarchy::tree::Tree;
use crate::occlusion::occluders::Occluders;
use common::mesh::Mesh;
use common::rays::Rays;
use pulp::Arch;
use std::ops::ControlFlow;

/// Told how far the solve has come, 0…1; may break.
pub type Watch<'a> = &'a mut dyn FnMut(f64) -> ControlFlow<()>;

/// The scene.
#[derive(Clone, Copy)]
pub struct World<'a> {
    /// Faces.
    pub mesh: &'a Mesh,
    /// What shoots.
    pub tree: &'a Tree,
    /// And what faces shoot as one.
    pub clusters: &'a Clusters,
    /// All faces, for rays.
    pub rays: &'a Rays,
    /// All faces, for shadows.
    pub occluders: &'a Occluders,
    /// The widest registers.
    pub arch: Arch,
}

/// What is gathered.
#[derive(Clone, Copy)]
pub enum What<'a> {
    /// What arrives.
    Light,
    /// What these objects take of that which the room alone would let arrive.
    Taken(&'a Occluders),
}

/// Light is even where what was predicted of it is off by so many thresholds at most.
pub const EVEN: f32 = 4.0;

/// What a link may leave out, of the RMS of the reflected light.
#[derive(Clone, Copy, Debug)]
pub struct Thresholds {
    /// By how a node's light varies.
    pub source: f32,
    /// By what stands between.
    pub visibility: f32,
    /// By a spot's size.
    pub near: f32,
    /// A shadow's edge changes more than so many times what sources may leave out.
    pub soft: f32,
}

impl Thresholds {
    /// For shadows of light from all sides: what their edges change is no more than what even light may be off.
    pub fn softened(self) -> Self {
        Self { soft: EVEN, ..self }
    }
}
