//! Checks the stages that refine one level of the trees.

use super::tally::{Place, StageTally, Word};
use super::twin::{Lanes, LevelTwin, Nudge, SPOTS, unwritten_lanes};
use super::{LANE_WORDS, LinkStages, PAIR_WORDS, pair_words, spot_groups};
use common::Result;
use common::constants::PATCH_SUM_LANES;
use gpu::hierarchy::link_probe::{UNWRITTEN, WORK_WORDS, as_words, from_words};
use gpu::link_records::{LaneRecord, PairRecord, RequestRecord};
use rayon::prelude::*;

/// Entry points of the four steps of refinement.
const STEPS: [&str; 4] = [
    "refine_by_source",
    "start_sampling",
    "request_samples",
    "refine_by_visibility",
];
/// Buffers of work lists, and of the workgroups over them, as `clear_work_lists` has them.
const LISTS: [[(&str, usize); 2]; 4] = [
    [("source_work", 2), ("source_dispatches", 6)],
    [("start_work", 2), ("start_dispatches", 6)],
    [("more_work", 2), ("more_dispatches", 6)],
    [("visibility_work", 2), ("visibility_dispatches", 6)],
];
/// Workgroups over an empty list: those of its front, and of its end.
const NO_WORKGROUPS: [u32; 6] = [0, 1, 1, 0, 1, 1];
/// Pairs that a step of refinement has listed: at the front, and at the end.
pub type WorkList = [Vec<u32>; 2];

/// A level of pairs, and what the levels before have made.
pub struct Level {
    pub pairs: Vec<PairRecord>,
    pub lanes: Vec<Lanes>,
    /// Pairs of each block.
    pub ranges: Vec<[u32; 2]>,
    /// H of each spot; 1 where a shadow's edge crosses its block.
    pub sums: Vec<[f32; 4]>,
    /// Links so far, and most pairs of a level.
    pub links: u32,
    pub most: u32,
    pub limits: RequestRecord,
}

impl Level {
    /// Returns the pairs of all blocks and these roots.
    pub fn new(blocks: usize, roots: &[u32], limits: RequestRecord) -> Self {
        let blocks = 0..blocks as u32;
        let ends = (blocks.clone()).flat_map(|block| roots.iter().map(move |node| (block, *node)));
        let pairs: Vec<PairRecord> = ends.map(|(block, node)| PairRecord::new(block, node)).collect();
        let of = roots.len() as u32;
        Self {
            lanes: vec![unwritten_lanes(); pairs.len()],
            ranges: blocks.clone().map(|k| [k * of, (k + 1) * of]).collect(),
            sums: vec![[0.0; 4]; blocks.len() * SPOTS],
            links: 0,
            most: pairs.len() as u32,
            pairs,
            limits,
        }
    }
}

impl LinkStages {
    /// Checks the stage that empties the work lists; uploads what is `given` to all stages of a request.
    pub fn check_cleared_lists(&mut self, given: &[(&str, &[u32])]) -> Result<()> {
        let found = self.run_stage(["clear_work_lists"; 2], 1, given, LISTS.as_flattened())?;
        for (k, ((name, _), words)) in LISTS.as_flattened().iter().zip(&found).enumerate() {
            let expected = if k % 2 == 0 { &[0, 0][..] } else { &NO_WORKGROUPS };
            for (n, (a, b)) in words.iter().zip(expected).enumerate() {
                (self.tallies.clear_work_lists).add_exact(name, n, k % 2, [*a, *b]);
            }
        }
        Ok(())
    }

    /// Checks all stages of a level, and returns the next one.
    pub fn check_level(&mut self, twin: &LevelTwin, mut level: Level) -> Result<Level> {
        self.check_bounds(twin, &mut level)?;
        for step in 1..=STEPS.len() {
            let list = self.check_refinement(twin, &mut level, step)?;
            match step {
                1 => self.check_factors(twin, &mut level, &list)?,
                _ => self.check_samples(twin, &mut level, &list)?,
            }
        }
        self.check_next_level(twin, level)
    }

