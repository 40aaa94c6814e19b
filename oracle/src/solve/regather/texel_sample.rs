//! Draws the sample of texels that are gathered again.

use common::mesh::Mesh;
use common::sampling::{RECURRENCE_STEPS, pcg_hash};
use common::shooting::RadiosityField;
use glam::DVec3;

/// A texel of the sample.
#[derive(Clone, Copy)]
pub struct SampledTexel {
    /// Index of the texel.
    pub texel: usize,
    /// Area that the texel represents: its own over its inclusion probability.
    pub area: f64,
    /// Inclusion probability; 1 for a texel that is always in the sample.
    pub probability: f64,
}

/// Draws at most `count` texels by systematic sampling with unequal probabilities. The density is the mean of
/// four: area; light, so that a small face in strong light is not missed; roughness (difference to the next
/// texels of the face), where noise and missed edges show; and an equal share for every face, so that a face
/// without any light is not missed. The order within a face is hashed, so that the steps do not follow its
/// rows.
pub fn sample_texels(mesh: &Mesh, field: &RadiosityField, count: u64) -> Vec<SampledTexel> {
    let mut order = mesh.texels_in_face_order();
    let area = |k: usize| f64::from(mesh.texels[k].area);
    let light = |k: usize| area(k) * reflected_radiosity(mesh, field, k).length_squared();
    let roughness = texel_roughness(mesh, field, &order);
    let sum = |part: &dyn Fn(usize) -> f64| (0..order.len()).map(part).sum::<f64>().max(f64::MIN_POSITIVE);
    let sums = [sum(&area), sum(&light), sum(&|k| roughness[k])];
    let same = |k: usize| {
        let [w, h] = mesh.faces[mesh.texels[k].face as usize].resolution;
        1.0 / (mesh.faces.len() as f64 * f64::from(w * h))
    };
    let density = |k: usize| {
        let parts = [area(k) / sums[0], light(k) / sums[1], roughness[k] / sums[2], same(k)];
        parts.iter().sum::<f64>() / parts.len() as f64
    };
    let density: Vec<f64> = (0..order.len()).map(density).collect();
    let share = inclusion_probabilities(&density, count);
    order.sort_by_key(|k| {
        let texel = &mesh.texels[*k];
        (texel.face, pcg_hash(texel.index), texel.index)
    });
    let mut next = f64::from(RECURRENCE_STEPS[0]) / (1u64 << 32) as f64;
    let (mut passed, mut chosen) = (0.0, Vec::new());
    for texel in order {
        let share = share[texel];
        let drawn = share < 1.0 && {
            passed += share;
            let drawn = next < passed;
            next += f64::from(u8::from(drawn));
            drawn
        };
        if drawn || share >= 1.0 {
            let area = area(texel) / share;
            chosen.push(SampledTexel {
                texel,
                area,
                probability: share,
            });
        }
    }
    chosen
}

/// Inclusion probability of each texel in a sample of `count`: proportional to its density, but at most 1. The
/// excess is distributed to the other texels.
fn inclusion_probabilities(density: &[f64], count: u64) -> Vec<f64> {
    let mut shares = vec![1.0; density.len()];
    let mut order: Vec<usize> = (0..density.len()).collect();
    order.sort_by(|a, b| density[*b].total_cmp(&density[*a]));
    let mut remaining = count as f64;
    let mut sum: f64 = density.iter().sum();
    for (n, k) in order.iter().enumerate() {
        if (order.len() - n) as f64 <= remaining {
            break;
        }
        let share = remaining * density[*k] / sum.max(f64::MIN_POSITIVE);
        if share >= 1.0 {
            remaining -= 1.0;
            sum -= density[*k];
        } else {
            order[n..]
                .iter()
                .for_each(|k| shares[*k] = remaining * density[*k] / sum.max(f64::MIN_POSITIVE));
            break;
        }
    }
    shares
}

/// B − E of a texel.
fn reflected_radiosity(mesh: &Mesh, field: &RadiosityField, k: usize) -> DVec3 {
    (field.radiosity[k].truncate() - mesh.texels[k].emission).as_dvec3()
}

/// Roughness of each texel j: the larger A (B_j − B_j')² over the texels j' before and after it on its face.
fn texel_roughness(mesh: &Mesh, field: &RadiosityField, order: &[usize]) -> Vec<f64> {
    let mut squares = vec![0.0f64; order.len()];
    for pair in order.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        if mesh.texels[a].face == mesh.texels[b].face {
            let square = (reflected_radiosity(mesh, field, a) - reflected_radiosity(mesh, field, b)).length_squared();
            for k in [a, b] {
                squares[k] = squares[k].max(square * f64::from(mesh.texels[k].area));
            }
        }
    }
    squares
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::{Face, Scene};
    use glam::{Vec3, Vec4};

    #[test]
    fn probability_above_one_is_distributed_to_other_texels() {
        let density = [1.0, 8.0, 1.0, 1.0, 1.0];
        assert_eq!(inclusion_probabilities(&density, 3), [0.5, 1.0, 0.5, 0.5, 0.5]);
        assert_eq!(inclusion_probabilities(&density, 5), [1.0; 5]);
        assert_eq!(inclusion_probabilities(&density, 9), [1.0; 5]);
    }

    /// A face of four texels of which one has light, and one of twice its area without: the density of each texel is the
    /// mean of its shares of area, light, roughness and faces.
    #[test]
    fn density_is_the_mean_of_four_shares() {
        let quad = |width: f64, z: f64| {
            let corners = [[0.0, 0.0], [width, 0.0], [width, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, z));
            Face::quad("face", corners, Vec3::ZERO, Vec3::ONE)
        };
        let scene = Scene {
            faces: vec![quad(1.0, 0.0), quad(2.0, 1.0)],
            ..Scene::default()
        };
        let mesh = Mesh::new(&scene, &[[2, 2], [1, 1]], 1).unwrap();
        let order = mesh.texels_in_face_order();
        let mut radiosity = vec![Vec4::ZERO; 5];
        radiosity[order[0]] = Vec4::new(1.0, 2.0, 0.5, 0.0);
        let field = RadiosityField {
            radiosity,
            ..RadiosityField::default()
        };
        let small = 0.25 / 3.0;
        let densities = [
            (small + 1.0 + 0.5 + 0.125) / 4.0,
            (small + 0.5 + 0.125) / 4.0,
            (small + 0.125) / 4.0,
            (small + 0.125) / 4.0,
            (2.0 / 3.0 + 0.5) / 4.0,
        ];
        let areas = [0.25, 0.25, 0.25, 0.25, 2.0];
        let mut seen = [false; 5];
        for count in 1..=2 {
            let sample = sample_texels(&mesh, &field, count);
            assert_eq!(sample.len() as u64, count);
            for drawn in sample {
                let n = order.iter().position(|k| *k == drawn.texel).unwrap();
                seen[n] = true;
                let expected = count as f64 * densities[n];
                assert!(
                    (drawn.probability - expected).abs() < 1e-6,
                    "{n}: {}",
                    drawn.probability
                );
                assert!((drawn.area - areas[n] / expected).abs() < 1e-4, "{n}: {}", drawn.area);
            }
        }
        assert!(seen.into_iter().filter(|seen| *seen).count() >= 2, "{seen:?}");
    }
}
