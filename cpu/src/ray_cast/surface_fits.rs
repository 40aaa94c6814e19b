//! Linear fits of light over clusters of 16 to 31 texels of one surface, whatever faces they are on: how light goes on across
//! small faces, and how much of it no line follows.

use super::Halves;
use super::smooth_light::{
    LinearFit, MIN_CHOICE_TEXELS, MIN_FITTED_TEXELS, NoisyLight, sort_by_likeness, split_cluster,
};
use common::mesh::Mesh;
use glam::{DMat3, Vec3, Vec3A};

/// Least cosine between a normal and the mean normal of texels on one surface.
const MIN_LIKE_COSINE: f32 = 0.9;
/// Largest distance of texels on one surface from the plane through their middle, as a share of their distance from it.
const MAX_LAYER_THICKNESS: f32 = 0.25;

/// Returns what fits over clusters of the `texels` remove from the `light` of each of them in a channel, and what fits over
/// four such clusters do: squares, times the texel's open area of these `areas`. Those of a cluster are shared by its texels;
/// they are 0 where a cluster does not lie on one surface. The halves of the light are crossed, so that their noise adds
/// nothing in the mean.
pub fn measure_fit_residuals(
    mesh: &Mesh,
    areas: &[f32],
    (light, channel): (Vec<Halves>, usize),
    mut texels: Vec<u32>,
) -> Vec<(u32, [f64; 2])> {
    sort_by_likeness(mesh, &mut texels);
    let weight = vec![Vec3A::AXES[channel]; light.len()];
    let light = NoisyLight {
        mesh,
        areas,
        weight: &weight,
        light,
        noise_share: 1.0,
    };
    let mut squares = Vec::with_capacity(texels.len());
    for group in divide_to(&texels, 2 * MIN_CHOICE_TEXELS) {
        let clusters = divide_to(group, 2 * MIN_FITTED_TEXELS);
        let fine: Vec<f64> = clusters.iter().map(|cluster| fit_residual(&light, cluster)).collect();
        let of_all: f64 = fine.iter().sum();
        let coarse = match group.len() >= MIN_CHOICE_TEXELS && of_all != 0.0 {
            true => fit_residual(&light, group) / of_all,
            false => 0.0,
        };
        for (cluster, fine) in clusters.into_iter().zip(fine) {
            let area: f64 = cluster.iter().map(|k| light.open_area(*k)).sum();
            let share = |k: &u32| {
                let own = fine * light.open_area(*k) / area.max(f64::MIN_POSITIVE);
                (*k, [own, own * coarse])
            };
            squares.extend(cluster.iter().map(share));
        }
    }
    squares
}

/// Returns the slope of the `light` at each texel, by channel and axis: that of the fit of its cluster; none where a cluster
/// does not lie on one surface, and at texels without open area.
pub fn fit_slopes(mesh: &Mesh, areas: &[f32], light: Vec<Halves>) -> Vec<DMat3> {
    let mut texels: Vec<u32> = (0..areas.len() as u32).filter(|k| areas[*k as usize] > 0.0).collect();
    sort_by_likeness(mesh, &mut texels);
    let light = NoisyLight {
        mesh,
        areas,
        weight: &[],
        light,
        noise_share: 1.0,
    };
    let mut slopes = vec![DMat3::ZERO; areas.len()];
    for cluster in divide_to(&texels, 2 * MIN_FITTED_TEXELS) {
        if let Some(fit) = fit_surface(&light, cluster) {
            for k in cluster {
                slopes[*k as usize] = 0.5 * (fit.slope[0] + fit.slope[1]);
            }
        }
    }
    slopes
}

/// Divides texels into halves, these into halves and so on until each cluster has fewer than `most`.
fn divide_to(texels: &[u32], most: usize) -> Vec<&[u32]> {
    if texels.len() < most {
        return vec![texels];
    }
    split_cluster(texels)
        .into_iter()
        .flat_map(|half| divide_to(half, most))
        .collect()
}

/// Fits the light of a cluster that lies on one surface.
fn fit_surface(light: &NoisyLight, texels: &[u32]) -> Option<LinearFit> {
    let is_fitted = texels.len() >= MIN_FITTED_TEXELS && lies_on_one_surface(light.mesh, texels);
    is_fitted.then(|| light.fit_linear(texels)).flatten()
}

