//! The camera's response by least squares, eq. 3 of Debevec and Malik:
//!
//! ```text
//! Σᵢⱼ {w(zᵢⱼ) [g(zᵢⱼ) − ln Eᵢ − ln Δtⱼ]}² + λ Σ_z [w(z) g''(z)]²  is least
//! ```
//!
//! Each ln Eᵢ stands in the rows of its own pixel alone and is the weighted mean of g − ln Δt
//! there; put in, it leaves normal equations in the 256 values of g. Adding a constant to g changes
//! nothing, so g(128) = 0 is no condition but one unknown fewer, and the other 255 equations are
//! positive definite once two codes of one pixel are known: Cholesky (faer).

use super::samples::choose;
use super::{Brackets, weight};
use common::{Error, Result};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// The code at which g is 0.
pub const MIDDLE: usize = 128;
/// λ: from one code to the next the response bends little, and no photograph is free of noise.
const SMOOTHNESS: f64 = 1000.0;
/// A pivot below this share of its diagonal is what rounding leaves of 0.
const SINGULAR: f64 = 1e-13;
/// Values of g.
const CODES: usize = 256;

/// ln of the exposure that gives a code, per channel; 0 at code 128.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// g of red, green and blue.
    pub curves: [[f64; CODES]; 3],
    /// Pixels that were asked, per channel.
    pub samples: [usize; 3],
}

impl Response {
    /// Recovers it from what the photographs show.
    ///
    /// Errors: [`Error::Input`] with the longest exposure's file: nothing is well exposed in two
    /// of them, or they become darker with longer exposure.
    pub fn recover(brackets: &Brackets) -> Result<Self> {
        let mut response = Self {
            curves: [[0.0; CODES]; 3],
            samples: [0; 3],
        };
        for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
            let refuse = |message: String| {
                let path = &brackets.exposures()[0].path;
                Error::input(path, format!("{name} channel"), message)
            };
            let pixels = choose(brackets, channel);
            let curve = recover(brackets, channel, &pixels).ok_or_else(|| {
                refuse("no pixel is well exposed in this picture and another: steps of one or two stops are needed".into())
            })?;
            if curve[CODES - 2] <= curve[1] {
                return Err(refuse(
                    "the longer the exposure the darker: each picture needs its own seconds".into(),
                ));
            }
            response.curves[channel] = curve;
            response.samples[channel] = pixels.len();
        }
        Ok(response)
    }

    /// Codes between the first and the last useful one at which a channel's curve does not rise.
    pub fn falls(&self, channel: usize) -> usize {
        let curve = &self.curves[channel][1..CODES - 1];
        curve.windows(2).filter(|pair| pair[1] <= pair[0]).count()
    }
}

/// g of a channel; none where the pixels do not tell.
fn recover(brackets: &Brackets, channel: usize, pixels: &[usize]) -> Option<[f64; CODES]> {
    if pixels.is_empty() {
        return None;
    }
    let mut equations = Equations::new();
    let ln_seconds = brackets.ln_seconds();
    let mut codes = Vec::new();
    for pixel in pixels {
        let exposures = brackets.exposures().iter();
        codes.clear();
        codes.extend(exposures.map(|e| e.pixels[*pixel][channel]));
        equations.pixel(&codes, &ln_seconds);
    }
    equations.smooth();
    equations.solve()
}

/// Normal equations M g = b.
struct Equations {
    matrix: Mat<f64>,
    right: Mat<f64>,
}

impl Equations {
    fn new() -> Self {
        Self {
            matrix: Mat::zeros(CODES, CODES),
            right: Mat::zeros(CODES, 1),
        }
    }

    /// The rows of one pixel, its ln E eliminated: Σ q (g − ln Δt − mean)², q = w².
    fn pixel(&mut self, codes: &[u8], ln_seconds: &[f64]) {
        let weights: Vec<f64> = codes.iter().map(|z| weight(*z).powi(2)).collect();
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

    /// λ Σ [w(z) (g(z − 1) − 2 g(z) + g(z + 1))]².
    fn smooth(&mut self) {
        const SECOND: [f64; 3] = [1.0, -2.0, 1.0];
        for z in 1..CODES - 1 {
            let share = SMOOTHNESS * weight(z as u8).powi(2);
            for (i, a) in SECOND.into_iter().enumerate() {
                for (j, b) in SECOND.into_iter().enumerate() {
                    self.matrix[(z + i - 1, z + j - 1)] += share * a * b;
                }
            }
        }
    }

    /// The solution with g(128) = 0; none where there are several.
    fn solve(mut self) -> Option<[f64; CODES]> {
        // The unknown that is 0 gets the equation g = 0 and leaves all others.
        for k in 0..CODES {
            self.matrix[(MIDDLE, k)] = 0.0;
            self.matrix[(k, MIDDLE)] = 0.0;
        }
        self.matrix[(MIDDLE, MIDDLE)] = 1.0;
        self.right[(MIDDLE, 0)] = 0.0;
        let factors = self.matrix.llt(Side::Lower).ok()?;
        let told = |k: usize| factors.L()[(k, k)].powi(2) > SINGULAR * self.matrix[(k, k)];
        if !(0..CODES).all(told) {
            return None;
        }
        let solution = factors.solve(&self.right);
        let g: [f64; CODES] = std::array::from_fn(|k| solution[(k, 0)]);
        g.iter().all(|value| value.is_finite()).then_some(g)
    }
}
