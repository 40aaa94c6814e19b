//! Compares each stage of the links between nodes with its twin: level after level of the trees, each stage on the twin's
//! results of the stages before, so that an error of one does not reach the next check.
//!
//! On an adapter without fused multiply-add all bits are equal. Elsewhere the bound of a stage is k roundings of the
//! terms that it adds, k counted from its operations; a decision may also be the twin's on the other side of a threshold that
//! is within rounding.

mod level;
mod next_level;
mod samples;
mod tally;
mod twin;

use crate::compare::checked_stages::CheckedStages;
use crate::compare::comparison::StageCheck;
use crate::compare::races::race_checks;
use crate::solve::gpu_linker::{node_records, radiosity_records, receiver_record};
use common::Result;
use cpu::hierarchy::linker::{LinkRequest, LinkerScene};
use cpu::hierarchy::refinement_steps::is_dark;
use gpu::hierarchy::link_probe::{LinkProbe, UNWRITTEN, as_words};
use gpu::link_records::{BlockReceiver, BlockRecord, LaneRecord, PairRecord, RequestRecord, SpotRecord};
use gpu::{Gpu, ShaderFault};
use level::Level;
use tally::StageTally;
pub(super) use twin::factor_sizes;
use twin::{LevelTwin, SPOTS};

/// Most blocks of a request that are checked, spread over all.
const CHECKED_BLOCKS: usize = 8;
/// Most roots with radiosity, and most without, that are checked at each block, spread over all.
const CHECKED_ROOTS: [usize; 2] = [40, 2];

/// Words of a pair, and of a pair at a spot.
const PAIR_WORDS: usize = size_of::<PairRecord>() / 4;
const LANE_WORDS: usize = size_of::<LaneRecord>() / 4;

/// Words beyond the end of each buffer that a stage writes, which it has to leave as they are.
const GUARD_WORDS: usize = 64;

/// Names of the words of a pair.
const PAIR_VALUES: [&str; PAIR_WORDS + 3] = [
    "block",
    "node",
    "state",
    "samples",
    "known samples",
    "points per side",
    "F at most",
    "light",
    "rest of the light",
    "entries at the list's front",
    "entries at the list's end",
    "workgroups",
];
/// Names of the words of a pair at a spot.
const LANE_VALUES: [&str; LANE_WORDS] = [
    "bound of F",
    "bound by variation",
    "bound by slope",
    "bound within the spot",
    "w·x",
    "w·y",
    "F",
    "w",
    "blocked samples",
    "blocked samples from 32",
    "F of known samples",
    "padding",
];

/// Comparisons of each stage.
struct Tallies {
    clear_work_lists: StageTally,
    link_bounds: StageTally,
    refine: StageTally,
    link_factors: StageTally,
    sample_links: StageTally,
    rays: StageTally,
    prefix_sum: StageTally,
    subdivide_nodes: StageTally,
    add_links: StageTally,
    store_links: StageTally,
}

impl Tallies {
    /// Starts the tallies of all stages, each with its bound and the reason.
    fn new() -> Self {
        let of = StageTally::new;
        Self {
            clear_work_lists: of(
                "clear_work_lists",
                (0.0, "words of the lists, all exact"),
                &["pairs", "workgroups"],
            ),
            link_bounds: of(
                "link_bounds",
                (
                    64.0,
                    "ulp of F without cosines: 4 corners of two dot products, a root, 6 divisions, 12 products",
                ),
                &LANE_VALUES,
            ),
            refine: of(
                "refine",
                (
                    4.0,
                    "ulp of the light: a product each; decisions are the twin's, or those of a threshold within rounding",
                ),
                &PAIR_VALUES,
            ),
            link_factors: of(
                "link_factors",
                (
                    192.0,
                    "ulp of F without its cosines: 5 edges of a cross product, a root, an angle and a division; 64 additions",
                ),
                &LANE_VALUES,
            ),
            sample_links: of(
                "sample_links",
                (
                    96.0,
                    "ulp of w on the same visibility: disc weights, one addition per sample",
                ),
                &LANE_VALUES,
            ),
            rays: of(
                "rays",
                (
                    0.0,
                    "samples of different visibility from the same points, though no rounding decides them",
                ),
                &["visibility"],
            ),
            prefix_sum: of(
                "prefix_sum",
                (0.0, "sums of integers, all exact"),
                &["children before", "links before", "total", "number", "workgroups"],
            ),
            subdivide_nodes: of("subdivide_nodes", (0.0, "ends of pairs, all exact"), &PAIR_VALUES),
            add_links: of(
                "add_links",
                (
                    1.0,
                    "roundings of the terms: 3 products and sums, one addition per link",
                ),
                &[
                    "H.r",
                    "H.g",
                    "H.b",
                    "shadow's edge",
                    "first pair of the next level",
                    "end of the next level's pairs",
                ],
            ),
            store_links: of(
                "store_links",
                (0.0, "copies, all exact"),
                &["block", "node", "w", "w·x", "w·y", "padding"],
            ),
        }
    }

    /// Returns the tallies in the order in which the stages run.
    fn in_order(&mut self) -> [&mut StageTally; 10] {
        [
            &mut self.clear_work_lists,
            &mut self.link_bounds,
            &mut self.refine,
            &mut self.link_factors,
            &mut self.sample_links,
            &mut self.rays,
            &mut self.prefix_sum,
            &mut self.subdivide_nodes,
            &mut self.add_links,
            &mut self.store_links,
        ]
    }
}

/// Checker of the stages of links.
pub struct LinkStages {
    /// Its shaders count races.
    watched: Gpu,
    probe: LinkProbe,
    tallies: Tallies,
}

