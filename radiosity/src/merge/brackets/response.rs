//! Recovers the camera's response by least squares, eq. 3 of Debevec and Malik:
//!
//! ```text
//! minimise Σᵢⱼ {w(zᵢⱼ) [g(zᵢⱼ) − ln Eᵢ − ln Δtⱼ]}² + λ Σ_z [w(z) g''(z)]²
//! ```
//!
//! Each ln Eᵢ occurs in its own pixel's rows only and is the weighted mean of g − ln Δt there. Its elimination leaves
//! normal equations in the 256 values of g. They are invariant under an added constant; g(128) = 0 removes one
//! unknown, and the other 255 equations are positive definite if two codes of one pixel are known. They are solved by
//! Cholesky factorisation (faer).

use super::samples::choose_pixels;
use super::{Brackets, code_weight};
use common::{Error, Result};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Code with g = 0.
pub const MIDDLE_CODE: usize = 128;
/// Smoothness weight λ of eq. 3.
const SMOOTHNESS_WEIGHT: f64 = 1000.0;
/// Pivots below this share of their diagonal are 0 up to rounding.
const SINGULAR_PIVOT_SHARE: f64 = 1e-13;
/// Number of codes, the values of g.
const CODE_COUNT: usize = 256;

/// Camera response: ln of the exposure that gives each code, per channel; 0 at code 128.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraResponse {
    /// Curves g of red, green and blue.
    pub curves: [[f64; CODE_COUNT]; 3],
    /// Number of pixels in the least-squares problem, per channel.
    pub samples: [usize; 3],
}

impl CameraResponse {
    /// Recovers the response from the photographs.
    ///
    /// Errors: [`Error::Input`] with the longest exposure's file if no pixel is well exposed in two photographs, or if
    /// they become darker with longer exposure.
    pub fn from_brackets(brackets: &Brackets) -> Result<Self> {
        let mut response = Self {
            curves: [[0.0; CODE_COUNT]; 3],
            samples: [0; 3],
        };
        for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
            let refuse = |message: String| {
                let path = &brackets.photographs()[0].path;
                Error::bad_input(path, format!("{name} channel"), message)
            };
            let pixels = choose_pixels(brackets, channel);
            let curve = recover_curve(brackets, channel, &pixels).ok_or_else(|| {
                refuse(
                    "no pixel is well exposed in this picture and another: steps of one or two stops are needed".into(),
                )
            })?;
            if curve[CODE_COUNT - 2] <= curve[1] {
                return Err(refuse(
                    "the longer the exposure the darker: each picture needs its own seconds".into(),
                ));
            }
            response.curves[channel] = curve;
            response.samples[channel] = pixels.len();
        }
        Ok(response)
    }

    /// Returns the number of codes, without the first and the last, at which a channel's curve does not rise.
    pub fn count_falls(&self, channel: usize) -> usize {
        let curve = &self.curves[channel][1..CODE_COUNT - 1];
        curve.windows(2).filter(|pair| pair[1] <= pair[0]).count()
    }
}

/// Recovers g of a channel; none if the pixels do not determine it.
fn recover_curve(brackets: &Brackets, channel: usize, pixels: &[usize]) -> Option<[f64; CODE_COUNT]> {
    if pixels.is_empty() {
        return None;
    }
    let mut equations = NormalEquations::new();
    let ln_seconds = brackets.ln_seconds();
    let mut codes = Vec::new();
    for pixel in pixels {
        let exposures = brackets.photographs().iter();
        codes.clear();
        codes.extend(exposures.map(|e| e.pixels[*pixel][channel]));
        equations.add_pixel(&codes, &ln_seconds);
    }
    equations.add_smoothness();
    equations.solve_normalised()
}

/// Normal equations M g = b.
struct NormalEquations {
    matrix: Mat<f64>,
    right: Mat<f64>,
}

impl NormalEquations {
    fn new() -> Self {
        Self {
            matrix: Mat::zeros(CODE_COUNT, CODE_COUNT),
            right: Mat::zeros(CODE_COUNT, 1),
        }
    }

    /// Adds one pixel with ln E eliminated: Σ q (g − ln Δt − mean)², q = w².
    fn add_pixel(&mut self, codes: &[u8], ln_seconds: &[f64]) {
        let weights: Vec<f64> = codes.iter().map(|z| code_weight(*z).powi(2)).collect();
        let whole: f64 = weights.iter().sum();
        if whole == 0.0 {
            return;
        }
        let times = weights.iter().zip(ln_seconds);
        let mean = times.map(|(q, t)| q * t).sum::<f64>() / whole;
        for ((z, q), time) in codes.iter().zip(&weights).zip(ln_seconds) {
            let row = usize::from(*z);
            self.right[(row, 0)] += q * (time - mean);
            self.matrix[(row, row)] += q;
            for (other, p) in codes.iter().zip(&weights) {
                self.matrix[(row, usize::from(*other))] -= q * p / whole;
            }
        }
    }

    /// Adds the smoothness term λ Σ [w(z) (g(z − 1) − 2 g(z) + g(z + 1))]².
    fn add_smoothness(&mut self) {
        const SECOND_DIFFERENCE: [f64; 3] = [1.0, -2.0, 1.0];
        for z in 1..CODE_COUNT - 1 {
            let share = SMOOTHNESS_WEIGHT * code_weight(z as u8).powi(2);
            for (i, a) in SECOND_DIFFERENCE.into_iter().enumerate() {
                for (j, b) in SECOND_DIFFERENCE.into_iter().enumerate() {
                    self.matrix[(z + i - 1, z + j - 1)] += share * a * b;
                }
            }
        }
    }

    /// Solves with g(128) = 0; none for a singular system.
    fn solve_normalised(mut self) -> Option<[f64; CODE_COUNT]> {
        // g(128) gets the equation g = 0 and is removed from all others.
        for k in 0..CODE_COUNT {
            self.matrix[(MIDDLE_CODE, k)] = 0.0;
            self.matrix[(k, MIDDLE_CODE)] = 0.0;
        }
        self.matrix[(MIDDLE_CODE, MIDDLE_CODE)] = 1.0;
        self.right[(MIDDLE_CODE, 0)] = 0.0;
        let factors = self.matrix.llt(Side::Lower).ok()?;
        let is_determined = |k: usize| factors.L()[(k, k)].powi(2) > SINGULAR_PIVOT_SHARE * self.matrix[(k, k)];
        if !(0..CODE_COUNT).all(is_determined) {
            return None;
        }
        let solution = factors.solve(&self.right);
        let g: [f64; CODE_COUNT] = std::array::from_fn(|k| solution[(k, 0)]);
        g.iter().all(|value| value.is_finite()).then_some(g)
    }
}