    fn check_bounds(&mut self, twin: &LevelTwin, level: &mut Level) -> Result<()> {
        let found = self.run_on_lanes(["link_bounds", "bound_links"], level, level.pairs.len(), &[])?;
        let tally = &mut self.tallies.link_bounds;
        let sizes = |k: usize| twin.bound_sizes(&level.pairs[k]).map(|own| lane_sizes(0, &own));
        let choose = |(k, lanes): (usize, &Lanes)| {
            let mut made = [level.lanes[k]; 2];
            let pair = &level.pairs[k];
            let bounds = twin.bounds(pair);
            let sizes = twin.bound_sizes(pair);
            for l in 0..SPOTS {
                let found = lanes[l].bound;
                let alike = |bound: &[f32; 4]| (0..4).all(|n| tally.allows(found[n], bound[n], sizes[l][n]));
                let nudged = (!alike(&bounds[l])).then(|| twin.nudged_bounds(pair, l).find(alike));
                made[0][l].bound = bounds[l];
                made[1][l].bound = nudged.flatten().unwrap_or(bounds[l]);
            }
            made
        };
        let made: Vec<[Lanes; 2]> = found.par_iter().enumerate().map(choose).collect();
        let expected: Vec<Lanes> = made.iter().map(|[_, chosen]| *chosen).collect();
        compare_lanes(tally, &level.pairs, [&found, &expected], sizes);
        level.lanes = made.iter().map(|[exact, _]| *exact).collect();
        Ok(())
    }

    /// Runs a stage over the spots of so many pairs, and returns all lanes.
    pub fn run_on_lanes(
        &mut self,
        names: [&'static str; 2],
        level: &Level,
        pairs: usize,
        work: &[u32],
    ) -> Result<Vec<Lanes>> {
        let given: [(&str, &[u32]); 4] = [
            ("pairs", as_words(&level.pairs)),
            ("lanes", as_words(level.lanes.as_flattened())),
            ("counts", &[level.pairs.len() as u32]),
            ("work", work),
        ];
        let made = [("lanes", level.pairs.len() * SPOTS * LANE_WORDS)];
        let found = self.run_stage(names, spot_groups(pairs), &given, &made)?;
        let lanes: Vec<LaneRecord> = from_words(&found[0]);
        Ok(lanes.as_chunks().0.to_vec())
    }

    /// Checks a step of refinement, and returns its list.
    fn check_refinement(&mut self, twin: &LevelTwin, level: &mut Level, step: usize) -> Result<WorkList> {
        for pair in &mut level.pairs {
            // What the step writes before anything reads it.
            [pair.samples, pair.known] = match step {
                1 | 3 => [UNWRITTEN; 2],
                2 => [UNWRITTEN, pair.known],
                _ => [pair.samples, pair.known],
            };
        }
        let count = level.pairs.len();
        let given: [(&str, &[u32]); 5] = [
            ("pairs", as_words(&level.pairs)),
            ("lanes", as_words(level.lanes.as_flattened())),
            ("counts", &[count as u32]),
            ("work", &[0, 0]),
            ("dispatches", &NO_WORKGROUPS),
        ];
        let made = [("pairs", count * PAIR_WORDS), ("work", WORK_WORDS), ("dispatches", 6)];
        let groups = count.div_ceil(PATCH_SUM_LANES);
        let found = self.run_stage(["refine", STEPS[step - 1]], groups, &given, &made)?;
        let pairs: Vec<PairRecord> = from_words(&found[0]);
        let entries = count_entries(&found[1], count);
        let refine = |(k, found): (usize, &PairRecord)| {
            let of = |nudge| twin.refine(step, &level.pairs[k], &level.lanes[k], nudge);
            let alike = |(pair, listed): &(PairRecord, Option<bool>)| {
                let decisions = |pair: &PairRecord| [pair.state, pair.samples, pair.known, pair.places];
                decisions(pair) == decisions(found) && entries[k] == entries_of(*listed)
            };
            let exact = of([0.0; 3]);
            let chosen = if alike(&exact) {
                None
            } else {
                nudges().map(of).find(alike)
            };
            [exact, chosen.unwrap_or(exact)]
        };
        let made: Vec<[(PairRecord, Option<bool>); 2]> = pairs.par_iter().enumerate().map(refine).collect();
        let tally = &mut self.tallies.refine;
        let mut numbers = [0; 2];
        for (k, [_, (expected, listed)]) in made.iter().enumerate() {
            let own = entries_of(*listed);
            numbers = [numbers[0] + own[0], numbers[1] + own[1]];
            let words = [pair_words(&pairs[k], entries[k]), pair_words(expected, own)];
            for (n, (a, b)) in words[0].iter().zip(&words[1]).enumerate() {
                let kind = if (6..9).contains(&n) {
                    Word::Float(0.0)
                } else {
                    Word::Integer
                };
                tally.add(Place::of_pair(expected, step), [k, n], [*a, *b], kind);
            }
        }
        for (n, number) in numbers.into_iter().enumerate() {
            tally.add_exact("step", step, 9 + n, [found[1][n], number]);
            let groups = [spot_groups(number as usize) as u32, 1, 1];
            for (a, b) in found[2][3 * n..3 * n + 3].iter().zip(groups) {
                tally.add_exact("step", step, 11, [*a, b]);
            }
        }
        level.pairs = made.iter().map(|[exact, _]| exact.0).collect();
        let listed = |end: bool| {
            let own = (0..count as u32).filter(|k| made[*k as usize][0].1 == Some(end));
            own.collect::<Vec<_>>()
        };
        Ok([false, true].map(listed))
    }

    fn check_factors(&mut self, twin: &LevelTwin, level: &mut Level, list: &WorkList) -> Result<()> {
        let work = work_words(list, level.pairs.len());
        for (end, entry) in ["unclipped_factors", "clipped_factors"].into_iter().enumerate() {
            let listed = &list[end];
            if listed.is_empty() {
                continue;
            }
            let found = self.run_on_lanes(["link_factors", entry], level, listed.len(), &work)?;
            let factors: Vec<[f32; SPOTS]> = (listed.par_iter())
                .map(|k| twin.factors(&level.pairs[*k as usize], end == 1))
                .collect();
            for (k, factors) in listed.iter().zip(factors) {
                for (lane, factor) in level.lanes[*k as usize].iter_mut().zip(factors) {
                    lane.factor = factor;
                }
            }
            let sizes = |k: usize| twin.factor_sizes(&level.pairs[k]).map(|size| lane_sizes(6, &[size]));
            let lanes = [&found[..], &level.lanes];
            compare_lanes(&mut self.tallies.link_factors, &level.pairs, lanes, sizes);
        }
        Ok(())
    }
}

/// Words of a lane that are integers: the bits of its blocked samples, and the padding.
const INTEGER_WORDS: [usize; 3] = [8, 9, 11];

/// Compares all words of all lanes; `sizes` are those of a pair's.
pub fn compare_lanes(
    tally: &mut StageTally,
    pairs: &[PairRecord],
    [found, expected]: [&[Lanes]; 2],
    sizes: impl Fn(usize) -> [[f32; LANE_WORDS]; SPOTS],
) {
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        let words = [as_words(found), as_words(expected)];
        if words[0] == words[1] {
            tally.add_equal(words[0].len() as u64);
            continue;
        }
        let is_integer = |n: usize| INTEGER_WORDS.contains(&(n % LANE_WORDS));
        // Sizes take as long as a link, and only floats need them.
        let differs = (0..words[0].len()).any(|n| !is_integer(n) && words[0][n] != words[1][n]);
        let sizes = differs.then(|| sizes(k));
        for (n, (a, b)) in words[0].iter().zip(words[1]).enumerate() {
            let (l, word) = (n / LANE_WORDS, n % LANE_WORDS);
            let kind = if is_integer(n) {
                Word::Integer
            } else {
                Word::Float(sizes.map_or(0.0, |sizes| sizes[l][word]))
            };
            tally.add(Place::of_spot(&pairs[k], l), [k * SPOTS + l, word], [*a, *b], kind);
        }
    }
}

