//! The first shot of the GPU beside that of the CPU, stage by stage: which stage errs.

use common::Result;
use common::mesh::Mesh;
use common::settings::Transport;
use common::shooting::{RadiosityField, Shoot, Shot, ShotOrder};
use cpu::CpuSolver;
use glam::Vec4;
use gpu::{Gpu, GpuSolver};
use std::ops::ControlFlow;

/// Relative difference beyond which a stage errs: roundings of a sum over texels in f32 are below it, and the smallest faults
/// of a shader above.
const STAGE_TOLERANCE: f64 = 1e-3;

/// What a solver has done in one shot.
struct FirstShot {
    /// Unshot power of each patch before it.
    power: Vec<f32>,
    shot: Shot,
    field: RadiosityField,
}

/// Returns the first stage, in the order of a shot, whose result on the GPU differs from that of the CPU; none if none does.
///
/// Errors: those of the device.
pub async fn find_wrong_stage(gpu: &Gpu, mesh: &Mesh, transport: &Transport) -> Result<Option<&'static str>> {
    let own = shoot_on_gpu(gpu, mesh, transport).await?;
    let Some(own) = own.filter(|own| (own.shot.patch as usize) < mesh.patches.len()) else {
        return Ok(Some("choice of the shooter: select.wgsl"));
    };
    let twin = shoot_on_cpu(mesh, transport, own.shot.patch)?;
    Ok(name_first_difference(&own, &twin))
}

async fn shoot_on_gpu(gpu: &Gpu, mesh: &Mesh, transport: &Transport) -> Result<Option<FirstShot>> {
    let mut solver = GpuSolver::request(gpu, mesh, transport).await?;
    let power = solver.request_power().await?;
    let mut first = None;
    let mut watch = |shot: &Shot| {
        first = Some(*shot);
        ControlFlow::Break(())
    };
    let order = ShotOrder::Greedy { threshold: 0.0 };
    solver.request_shots(order, 1, &mut watch).await?;
    let field = solver.request_field().await?;
    Ok(first.map(|shot| FirstShot { power, shot, field }))
}

fn shoot_on_cpu(mesh: &Mesh, transport: &Transport, patch: u32) -> Result<FirstShot> {
    let mut solver = CpuSolver::new(mesh, transport);
    let power = solver.patch_power()?;
    let shot = solver.shoot(patch)?;
    let field = solver.read_field()?;
    Ok(FirstShot { power, shot, field })
}

fn name_first_difference(own: &FirstShot, twin: &FirstShot) -> Option<&'static str> {
    let largest = twin.power.iter().copied().fold(0.0, f32::max);
    let chosen = twin.power.get(own.shot.patch as usize).copied().unwrap_or(0.0);
    let links = |shot: &FirstShot| shot.field.irradiance.iter().map(|value| value.w).collect::<Vec<f32>>();
    let [own_links, twin_links] = [links(own), links(twin)];
    let numbers = |values: &[Vec4]| {
        values
            .iter()
            .flat_map(|value| value.truncate().to_array())
            .collect::<Vec<f32>>()
    };
    let fields = |shot: &FirstShot| {
        [&shot.field.radiosity, &shot.field.residual]
            .map(|values| numbers(values))
            .concat()
    };
    let single = |a: f32, b: f32| differ(&[a], &[b]);
    let stages = [
        (differ(&own.power, &twin.power), "unshot power: unshot_power.wgsl"),
        (
            chosen < largest * (1.0 - STAGE_TOLERANCE as f32) || differ(&own.shot.power, &twin.shot.power),
            "choice of the shooter: select.wgsl",
        ),
        (
            sees_others(&own_links, &twin_links),
            "visible shares: rays.wgsl and bvh.wgsl, or item_buffer.wgsl and lookup.wgsl with what they use",
        ),
        (
            differ(&own_links, &twin_links),
            "form factors: form_factor.wgsl and link.wgsl",
        ),
        (
            single(own.shot.form_factor_sum, twin.shot.form_factor_sum),
            "sum of the form factors: closure.wgsl",
        ),
        (
            single(own.shot.escaped, twin.shot.escaped),
            "escaped share: escape.wgsl",
        ),
        (differ(&fields(own), &fields(twin)), "deposit: deposit.wgsl"),
        (
            single(own.shot.unshot, twin.shot.unshot),
            "sum of the unshot power: select.wgsl",
        ),
    ];
    stages.into_iter().find(|(is_wrong, _)| *is_wrong).map(|(_, name)| name)
}

/// Returns whether many texels are linked by one solver alone: it sees others than the other does.
fn sees_others(own: &[f32], twin: &[f32]) -> bool {
    let pairs = own.iter().zip(twin).filter(|(a, b)| (**a == 0.0) != (**b == 0.0));
    let seen_by_one: Vec<f32> = pairs.map(|(a, b)| a + b).collect();
    size_of(&seen_by_one) > STAGE_TOLERANCE * size_of(twin)
}

/// Returns whether the RMS difference is beyond the tolerance, or something is no number.
fn differ(own: &[f32], twin: &[f32]) -> bool {
    let difference: Vec<f32> = own.iter().zip(twin).map(|(a, b)| a - b).collect();
    let share = size_of(&difference) / size_of(twin).max(f64::MIN_POSITIVE);
    own.len() != twin.len() || share.is_nan() || share > STAGE_TOLERANCE
}

fn size_of(values: &[f32]) -> f64 {
    values.iter().map(|value| f64::from(*value).powi(2)).sum::<f64>().sqrt()
}
