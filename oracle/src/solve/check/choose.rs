//! Which texels of an answer are checked.

use common::mesh::Mesh;
use common::sampling::{STEPS, hash};
use common::shooting::Field;
use glam::DVec3;

/// A texel that is looked at.
#[derive(Clone, Copy)]
pub struct Chosen {
    /// It.
    pub texel: usize,
    /// The area that it stands for.
    pub area: f64,
    /// How likely it was to be chosen; 1 for one that is looked at whatever is drawn.
    pub share: f64,
}

/// At most `count` texels, each as likely as a density says. The density is a quarter
/// each of area; of light, so that a small face in strong light is not missed; of roughness, the
/// difference to the next texels of the face: noise and missed edges show there; and of the same for
/// every face, so that one which has lost all its light is not missed. They are drawn at even steps.
/// Within a face the order is scattered, so that the steps do not follow its rows.
pub fn choose(mesh: &Mesh, field: &Field, count: u64) -> Vec<Chosen> {
    let mut order = mesh.in_face_order();
    let area = |k: usize| f64::from(mesh.texels[k].area);
    let light = |k: usize| area(k) * reflected(mesh, field, k).length_squared();
    let roughness = roughness(mesh, field, &order);
    let sum = |part: &dyn Fn(usize) -> f64| {
        (0..order.len())
            .map(part)
            .sum::<f64>()
            .max(f64::MIN_POSITIVE)
    };
    let sums = [sum(&area), sum(&light), sum(&|k| roughness[k])];
    let same = |k: usize| {
        let [w, h] = mesh.faces[mesh.texels[k].face as usize].resolution;
        1.0 / (mesh.faces.len() as f64 * f64::from(w * h))
    };
    let density = |k: usize| {
        let parts = [
            area(k) / sums[0],
            light(k) / sums[1],
            roughness[k] / sums[2],
            same(k),
        ];
        parts.iter().sum::<f64>() / parts.len() as f64
    };
    let density: Vec<f64> = (0..order.len()).map(density).collect();
    let share = shares(&density, count);
    order.sort_by_key(|k| {
        let texel = &mesh.texels[*k];
        (texel.face, hash(texel.index), texel.index)
    });
    let mut next = f64::from(STEPS[0]) / (1u64 << 32) as f64;
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
            chosen.push(Chosen { texel, area, share });
        }
    }
    chosen
}

/// How likely each texel is to be one of `count`: as its density says, but no more than 1. What is
/// more than that of some is left to the others.
fn shares(density: &[f64], count: u64) -> Vec<f64> {
    let mut shares = vec![1.0; density.len()];
    let mut order: Vec<usize> = (0..density.len()).collect();
    order.sort_by(|a, b| density[*b].total_cmp(&density[*a]));
    let mut left = count as f64;
    let mut sum: f64 = density.iter().sum();
    for (n, k) in order.iter().enumerate() {
        if (order.len() - n) as f64 <= left {
            break;
        }
        let share = left * density[*k] / sum.max(f64::MIN_POSITIVE);
        if share >= 1.0 {
            left -= 1.0;
            sum -= density[*k];
        } else {
            order[n..]
                .iter()
                .for_each(|k| shares[*k] = left * density[*k] / sum.max(f64::MIN_POSITIVE));
            break;
        }
    }
    shares
}

/// B − E.
fn reflected(mesh: &Mesh, field: &Field, k: usize) -> DVec3 {
    (field.radiosity[k].truncate() - mesh.texels[k].emission).as_dvec3()
}

/// A (B_j − B_j')² of each texel, j' the one before it in its face's row or the one after.
fn roughness(mesh: &Mesh, field: &Field, order: &[usize]) -> Vec<f64> {
    let mut squares = vec![0.0f64; order.len()];
    for pair in order.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        if mesh.texels[a].face == mesh.texels[b].face {
            let square = (reflected(mesh, field, a) - reflected(mesh, field, b)).length_squared();
            for k in [a, b] {
                squares[k] = squares[k].max(square * f64::from(mesh.texels[k].area));
            }
        }
    }
    squares
}

#[cfg(test)]
mod tests {
    use super::shares;

    /// What one has beyond certainty goes to the others; where all can be looked at, all are.
    #[test]
    fn no_texel_is_drawn_twice() {
        let density = [1.0, 8.0, 1.0, 1.0, 1.0];
        assert_eq!(shares(&density, 3), [0.5, 1.0, 0.5, 0.5, 0.5]);
        assert_eq!(shares(&density, 5), [1.0; 5]);
        assert_eq!(shares(&density, 9), [1.0; 5]);
    }
}
