//! Compares the links that the GPU makes with those that the CPU makes by rays from the same requests.
//!
//! On an adapter without fused multiply-add all bits are equal. Elsewhere form factors and sums differ by
//! roundings. If a value is within rounding of a threshold, one side may subdivide a node that the other
//! links, or a ray may pass an edge that the other ray meets.

use crate::compare::comparison::{StageCheck, VisibilityStatistics};
use crate::solve::gpu_linker::LinkerOnGpu;
use common::Result;
use common::passes::ProgressCallback;
use cpu::hierarchy::coarse::StoredLink;
use cpu::hierarchy::cpu_linker::CpuLinker;
use cpu::hierarchy::linker::BlockIrradiance;
use cpu::hierarchy::linker::LinkRequest;
use cpu::hierarchy::linker::Linker;
use cpu::hierarchy::linker::LinkerScene;
use gpu::{Gpu, ShaderFault};
use std::cell::RefCell;
use std::rc::Rc;

/// Largest rounding error of a block's sums and weights relative to its largest value, in units of 2⁻²⁴: a
/// polygon's form factor and its moments, a sum over links, and WGSL's weaker divisions and roots.
const MAX_BLOCK_ROUNDINGS: f64 = 384.0;
/// Largest share of blocks in which rounding may turn a decision. Each block makes about a thousand comparisons
/// with a threshold or an edge, and one of 40 000 values is within [`MAX_BLOCK_ROUNDINGS`] of it.
const MAX_TURNED_SHARE: f64 = 0.05;

/// Differences of blocks in one kind of request.
#[derive(Clone, Copy, Debug, Default)]
pub struct BlockStatistics {
    /// Number of blocks.
    pub blocks: u64,
    /// Blocks in which any bit differs.
    pub differing: u64,
    /// Blocks that differ by more than rounding.
    pub turned: u64,
    /// Number of receiving points with light, or of stored links.
    pub links: u64,
}

impl BlockStatistics {
    /// Counts blocks without a result as wrong.
    fn count_missing(&mut self, found: usize, expected: usize) {
        let missing = expected.abs_diff(found) as u64;
        self.blocks += missing;
        self.differing += missing;
        self.turned += missing;
    }

    fn count_block(&mut self, exact: bool, difference: f64, found: usize) {
        self.blocks += 1;
        self.differing += u64::from(!exact);
        // A NaN counts as turned.
        let rounded = difference <= MAX_BLOCK_ROUNDINGS * f64::from(f32::EPSILON) / 2.0;
        self.turned += u64::from(!exact && !rounded);
        self.links += found as u64;
    }

    /// Returns the share of blocks that differ by more than rounding.
    pub fn turned_share(&self) -> f64 {
        self.turned as f64 / self.blocks as f64
    }

    fn stage_check(&self, name: &str, what: &str) -> StageCheck {
        let worst = self.turned_share();
        StageCheck {
            name: name.into(),
            values: self.links,
            differing: self.differing,
            worst,
            bound: MAX_TURNED_SHARE,
            reason: format!(
                "blocks, of {}, {what} by more than rounding: a comparison that it decides may turn",
                self.blocks
            ),
            agree: self.links > 0 && worst <= MAX_TURNED_SHARE,
        }
    }
}

/// Differences between the links of CPU and GPU in one solve.
#[derive(Clone, Copy, Debug, Default)]
pub struct LinkDiff {
    /// Irradiance of blocks.
    pub gathered: BlockStatistics,
    /// Stored links.
    pub kept: BlockStatistics,
}

impl LinkDiff {
    /// Returns one check for each kind of request.
    pub fn stage_checks(&self) -> Vec<StageCheck> {
        vec![
            self.gathered.stage_check("gathered", "at which light differs"),
            self.kept.stage_check("kept", "whose links differ"),
        ]
    }

    /// Returns the statistics in the format of visibility pairs: blocks take the place of pairs of points.
    pub fn block_statistics(&self) -> VisibilityStatistics {
        let kinds = [self.gathered, self.kept];
        let sum = |of: fn(&BlockStatistics) -> u64| kinds.iter().map(of).sum::<u64>();
        let (blocks, turned) = (sum(|s| s.blocks), sum(|s| s.turned));
        let allowed = (MAX_TURNED_SHARE * blocks as f64) as u64;
        VisibilityStatistics {
            pairs: sum(|s| s.links),
            facing: blocks,
            mismatched: turned,
            explained: turned.min(allowed),
            unexplained: turned.saturating_sub(allowed),
            explainable: allowed,
            weighted_mismatch: turned as f64 / blocks as f64,
            weighted_explainable: MAX_TURNED_SHARE,
            ..VisibilityStatistics::default()
        }
    }