/// Returns the squared light that the fit of a cluster removes from it; 0 without a fit.
fn fit_residual(light: &NoisyLight, texels: &[u32]) -> f64 {
    let square = |fit: LinearFit| {
        let of_texel = |k: &u32| {
            let ([a, b], [c, d]) = (light.light[*k as usize], light.light_by_fit(&fit, *k));
            light.weigh_product(*k, a - c, b - d)
        };
        texels.iter().map(of_texel).sum()
    };
    fit_surface(light, texels).map_or(0.0, square)
}

/// Returns whether texels face alike and lie in one layer.
fn lies_on_one_surface(mesh: &Mesh, texels: &[u32]) -> bool {
    let texel = |k: &u32| &mesh.texels[*k as usize];
    let normal = |k: &u32| mesh.faces[texel(k).face as usize].normal;
    let mean = texels.iter().map(normal).sum::<Vec3>().normalize_or_zero();
    let centre = texels.iter().map(|k| texel(k).position).sum::<Vec3>() / texels.len() as f32;
    let offsets = || texels.iter().map(|k| texel(k).position - centre);
    let thickness = offsets().map(|offset| offset.dot(mean).abs()).fold(0.0, f32::max);
    let width = offsets().map(Vec3::length).fold(0.0, f32::max);
    texels.iter().all(|k| normal(k).dot(mean) >= MIN_LIKE_COSINE) && thickness <= MAX_LAYER_THICKNESS * width
}

#[cfg(test)]
mod tests {
    use super::fit_slopes;
    use common::mesh::Mesh;
    use common::scene::{Face, Scene};
    use glam::{DMat3, DVec3, Vec3, Vec3A};

    /// Returns a unit square of 4×4 quads at a corner, of one texel each.
    fn quad_grid(corner: DVec3, [along, across]: [DVec3; 2]) -> Vec<Face> {
        let place = |i: u32, j: u32| corner + (along * f64::from(i) + across * f64::from(j)) / 4.0;
        let quad = |k: u32| {
            let (i, j) = (k % 4, k / 4);
            let corners = [place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)];
            Face::quad("part", corners, Vec3::ZERO, Vec3::ONE)
        };
        (0..16).map(quad).collect()
    }

    fn slopes_of(faces: Vec<Face>) -> Vec<DMat3> {
        let scene = Scene {
            faces,
            ..Scene::default()
        };
        let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
        let areas: Vec<f32> = mesh.texels.iter().map(|texel| texel.area).collect();
        let light = |at: Vec3| Vec3A::new(2.0 + at.x, 3.0 - 0.5 * at.y, 1.0);
        let halves = mesh.texels.iter().map(|texel| [light(texel.position); 2]);
        fit_slopes(&mesh, &areas, halves.collect())
    }

    /// Linear light has its slope on faces of one texel.
    #[test]
    fn slope_goes_on_across_faces() {
        let slopes = slopes_of(quad_grid(DVec3::ZERO, [DVec3::X, DVec3::Y]));
        let expected = DMat3::from_cols(DVec3::X, -0.5 * DVec3::Y, DVec3::ZERO);
        for slope in slopes {
            // Of the ridge, and of f32.
            assert!(slope.abs_diff_eq(expected, 1e-4), "{slope}");
        }
    }

    /// Texels that face differently, or lie in two layers, have no slope in common.
    #[test]
    fn different_surfaces_have_no_slope() {
        let floor = quad_grid(DVec3::ZERO, [DVec3::X, DVec3::Y]);
        let wall = quad_grid(DVec3::ZERO, [DVec3::Y, DVec3::Z]);
        let above = quad_grid(DVec3::Z, [DVec3::X, DVec3::Y]);
        for other in [wall, above] {
            let half = |faces: &[Face]| faces.iter().step_by(2).cloned().collect::<Vec<Face>>();
            let slopes = slopes_of([half(&floor), half(&other)].concat());
            assert!(slopes.iter().all(|slope| *slope == DMat3::ZERO), "{slopes:?}");
        }
    }
}
