//! Gaps much narrower than a texel: part of it lies in the dark under a face, and what the rest of it
//! reflects is shot from all of it. No choice of cells shows that, only more texels do. Under a lamp
//! it is not dark: what lies that close is lit by E°, what the lamp emits.

use common::mesh::{Cover, Mesh, Point};
use common::rays::Rays;
use common::shooting::Run;
use rayon::prelude::*;

/// A face nearer than this, in radii of a texel, leaves nothing to see.
const NARROW: f32 = 0.1;

/// Of all reflected light, what is shot into such gaps; and the faces it leaves, most first.
pub fn light_in_gaps(mesh: &Mesh, run: &Run) -> (f64, Vec<u32>) {
    let rays = Rays::new(mesh);
    let escaped = {
        let mut shares = vec![0.0; mesh.cells.len()];
        for shot in &run.shots {
            shares[shot.cell as usize] = f64::from(shot.escaped);
        }
        shares
    };
    let (mut all, mut faces) = (0.0, vec![0.0f64; mesh.faces.len()]);
    let lamps = lamps(mesh);
    let dark: Vec<f64> = (0..mesh.cells.len())
        .into_par_iter()
        .map(|c| dark(mesh, run, &rays, &lamps, c))
        .collect();
    for (c, cell) in mesh.cells.iter().enumerate() {
        let reflected: f64 = cell.texels().map(|k| reflected(mesh, run, k)).sum();
        all += reflected;
        // All of it in a gap: then it is dark, and that is right.
        if dark[c] < 1.0 {
            faces[cell.face as usize] += dark[c] * (1.0 - escaped[c]) * reflected;
        }
    }
    let lost: f64 = faces.iter().sum();
    let mut order: Vec<u32> = (0..faces.len() as u32).collect();
    order.retain(|k| faces[*k as usize] > 0.0);
    order.sort_by(|a, b| faces[*b as usize].total_cmp(&faces[*a as usize]));
    (if lost > 0.0 { lost / all } else { 0.0 }, order)
}

/// The mean emission of each face, its channels added up.
fn lamps(mesh: &Mesh) -> Vec<f32> {
    let (mut lamps, mut texels) = (vec![0.0; mesh.faces.len()], vec![0.0; mesh.faces.len()]);
    for texel in &mesh.texels {
        lamps[texel.face as usize] += texel.emission.element_sum();
        texels[texel.face as usize] += 1.0;
    }
    lamps.iter().zip(texels).map(|(l, n)| l / n).collect()
}

/// The share of a cell's points that have a face close above them, each by the share of the cell's
/// light that is missing there: 1 − E°/H.
fn dark(mesh: &Mesh, run: &Run, rays: &Rays, lamps: &[f32], c: usize) -> f64 {
    let cell = &mesh.cells[c];
    let face = &mesh.faces[cell.face as usize];
    let up = cell.shooter.normal * (NARROW * face.texel_radius);
    let ends = [cell.face, cell.face];
    let found = irradiance(mesh, run, c);
    let missing = |point: &Point| {
        let above = rays.blockers(point.position, point.position + up, ends);
        let facing = |k: &&u32| mesh.faces[**k as usize].normal.dot(cell.shooter.normal) < 0.0;
        let lit = above.iter().filter(facing).map(|k| lamps[*k as usize]);
        let lit = f64::from(lit.fold(0.0, f32::max));
        if above.is_empty() || lit >= found {
            0.0
        } else {
            1.0 - lit / found
        }
    };
    let samples = mesh.samples as usize;
    let points = &mesh.points[c * samples..(c + 1) * samples];
    let open = points.iter().filter(|point| point.cover == Cover::Open);
    open.map(missing).sum::<f64>() / samples as f64
}

/// H of a cell, the mean over its texels, its channels added up.
fn irradiance(mesh: &Mesh, run: &Run, c: usize) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for k in mesh.cells[c].texels() {
        let a = f64::from(mesh.texels[k].area);
        sum += a * f64::from(run.field.irradiance[k].truncate().abs().element_sum());
        area += a;
    }
    sum / f64::max(area, f64::MIN_POSITIVE)
}

fn reflected(mesh: &Mesh, run: &Run, k: usize) -> f64 {
    let texel = &mesh.texels[k];
    let light = run.field.radiosity[k].truncate() - texel.emission;
    f64::from(texel.area * light.abs().element_sum())
}
