//! How long a solve will take: a few of its cells are linked, and their time is scaled up.

use super::passes::Expected;
use crate::show::number::number;
use common::Result;
use common::mesh::Mesh;
use common::passes::Engine;
use glam::Vec3;
use std::ops::ControlFlow;
use std::time::Instant;

/// Seconds of cells.
const LONGEST: f64 = 1.5;
/// Cells at most.
const MOST: usize = 48;
/// The counts come from a coarser mesh: this share of doubt, beside the cells' own spread.
const DOUBT: f64 = 0.3;

/// Seconds of the parts of a solve.
#[derive(Clone, Copy, Debug, Default)]
pub struct Time {
    /// All links.
    pub links: f64,
    /// All passes or shots.
    pub passes: f64,
    /// What the texels take in the end.
    pub gather: f64,
    /// Cells tried.
    pub tried: usize,
    /// The truth should lie between this many times less and more.
    pub factor: f64,
}

impl Time {
    /// The sum.
    pub fn seconds(&self) -> f64 {
        self.links + self.passes + self.gather
    }
}

/// Tries some cells of `engine`, spread over the scene.
pub fn time(engine: &mut dyn Engine, mesh: &Mesh, expected: &Expected) -> Result<Time> {
    // The first call pays for what all later ones find ready.
    let exchanges = engine.has_room();
    let cells = spread(mesh.cells.len());
    let Some((first, others)) = cells.split_first() else {
        return Ok(Time::default());
    };
    link(engine, *first, exchanges)?;
    let (mut tried, mut seconds) = (vec![*first], Vec::new());
    let start = Instant::now();
    for cell in others {
        seconds.push(link(engine, *cell, exchanges)?);
        tried.push(*cell);
        if start.elapsed().as_secs_f64() > LONGEST {
            break;
        }
    }
    if seconds.is_empty() {
        seconds.push(link(engine, *first, exchanges)?);
    }
    let n = seconds.len() as f64;
    let mean = seconds.iter().sum::<f64>() / n;
    let variance = seconds.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / n;
    let doubt = 2.0 * (variance / n).sqrt() / mean;
    let time = Time {
        tried: tried.len(),
        factor: 1.0 + DOUBT + if doubt.is_finite() { doubt } else { 0.0 },
        ..Time::default()
    };
    if exchanges {
        passes(engine, mesh, &tried, mean, expected, time)
    } else {
        shots(engine, &tried, mean, expected, time)
    }
}

/// Evenly over all cells, in an order that is spread however early it ends.
fn spread(count: usize) -> Vec<u32> {
    let all = count.min(MOST);
    // A stride coprime to the number visits each once.
    let stride = (all * 5 / 8..).find(|s| gcd(*s, all) == 1).unwrap_or(1);
    (0..all)
        .map(|k| ((k * stride % all) * count / all) as u32)
        .collect()
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

fn link(engine: &mut dyn Engine, cell: u32, exchanges: bool) -> Result<f64> {
    let start = Instant::now();
    if exchanges {
        engine.link(&[cell], &mut |_| ControlFlow::Continue(()))?;
    } else {
        engine.shoot(cell)?;
    }
    Ok(start.elapsed().as_secs_f64())
}

fn passes(
    engine: &mut dyn Engine,
    mesh: &Mesh,
    tried: &[u32],
    link: f64,
    expected: &Expected,
    time: Time,
) -> Result<Time> {
    let mut radiosity = vec![Vec3::ZERO; mesh.cells.len()];
    for cell in tried {
        radiosity[*cell as usize] = Vec3::ONE;
    }
    let all = expected.linked / tried.len() as f64;
    let start = Instant::now();
    engine.exchange(&radiosity)?;
    let exchange = start.elapsed().as_secs_f64() * all;
    let start = Instant::now();
    engine.gather(&radiosity, &radiosity)?;
    Ok(Time {
        links: expected.linked * link,
        passes: expected.passes * exchange,
        gather: start.elapsed().as_secs_f64() * all,
        ..time
    })
}

/// A cell's first shot makes its links, a later one finds them.
fn shots(
    engine: &mut dyn Engine,
    tried: &[u32],
    first: f64,
    expected: &Expected,
    time: Time,
) -> Result<Time> {
    let start = Instant::now();
    for cell in tried {
        engine.shoot(*cell)?;
    }
    let again = start.elapsed().as_secs_f64() / tried.len() as f64;
    Ok(Time {
        links: expected.linked * (first - again).max(0.0),
        passes: expected.shots * again,
        ..time
    })
}

/// Two digits: more would be made up.
pub fn two(seconds: f64) -> String {
    let scale = 10f64.powf(seconds.log10().floor() - 1.0);
    let rounded = (seconds / scale).round() * scale;
    number(if rounded.is_finite() {
        rounded
    } else {
        seconds
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cells_tried_are_different_and_spread() {
        for count in [1, 2, 7, 48, 1000] {
            let mut cells = spread(count);
            let early: Vec<u32> = cells.iter().copied().take(8).collect();
            assert!(cells.iter().all(|c| (*c as usize) < count));
            cells.sort_unstable();
            cells.dedup();
            assert_eq!(cells.len(), count.min(MOST));
            if count == 1000 {
                assert!(early.iter().any(|c| *c > 700) && early.iter().any(|c| *c < 300));
            }
        }
        assert!(spread(0).is_empty());
    }
}
