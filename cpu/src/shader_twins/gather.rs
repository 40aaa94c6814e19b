//! Gathering of many shots at once: y_k = Σ_i x_i w_ik, in f32 and in the order of the shots. At texels w are
//! links, at patches transfers.

use common::mesh::Texel;
use glam::Vec3;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Receivers of a task: their sums stay in the first-level cache.
const TASK_RECEIVERS: usize = 1024;

/// Adds every row times its shot to `sums`, in the order of `rows`.
pub fn gather_irradiance(arch: Arch, rows: &[(Vec3, &[f32])], sums: &mut [Vec3]) {
    sums.par_chunks_mut(TASK_RECEIVERS)
        .enumerate()
        .for_each(|(task, sums)| {
            arch.dispatch(AccumulateTask {
                rows,
                first: task * TASK_RECEIVERS,
                sums,
            });
        });
}

/// The receivers of one task.
struct AccumulateTask<'a> {
    rows: &'a [(Vec3, &'a [f32])],
    first: usize,
    sums: &'a mut [Vec3],
}

impl NullaryFnOnce for AccumulateTask<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (first, sums) = (self.first, self.sums);
        let mut lanes = [[0.0f32; TASK_RECEIVERS]; 3];
        for (k, sum) in sums.iter().enumerate() {
            [lanes[0][k], lanes[1][k], lanes[2][k]] = sum.to_array();
        }
        let [x, y, z] = &mut lanes;
        for (shot, row) in self.rows {
            let row = &row[first..first + sums.len()];
            for (k, w) in row.iter().enumerate() {
                x[k] += shot.x * w;
                y[k] += shot.y * w;
                z[k] += shot.z * w;
            }
        }
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum = Vec3::new(lanes[0][k], lanes[1][k], lanes[2][k]);
        }
    }
}

/// Returns B = E + ρH.
pub fn update_radiosity(texel: &Texel, reflectance: Vec3, irradiance: Vec3) -> Vec3 {
    let reflected = reflectance * irradiance;
    texel.emission + reflected
}
