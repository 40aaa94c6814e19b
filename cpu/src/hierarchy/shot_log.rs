//! The log of shots of a hierarchical solution: each face shoots once, with all power that leaves it.

use crate::hierarchy::solver::TexelSolution;
use common::cover::{cover_directions, is_open};
use common::escape::{meets_front, weyl_sequence};
use common::mesh::{Mesh, Patch, Texel};
use common::rays::Rays;
use common::shooting::{RadiosityField, Shot, SolveRun};
use common::texel_point::point_on_texel;
use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

/// Rays of all faces that measure the escaped light: a tenth of a second's work.
const ESCAPE_RAY_COUNT: usize = 1 << 17;
/// Rays of each face at least.
const MIN_FACE_RAYS: usize = 4;
/// Steps by which the rays of a face are numbered on from those of the face before, so that their errors differ.
const FACE_RAY_STEP: usize = 7919;
/// Points of a partly covered texel that are tried before one counts as open.
const MAX_POINT_TRIES: usize = 8;

/// Returns `solution` as a run on `mesh`, of which each face is one patch; `escaped` is the share of each face's power
/// that meets no front, of [`measure_escape`].
pub fn record_run(mesh: &Mesh, solution: &TexelSolution, escaped: &[f32]) -> SolveRun {
    let mut powers = vec![DVec3::ZERO; mesh.patches.len()];
    let (mut emitted, mut unshot, mut received) = (0.0, 0.0, 0.0);
    let mut field = RadiosityField {
        origin: "hierarchy".into(),
        radiosity: Vec::with_capacity(mesh.texels.len()),
        residual: solution.residual.iter().map(|r| r.extend(0.0)).collect(),
        irradiance: solution.irradiance.iter().map(|h| h.extend(0.0)).collect::<Vec<Vec4>>(),
    };
    for ((k, texel), sent) in mesh.texels.iter().enumerate().zip(sent_powers(mesh, solution)) {
        let area = f64::from(texel.area);
        let (h, r) = (solution.irradiance[k], solution.residual[k]);
        field
            .radiosity
            .push((texel.emission + texel.reflectance * h).extend(0.0));
        powers[texel.face as usize] += sent;
        emitted += channel_sum(texel.emission + texel.sky) * area;
        unshot += channel_sum(r.abs()) * area;
        received += channel_sum(h - texel.sky) * area;
    }
    let shot: f64 = powers.iter().map(|p| p.element_sum()).sum();
    let form_factor_sum = if shot > 0.0 { received / shot } else { 0.0 };
    let patches = (0..mesh.patches.len()).filter(|k| powers[*k] != DVec3::ZERO);
    let shots: Vec<Shot> = patches
        .map(|k| Shot {
            patch: k as u32,
            power: powers[k].as_vec3().into(),
            form_factor_sum: form_factor_sum as f32,
            escaped: escaped[k],
            unshot: unshot as f32,
        })
        .collect();
    SolveRun {
        emitted: emitted as f32,
        converged: solution.converged,
        stagnated: false,
        passes: solution.passes,
        shooters: shots.len() as u64,
        shots,
        field,
    }
}

/// Returns the power that each texel sent.
fn sent_powers(mesh: &Mesh, solution: &TexelSolution) -> Vec<DVec3> {
    let sent = |(k, texel): (usize, &Texel)| {
        let reflected = texel.reflectance * solution.irradiance[k];
        let leaving = texel.emission * solution.open[k] + reflected - solution.residual[k];
        leaving.as_dvec3() * f64::from(texel.area)
    };
    mesh.texels.iter().enumerate().map(sent).collect()
}

/// Returns the share of each face's power that meets no front. It is measured on the texels that were solved: within a
/// larger one of the result light may leave from one side only.
pub fn measure_escape(mesh: &Mesh, solution: &TexelSolution) -> Vec<f32> {
    escaped_shares(mesh, &sent_powers(mesh, solution), &solution.open)
}

/// Sets the open share of each patch of `mesh` to the mean of its texels' open shares.
pub fn set_open_shares(mesh: &mut Mesh, solution: &TexelSolution) {
    let mut open = vec![[0.0; 2]; mesh.patches.len()];
    for (texel, share) in mesh.texels.iter().zip(&solution.open) {
        let area = f64::from(texel.area);
        open[texel.face as usize][0] += area;
        open[texel.face as usize][1] += area * f64::from(*share);
    }
    for (patch, [all, open]) in mesh.patches.iter_mut().zip(open) {
        patch.open_share = if all > 0.0 { (open / all) as f32 } else { 0.0 };
    }
}

