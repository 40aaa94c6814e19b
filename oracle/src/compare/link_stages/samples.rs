//! Checks the stage that samples links: its weights on the visibility that the GPU found, and that visibility.

use super::LinkStages;
use super::level::{Level, WorkList, compare_lanes, lane_sizes, work_words};
use super::tally::{Place, Word};
use super::twin::{Lanes, LevelTwin, SPOTS};
use crate::compare::stages::decided_by_rounding;
use common::Result;
use common::constants::CONTACT_DISTANCE;
use gpu::hierarchy::link_probe::{UNWRITTEN, as_words};
use gpu::link_records::PairRecord;
use rayon::prelude::*;

/// Words of a lane that are weights: w·x, w·y, w.
const WEIGHT_WORDS: [usize; 3] = [4, 5, 7];

impl LinkStages {
    /// Checks the samples of the pairs of a list.
    pub fn check_samples(&mut self, twin: &LevelTwin, level: &mut Level, list: &WorkList) -> Result<()> {
        let listed = &list[0];
        if listed.is_empty() {
            return Ok(());
        }
        let nothing = f32::from_bits(UNWRITTEN);
        for k in listed {
            for lane in &mut level.lanes[*k as usize] {
                [lane.weight, lane.known, lane.along[0], lane.along[1]] = [nothing; 4];
            }
        }
        let found = self.run_on_lanes(
            ["sample_links"; 2],
            level,
            listed.len(),
            &work_words(list, level.pairs.len()),
        )?;
        let sampled: Vec<SampledPair> = (listed.par_iter())
            .map(|k| {
                sample_pair(
                    twin,
                    &level.pairs[*k as usize],
                    &level.lanes[*k as usize],
                    &found[*k as usize],
                )
            })
            .collect();
        let mut expected = level.lanes.clone();
        for (k, pair) in listed.iter().zip(&sampled) {
            expected[*k as usize] = pair.judged;
        }
        let sizes = |k: usize| {
            let (pair, radius) = (&level.pairs[k], twin.node(&level.pairs[k]).shooter.radius);
            let sizes = twin.weight_sizes(pair, &level.lanes[k]);
            sizes.map(|size| lane_sizes(4, &[size * radius, size * radius, 0.0, size]))
        };
        let tally = &mut self.tallies.sample_links;
        compare_lanes(tally, &level.pairs, [&found, &expected], sizes);
        let rays = &mut self.tallies.rays;
        for (k, sampled) in listed.iter().zip(&sampled) {
            let k = *k as usize;
            rays.add_equal(u64::from(sampled.right));
            if sampled.wrong.is_empty() {
                continue;
            }
            let sizes = sizes(k);
            for (l, is_blocked) in &sampled.wrong {
                let words = [&found[k][*l], &sampled.judged[*l]].map(|lane| as_words(std::slice::from_ref(lane)));
                let float = |of: usize, n: usize| f32::from_bits(words[of][n]);
                // Weights of other points hide the visibility.
                if WEIGHT_WORDS
                    .iter()
                    .all(|n| tally.allows(float(0, *n), float(1, *n), sizes[*l][*n]))
                {
                    let seen = [*is_blocked, !is_blocked].map(u32::from);
                    rays.add(
                        Place::of_spot(&level.pairs[k], *l),
                        [k * SPOTS + l, 0],
                        seen,
                        Word::Integer,
                    );
                }
            }
        }
        for (k, sampled) in listed.iter().zip(&sampled) {
            level.lanes[*k as usize] = sampled.exact;
        }
        Ok(())
    }
}

/// A pair after sampling.
struct SampledPair {
    /// The twin's lanes.
    exact: Lanes,
    /// The twin's lanes on the GPU's visibility.
    judged: Lanes,
    /// Spots of the samples whose visibility rays have wrong, and whether the twin's is blocked.
    wrong: Vec<(usize, bool)>,
    /// Samples whose visibility is equal, or decided by rounding.
    right: u32,
}

fn sample_pair(twin: &LevelTwin, pair: &PairRecord, given: &Lanes, found: &Lanes) -> SampledPair {
    let exact = twin.sample_links(pair, given, pair.known);
    let mut sampled = SampledPair {
        exact,
        judged: exact,
        wrong: Vec::new(),
        right: 0,
    };
    let lit = given.iter().filter(|lane| lane.factor > 0.0).count() as u32;
    sampled.right = lit * pair.samples.saturating_sub(pair.known);
    if (0..SPOTS).all(|l| found[l].blocked == exact[l].blocked) {
        return sampled;
    }
    let block = twin.block(pair);
    let mut bits = *given;
    for (lane, exact) in bits.iter_mut().zip(&exact) {
        lane.blocked = exact.blocked;
    }
    for s in pair.known..pair.samples {
        let (word, bit) = (s as usize / 32, 1 << (s % 32));
        let samples = twin.spot_samples(pair, given, s);
        for (l, sample) in samples.into_iter().enumerate().filter(|(l, _)| given[*l].factor > 0.0) {
            let differs = (found[l].blocked[word] ^ exact[l].blocked[word]) & bit != 0;
            let margin = 8.0 * f32::EPSILON * sample.p.distance(sample.q).max(1.0);
            let undecided = (sample.height + CONTACT_DISTANCE).abs() < margin;
            // A sample from below the horizon, or without weight, needs no ray: the stage itself has it wrong.
            let is_traced = sample.height > -CONTACT_DISTANCE && sample.weight > 0.0;
            if !differs || !(is_traced || undecided) {
                continue;
            }
            bits[l].blocked[word] ^= bit;
            let ends = [twin.node(pair).face, block.faces[l]];
            let visible = |q, p| twin.scene.rays.is_visible(q, p, ends);
            if !undecided && !decided_by_rounding(&visible, sample.q, sample.p) {
                sampled.wrong.push((l, exact[l].blocked[word] & bit != 0));
            }
        }
    }
    sampled.right -= sampled.wrong.len() as u32;
    sampled.judged = twin.sample_links(pair, &bits, pair.samples);
    sampled
}
