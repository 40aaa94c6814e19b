//! HDR-FLIP: the visible difference between two alternating pictures (Andersson et al. 2021), by the crate flip-rs, a
//! port of NVIDIA's FLIP 1.7.
//!
//! It is the maximum LDR-FLIP over a range of exposures determined by the reference. The picture's empty background is
//! excluded from the range and from the mean.

use crate::report::picture::compute_luminance;
use flip_rs::{FlipError, HdrOptions, RgbImage, hdr_flip};
use glam::Vec3;

/// Luminance that FLIP's ACES tone mapping maps to 0.85 of white.
const NEARLY_WHITE: f32 = 2.118_872_3;
/// Minimum median luminance relative to the maximum: bounds the range of exposures.
const MIN_MEDIAN_LUMINANCE: f32 = 1e-6;

/// Returns HDR-FLIP between two square pictures (linear radiosity, none for background) with reference `b`: the mean
/// over the pixels that show a surface, 0 (no visible difference) … 1.
///
/// Errors: a value that is not finite.
pub fn compare_flip(a: &[Option<Vec3>], b: &[Option<Vec3>], size: u32) -> std::result::Result<f64, FlipError> {
    let brightest = |pixels: &[Option<Vec3>]| {
        let all = pixels.iter().flatten();
        all.map(|p| compute_luminance(*p)).fold(0.0, f32::max)
    };
    // A black reference determines no exposure.
    let (white, reference) = match brightest(b) {
        white if white > 0.0 => (white, b),
        _ => (brightest(a), a),
    };
    let scale = if white > 0.0 { 1.0 / white } else { 1.0 };
    let image = |pixels: &[Option<Vec3>]| {
        let channels = pixels
            .iter()
            .flat_map(|p| (p.unwrap_or(Vec3::ZERO).max(Vec3::ZERO) * scale).to_array());
        RgbImage::new(size as usize, size as usize, channels.collect())
    };
    let mut options = HdrOptions::default();
    options.start_exposure = Some(NEARLY_WHITE.log2());
    options.stop_exposure = Some((NEARLY_WHITE / median_luminance(reference, scale)).log2());
    let result = hdr_flip(&image(b)?, &image(a)?, options)?;
    let shown = result.error_map.pixels().iter().zip(b).filter(|(_, p)| p.is_some());
    let (sum, count) = shown.fold((0.0, 0.0), |(sum, count), (e, _)| (sum + f64::from(*e), count + 1.0));
    Ok(sum / f64::max(count, 1.0))
}

/// Returns the median luminance of the surfaces, relative to the maximum.
fn median_luminance(pixels: &[Option<Vec3>], scale: f32) -> f32 {
    let mut sizes: Vec<f32> = pixels.iter().flatten().map(|p| compute_luminance(*p) * scale).collect();
    sizes.sort_by(f32::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or(1.0);
    median.clamp(MIN_MEDIAN_LUMINANCE, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    const SIZE: u32 = 24;

    fn ramp_picture(factor: f32) -> Vec<Option<Vec3>> {
        (0..SIZE * SIZE)
            .map(|k| Some(Vec3::new(0.2 + (k % SIZE) as f32, 3.0, 0.1 * (k / SIZE) as f32) * factor))
            .collect()
    }

    #[test]
    fn flip_is_zero_for_equal_pictures_and_scale_invariant() {
        let flip = |a: f32, b: f32| compare_flip(&ramp_picture(a), &ramp_picture(b), SIZE).unwrap();
        assert_eq!(flip(1.0, 1.0), 0.0);
        let [once, scaled] = [flip(1.2, 1.0), flip(1.2e6, 1e6)];
        assert!(
            once > 0.01 && abs_diff_eq!(once, scaled, epsilon = 1e-3 * once),
            "{once} {scaled}"
        );
    }

    #[test]
    fn exposures_equal_the_crates_without_background() {
        let (a, b) = (ramp_picture(1.1), ramp_picture(1.0));
        let image = |pixels: &[Option<Vec3>]| {
            let values = pixels.iter().flatten().flat_map(|p| p.to_array());
            RgbImage::new(SIZE as usize, SIZE as usize, values.collect()).unwrap()
        };
        let theirs = hdr_flip(&image(&b), &image(&a), HdrOptions::default()).unwrap();
        let ours = compare_flip(&a, &b, SIZE).unwrap();
        let mean = f64::from(theirs.error_map.statistics().mean);
        assert!(abs_diff_eq!(ours, mean, epsilon = 1e-4 * mean), "{ours} {mean}");
    }

    #[test]
    fn black_and_empty_pictures_give_no_error() {
        let black = vec![Some(Vec3::ZERO); (SIZE * SIZE) as usize];
        let nothing = vec![None; (SIZE * SIZE) as usize];
        assert_eq!(compare_flip(&black, &black, SIZE).unwrap(), 0.0);
        assert_eq!(compare_flip(&nothing, &nothing, SIZE).unwrap(), 0.0);
        assert!(compare_flip(&ramp_picture(1.0), &black, SIZE).unwrap() > 0.1);
    }
}
