//! HDR-FLIP: what an eye would see of the difference when the two pictures alternate
//! (Andersson et al. 2021), by the crate flip-rs, a port of NVIDIA's FLIP 1.7.
//!
//! The largest LDR-FLIP over a range of exposures; the range comes from the reference. The
//! picture's empty background takes no part in it, nor in the mean.

use crate::show::picture::{Picture, luminance};
use flip_rs::{FlipError, HdrOptions, RgbImage, hdr_flip};
use glam::Vec3;

/// The luminance at which FLIP's ACES tone mapping gives 0.85 of white.
const NEARLY_WHITE: f32 = 2.118_872_3;
/// A median below this share of the maximum asks for no further exposures.
const DARKEST: f32 = 1e-6;

/// FLIP's error map and its mean.
pub struct Flip {
    /// The mean over the pixels that show a surface, 0 (no visible difference) … 1.
    pub mean: f64,
    /// The largest of them.
    pub max: f64,
    /// In the magma colours; transparent where no surface is.
    pub picture: Picture,
}

/// FLIP between two square pictures (linear radiosity, none is background), `b` the reference.
///
/// Errors: a value that is not finite.
pub fn flip(
    a: &[Option<Vec3>],
    b: &[Option<Vec3>],
    size: u32,
) -> std::result::Result<Flip, FlipError> {
    let brightest = |pixels: &[Option<Vec3>]| {
        let all = pixels.iter().flatten();
        all.map(|p| luminance(*p)).fold(0.0, f32::max)
    };
    // A black reference has no exposure of its own.
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
    options.stop_exposure = Some((NEARLY_WHITE / median(reference, scale)).log2());
    let result = hdr_flip(&image(b)?, &image(a)?, options)?;
    let (errors, colours) = (result.error_map.pixels(), result.error_map.colorize()?);
    let shown = || errors.iter().zip(b).filter(|(_, p)| p.is_some());
    let count = shown().count().max(1);
    let colour = |x: u32, y: u32| {
        let k = y as usize * size as usize + x as usize;
        let byte = |c: usize| (colours.pixels()[3 * k + c] * 255.0).round() as u8;
        b[k].map(|_| [byte(0), byte(1), byte(2)])
    };
    Ok(Flip {
        mean: shown().map(|(e, _)| f64::from(*e)).sum::<f64>() / count as f64,
        max: shown().map(|(e, _)| f64::from(*e)).fold(0.0, f64::max),
        picture: Picture::from_pixels(size, size, colour),
    })
}

/// The median luminance of the surfaces, of a maximum of 1.
fn median(pixels: &[Option<Vec3>], scale: f32) -> f32 {
    let mut sizes: Vec<f32> = pixels
        .iter()
        .flatten()
        .map(|p| luminance(*p) * scale)
        .collect();
    sizes.sort_by(f32::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or(1.0);
    median.clamp(DARKEST, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    const SIZE: u32 = 24;

    fn ramp(factor: f32) -> Vec<Option<Vec3>> {
        (0..SIZE * SIZE)
            .map(|k| {
                Some(Vec3::new(0.2 + (k % SIZE) as f32, 3.0, 0.1 * (k / SIZE) as f32) * factor)
            })
            .collect()
    }

    #[test]
    fn equal_pictures_have_no_error_and_the_unit_does_not_matter() {
        assert_eq!(flip(&ramp(1.0), &ramp(1.0), SIZE).unwrap().max, 0.0);
        let once = flip(&ramp(1.2), &ramp(1.0), SIZE).unwrap().mean;
        let scaled = flip(&ramp(1.2e6), &ramp(1e6), SIZE).unwrap().mean;
        assert!(
            once > 0.01 && abs_diff_eq!(once, scaled, epsilon = 1e-3 * once),
            "{once} {scaled}"
        );
    }

    #[test]
    fn exposures_are_those_of_the_crate_where_no_background_is() {
        let (a, b) = (ramp(1.1), ramp(1.0));
        let image = |pixels: &[Option<Vec3>]| {
            let values = pixels.iter().flatten().flat_map(|p| p.to_array());
            RgbImage::new(SIZE as usize, SIZE as usize, values.collect()).unwrap()
        };
        let theirs = hdr_flip(&image(&b), &image(&a), HdrOptions::default()).unwrap();
        let ours = flip(&a, &b, SIZE).unwrap().mean;
        let mean = f64::from(theirs.error_map.statistics().mean);
        assert!(
            abs_diff_eq!(ours, mean, epsilon = 1e-4 * mean),
            "{ours} {mean}"
        );
    }

    #[test]
    fn black_and_empty_pictures_are_no_failure() {
        let black = vec![Some(Vec3::ZERO); (SIZE * SIZE) as usize];
        let nothing = vec![None; (SIZE * SIZE) as usize];
        assert_eq!(flip(&black, &black, SIZE).unwrap().mean, 0.0);
        assert_eq!(flip(&nothing, &nothing, SIZE).unwrap().mean, 0.0);
        assert!(flip(&ramp(1.0), &black, SIZE).unwrap().mean > 0.1);
    }
}
