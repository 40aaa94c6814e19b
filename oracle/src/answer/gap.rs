//! Gaps much narrower than a texel: part of it lies in the dark under a face, and what the rest of it
//! reflects is shot from all of it. No choice of cells shows that, only more texels do.

use common::mesh::{Cover, Mesh};
use common::shooting::Run;
use cpu::rays::Rays;
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
    let hidden: Vec<f64> = (0..mesh.cells.len())
        .into_par_iter()
        .map(|c| hidden(mesh, &rays, c))
        .collect();
    for (c, cell) in mesh.cells.iter().enumerate() {
        let reflected: f64 = cell.texels().map(|k| reflected(mesh, run, k)).sum();
        all += reflected;
        // All of it in a gap: then it is dark, and that is right.
        if hidden[c] < 1.0 {
            faces[cell.face as usize] += hidden[c] * (1.0 - escaped[c]) * reflected;
        }
    }
    let lost: f64 = faces.iter().sum();
    let mut order: Vec<u32> = (0..faces.len() as u32).collect();
    order.retain(|k| faces[*k as usize] > 0.0);
    order.sort_by(|a, b| faces[*b as usize].total_cmp(&faces[*a as usize]));
    (if lost > 0.0 { lost / all } else { 0.0 }, order)
}

/// The share of a cell's points that have a face close above them.
fn hidden(mesh: &Mesh, rays: &Rays, c: usize) -> f64 {
    let cell = &mesh.cells[c];
    let face = &mesh.faces[cell.face as usize];
    let up = cell.shooter.normal * (NARROW * face.texel_radius);
    let samples = mesh.samples as usize;
    let points = &mesh.points[c * samples..(c + 1) * samples];
    let near = |point: &&common::mesh::Point| {
        let ends = [cell.face, cell.face];
        point.cover == Cover::Open && !rays.visible(point.position, point.position + up, ends)
    };
    points.iter().filter(near).count() as f64 / samples as f64
}

fn reflected(mesh: &Mesh, run: &Run, k: usize) -> f64 {
    let texel = &mesh.texels[k];
    let light = run.field.radiosity[k].truncate() - texel.emission;
    f64::from(texel.area * light.abs().element_sum())
}
