//! Averages a solution over larger texels, for `view.html` and the pages of `diff` and `check`.

use common::Result;
use common::mesh::Mesh;
use common::resample::{area_average, shared_pieces};
use common::scene::Scene;
use common::shooting::RadiosityField;
use common::texel::texel_count;
use glam::{DVec3, Vec4};

/// Maximum number of texels drawn individually; a page then has about ten million bytes.
const MAX_DRAWN_TEXELS: u64 = 1 << 18;
/// Maximum texels per side averaged into one.
const MAX_MERGED_SIDE: u32 = 64;

/// Solution averaged over larger texels.
pub struct CoarseSolution {
    /// Mesh of the averaged texels.
    pub mesh: Mesh,
    /// Averaged radiosity, residual and irradiance.
    pub field: RadiosityField,
    /// Averaged error estimate per texel, W/m².
    pub texel_errors: Option<Vec<f32>>,
    /// Share of each texel that no body covers; none if not known.
    pub open: Option<Vec<f32>>,
}

/// Returns the sizes of all faces in texels at which they are drawn, and how many texels per side one of these merges.
pub fn drawn_sizes(sizes: &[[u32; 2]]) -> (Vec<[u32; 2]>, u32) {
    let count: u64 = sizes.iter().map(|size| u64::from(texel_count(*size))).sum();
    let mut merged = 1;
    while count / u64::from(merged * merged) > MAX_DRAWN_TEXELS && merged < MAX_MERGED_SIDE {
        merged *= 2;
    }
    let sizes = sizes.iter().map(|size| size.map(|n| (n / merged).max(1)));
    (sizes.collect(), merged)
}

impl CoarseSolution {
    /// Averages the solution on `mesh`, with error estimates and open shares, over texels of the given sizes.
    ///
    /// Errors: those of [`Mesh::new`].
    pub fn new(
        scene: &Scene,
        (mesh, field, [errors, open]): (&Mesh, &RadiosityField, [Option<&[f32]>; 2]),
        sizes: &[[u32; 2]],
    ) -> Result<Self> {
        let mut coarse = Mesh::new(scene, sizes, 1)?;
        let average = |value: &dyn Fn(usize) -> DVec3| average_texels(scene, [mesh, &coarse], value);
        let light = |values: &[Vec4]| average(&|k| values[k].truncate().as_dvec3());
        let field = RadiosityField {
            origin: field.origin.clone(),
            radiosity: light(&field.radiosity),
            residual: light(&field.residual),
            irradiance: light(&field.irradiance),
        };
        let scalars = |values: Option<&[f32]>| {
            values.map(|values| {
                let means = average(&|k| DVec3::splat(f64::from(values[k])));
                means.iter().map(|mean| mean.x).collect::<Vec<f32>>()
            })
        };
        let [texel_errors, open] = [errors, open].map(scalars);
        // A captured room's ρ and E vary per texel.
        let emission = average(&|k| mesh.texels[k].emission.as_dvec3());
        let reflectance = average(&|k| mesh.texels[k].reflectance.as_dvec3());
        for ((texel, e), rho) in coarse.texels.iter_mut().zip(emission).zip(reflectance) {
            (texel.emission, texel.reflectance) = (e.truncate(), rho.truncate());
        }
        Ok(Self {
            mesh: coarse,
            field,
            texel_errors,
            open,
        })
    }
}

/// Averages `value` over the texels of a mesh; one mean per texel of a coarser one of the same scene.
fn average_texels(scene: &Scene, [from, to]: [&Mesh; 2], value: &dyn Fn(usize) -> DVec3) -> Vec<Vec4> {
    let mut means = vec![Vec4::ZERO; to.texels.len()];
    let [mut fine, mut coarse] = [from, to].map(|mesh| mesh.texels_in_face_order().into_iter());
    for (f, face) in scene.faces.iter().enumerate() {
        let [fine_size, coarse_size] = [from, to].map(|mesh| mesh.faces[f].resolution);
        let own = fine.by_ref().take(texel_count(fine_size) as usize);
        let own: Vec<DVec3> = own.map(value).collect();
        let averages = area_average(&own, &shared_pieces(face, fine_size, coarse_size), coarse_size);
        for (mean, k) in averages.into_iter().zip(&mut coarse) {
            means[k] = mean.as_vec3().extend(0.0);
        }
    }
    means
}