/// Returns the sizes of a lane's words: these from word `first` on, else 0.
pub fn lane_sizes(first: usize, sizes: &[f32]) -> [f32; LANE_WORDS] {
    let mut all = [0.0; LANE_WORDS];
    all[first..first + sizes.len()].copy_from_slice(sizes);
    all
}

/// Returns the words of a work list: the numbers of its two parts, and the pairs. The words between name the pair behind the
/// `pairs` of the level, whose spots no stage may write.
pub fn work_words(list: &WorkList, pairs: usize) -> Vec<u32> {
    let mut words = vec![pairs as u32; WORK_WORDS];
    [words[0], words[1]] = [list[0].len() as u32, list[1].len() as u32];
    words[2..2 + list[0].len()].copy_from_slice(&list[0]);
    for (k, pair) in list[1].iter().enumerate() {
        words[WORK_WORDS - 1 - k] = *pair;
    }
    words
}

/// Counts the entries of each of `count` pairs in a list's front and end; numbers that name no pair are left out.
fn count_entries(words: &[u32], count: usize) -> Vec<[u32; 2]> {
    let mut entries = vec![[0; 2]; count];
    let parts: [Box<dyn Iterator<Item = &u32>>; 2] = [Box::new(words[2..].iter()), Box::new(words[2..].iter().rev())];
    for (n, part) in parts.into_iter().enumerate() {
        for pair in part.take(words[n] as usize) {
            if let Some(own) = entries.get_mut(*pair as usize) {
                own[n] += 1;
            }
        }
    }
    entries
}

fn entries_of(listed: Option<bool>) -> [u32; 2] {
    [Some(false), Some(true)].map(|part| u32::from(listed == part))
}

/// Returns all combinations of directions in which rounding may move what decides.
fn nudges() -> impl Iterator<Item = Nudge> {
    let step = |k: i32| (k % 3 - 1) as f32;
    (0..27).map(move |k| [step(k), step(k / 3), step(k / 9)])
}
