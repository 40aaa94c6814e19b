//! What is done about a node at a block, where something may be between: as many pairs of points as the
//! doubt asks for, or its parts.

use crate::hierarchy::link::{Bound, Found, Link};
use crate::hierarchy::world::Thresholds;
use common::constants::{LITTLE, SAMPLES};

/// What is done about a node at a block.
pub enum Choice {
    /// It sends nothing.
    Nothing,
    /// Its parts are looked at.
    Cut,
    /// And whether a shadow's edge crosses the block.
    Link(Box<Link>, bool),
}

/// Places a side on each spot, of which its factor is the mean.
pub fn places(within: f32, light: f32, near: f32) -> u32 {
    match within * light / near {
        ..1.0 => 1,
        1.0..10.0 => 2,
        10.0..100.0 => 4,
        _ => 8,
    }
}

/// What is done where something may be between: as many pairs of points as the doubt asks for.
/// `whole`: the source cannot be cut.
pub fn through(
    bound: &Bound,
    [mean, rest]: [f32; 2],
    whole: bool,
    thresholds: Thresholds,
    mut sampled: impl FnMut(u32) -> Found,
) -> Choice {
    let shines = bound.factor * (mean + rest);
    let mut found = sampled(SAMPLES[0]);
    let left = |found: &Found| needed(shines, found.seen, thresholds.visibility);
    if left(&found) > LITTLE {
        found = sampled(SAMPLES[1]);
    }
    let hides = bound.factor * rest * mixed(found.seen).max(0.125) / thresholds.source;
    let needed = left(&found);
    if !whole && (hides > 1.0 || needed > SAMPLES[2] as f32) {
        return Choice::Cut;
    }
    let edge = shines * mixed(found.seen) > thresholds.soft * thresholds.source;
    if needed > SAMPLES[1] as f32 {
        found = sampled(needed.ceil().min(SAMPLES[3] as f32) as u32);
    }
    Choice::Link(Box::new(found.link), edge)
}

fn mixed(seen: f32) -> f32 {
    (seen * (1.0 - seen)).max(0.0).sqrt()
}

/// What S stratified samples leave falls as S^(−3/4).
fn needed(shines: f32, seen: f32, visibility: f32) -> f32 {
    let doubt = shines * mixed(seen).max(0.125) * 0.5 / visibility;
    power(doubt)
}

/// x^(85/64), which is 4/3 but for a two hundredth, by roots: they are exact wherever this is computed.
fn power(x: f32) -> f32 {
    let fourth = x.sqrt().sqrt();
    let sixteenth = fourth.sqrt().sqrt();
    x * fourth * sixteenth * sixteenth.sqrt().sqrt()
}
