//! What a radiosity that is given sends to each texel, and what the difference from it sends in turn.

use crate::hierarchy::descent::Receiving;
use crate::hierarchy::find::Way;
use crate::hierarchy::solve::{CORRECTED, FINE, Goal, sum};
use crate::hierarchy::state::{Solve, prepared};
use crate::hierarchy::world::{Watch, What};
use common::Result;
use common::mesh::Mesh;
use common::scene::Scene;
use glam::Vec3;

/// The light that follows from light.
pub struct Anew {
    /// H of each texel as the given radiosity sends it, the mean over its area, W/m².
    pub irradiance: Vec<Vec3>,
    /// What its difference from the given H sends in turn, over all further bounces.
    pub later: Vec<Vec3>,
    /// The open share of its area.
    pub open: Vec<f32>,
}

/// What the radiosity whose part `reflected` is ρH, on the texels of `mesh`, sends to each texel.
///
/// Errors: those of [`crate::hierarchy::solve::solve`].
pub fn anew(
    scene: &Scene,
    mesh: &Mesh,
    reflected: &[Vec3],
    goal: Goal,
    watch: Watch,
) -> Result<Anew> {
    prepared(scene, mesh, &[], Way::Shafts, |solve| {
        follow(solve, reflected, goal, watch)
    })
}

fn follow(mut solve: Solve, reflected: &[Vec3], goal: Goal, watch: Watch) -> Result<Anew> {
    let texels = &solve.world.mesh.texels;
    let share = |a: Vec3, b: Vec3| Vec3::select(b.cmpgt(Vec3::ZERO), a / b, Vec3::ZERO);
    let received: Vec<Vec3> = reflected
        .iter()
        .zip(texels)
        .map(|(r, t)| share(*r, t.reflectance))
        .collect();
    let received = solve.of_open(&received);
    let shone = solve.reflected(&received);
    let emission: Vec<Vec3> = texels.iter().map(|t| t.emission).collect();
    let emitted = sum(&shone, &emission);
    let glow = solve.glow(&emitted);
    solve.first_look(&emitted, &glow, watch)?;
    let all = Receiving::on(0..solve.world.mesh.faces.len());
    let found = solve.at_texels(What::Light, &glow, &all, goal.fine, FINE, watch)?;
    let new = solve.of_open(&found);
    let delta: Vec<Vec3> = new.iter().zip(&received).map(|(n, h)| *n - *h).collect();
    // Links are those of the light that there will be: a result may be dark where it should not.
    let more = solve.ambient(&solve.reflected(&delta)).max(Vec3::ZERO);
    let light: Vec<Vec3> = new.iter().map(|h| *h + more).collect();
    solve.scale = solve.inverse_rms(&light);
    let glow = solve.glow(&sum(&emission, &solve.reflected(&light)));
    let kept = solve.kept(&glow, goal.coarse, watch)?;
    let later = solve.spend(&kept, &solve.reflected(&delta), CORRECTED, watch)?;
    let over = later.received.iter().zip(&solve.open);
    Ok(Anew {
        irradiance: found,
        later: over.map(|(h, open)| *h * *open).collect(),
        open: solve.open,
    })
}
