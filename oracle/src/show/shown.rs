//! What is drawn of a solve with more texels than one can see: means over some of them.

use crate::judge::resample::{average, pieces};
use common::Result;
use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::Field;
use common::texel::count;
use glam::{DVec3, Vec4};

/// Texels that are drawn one by one: a page of ten million bytes.
const MOST: usize = 1 << 18;
/// No texel that is drawn is more of them a side.
const COARSEST: u32 = 64;

/// Fewer texels.
pub struct Shown {
    /// They.
    pub mesh: Mesh,
    /// Their light.
    pub field: Field,
    /// How far each may be off, W/m².
    pub off: Option<Vec<f32>>,
    /// How many a side make up one.
    pub over: u32,
}

impl Shown {
    /// Of `scene` as it was solved on `mesh`; none where all of it is drawn.
    ///
    /// Errors: those of a mesh.
    pub fn new(
        scene: &Scene,
        mesh: &Mesh,
        field: &Field,
        off: Option<&[f32]>,
    ) -> Result<Option<Self>> {
        let mut over = 1;
        while mesh.texels.len() / (over * over) as usize > MOST && over < COARSEST {
            over *= 2;
        }
        if over == 1 {
            return Ok(None);
        }
        let sides = mesh.faces.iter().map(|face| face.resolution);
        let fewer: Vec<[u32; 2]> = sides.map(|side| side.map(|n| (n / over).max(1))).collect();
        let mut fewer = Mesh::new(scene, &fewer, 1)?;
        let onto = Onto {
            scene,
            from: mesh,
            to: &fewer,
        };
        let light = |values: &[Vec4]| onto.means(|k| values[k].truncate().as_dvec3());
        let field = Field {
            origin: field.origin.clone(),
            radiosity: light(&field.radiosity),
            residual: light(&field.residual),
            irradiance: light(&field.irradiance),
        };
        let off = off.map(|off| {
            let means = onto.means(|k| DVec3::splat(f64::from(off[k])));
            means.iter().map(|mean| mean.x).collect()
        });
        // What was captured has a ρ and an E of its own in each texel.
        let emission = onto.means(|k| mesh.texels[k].emission.as_dvec3());
        let reflectance = onto.means(|k| mesh.texels[k].reflectance.as_dvec3());
        for ((texel, e), rho) in fewer.texels.iter_mut().zip(emission).zip(reflectance) {
            (texel.emission, texel.reflectance) = (e.truncate(), rho.truncate());
        }
        Ok(Some(Self {
            mesh: fewer,
            field,
            off,
            over,
        }))
    }
}

struct Onto<'a> {
    scene: &'a Scene,
    from: &'a Mesh,
    to: &'a Mesh,
}

impl Onto<'_> {
    /// Means of each texel's `value`, in the order of the fewer texels.
    fn means(&self, value: impl Fn(usize) -> DVec3) -> Vec<Vec4> {
        let mut means = vec![Vec4::ZERO; self.to.texels.len()];
        let mut from = self.from.in_face_order().into_iter();
        let mut to = self.to.in_face_order().into_iter();
        for (f, face) in self.scene.faces.iter().enumerate() {
            let [many, few] = [self.from, self.to].map(|mesh| mesh.faces[f].resolution);
            let own: Vec<DVec3> = from
                .by_ref()
                .take(count(many) as usize)
                .map(&value)
                .collect();
            let found = average(&own, &pieces(face, many, few), few);
            for (mean, k) in found.into_iter().zip(&mut to) {
                means[k] = mean.as_vec3().extend(0.0);
            }
        }
        means
    }
}
