//! Recovers a radiance map from bracketed photographs of one view (Debevec and Malik 1997, "Recovering high
//! dynamic range radiance maps from photographs").
//!
//! ```text
//! photographs, seconds ─ samples (pixels for eq. 3) ─ response (g, eq. 3) ─ merge (ln E, eq. 6)
//! ```
//!
//! A camera maps the exposure X = E Δt of a pixel to a code z = f(X), 0…255. g = ln f⁻¹ is determined up to a
//! constant, fixed by g(128) = 0 in each channel: grey at code 128 stays grey. Radiance is relative; radiance 1 gives
//! code 128 in one second.

mod merge;
mod response;
mod samples;

pub use merge::{RadianceMap, UnseenPixels};
pub use response::{CameraResponse, MIDDLE_CODE};

use common::capture::check_size;
use common::{Error, Result};
use std::path::{Path, PathBuf};

/// Maximum number of pixels in all photographs together: 1.6 GB.
pub const MAX_PIXELS_IN_ALL: u64 = 1 << 29;

/// Minimum and maximum exposure time in seconds; within it radiances fit 32-bit floats.
const EXPOSURE_SECONDS_RANGE: [f64; 2] = [1e-9, 1e9];

/// Photograph with its exposure time.
#[derive(Clone, Debug)]
pub struct Photograph {
    /// File, for messages.
    pub path: PathBuf,
    /// Exposure time in seconds.
    pub seconds: f64,
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Codes of red, green and blue, row-major from the upper left.
    pub pixels: Vec<[u8; 3]>,
}

/// Photographs of one view and size, the longest exposure first.
#[derive(Clone, Debug)]
pub struct Brackets {
    photographs: Vec<Photograph>,
}

/// Step from one exposure to the next shorter one, in stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExposureStep {
    /// Nominal step, by the exposure times.
    pub nominal: f64,
    /// Measured step, by pixels well exposed in both photographs; none without such pixels.
    pub measured: Option<f64>,
}

/// Returns a code's weight: the hat function of eq. 4, 0 at both ends.
pub(crate) fn code_weight(code: u8) -> f64 {
    f64::from(code.min(255 - code))
}

/// Checks the size of a photograph, one of `count`, before it is decoded.
///
/// Errors: [`Error::Input`] with the file if it is too large.
pub fn check_picture_size(path: &Path, size: [usize; 2], count: usize) -> Result<()> {
    let [w, h] = size.map(|n| n as u64);
    let refuse = |message: String| Err(Error::bad_input(path, "", message));
    check_size(w, h).or_else(refuse)?;
    if (w * h).saturating_mul(count as u64) > MAX_PIXELS_IN_ALL {
        return refuse(format!(
            "{count} pictures of {w}×{h} pixels are more than {MAX_PIXELS_IN_ALL} (2^29) pixels: scale them down"
        ));
    }
    Ok(())
}

impl Brackets {
    /// Takes photographs in any order.
    ///
    /// Errors: [`Error::Usage`] for fewer than two; [`Error::Input`] with the file for a size other than the first's,
    /// or an exposure time that is out of range or occurs twice.
    pub fn new(mut exposures: Vec<Photograph>) -> Result<Self> {
        let count = exposures.len();
        if count < 2 {
            return Err(Error::Usage(format!("{count} exposures: two at least are needed")));
        }
        let first = (exposures[0].path.clone(), exposures[0].size);
        exposures.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
        for (
            k,
            Photograph {
                path, seconds, size, ..
            },
        ) in exposures.iter().enumerate()
        {
            let before = k.checked_sub(1).map(|before| &exposures[before]);
            let message = if !(EXPOSURE_SECONDS_RANGE[0]..=EXPOSURE_SECONDS_RANGE[1]).contains(seconds) {
                format!("is said to be exposed for {seconds} s: seconds above 0 are needed")
            } else if let Some(equal) = before.filter(|before| before.seconds == *seconds) {
                let other = equal.path.display();
                format!("is exposed for {seconds} s, as {other} is: each once is needed")
            } else if *size != first.1 {
                let ([w, h], [first_w, first_h], name) = (size, first.1, first.0.display());
                format!(
                    "has {w}×{h} pixels and {name} has {first_w}×{first_h}: aligned pictures of one size are needed"
                )
            } else {
                continue;
            };
            return Err(Error::bad_input(path, "", message));
        }
        Ok(Self { photographs: exposures })
    }

    /// Returns the photographs, the longest exposure first.
    pub fn photographs(&self) -> &[Photograph] {
        &self.photographs
    }

    /// Returns width and height in pixels.
    pub fn picture_size(&self) -> [usize; 2] {
        self.photographs[0].size
    }

    /// Returns ln Δt of each photograph.
    fn ln_seconds(&self) -> Vec<f64> {
        self.photographs.iter().map(|e| e.seconds.ln()).collect()
    }

    /// Returns the steps between successive exposures, the longest first.
    ///
    /// The measured step is the mean of g(z) − g(z') over all pixels and channels, weighted by both codes. It reveals
    /// exposure times assigned to the wrong photograph.
    pub fn exposure_steps(&self, response: &CameraResponse) -> Vec<ExposureStep> {
        let step = |pair: &[Photograph]| {
            let (mut sum, mut whole) = (0.0, 0.0);
            for (a, b) in pair[0].pixels.iter().zip(&pair[1].pixels) {
                for c in 0..3 {
                    let weight = code_weight(a[c]) * code_weight(b[c]);
                    let curve = &response.curves[c];
                    sum += weight * (curve[usize::from(a[c])] - curve[usize::from(b[c])]);
                    whole += weight;
                }
            }
            ExposureStep {
                nominal: (pair[0].seconds / pair[1].seconds).log2(),
                measured: (whole > 0.0).then(|| sum / whole / std::f64::consts::LN_2),
            }
        };
        self.photographs.windows(2).map(step).collect()
    }
}