impl LinkStages {
    /// Uploads the scene; `faults` are planted in the shaders.
    ///
    /// Errors: [`common::Error::Device`].
    pub fn new(gpu: &Gpu, scene: &LinkerScene, faults: &[ShaderFault]) -> Result<Self> {
        let watched = gpu.for_checks();
        Ok(Self {
            probe: LinkProbe::new(&watched, scene.mesh, &node_records(scene), faults)?,
            watched,
            tallies: Tallies::new(),
        })
    }

    /// Runs a stage as [`LinkProbe::run_stage`] does, and checks that it writes nothing beyond the ends of the buffers `made`.
    fn run_stage(
        &mut self,
        names: [&'static str; 2],
        groups: usize,
        given: &[(&str, &[u32])],
        made: &[(&str, usize)],
    ) -> Result<Vec<Vec<u32>>> {
        let guarded = made.iter().map(|(name, words)| {
            let room = self.probe.buffer_words(name);
            (*name, (words + GUARD_WORDS).min(room).max(*words))
        });
        let guarded: Vec<(&str, usize)> = guarded.collect();
        let mut found = self.probe.run_stage(names, groups, given, &guarded)?;
        let mut tallies = self.tallies.in_order().into_iter();
        let mut tally = tallies.find(|tally| tally.name == names[0]);
        for (words, (_, count)) in found.iter_mut().zip(made) {
            for (k, word) in words.split_off(*count).into_iter().enumerate() {
                if let Some(tally) = &mut tally {
                    tally.add_exact("word beyond the end", k, 0, [word, UNWRITTEN]);
                }
            }
        }
        Ok(found)
    }

    /// Checks all stages at some blocks of a request, from some roots down to the leaves.
    ///
    /// Errors: the device fails.
    pub fn check_request(&mut self, scene: &LinkerScene, request: &LinkRequest) -> Result<()> {
        let blocks = &request.receivers.blocks;
        let planes: Vec<_> = scene.mesh.faces.iter().map(|face| face.plane).collect();
        let twin = LevelTwin {
            scene,
            request,
            blocks: spread(blocks.len(), CHECKED_BLOCKS).map(|k| &blocks[k]).collect(),
        };
        let records: Vec<BlockReceiver> = (twin.blocks.iter())
            .map(|block| receiver_record(request, block, &planes))
            .collect();
        let spots: Vec<SpotRecord> = records.iter().flat_map(|block| block.spots).collect();
        let blocks: Vec<BlockRecord> = records.iter().map(|block| block.block).collect();
        let thresholds = request.thresholds;
        let limits = RequestRecord {
            source: thresholds.source,
            visibility: thresholds.visibility,
            near: thresholds.near,
            edge: thresholds.edge,
            blocks: blocks.len() as u32,
            pairs: u32::MAX,
            links: u32::MAX,
            pad: 0,
        };
        let light = radiosity_records(&request.radiosity[..scene.tree.nodes.len()]);
        let given: [(&str, &[u32]); 4] = [
            ("spots", as_words(&spots)),
            ("blocks", as_words(&blocks)),
            ("radiosity", as_words(&light)),
            ("request", as_words(std::slice::from_ref(&limits))),
        ];
        self.check_cleared_lists(&given)?;
        let (dark, lit): (Vec<u32>, Vec<u32>) =
            (scene.tree.roots.iter()).partition(|k| is_dark(&request.radiosity[**k as usize]));
        let roots: Vec<u32> = [(&lit, CHECKED_ROOTS[0]), (&dark, CHECKED_ROOTS[1])]
            .into_iter()
            .flat_map(|(roots, most)| spread(roots.len(), most).map(|k| roots[k]))
            .collect();
        let mut level = Level::new(blocks.len(), &roots, limits);
        while !level.pairs.is_empty() {
            level = self.check_level(&twin, level)?;
        }
        Ok(())
    }

    /// Returns why a solve with these stages is not run: a dispatch of any number of workgroups may have no end.
    fn refuse_solve(&mut self) -> Option<String> {
        let wrong = (self.tallies.in_order().into_iter()).find(|tally| tally.has_wrong_workgroups)?;
        Some(format!(
            "{} makes wrong numbers of workgroups: the GPU's solve is not run",
            wrong.name
        ))
    }

    /// Returns the checks of the stages that were reached and those of their races, and the names of the others.
    ///
    /// Errors: the device fails.
    pub fn checked_stages(&mut self) -> Result<CheckedStages> {
        let (reached, others): (Vec<_>, Vec<_>) = self
            .tallies
            .in_order()
            .into_iter()
            .partition(|tally| tally.is_reached());
        let mut checks: Vec<StageCheck> = reached.into_iter().map(|tally| tally.stage_check()).collect();
        checks.append(&mut pollster::block_on(race_checks(&self.watched))?);
        Ok(CheckedStages {
            checks,
            unreached: others.into_iter().map(|tally| tally.name).collect(),
            refusal: self.refuse_solve(),
        })
    }
}

/// Returns at most `most` of so many indices, spread over all.
fn spread(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let chosen = count.min(most);
    (0..chosen).map(move |k| (2 * k + 1) * count / (2 * chosen))
}

/// Returns the workgroups over the spots of so many pairs.
fn spot_groups(pairs: usize) -> usize {
    (pairs * SPOTS).div_ceil(common::constants::PATCH_SUM_LANES)
}

/// Returns the words of a pair with the number of its entries in a list.
fn pair_words(pair: &PairRecord, entries: [u32; 2]) -> Vec<u32> {
    [as_words(std::slice::from_ref(pair)), &entries].concat()
}
