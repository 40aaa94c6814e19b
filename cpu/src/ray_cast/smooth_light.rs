//! Light smoothed over clusters of texels: where it varies linearly over texels that lie and face alike, a mean and a slope
//! that are fitted to all of them have less noise than each by itself.
//!
//! What a fit removes from the texels is noise and, where light is not linear, light. The halves of the rays tell them apart:
//! the noise of either is its own, so that the product of what is removed from each is the squared light in the mean. A
//! cluster is fitted where this and the noise that remains are less than the noise without the fit (pruning of a tree by
//! cost: Breiman, Friedman, Olshen & Stone 1984).

use super::Halves;
use common::mesh::Mesh;
use glam::{DMat3, DVec3, Vec3A};

/// Number of parts of each half of the rays: each is fitted as the other shows.
pub const PART_COUNT: usize = 2;
/// Least number of texels that are fitted. Of so many texels a plane fit leaves 3/16 of the variance.
pub(super) const MIN_FITTED_TEXELS: usize = 16;
/// Least number of texels for which one choice is made: from fewer, choices by the noise would make the noise that is seen
/// too small.
pub(super) const MIN_CHOICE_TEXELS: usize = 64;
/// Largest number of texels that are fitted: more leave hardly less noise.
const MAX_FITTED_TEXELS: usize = 2048;
/// Added to the variances of the places along each axis, over their sum, so that texels in a plane have no slope across it.
const RIDGE_SHARE: f64 = 1e-6;

/// The texels of a mesh in clusters.
pub struct LightSmoother<'a> {
    mesh: &'a Mesh,
    /// Open share of each texel.
    open: &'a [f32],
    /// The texels with an open part in the order of a binary tree: each half of a cluster is a cluster again.
    order: Vec<u32>,
}

/// The cheapest division of a cluster.
struct CheapestFits<'a> {
    /// Its squared error.
    cost: f64,
    /// The clusters that are fitted; other texels stay as they are.
    clusters: Vec<&'a [u32]>,
}

impl CheapestFits<'_> {
    /// Returns the fits of two clusters.
    fn join_fits(mut self, other: Self) -> Self {
        self.cost += other.cost;
        self.clusters.extend(other.clusters);
        self
    }

    fn or_if_cheaper(self, other: Self) -> Self {
        if other.cost < self.cost { other } else { self }
    }
}

/// Returns the mean of the light that two parts of the rays bring.
fn average_parts([a, b]: &[Vec<Halves>; PART_COUNT]) -> Vec<Halves> {
    let mean = |(a, b): (&Halves, &Halves)| [0, 1].map(|half| 0.5 * (a[half] + b[half]));
    a.iter().zip(b).map(mean).collect()
}

/// Returns the halves of a cluster.
pub(super) fn split_cluster(texels: &[u32]) -> [&[u32]; 2] {
    texels.split_at(texels.len() / 2).into()
}

impl<'a> LightSmoother<'a> {
    /// Divides the texels of `mesh`, of these `open` shares.
    pub fn new(mesh: &'a Mesh, open: &'a [f32]) -> Self {
        let is_open = |k: &u32| open[*k as usize] > 0.0;
        let mut order: Vec<u32> = (0..mesh.texels.len() as u32).filter(is_open).collect();
        sort_by_likeness(mesh, &mut order);
        Self { mesh, open, order }
    }

