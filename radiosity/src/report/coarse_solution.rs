//! Reduces a solution for drawing: texels are averaged in square groups until at most 2¹⁸ remain.

use common::Result;
use common::mesh::Mesh;
use common::resample::{area_average, shared_pieces};
use common::scene::Scene;
use common::shooting::RadiosityField;
use common::texel::texel_count;
use glam::{DVec3, Vec4};

/// Maximum number of texels drawn individually; a page then has about ten million bytes.
const MAX_DRAWN_TEXELS: usize = 1 << 18;
/// Maximum texels per side averaged into one.
const MAX_MERGED_SIDE: u32 = 64;

/// Solution averaged to fewer texels.
pub struct CoarseSolution {
    /// Mesh of the averaged texels.
    pub mesh: Mesh,
    /// Averaged radiosity, residual and irradiance.
    pub field: RadiosityField,
    /// Averaged error estimate per texel, W/m².
    pub texel_errors: Option<Vec<f32>>,
    /// Texels per side averaged into one.
    pub merged_side: u32,
}

impl CoarseSolution {
    /// Averages the solution on `mesh`; none where all its texels can be drawn.
    ///
    /// Errors: those of [`Mesh::new`].
    pub fn new(scene: &Scene, mesh: &Mesh, field: &RadiosityField, off: Option<&[f32]>) -> Result<Option<Self>> {
        let mut over = 1;
        while mesh.texels.len() / (over * over) as usize > MAX_DRAWN_TEXELS && over < MAX_MERGED_SIDE {
            over *= 2;
        }
        if over == 1 {
            return Ok(None);
        }
        let sides = mesh.faces.iter().map(|face| face.resolution);
        let coarse: Vec<[u32; 2]> = sides.map(|side| side.map(|n| (n / over).max(1))).collect();
        let mut coarse = Mesh::new(scene, &coarse, 1)?;
        let average = |value: &dyn Fn(usize) -> DVec3| average_texels(scene, [mesh, &coarse], value);
        let light = |values: &[Vec4]| average(&|k| values[k].truncate().as_dvec3());
        let field = RadiosityField {
            origin: field.origin.clone(),
            radiosity: light(&field.radiosity),
            residual: light(&field.residual),
            irradiance: light(&field.irradiance),
        };
        let off = off.map(|off| {
            let means = average(&|k| DVec3::splat(f64::from(off[k])));
            means.iter().map(|mean| mean.x).collect()
        });
        // A captured room's ρ and E vary per texel.
        let emission = average(&|k| mesh.texels[k].emission.as_dvec3());
        let reflectance = average(&|k| mesh.texels[k].reflectance.as_dvec3());
        for ((texel, e), rho) in coarse.texels.iter_mut().zip(emission).zip(reflectance) {
            (texel.emission, texel.reflectance) = (e.truncate(), rho.truncate());
        }
        Ok(Some(Self {
            mesh: coarse,
            field,
            texel_errors: off,
            merged_side: over,
        }))
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
