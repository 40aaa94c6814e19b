//! Light from outside the scene in a solve by rays. A ray that leaves the scene brings what the sky shows in its direction.
//!
//! The box around the scene is divided into cells, and points are drawn on those through which rays left, in proportion to
//! the light that they brought: through a window light comes from a small part of all directions. What either kind of ray
//! brings is weighted as that of lamps is. Suns are too small to be met: a ray goes to each directly.

use common::Result;
use common::capture::sky::{SUN_SOLID_ANGLE, build_sky_faces};
use common::escape::escape_directions;
use common::mesh::{Mesh, Texel};
use common::rays::{RayEnd, Rays};
use common::scene::Scene;
use common::sky::{Sky, Sun};
use common::texel_point::locate_texel;
use glam::{DVec3, UVec3, Vec3};
use rayon::prelude::*;

/// Cells per side of a side of the box.
const CELLS_PER_SIDE: u32 = 32;
/// Distance of the box from the scene, mesh units.
const BOX_MARGIN: f32 = 0.01;
/// Rays that look for ways out of the scene.
const PILOT_RAYS: usize = 1 << 17;
/// Step between the directions of successive rays: coprime to their number, and large.
const DIRECTION_STRIDE: usize = 387;
/// Distance of a point of a sun: beyond the scene, which is two units wide.
const SUN_DISTANCE: f32 = 8.0;

/// The sky around a scene.
pub struct SkyLight {
    /// A box of two units around the origin, whose texels are the sky's; none if there are only suns.
    shown: Option<(Mesh, Rays)>,
    radiosity: Vec<Vec3>,
    /// Suns.
    pub suns: Vec<Sun>,
    low: Vec3,
    high: Vec3,
    /// Probability of each cell, and the sum over it and those before; empty where no ray left.
    cells: Vec<[f32; 2]>,
}

impl SkyLight {
    /// Finds where light from outside enters the scene of `mesh`; none without a sky.
    ///
    /// Errors: those of the sky's faces.
    pub fn new(scene: &Scene, mesh: &Mesh, rays: &Rays) -> Result<Option<Self>> {
        let Some(sky) = &scene.sky else {
            return Ok(None);
        };
        let alone = Sky {
            suns: Vec::new(),
            ..(**sky).clone()
        };
        // Its faces are 4096 units away.
        let built = build_sky_faces(&alone, DVec3::ZERO, 1.0 / 4096.0)?;
        let faces = Scene {
            faces: built.faces,
            ..Scene::default()
        };
        let shown = match faces.faces.is_empty() {
            true => None,
            false => {
                let shown = Mesh::within_bounds(&faces, &built.resolutions, 1, (DVec3::ZERO, 1.0))?;
                let rays = Rays::new(&shown);
                Some((shown, rays))
            }
        };
        let corners = || mesh.faces.iter().flat_map(|face| face.corners);
        let mut light = Self {
            shown,
            radiosity: built.radiosity,
            suns: sky.suns.clone(),
            low: corners().fold(Vec3::INFINITY, Vec3::min) - BOX_MARGIN,
            high: corners().fold(Vec3::NEG_INFINITY, Vec3::max) + BOX_MARGIN,
            cells: Vec::new(),
        };
        if light.shown.is_some() {
            light.find_ways_out(mesh, rays);
        }
        Ok(Some(light))
    }

    /// Traces rays from all texels and sets the probability of each cell.
    fn find_ways_out(&mut self, mesh: &Mesh, rays: &Rays) {
        let directions = escape_directions();
        let each = (PILOT_RAYS / mesh.texels.len().max(1)).clamp(1, directions.len());
        let leaving = |(k, texel): (usize, &Texel)| -> Vec<(usize, f32)> {
            let face = &mesh.faces[texel.face as usize];
            let ways = (0..each).filter_map(|n| {
                // All directions in turn from one texel to the next, spread evenly over the hemisphere.
                let d = directions[(k * each + n) * DIRECTION_STRIDE % directions.len()];
                let direction = face.direction_in_frame(d);
                let left = matches!(rays.trace_ray(texel.position, direction, face.sheet), RayEnd::Outside);
                let brought = self.radiosity_along(direction).element_sum() * texel.area;
                left.then(|| (self.exit_cell(texel.position, direction).0, brought))
            });
            ways.collect()
        };
        let left: Vec<Vec<(usize, f32)>> = mesh.texels.par_iter().enumerate().map(leaving).collect();
        let mut light = vec![0.0; 6 * (CELLS_PER_SIDE * CELLS_PER_SIDE) as usize];
        for (cell, brought) in left.into_iter().flatten() {
            light[cell] += f64::from(brought);
        }
        let all: f64 = light.iter().sum();
        let mut sum = 0.0;
        if all > 0.0 {
            let cell = |light: f64| {
                sum += light / all;
                [(light / all) as f32, sum as f32]
            };
            self.cells = light.into_iter().map(cell).collect();
        }
    }

