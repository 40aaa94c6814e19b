//! The radiosity that a solution claims at every point of the scene, and sampling of points in proportion to
//! it.

use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::shooting::RadiosityField;
use common::texel_point::{SampledOutline, TexelLookup, texel_corners};
use cpu::dense::open_area::nonzero_open_shares;
use cpu::occlusion::occluders::Occluders;
use glam::{DVec3, Vec3};

/// Smallest open share of a texel from which its reflected light leaves.
const MIN_OPEN_SHARE: f64 = 1e-3;

/// Share by which points are moved towards their texel's middle: far more than rounding, far less than the
/// distance over which light changes.
const EDGE_INSET: f32 = 1e-3;

/// The radiosity of a solution.
pub struct ClaimedLight<'a> {
    /// Its texels by place.
    pub lookup: TexelLookup<'a>,
    /// True for texels that a body covers in part.
    partly_covered: Vec<bool>,
    /// Mean radiosity of the open part of each texel, W/m².
    radiosity: Vec<Vec3>,
    /// Sampling density of each texel, not normalised.
    density: Vec<f32>,
    outlines: Vec<SampledOutline>,
    /// Mean reflected radiosity ū, the control variate of gathering: in a white room it removes nearly all
    /// noise.
    pub mean_reflected: Vec3,
    /// Cumulative sum of density times area.
    cumulative_power: Vec<f64>,
}

/// A point drawn in proportion to its radiosity.
pub struct LightSample {
    /// Position in the mesh's unit.
    pub position: Vec3,
    /// Texel of the point.
    pub texel: usize,
}

impl<'a> ClaimedLight<'a> {
    /// Collects the light of `field`. Reflected light leaves from a texel's open share o only: u = E + (B − E)/o.
    pub fn new(scene: &'a Scene, mesh: &'a Mesh, field: &RadiosityField, rays: &Rays) -> Self {
        let open = nonzero_open_shares(scene, mesh, &Occluders::new(scene, mesh), rays);
        let claimed = |k: usize| field.radiosity[k].truncate();
        let leaves = |k: usize| {
            let emission = mesh.texels[k].emission;
            emission + (claimed(k) - emission) / open[k].max(MIN_OPEN_SHARE) as f32
        };
        let texels = 0..mesh.texels.len();
        let radiosity: Vec<Vec3> = texels.clone().map(leaves).collect();
        let density: Vec<f32> = texels.map(|k| claimed(k).abs().element_sum()).collect();
        let mut sum = 0.0;
        let power = density.iter().zip(&mesh.texels).map(|(density, texel)| {
            sum += f64::from(density * texel.area);
            sum
        });
        let passed = power.collect();
        let outline = |texel| SampledOutline::new(texel_corners(mesh, texel));
        Self {
            lookup: TexelLookup::new(mesh),
            partly_covered: open.iter().map(|share| *share < 1.0).collect(),
            radiosity,
            density,
            outlines: mesh.texels.iter().map(outline).collect(),
            mean_reflected: mean_reflected(mesh, field),
            cumulative_power: passed,
        }
    }

    /// Power of all light, sum of channels; W in the mesh's unit.
    fn total_power(&self) -> f64 {
        self.cumulative_power.last().copied().unwrap_or(0.0)
    }

    /// Density with which [`Self::sample_point`] draws points of a texel; its integral over all faces is 1.
    pub fn sampling_density(&self, texel: usize) -> f32 {
        self.density[texel] / self.total_power() as f32
    }

    /// Mean of u over a texel.
    pub fn mean_radiosity(&self, texel: usize) -> Vec3 {
        self.radiosity[texel]
    }

    /// True if a body covers a part of a texel.
    pub fn is_partly_covered(&self, texel: usize) -> bool {
        self.partly_covered[texel]
    }

    /// Maps u, v in 0…1 to a point of a texel; the map keeps ratios of areas.
    pub fn point_of_texel(&self, texel: usize, at: [f32; 2]) -> Vec3 {
        self.outlines[texel].point_at(at)
    }

    /// Moves a point of a texel away from the texel's edges, so that rounding does not put it behind another wall.
    pub fn inset_point(&self, texel: usize, point: Vec3) -> Vec3 {
        let middle = self.outlines[texel].corners.iter().sum::<Vec3>() / 4.0;
        point.lerp(middle, EDGE_INSET)
    }

    /// Draws a point in proportion to its radiosity, from three numbers in 0…1.
    pub fn sample_point(&self, [which, u, v]: [f32; 3]) -> LightSample {
        let wanted = f64::from(which) * self.total_power();
        let k = self.cumulative_power.partition_point(|passed| *passed <= wanted);
        let k = k.min(self.cumulative_power.len() - 1);
        LightSample {
            position: self.point_of_texel(k, [u, v]),
            texel: k,
        }
    }
}

fn mean_reflected(mesh: &Mesh, field: &RadiosityField) -> Vec3 {
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    for (texel, b) in mesh.texels.iter().zip(&field.radiosity) {
        sum += (b.truncate() - texel.emission).as_dvec3() * f64::from(texel.area);
        area += f64::from(texel.area);
    }
    (sum / f64::max(area, f64::MIN_POSITIVE)).as_vec3()
}

/// Reflected radiosity ρH that the solution claims for texel `k`.
pub fn claimed_reflection(mesh: &Mesh, field: &RadiosityField, k: usize) -> DVec3 {
    let texel = &mesh.texels[k];
    texel.reflectance.as_dvec3() * field.irradiance[k].truncate().as_dvec3()
}