    /// Smooths light that equal `parts` of the rays bring, the mean over each texel's area, for an error that is weighted by
    /// `weight`; if that makes the error larger, returns the light as it is. Each part is fitted where the other shows that it
    /// is cheapest: a choice by the same noise would make the error look too small.
    pub fn smooth_light(&self, parts: &[Vec<Halves>; PART_COUNT], weight: &[Vec3A]) -> Vec<Halves> {
        let all = average_parts(parts);
        if self.order.len() < MIN_CHOICE_TEXELS {
            return all;
        }
        let areas = self.open_areas();
        let on_open = |light: &[Halves], noise_share| NoisyLight {
            mesh: self.mesh,
            areas: &areas,
            weight,
            light: self.divide_by_open(light),
            noise_share,
        };
        // The mean of both parts has half of the variance of either.
        let smooth_part = |part: usize| {
            let clusters = on_open(&parts[1 - part], 0.5).divide_cheapest(&self.order).clusters;
            on_open(&parts[part], 1.0).fit_clusters(&clusters)
        };
        let (a, b) = rayon::join(|| smooth_part(0), || smooth_part(1));
        let smoothed = average_parts(&[a, b]);
        let plain = on_open(&all, 1.0);
        let cost = |k: &u32| plain.fit_cost(*k, smoothed[*k as usize]) - plain.texel_cost(*k);
        if self.order.iter().map(cost).sum::<f64>() >= 0.0 {
            return all;
        }
        let of_area = |(halves, open): (&Halves, &f32)| halves.map(|half| half * *open);
        smoothed.iter().zip(self.open).map(of_area).collect()
    }

    /// Returns the light of each texel's open part.
    fn divide_by_open(&self, light: &[Halves]) -> Vec<Halves> {
        let on_open = |(light, open): (&Halves, &f32)| match *open > 0.0 {
            true => light.map(|half| half / *open),
            false => [Vec3A::ZERO; 2],
        };
        light.iter().zip(self.open).map(on_open).collect()
    }

    fn open_areas(&self) -> Vec<f32> {
        let texels = self.mesh.texels.iter().zip(self.open);
        texels.map(|(texel, open)| texel.area * open).collect()
    }
}

/// Sorts `texels` so that those in each half of the range, each quarter and so on lie near each other and face alike: a range
/// is halved across its longest side, where a normal counts as a place on a sphere as wide as the scene.
pub(super) fn sort_by_likeness(mesh: &Mesh, texels: &mut [u32]) {
    if texels.len() < 2 * MIN_FITTED_TEXELS {
        return;
    }
    let place = |k: u32| -> [f32; 6] {
        let texel = &mesh.texels[k as usize];
        let [at, normal] = [texel.position, mesh.faces[texel.face as usize].normal];
        [at.x, at.y, at.z, normal.x, normal.y, normal.z]
    };
    let (mut low, mut high) = ([f32::INFINITY; 6], [f32::NEG_INFINITY; 6]);
    for k in texels.iter() {
        for (axis, value) in place(*k).into_iter().enumerate() {
            low[axis] = low[axis].min(value);
            high[axis] = high[axis].max(value);
        }
    }
    let longer = |a: &usize, b: &usize| (high[*a] - low[*a]).total_cmp(&(high[*b] - low[*b]));
    let axis = (0..6).max_by(longer).unwrap_or(0);
    let middle = texels.len() / 2;
    let by_place = |a: &u32, b: &u32| place(*a)[axis].total_cmp(&place(*b)[axis]).then(a.cmp(b));
    texels.select_nth_unstable_by(middle, by_place);
    let (below, above) = texels.split_at_mut(middle);
    rayon::join(|| sort_by_likeness(mesh, below), || sort_by_likeness(mesh, above));
}

/// The light of the texels' open parts.
pub(super) struct NoisyLight<'a> {
    pub(super) mesh: &'a Mesh,
    /// Open area of each texel.
    pub(super) areas: &'a [f32],
    pub(super) weight: &'a [Vec3A],
    pub(super) light: Vec<Halves>,
    /// Variance of the light that is smoothed over that of this.
    pub(super) noise_share: f64,
}

/// A linear fit of the light of a cluster.
pub(super) struct LinearFit {
    centre: DVec3,
    /// Mean of each half.
    mean: [DVec3; 2],
    /// Slope of each half: by channel and axis.
    pub(super) slope: [DMat3; 2],
}