    /// Returns whether a ray left the scene: only then are points drawn.
    pub fn has_ways_out(&self) -> bool {
        !self.cells.is_empty()
    }

    /// Returns the radiosity of the sky in a direction.
    pub fn radiosity_along(&self, direction: Vec3) -> Vec3 {
        let met = self.shown.as_ref().and_then(|(shown, rays)| {
            let (f, t) = rays.nearest_front(Vec3::ZERO, direction)?;
            Some((&shown.faces[f as usize], f, t))
        });
        let Some((face, f, t)) = met else {
            return Vec3::ZERO;
        };
        let [w, h] = face.resolution;
        self.radiosity[(f * w * h + locate_texel(face, direction * t)) as usize]
    }

    /// Returns the cell by which a ray from within the box leaves it, and its parameter and the axis of its side.
    fn exit_cell(&self, origin: Vec3, direction: Vec3) -> (usize, f32, usize) {
        let far = Vec3::select(direction.cmpgt(Vec3::ZERO), self.high, self.low);
        let along = (far - origin) / direction;
        let along = Vec3::select(direction.abs().cmpgt(Vec3::splat(1e-20)), along, Vec3::INFINITY);
        let axis = along.min_position();
        let place = (origin + direction * along[axis] - self.low) / (self.high - self.low);
        let cell = (place * CELLS_PER_SIDE as f32)
            .as_uvec3()
            .min(UVec3::splat(CELLS_PER_SIDE - 1));
        let [u, v] = [cell[(axis + 1) % 3], cell[(axis + 2) % 3]];
        let side = 2 * axis as u32 + u32::from(direction[axis] > 0.0);
        let index = (side * CELLS_PER_SIDE + v) * CELLS_PER_SIDE + u;
        (index as usize, along[axis], axis)
    }

    /// Returns the area of a cell on a side across `axis`.
    fn cell_area(&self, axis: usize) -> f32 {
        let size = (self.high - self.low) / CELLS_PER_SIDE as f32;
        size[(axis + 1) % 3] * size[(axis + 2) % 3]
    }

    /// Returns the density, by solid angle, with which [`Self::draw_point`] draws the unit `direction` from `origin`.
    pub fn direction_density(&self, origin: Vec3, direction: Vec3) -> f32 {
        if self.cells.is_empty() {
            return 0.0;
        }
        let (cell, distance, axis) = self.exit_cell(origin, direction);
        let cosine = direction[axis].abs();
        self.cells[cell][0] / self.cell_area(axis) * distance * distance / cosine.max(f32::MIN_POSITIVE)
    }

    /// Draws a point of the box by numbers in [0, 1).
    pub fn draw_point(&self, number: f32, [x, y]: [f32; 2]) -> Vec3 {
        let most = self.cells.len() - 1;
        let k = self.cells.partition_point(|[_, sum]| *sum <= number).min(most) as u32;
        let (side, cell) = (
            k / (CELLS_PER_SIDE * CELLS_PER_SIDE),
            k % (CELLS_PER_SIDE * CELLS_PER_SIDE),
        );
        let axis = (side / 2) as usize;
        let place = |n: u32, offset: f32| (n as f32 + offset) / CELLS_PER_SIDE as f32;
        let mut share = Vec3::splat((side % 2) as f32);
        share[(axis + 1) % 3] = place(cell % CELLS_PER_SIDE, x);
        share[(axis + 2) % 3] = place(cell / CELLS_PER_SIDE, y);
        self.low + (self.high - self.low) * share
    }
}

/// Returns the offset from any point of the scene to a point of a sun's disc.
pub fn offset_to_sun(sun: &Sun, [x, y]: [f32; 2]) -> Vec3 {
    let towards = sun.direction.as_vec3();
    let u = towards.any_orthonormal_vector();
    let width = (SUN_SOLID_ANGLE as f32).sqrt();
    let aside = u * ((x - 0.5) * width) + towards.cross(u) * ((y - 0.5) * width);
    (towards + aside) * SUN_DISTANCE
}
