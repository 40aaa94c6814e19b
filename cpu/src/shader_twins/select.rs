//! Selection of the next shooter, and the record of the shot just done.

pub use common::dispatch::count_workgroups;
pub use common::shooting::{choose_shooter, reduce_power, select_first, select_next};

use crate::shader_twins::deposit::ShotInFlight;
use common::mesh::Mesh;
use common::passes::PatchClosure;
use common::shooting::{DepositRule, Shot, total_power};
use glam::Vec3;

/// Returns the record of a shot of `patch`, after which the patches have this unshot `power`.
pub fn record_shot(patch: u32, flux: Vec3, scale: f32, closure: PatchClosure, power: &[f32]) -> Shot {
    Shot {
        patch,
        power: flux.into(),
        form_factor_sum: closure.form_factor_sum * scale,
        escaped: closure.escaped,
        unshot: total_power(power),
    }
}

/// Returns the shot of patch number `patch`, which has this unshot `flux`.
pub fn load_shot<'a>(
    mesh: &'a Mesh,
    patch: u32,
    flux: Vec3,
    scale: f32,
    rule: DepositRule,
    reflectance: &'a [Vec3],
) -> ShotInFlight<'a> {
    let patch = &mesh.patches[patch as usize];
    ShotInFlight {
        mesh,
        patch,
        radiosity: flux / patch.shooter.area,
        scale,
        rule,
        reflectance,
    }
}