impl NoisyLight<'_> {
    /// Returns the cheapest division of a cluster: as it is, in halves or quarters of one choice, or each half in its own way.
    fn divide_cheapest<'a>(&self, texels: &'a [u32]) -> CheapestFits<'a> {
        let [a, b] = split_cluster(texels);
        if texels.len() > MAX_FITTED_TEXELS {
            let (a, b) = rayon::join(|| self.divide_cheapest(a), || self.divide_cheapest(b));
            return a.join_fits(b);
        }
        let apart = if texels.len() >= 2 * MIN_CHOICE_TEXELS {
            self.divide_cheapest(a).join_fits(self.divide_cheapest(b))
        } else {
            let as_they_are = CheapestFits {
                cost: texels.iter().map(|k| self.texel_cost(*k)).sum(),
                clusters: Vec::new(),
            };
            let in_quarters = self.fit_halves(a).join_fits(self.fit_halves(b));
            as_they_are
                .or_if_cheaper(in_quarters)
                .or_if_cheaper(self.fit_halves(texels))
        };
        apart.or_if_cheaper(self.fit_whole(texels))
    }

    /// Fits each half of a cluster as one.
    fn fit_halves<'a>(&self, texels: &'a [u32]) -> CheapestFits<'a> {
        let [a, b] = split_cluster(texels);
        self.fit_whole(a).join_fits(self.fit_whole(b))
    }

    /// Fits all `texels` as one: its cost is the squared light that the fit removes and the squared noise that it leaves,
    /// infinite without a fit.
    fn fit_whole<'a>(&self, texels: &'a [u32]) -> CheapestFits<'a> {
        let cost = |fit: LinearFit| {
            let of_texel = |k: &u32| self.fit_cost(*k, self.light_by_fit(&fit, *k));
            texels.iter().map(of_texel).sum()
        };
        CheapestFits {
            cost: self.fit_positive(texels).map_or(f64::INFINITY, cost),
            clusters: vec![texels],
        }
    }

    /// Returns the light with that of each of the `clusters` by its fit.
    fn fit_clusters(&self, clusters: &[&[u32]]) -> Vec<Halves> {
        let mut fitted = self.light.clone();
        for texels in clusters {
            if let Some(fit) = self.fit_positive(texels) {
                for k in *texels {
                    fitted[*k as usize] = self.light_by_fit(&fit, *k);
                }
            }
        }
        fitted
    }

    /// Fits mean and slope as [`Self::fit_linear`] does; none that is negative anywhere.
    fn fit_positive(&self, texels: &[u32]) -> Option<LinearFit> {
        let fit = self.fit_linear(texels)?;
        let is_negative = |k: &u32| {
            let [a, b] = self.light_by_fit(&fit, *k);
            (a + b).min_element() < 0.0
        };
        (!texels.iter().any(is_negative)).then_some(fit)
    }

    /// Fits mean and slope by least squares over the open area; none of texels without area or in one place.
    pub(super) fn fit_linear(&self, texels: &[u32]) -> Option<LinearFit> {
        let area: f64 = texels.iter().map(|k| self.open_area(*k)).sum();
        if area <= 0.0 {
            return None;
        }
        let average =
            |of: &dyn Fn(u32) -> DVec3| texels.iter().map(|k| self.open_area(*k) * of(*k)).sum::<DVec3>() / area;
        let place = |k: u32| self.mesh.texels[k as usize].position.as_dvec3();
        let light = |k: u32, half: usize| self.light[k as usize][half].as_dvec3();
        let centre = average(&place);
        let mean = [0, 1].map(|half| average(&|k| light(k, half)));
        let mut places = DMat3::ZERO;
        let mut with_light = [DMat3::ZERO; 2];
        for k in texels {
            let share = self.open_area(*k) / area;
            let at = place(*k) - centre;
            places += outer_product(at, share * at);
            for half in 0..2 {
                with_light[half] += outer_product(light(*k, half) - mean[half], share * at);
            }
        }
        let spread = places.x_axis.x + places.y_axis.y + places.z_axis.z;
        if spread <= 0.0 {
            return None;
        }
        let inverse = (places + RIDGE_SHARE * spread * DMat3::IDENTITY).inverse();
        Some(LinearFit {
            centre,
            mean,
            slope: with_light.map(|with_light| with_light * inverse),
        })
    }

    pub(super) fn open_area(&self, k: u32) -> f64 {
        f64::from(self.areas[k as usize])
    }

    pub(super) fn light_by_fit(&self, fit: &LinearFit, k: u32) -> Halves {
        let at = self.mesh.texels[k as usize].position.as_dvec3() - fit.centre;
        [0, 1].map(|half| (fit.mean[half] + fit.slope[half] * at).as_vec3a())
    }

    /// Returns the squared noise of a texel's light as it is.
    fn texel_cost(&self, k: u32) -> f64 {
        self.weigh_noise(k, self.light[k as usize])
    }

    /// Returns the squared light that a fit of a texel removes, and the squared noise that it leaves.
    fn fit_cost(&self, k: u32, fitted: Halves) -> f64 {
        let [a, b] = self.light[k as usize];
        self.weigh_product(k, a - fitted[0], b - fitted[1]) + self.weigh_noise(k, fitted)
    }

    fn weigh_noise(&self, k: u32, [a, b]: Halves) -> f64 {
        self.noise_share * self.weigh_product(k, 0.5 * (a - b), 0.5 * (a - b))
    }

    pub(super) fn weigh_product(&self, k: u32, a: Vec3A, b: Vec3A) -> f64 {
        let weight = self.weight[k as usize];
        f64::from((a * weight * b * weight).element_sum() * self.areas[k as usize])
    }
}

