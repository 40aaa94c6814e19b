//! A radiance map from bracketed exposures of one view (Debevec and Malik 1997, "Recovering high
//! dynamic range radiance maps from photographs").
//!
//! ```text
//! photographs, seconds ─ samples (which pixels are asked) ─ response (g, eq. 3) ─ merge (ln E, eq. 6)
//! ```
//!
//! A camera turns the exposure X = E Δt of a pixel into a code z = f(X), 0…255. g = ln f⁻¹ is
//! known up to a constant, which g(128) = 0 fixes in each channel: what is grey at code 128 stays
//! grey, and radiance is relative: 1 is what gives code 128 in one second.

mod merge;
mod response;
mod samples;

pub use merge::{Merged, Unseen};
pub use response::{MIDDLE, Response};

use common::capture::check_size;
use common::{Error, Result};
use std::path::{Path, PathBuf};

/// More pixels than this in all photographs together are refused: 1.6 GB.
pub const MAX_PIXELS_IN_ALL: u64 = 1 << 29;

/// Seconds outside this range are a slip of the pen; within it radiances fit 32-bit floats.
const SECONDS: [f64; 2] = [1e-9, 1e9];

/// One photograph.
#[derive(Clone, Debug)]
pub struct Exposure {
    /// What messages call it.
    pub path: PathBuf,
    /// How long it was exposed.
    pub seconds: f64,
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Codes of red, green and blue, row by row from the upper left.
    pub pixels: Vec<[u8; 3]>,
}

/// Photographs of one view, of one size, the longest exposure first.
#[derive(Clone, Debug)]
pub struct Brackets {
    exposures: Vec<Exposure>,
}

/// How much the light changes from one exposure to the next shorter, in stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// By their seconds.
    pub said: f64,
    /// By the pixels that both show, through the response; none where there is none.
    pub seen: Option<f64>,
}

/// How much a code is to be trusted: the hat of eq. 4, 0 at both ends.
pub(crate) fn weight(code: u8) -> f64 {
    f64::from(code.min(255 - code))
}

/// Refuses seconds that no exposure has.
///
/// Errors: [`Error::Input`] with the file.
pub fn check_seconds(path: &Path, seconds: f64) -> Result<()> {
    if (SECONDS[0]..=SECONDS[1]).contains(&seconds) {
        return Ok(());
    }
    let message = format!("is said to be exposed for {seconds} s: seconds above 0 are needed");
    Err(Error::input(path, "", message))
}

/// Refuses a photograph of `size` pixels, one of `count`, beside the `first` one: before it is
/// decoded.
///
/// Errors: [`Error::Input`] with the file.
pub fn admit(
    path: &Path,
    size: [usize; 2],
    first: Option<(&Path, [usize; 2])>,
    count: usize,
) -> Result<()> {
    let [w, h] = size.map(|n| n as u64);
    let refuse = |message: String| Err(Error::input(path, "", message));
    check_size(w, h).or_else(refuse)?;
    if let Some((name, [first_w, first_h])) = first.filter(|first| first.1 != size) {
        return refuse(format!(
            "has {w}×{h} pixels and {} has {first_w}×{first_h}: aligned pictures of one size are needed",
            name.display()
        ));
    }
    if (w * h).saturating_mul(count as u64) > MAX_PIXELS_IN_ALL {
        return refuse(format!(
            "{count} pictures of {w}×{h} pixels are more than {MAX_PIXELS_IN_ALL} (2^29) pixels: scale them down"
        ));
    }
    Ok(())
}

impl Brackets {
    /// Takes the photographs in any order.
    ///
    /// Errors: [`Error::Usage`] for fewer than two; else [`Error::Input`] with the file: another
    /// size than the first, too large, seconds that are not above 0 or that two have in common.
    pub fn new(mut exposures: Vec<Exposure>) -> Result<Self> {
        let count = exposures.len();
        if count < 2 {
            return Err(Error::Usage(format!(
                "{count} exposures: two at least are needed"
            )));
        }
        for exposure in &exposures {
            check_seconds(&exposure.path, exposure.seconds)?;
            let first = (exposures[0].path.as_path(), exposures[0].size);
            admit(&exposure.path, exposure.size, Some(first), count)?;
            if exposure.pixels.len() != exposure.size[0] * exposure.size[1] {
                let message = "has another number of pixels than its size says";
                return Err(Error::input(&exposure.path, "", message));
            }
        }
        exposures.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
        let equal = |pair: &&[Exposure]| pair[0].seconds == pair[1].seconds;
        if let Some(pair) = exposures.windows(2).find(equal) {
            let message = format!(
                "is exposed for {} s, as {} is: each once is needed",
                pair[1].seconds,
                pair[0].path.display()
            );
            return Err(Error::input(&pair[1].path, "", message));
        }
        Ok(Self { exposures })
    }

    /// The photographs, the longest exposure first.
    pub fn exposures(&self) -> &[Exposure] {
        &self.exposures
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.exposures[0].size
    }

    /// ln Δt of each exposure.
    fn ln_seconds(&self) -> Vec<f64> {
        self.exposures.iter().map(|e| e.seconds.ln()).collect()
    }

    /// The steps between neighbours, the longest exposures first.
    ///
    /// The step seen is the mean of g(z) − g(z') over all pixels and channels, each with the
    /// weight of both its codes. Seconds that belong to another picture show here.
    pub fn steps(&self, response: &Response) -> Vec<Step> {
        let step = |pair: &[Exposure]| {
            let (mut sum, mut whole) = (0.0, 0.0);
            for (a, b) in pair[0].pixels.iter().zip(&pair[1].pixels) {
                for c in 0..3 {
                    let weight = weight(a[c]) * weight(b[c]);
                    let curve = &response.curves[c];
                    sum += weight * (curve[usize::from(a[c])] - curve[usize::from(b[c])]);
                    whole += weight;
                }
            }
            Step {
                said: (pair[0].seconds / pair[1].seconds).log2(),
                seen: (whole > 0.0).then(|| sum / whole / std::f64::consts::LN_2),
            }
        };
        self.exposures.windows(2).map(step).collect()
    }
}