/// Returns the share of each patch's power that meets no front. Origins are drawn in proportion to the power
/// `sent` by each texel, which may be small just where the sky is visible: above a lamp, or outside a wall. The
/// number of rays of a patch is in proportion to its power: few large lamps among many small faces decide the sum.
fn escaped_shares(mesh: &Mesh, sent: &[DVec3], shares: &[f32]) -> Vec<f32> {
    let sky = SkyVisibility {
        mesh,
        rays: Rays::new(mesh),
        cover_directions: cover_directions(),
        shares,
    };
    let power_of = |sent: &DVec3| sent.abs().element_sum();
    let all: f64 = sent.iter().map(power_of).sum();
    let escaped_share = |(number, patch): (usize, &Patch)| {
        let sums = patch.texels().scan(0.0, |sum, k| {
            *sum += power_of(&sent[k]);
            Some(*sum)
        });
        let sums: Vec<f64> = sums.collect();
        let power = sums.last().copied().unwrap_or(0.0);
        if power == 0.0 {
            return 0.0;
        }
        let count = ((ESCAPE_RAY_COUNT as f64 * power / all) as usize).max(MIN_FACE_RAYS);
        let first = number * FACE_RAY_STEP;
        let seen = (0..count).filter_map(|n| {
            let drawn = power * weyl_sequence(n, 0.618_033_988_749_895);
            let drawn = sums.partition_point(|sum| *sum <= drawn);
            let k = patch.texels().start + drawn.min(sums.len() - 1);
            let [u, v] = [0.414_213_562_373_095, 0.732_050_807_568_877].map(|alpha| weyl_sequence(first + n, alpha));
            let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
            let along = DVec3::new(u.sqrt() * cos, u.sqrt() * sin, (1.0 - u).sqrt()).as_vec3();
            sky.sees_sky(k, first + n, along)
        });
        let seen: Vec<bool> = seen.collect();
        seen.iter().filter(|seen| **seen).count() as f32 / seen.len().max(1) as f32
    };
    mesh.patches.par_iter().enumerate().map(escaped_share).collect()
}

/// Returns the standard deviation of the power that rays of `shots` found to escape, summed over channels. It is 0 if
/// none escaped. The rays of all faces count as one sample, since their number is in proportion to power: of N rays the
/// share p escapes, (Np + 1)/(N + 2) as estimated.
pub fn escape_deviation(shots: &[Shot]) -> f64 {
    let (mut power, mut escaped) = (0.0, 0.0);
    for shot in shots {
        let own: f64 = shot.power.iter().map(|p| f64::from(p.abs())).sum();
        power += own;
        escaped += own * f64::from(shot.escaped);
    }
    if escaped == 0.0 {
        return 0.0;
    }
    let count = ESCAPE_RAY_COUNT as f64;
    let share = (count * escaped / power + 1.0) / (count + 2.0);
    power * (share * (1.0 - share) / count).sqrt()
}

/// Tests whether rays leave the scene.
struct SkyVisibility<'a> {
    mesh: &'a Mesh,
    rays: Rays,
    /// Directions that decide whether a point is covered.
    cover_directions: Vec<Vec3>,
    /// Open share of each texel.
    shares: &'a [f32],
}

impl SkyVisibility<'_> {
    /// Returns true if a ray from an open point of texel `k`, a new one for each `n`, meets no front; none if no
    /// open point is found.
    fn sees_sky(&self, k: usize, n: usize, along: Vec3) -> Option<bool> {
        let texel = &self.mesh.texels[k];
        let face = &self.mesh.faces[texel.face as usize];
        let mut places = (MAX_POINT_TRIES * n..MAX_POINT_TRIES * (n + 1)).map(|n| {
            let uv = [0.754_877_666_246_693, 0.569_840_290_998_053];
            let uv = uv.map(|alpha| weyl_sequence(n, alpha) as f32);
            point_on_texel(face, texel.kind, texel.lattice_corner, texel.area, uv).truncate()
        });
        let faces = self.mesh.faces.len();
        let is_open =
            |at: &Vec3| self.shares[k] == 1.0 || is_open(&self.rays, faces, face, *at, &self.cover_directions);
        let origin = places.find(is_open)?;
        Some(!meets_front(
            &self.rays,
            face.sheet,
            origin,
            face.direction_in_frame(along),
        ))
    }
}

fn channel_sum(light: Vec3) -> f64 {
    light.as_dvec3().element_sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::{Face, Scene};

    /// A lamp that is half covered, and a wall below a sky: each number of the run from its definition.
    #[test]
    fn run_has_the_powers_of_a_solution() {
        let faces = [(0.0, 3.0, 0.0), (1.0, 0.0, 0.5)].map(|(z, emission, reflectance)| {
            let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, z));
            Face::quad("face", corners, Vec3::splat(emission), Vec3::splat(reflectance))
        });
        let scene = Scene {
            faces: faces.to_vec(),
            ..Scene::default()
        };
        let mut mesh = Mesh::uniform(&scene, 1, 1).unwrap();
        mesh.texels[1].sky = Vec3::splat(0.25);
        let solution = TexelSolution {
            irradiance: [0.0, 4.0].map(Vec3::splat).to_vec(),
            residual: [0.0, -0.5].map(Vec3::splat).to_vec(),
            open: vec![0.5, 1.0],
            passes: 7,
            converged: true,
            ..TexelSolution::default()
        };
        let run = record_run(&mesh, &solution, &[0.125, 0.75]);
        let grey = |value: f32| [value; 3].into_iter().sum::<f32>();
        let area = 2.0;
        assert_eq!(run.emitted, grey(3.0 + 0.25) * area);
        // The lamp sends half of its light, the wall ρH and what was shot too much.
        let powers: Vec<[f32; 3]> = run.shots.iter().map(|shot| shot.power).collect();
        assert_eq!(powers, [[1.5 * area; 3], [(2.0 + 0.5) * area; 3]]);
        for (shot, escaped) in run.shots.iter().zip([0.125, 0.75]) {
            assert_eq!(shot.unshot, grey(0.5) * area);
            assert_eq!(shot.escaped, escaped);
            assert_eq!(shot.form_factor_sum, (4.0 - 0.25) / (1.5 + 2.5));
        }
        let radiosity: Vec<f32> = run.field.radiosity.iter().map(|b| b.x).collect();
        assert_eq!(radiosity, [3.0, 2.0]);
        assert_eq!((run.passes, run.shooters, run.converged), (7, 2, true));
    }
}