    /// Returns the larger share of blocks that differ by more than rounding.
    pub fn largest_turned_share(&self) -> f64 {
        self.gathered.turned_share().max(self.kept.turned_share())
    }
}

/// Linker that runs both linkers, compares them and returns the CPU's result, so that a difference in one request
/// does not reach the next.
pub struct LinkerPair<'w> {
    cpu: CpuLinker<'w>,
    gpu: LinkerOnGpu,
    diff: Rc<RefCell<LinkDiff>>,
}

impl LinkerPair<'_> {
    /// Returns a factory of such linkers, which count in `diff`. `faults` are planted in the shaders.
    pub fn linker_factory<'m>(
        gpu: &'m Gpu,
        faults: &'m [ShaderFault],
        diff: &'m Rc<RefCell<LinkDiff>>,
    ) -> impl for<'w> Fn(&LinkerScene<'w>) -> Result<Box<dyn Linker + 'w>> + 'm {
        move |scene| {
            Ok(Box::new(LinkerPair {
                cpu: CpuLinker {
                    scene: *scene,
                    rays_only: true,
                },
                gpu: LinkerOnGpu::new(gpu, scene, faults)?,
                diff: diff.clone(),
            }))
        }
    }
}

impl Linker for LinkerPair<'_> {
    fn gather_irradiance(&self, request: &LinkRequest, watch: ProgressCallback) -> Result<Vec<BlockIrradiance>> {
        let found = self.gpu.gather_irradiance(request, watch)?;
        let expected = self.cpu.gather_irradiance(request, watch)?;
        let statistics = &mut self.diff.borrow_mut().gathered;
        statistics.count_missing(found.len(), expected.len());
        let pairs = found.iter().zip(&expected);
        for ((found, expected), block) in pairs.zip(&request.receivers.blocks) {
            // Lanes beyond the block's points hold no results.
            let used_lanes = |lit: &BlockIrradiance| lit.sums.map(|lane| lane[..block.count].to_vec()).concat();
            let (found, expected) = (
                (used_lanes(found), found.crosses_shadow_edge),
                (used_lanes(expected), expected.crosses_shadow_edge),
            );
            let light = expected.0.iter().filter(|h| **h > 0.0).count();
            statistics.count_block(
                found.1 == expected.1 && equal_bits(&found.0, &expected.0),
                relative_difference(&found.0, &expected.0) + f64::from(u8::from(found.1 != expected.1)),
                light,
            );
        }
        Ok(expected)
    }

    fn create_links(&self, request: &LinkRequest, watch: ProgressCallback) -> Result<Vec<Vec<StoredLink>>> {
        let found = self.gpu.create_links(request, watch)?;
        let expected = self.cpu.create_links(request, watch)?;
        let statistics = &mut self.diff.borrow_mut().kept;
        statistics.count_missing(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            let nodes = |links: &[StoredLink]| links.iter().map(|stored| stored.node).collect::<Vec<_>>();
            let [a, b] = [found, expected].map(|links| link_parts(links));
            let same = nodes(found) == nodes(expected);
            let difference = (0..3).map(|k| relative_difference(&a[k], &b[k])).fold(0.0, f64::max);
            let exact = (0..3).all(|k| equal_bits(&a[k], &b[k]));
            let difference = if same { difference } else { f64::INFINITY };
            statistics.count_block(same && exact, difference, expected.len());
        }
        Ok(expected)
    }
}

/// Collects the weights of links, and their moments along the node's two axes.
fn link_parts(links: &[StoredLink]) -> [Vec<f32>; 3] {
    let all = |of: &dyn Fn(&StoredLink) -> Vec<f32>| links.iter().flat_map(of).collect();
    [
        all(&|stored| stored.link.weight.to_vec()),
        all(&|stored| stored.link.along[0].to_vec()),
        all(&|stored| stored.link.along[1].to_vec()),
    ]
}

fn equal_bits(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

/// Returns the largest |a − b| relative to the largest |b|.
fn relative_difference(a: &[f32], b: &[f32]) -> f64 {
    let largest = b.iter().fold(0.0f32, |largest, x| largest.max(x.abs()));
    let pairs = a.iter().zip(b);
    let difference = pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs());
    // A NaN must stay: f64::max would drop it.
    let difference = difference.fold(0.0, |largest: f64, x| if x <= largest { largest } else { x });
    if difference == 0.0 {
        0.0
    } else {
        difference / f64::from(largest)
    }
}
