//! Estimates the time of a solve: links a few of its patches and scales their time up.

use super::passes::ExpectedPasses;
use crate::report::format::format_number;
use common::Result;
use common::mesh::Mesh;
use common::passes::Engine;
use glam::Vec3;
use std::ops::ControlFlow;
use std::time::Instant;

/// Seconds after which no further patch is tried.
const MAX_TRIAL_SECONDS: f64 = 1.5;
/// Largest number of patches tried.
const MAX_TRIAL_PATCHES: usize = 48;
/// Relative uncertainty of the counts, which come from a coarser mesh; the spread of the patches' times is added.
const COUNT_UNCERTAINTY: f64 = 0.3;

/// Seconds of each part of a solve.
#[derive(Clone, Copy, Debug, Default)]
pub struct SolveTime {
    /// All links.
    pub links: f64,
    /// All passes or shots.
    pub passes: f64,
    /// The final gather of the texels.
    pub gather: f64,
    /// Patches tried.
    pub tried: usize,
    /// The true time should lie within this factor, either way.
    pub factor: f64,
}

impl SolveTime {
    /// Returns the sum of all parts.
    pub fn total_seconds(&self) -> f64 {
        self.links + self.passes + self.gather
    }
}

/// Times some patches of `engine`, spread over the scene, and extrapolates to the `expected` solve.
pub fn time_patches(engine: &mut dyn Engine, mesh: &Mesh, expected: &ExpectedPasses) -> Result<SolveTime> {
    // The first call also pays for one-time preparations.
    let exchanges = engine.has_room();
    let patches = spread_patches(mesh.patches.len());
    let Some((first, others)) = patches.split_first() else {
        return Ok(SolveTime::default());
    };
    time_link(engine, *first, exchanges)?;
    let (mut tried, mut seconds) = (vec![*first], Vec::new());
    let start = Instant::now();
    for patch in others {
        seconds.push(time_link(engine, *patch, exchanges)?);
        tried.push(*patch);
        if start.elapsed().as_secs_f64() > MAX_TRIAL_SECONDS {
            break;
        }
    }
    if seconds.is_empty() {
        seconds.push(time_link(engine, *first, exchanges)?);
    }
    let n = seconds.len() as f64;
    let mean = seconds.iter().sum::<f64>() / n;
    let variance = seconds.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / n;
    let doubt = 2.0 * (variance / n).sqrt() / mean;
    let time = SolveTime {
        tried: tried.len(),
        factor: 1.0 + COUNT_UNCERTAINTY + if doubt.is_finite() { doubt } else { 0.0 },
        ..SolveTime::default()
    };
    if exchanges {
        time_passes(engine, mesh, &tried, mean, expected, time)
    } else {
        time_shots(engine, &tried, mean, expected, time)
    }
}

/// Returns patches spread evenly over `count`, in an order of which every beginning is spread, too.
fn spread_patches(count: usize) -> Vec<u32> {
    let all = count.min(MAX_TRIAL_PATCHES);
    // A stride coprime to the number visits each patch once.
    let stride = (all * 5 / 8..).find(|s| gcd(*s, all) == 1).unwrap_or(1);
    (0..all).map(|k| ((k * stride % all) * count / all) as u32).collect()
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

fn time_link(engine: &mut dyn Engine, patch: u32, exchanges: bool) -> Result<f64> {
    let start = Instant::now();
    if exchanges {
        engine.make_links(&[patch], &mut |_| ControlFlow::Continue(()))?;
    } else {
        engine.shoot(patch)?;
    }
    Ok(start.elapsed().as_secs_f64())
}

fn time_passes(
    engine: &mut dyn Engine,
    mesh: &Mesh,
    tried: &[u32],
    link: f64,
    expected: &ExpectedPasses,
    time: SolveTime,
) -> Result<SolveTime> {
    let mut radiosity = vec![Vec3::ZERO; mesh.patches.len()];
    for patch in tried {
        radiosity[*patch as usize] = Vec3::ONE;
    }
    let all = expected.linked / tried.len() as f64;
    let start = Instant::now();
    engine.exchange_flux(&radiosity)?;
    let exchange = start.elapsed().as_secs_f64() * all;
    let start = Instant::now();
    engine.gather_field(&radiosity, &radiosity)?;
    Ok(SolveTime {
        links: expected.linked * link,
        passes: expected.passes * exchange,
        gather: start.elapsed().as_secs_f64() * all,
        ..time
    })
}

/// Times second shots: a patch's first shot makes its links, the second finds them kept.
fn time_shots(
    engine: &mut dyn Engine,
    tried: &[u32],
    first: f64,
    expected: &ExpectedPasses,
    time: SolveTime,
) -> Result<SolveTime> {
    let start = Instant::now();
    for patch in tried {
        engine.shoot(*patch)?;
    }
    let again = start.elapsed().as_secs_f64() / tried.len() as f64;
    Ok(SolveTime {
        links: expected.linked * (first - again).max(0.0),
        passes: expected.shots * again,
        ..time
    })
}

/// Formats a time with two significant digits.
pub fn format_two_digits(seconds: f64) -> String {
    let scale = 10f64.powf(seconds.log10().floor() - 1.0);
    let rounded = (seconds / scale).round() * scale;
    format_number(if rounded.is_finite() { rounded } else { seconds })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cells_tried_are_different_and_spread() {
        for count in [1, 2, 7, 48, 1000] {
            let mut patches = spread_patches(count);
            let early: Vec<u32> = patches.iter().copied().take(8).collect();
            assert!(patches.iter().all(|c| (*c as usize) < count));
            patches.sort_unstable();
            patches.dedup();
            assert_eq!(patches.len(), count.min(MAX_TRIAL_PATCHES));
            if count == 1000 {
                assert!(early.iter().any(|c| *c > 700) && early.iter().any(|c| *c < 300));
            }
        }
        assert!(spread_patches(0).is_empty());
    }
}
