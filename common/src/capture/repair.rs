//! Repairs pixels whose value no radiance can have.
//!
//! Negative channels become 0. A pixel with a channel that is NaN or infinite becomes the mean of
//! those of its eight neighbours that lie in the map and are finite (with their negative channels already
//! 0), or 0 if there are none. The repaired pixels are counted and reported in a note.

use glam::{DVec3, Vec3};

/// Numbers of repaired pixels; a pixel counts once, for the first reason that applies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RepairCounts {
    /// Pixels with a channel that is NaN.
    pub nan: usize,
    /// Pixels with an infinite channel.
    pub infinite: usize,
    /// Pixels with a channel below 0.
    pub negative: usize,
}

/// Repairs `pixels` (row by row, `size` = width, height) by the rule above.
pub(super) fn repair_pixels(size: [usize; 2], pixels: &mut [Vec3], notes: &mut Vec<String>) -> RepairCounts {
    let mut counts = RepairCounts::default();
    let mut broken = Vec::new();
    for (index, pixel) in pixels.iter_mut().enumerate() {
        if pixel.is_nan() {
            counts.nan += 1;
            broken.push(index);
        } else if !pixel.is_finite() {
            counts.infinite += 1;
            broken.push(index);
        } else if pixel.min_element() < 0.0 {
            counts.negative += 1;
            *pixel = pixel.max(Vec3::ZERO);
        }
    }
    // All means come from the unrepaired pixels: no repaired pixel feeds another.
    let means: Vec<Vec3> = broken.iter().map(|at| mean_of_neighbours(size, pixels, *at)).collect();
    for (at, mean) in broken.iter().zip(means) {
        pixels[*at] = mean;
    }
    let mut note = |count: usize, what: &str| {
        if count > 0 {
            notes.push(format!("{count} of {} pixels {what}", pixels.len()));
        }
    };
    let repaired = "and became the mean of their finite neighbours";
    note(counts.nan, &format!("are not numbers {repaired}"));
    note(counts.infinite, &format!("are infinite {repaired}"));
    note(counts.negative, "have a negative channel, which became 0");
    counts
}

fn mean_of_neighbours([w, h]: [usize; 2], pixels: &[Vec3], at: usize) -> Vec3 {
    let (x, y) = (at % w, at / w);
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for row in y.saturating_sub(1)..(y + 2).min(h) {
        for column in x.saturating_sub(1)..(x + 2).min(w) {
            let pixel = pixels[row * w + column];
            if pixel.is_finite() {
                sum += pixel.as_dvec3();
                count += 1.0;
            }
        }
    }
    (sum / f64::max(count, 1.0)).as_vec3()
}