/// Returns a bᵀ.
fn outer_product(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::sampling::pcg_hash;
    use common::scene::{Face, Scene};
    use common::texel::{Texel, TexelKind};
    use glam::{Vec2, Vec3};

    /// Noise of either half.
    const NOISE: f32 = 0.05;

    /// A white square of 32×32 texels and a triangle of 16×16.
    fn square_and_triangle() -> Mesh {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let triangle = [corners[0], corners[1], corners[3]].map(|corner| corner + DVec3::Z);
        let scene = Scene {
            faces: vec![
                Face::quad("square", corners, Vec3::ZERO, Vec3::ONE),
                Face::triangle("triangle", triangle, Vec3::ZERO, Vec3::ONE),
            ],
            ..Scene::default()
        };
        Mesh::new(&scene, &[[32, 32], [16, 16]], 1).unwrap()
    }

    /// Returns where a texel lies, from 0 to 1 along the sides of its face.
    fn place_on_face(mesh: &Mesh, texel: &Texel) -> Vec2 {
        let middle = match texel.kind {
            TexelKind::Quad => 0.5,
            TexelKind::Upright => 1.0 / 3.0,
            TexelKind::Inverted => 2.0 / 3.0,
        };
        let [i, j] = texel.lattice_corner.map(|corner| corner as f32 + middle);
        Vec2::new(i, j) / mesh.faces[texel.face as usize].resolution[0] as f32
    }

    /// Returns a random value in −1 to 1 for texel k, a part and a half.
    fn random(k: usize, part: usize, half: usize) -> f32 {
        pcg_hash((2 * (PART_COUNT * k + part) + half) as u32) as f32 / u32::MAX as f32 * 2.0 - 1.0
    }

    /// Returns parts of the `light` of each texel's face and place, with noise.
    fn noisy_light(mesh: &Mesh, light: impl Fn(u32, Vec2) -> f32) -> [Vec<Halves>; PART_COUNT] {
        let of_texel = |part: usize, (k, texel): (usize, &Texel)| {
            let mean = light(texel.face, place_on_face(mesh, texel));
            [0, 1].map(|half| Vec3A::splat(mean + NOISE * random(k, part, half)))
        };
        std::array::from_fn(|part| mesh.texels.iter().enumerate().map(|own| of_texel(part, own)).collect())
    }

    fn smooth(mesh: &Mesh, open: &[f32], parts: &[Vec<Halves>; PART_COUNT]) -> Vec<Halves> {
        let weight = vec![Vec3A::ONE; mesh.texels.len()];
        LightSmoother::new(mesh, open).smooth_light(parts, &weight)
    }

    /// Returns the mean square of half the difference of the halves.
    fn noise_variance(light: &[Halves]) -> f32 {
        let squares = light.iter().map(|[a, b]| (0.25 * (*a - *b) * (*a - *b)).x);
        squares.sum::<f32>() / light.len() as f32
    }

    #[test]
    fn linear_light_loses_its_noise_and_keeps_its_power() {
        let mesh = square_and_triangle();
        let open = vec![1.0; mesh.texels.len()];
        let parts = noisy_light(&mesh, |_, at| 1.0 + 0.5 * at.x - 0.3 * at.y);
        let smoothed = smooth(&mesh, &open, &parts);
        let light = average_parts(&parts);
        // Few by fits of fewer than 32 texels with a mean and at most three slopes.
        let [before, after] = [&light, &smoothed].map(|light| noise_variance(light));
        let most = 4.0 / 32.0;
        assert!(after > 0.0 && after < most * before, "{after} of {before}");
        let power = |light: &[Halves]| -> f32 {
            let parts = light.iter().zip(&mesh.texels);
            parts.map(|([half, _], texel)| half.x * texel.area).sum()
        };
        let (before, after) = (power(&light), power(&smoothed));
        assert!((after / before - 1.0).abs() < 1e-5, "{after}, {before}");
    }

    /// Where light has an edge, the texels stay as they are; away from it most are fitted.
    #[test]
    fn edge_of_a_shadow_is_kept() {
        let mesh = square_and_triangle();
        let open = vec![1.0; mesh.texels.len()];
        let parts = noisy_light(&mesh, |_, at| if at.x < 0.45 { 1.0 } else { 0.2 });
        let smoothed = smooth(&mesh, &open, &parts);
        let light = average_parts(&parts);
        for (k, texel) in mesh.texels.iter().enumerate() {
            let off = [0, 1].map(|half| (smoothed[k][half] - light[k][half]).x.abs());
            let at = place_on_face(&mesh, texel);
            assert!(off.iter().all(|off| *off < 2.0 * NOISE), "{at}: {off:?}");
        }
        let fitted = smoothed.iter().zip(&light).filter(|(a, b)| a != b).count();
        assert!(2 * fitted > mesh.texels.len() && fitted < mesh.texels.len(), "{fitted}");
    }

    /// What lies on a partly covered texel is the light of its open part.
    #[test]
    fn light_of_open_parts_is_fitted() {
        let mesh = square_and_triangle();
        let open: Vec<f32> = (0..mesh.texels.len()).map(|k| 0.25 * (k % 5) as f32).collect();
        let on_open = noisy_light(&mesh, |_, at| 1.0 + at.x);
        let of_area = |(halves, open): (&Halves, &f32)| halves.map(|half| half * *open);
        let parts = on_open.map(|part| -> Vec<Halves> { part.iter().zip(&open).map(of_area).collect() });
        let smoothed = smooth(&mesh, &open, &parts);
        let light = average_parts(&parts);
        let (mut off, mut noise) = (0.0, 0.0);
        for (k, texel) in mesh.texels.iter().enumerate() {
            let expected = open[k] * (1.0 + place_on_face(&mesh, texel).x);
            off += (smoothed[k][0].x - expected).powi(2);
            noise += (light[k][0].x - expected).powi(2);
        }
        assert!(noise > 0.0 && off < 0.25 * noise, "{off}, {noise}");
    }

    /// The line through a parabola that is 0 at one end is negative there.
    #[test]
    fn negative_fits_are_none() {
        let mesh = square_and_triangle();
        let areas: Vec<f32> = mesh.texels.iter().map(|texel| texel.area).collect();
        let square: Vec<u32> = (0..areas.len() as u32)
            .filter(|k| mesh.texels[*k as usize].face == 0)
            .collect();
        for (least, is_fitted) in [(0.0, false), (0.5, true)] {
            let light = |texel: &Texel| [Vec3A::splat(least + place_on_face(&mesh, texel).x.powi(2)); 2];
            let noisy = NoisyLight {
                mesh: &mesh,
                areas: &areas,
                weight: &[],
                light: mesh.texels.iter().map(light).collect(),
                noise_share: 1.0,
            };
            assert_eq!(noisy.fit_positive(&square).is_some(), is_fitted, "{least}");
        }
    }
}
