//! Compares the links that the GPU makes with those that the CPU makes by rays from the same requests, stage by stage
//! ([`LinkStages`]) and as a whole.
//!
//! On an adapter without fused multiply-add all bits are equal. Elsewhere form factors and sums differ by
//! roundings. If a value is within rounding of a threshold, one side may subdivide a node that the other
//! links, or a ray may pass an edge that the other ray meets.

use super::link_stages::LinkStages;
use super::statistics::describe_difference;
use crate::compare::checked_stages::CheckedStages;
use crate::compare::comparison::{Criterion, VisibilityStatistics};
use crate::solve::gpu_linker::LinkerOnGpu;
use common::Result;
use common::passes::ProgressCallback;
use common::precision::UNIT_ROUNDOFF;
use cpu::hierarchy::coarse::StoredLink;
use cpu::hierarchy::cpu_linker::CpuLinker;
use cpu::hierarchy::linker::{BlockIrradiance, LinkRequest, Linker, LinkerScene};
use gpu::{Gpu, ShaderFault};
use stage_check::tally::{Compared, Tally, Value, larger_or_nan};
use std::cell::RefCell;
use std::rc::Rc;

/// Largest rounding error of a block's sums and weights relative to its largest value, in units of 2⁻²⁴: a
/// polygon's form factor and its moments, a sum over links, and WGSL's weaker divisions and roots.
const MAX_BLOCK_ROUNDINGS: f64 = 384.0;
/// Largest share of blocks in which rounding may turn a decision. Each block makes about a thousand comparisons
/// with a threshold or an edge, and one of 40 000 values is within [`MAX_BLOCK_ROUNDINGS`] of it.
const MAX_TURNED_SHARE: f64 = 0.05;

/// Differences of blocks in one kind of request.
#[derive(Clone, Debug)]
pub struct BlockStatistics {
    /// Blocks, with the largest difference of their values in units of 2⁻²⁴; one beyond the bound has turned. The label
    /// is the name of the value.
    pub blocks: Tally<&'static str>,
    /// Number of receiving points with light, or of stored links.
    pub links: u64,
}

/// Results of a block.
struct BlockParts {
    /// Decisions, and their name.
    decisions: (&'static str, Vec<u32>),
    /// Values in groups of one scale, and their name.
    values: (&'static str, Vec<Vec<f32>>),
    links: usize,
}

impl BlockParts {
    /// Returns the error of a block, and the first value that differs: its name, and both sides.
    fn compare(&self, expected: &Self) -> (f64, Option<(&'static str, [Value; 2])>) {
        if let Some(values) = first_unequal(&self.decisions.1, &expected.decisions.1, |x| x) {
            return (f64::INFINITY, Some((self.decisions.0, values)));
        }
        let groups = || self.values.1.iter().zip(&expected.values.1);
        let unequal = groups().find_map(|(a, b)| first_unequal(a, b, f32::to_bits));
        let differences = groups().map(|(a, b)| relative_difference(a, b) * 2.0 / f64::from(f32::EPSILON));
        match unequal {
            // −0 differs from 0.
            Some(values) => (
                differences.fold(f64::MIN_POSITIVE, larger_or_nan),
                Some((self.values.0, values)),
            ),
            None => (0.0, None),
        }
    }
}

/// Returns the first values of two lists with different bits; of the shorter list `Unwritten`.
fn first_unequal<T: Copy + Into<Value>>(found: &[T], expected: &[T], bits: fn(T) -> u32) -> Option<[Value; 2]> {
    let value = |list: &[T], k: usize| list.get(k).map_or(Value::Unwritten, |x| (*x).into());
    let differ = |k: &usize| found.get(*k).copied().map(bits) != expected.get(*k).copied().map(bits);
    let first = (0..found.len().max(expected.len())).find(differ)?;
    Some([value(found, first), value(expected, first)])
}

impl Default for BlockStatistics {
    fn default() -> Self {
        Self {
            blocks: Tally::new(MAX_BLOCK_ROUNDINGS),
            links: 0,
        }
    }
}

impl BlockStatistics {
    /// Counts the results of a request; blocks without a result count as wrong.
    fn count_blocks<T>(&mut self, [found, expected]: [&[T]; 2], parts: impl Fn(usize, &T) -> BlockParts) {
        for k in 0..found.len().max(expected.len()) {
            let [found, expected] = [found, expected].map(|list| list.get(k).map(|block| parts(k, block)));
            self.links += expected.as_ref().map_or(0, |block| block.links) as u64;
            let (error, unequal) = match (&found, &expected) {
                (Some(found), Some(expected)) => found.compare(expected),
                _ => (f64::NAN, None),
            };
            let (label, [found, expected]) = unequal.unwrap_or(("result", [Value::Unwritten; 2]));
            self.blocks.add(Compared {
                element: k,
                component: 0,
                label,
                found,
                expected,
                error,
            });
        }
    }

    fn turned_share(&self) -> f64 {
        self.blocks.beyond as f64 / self.blocks.values as f64
    }

    fn criterion(&self, name: &str, what: &str) -> Criterion {
        let worst = self.turned_share();
        let agree = self.links > 0 && worst <= MAX_TURNED_SHARE;
        let element = |block: &Compared<&str>| format!("{} of block {}", block.label, block.element);
        let difference = describe_difference(&self.blocks, [0, 1], |_| String::new(), element);
        Criterion {
            name: name.into(),
            value: worst,
            bound: MAX_TURNED_SHARE,
            reason: format!(
                "blocks, of {}, {what} by more than rounding: a comparison that it decides may turn",
                self.blocks.values
            ),
            pass: agree,
            difference: difference.filter(|_| !agree),
        }
    }
}

/// Differences between the links of CPU and GPU in one solve.
#[derive(Clone, Debug, Default)]
pub struct LinkDiff {
    /// Stages, each on equal input. The GPU is not asked further where workgroups are wrong, too.
    pub stages: CheckedStages,
    /// Irradiance of blocks.
    pub gathered: BlockStatistics,
    /// Stored links.
    pub kept: BlockStatistics,
}

impl LinkDiff {
    /// Returns the criteria of the stages, and one for each kind of request as a whole.
    pub fn criteria(&self) -> Vec<Criterion> {
        let mut criteria = self.stages.criteria();
        criteria.extend([
            (self.gathered).criterion("links: gathered light", "at which light differs"),
            self.kept.criterion("links: stored links", "whose links differ"),
        ]);
        criteria
    }

    /// Returns the statistics in the format of visibility pairs: blocks take the place of pairs of points.
    pub fn block_statistics(&self) -> VisibilityStatistics {
        let kinds = [&self.gathered, &self.kept];
        let sum = |of: fn(&BlockStatistics) -> u64| kinds.iter().map(|s| of(s)).sum::<u64>();
        let (blocks, turned) = (sum(|s| s.blocks.values), sum(|s| s.blocks.beyond));
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

    /// Returns the largest difference between links of equal decisions, relative to the largest of a block: 0 where the
    /// adapter rounds as the CPU does.
    pub fn largest_rounding(&self) -> f64 {
        let equal = self.gathered.blocks.unequal + self.kept.blocks.unequal == 0;
        if equal {
            0.0
        } else {
            MAX_BLOCK_ROUNDINGS * UNIT_ROUNDOFF
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
    stages: RefCell<LinkStages>,
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
                stages: LinkStages::new(gpu, scene, faults)?.into(),
                diff: diff.clone(),
            }))
        }
    }

    /// Checks the stages at a request, and returns what it finds on both sides; nothing of the GPU once
    /// it is refused.
    fn find_both<T>(&self, request: &LinkRequest, find: impl Fn(&dyn Linker) -> Result<T>) -> Result<(Option<T>, T)> {
        let mut checked = std::mem::take(&mut self.diff.borrow_mut().stages);
        let mut found = None;
        if checked.refusal.is_none() {
            let mut stages = self.stages.borrow_mut();
            stages.check_request(&self.cpu.scene, request)?;
            checked = stages.checked_stages()?;
        }
        if checked.refusal.is_none() {
            match find(&self.gpu) {
                Ok(links) => found = Some(links),
                Err(error) => checked.take_refusal(error)?,
            }
        }
        self.diff.borrow_mut().stages = checked;
        Ok((found, find(&self.cpu)?))
    }
}

impl Linker for LinkerPair<'_> {
    fn gather_irradiance(&self, request: &LinkRequest, watch: ProgressCallback) -> Result<Vec<BlockIrradiance>> {
        let watch = RefCell::new(watch);
        let (found, expected) = self.find_both(request, |linker| {
            linker.gather_irradiance(request, &mut **watch.borrow_mut())
        })?;
        let parts = |k: usize, lit: &BlockIrradiance| {
            // Lanes beyond the block's points hold no results.
            let used = lit
                .sums
                .map(|lane| lane[..request.receivers.blocks[k].count].to_vec())
                .concat();
            let links = used.iter().filter(|h| **h > 0.0).count();
            BlockParts {
                decisions: ("shadow edge", vec![u32::from(lit.crosses_shadow_edge)]),
                values: ("irradiance", vec![used]),
                links,
            }
        };
        if let Some(found) = found {
            (self.diff.borrow_mut().gathered).count_blocks([&found, &expected], parts);
        }
        Ok(expected)
    }

    fn create_links(&self, request: &LinkRequest, watch: ProgressCallback) -> Result<Vec<Vec<StoredLink>>> {
        let watch = RefCell::new(watch);
        let (found, expected) = self.find_both(request, |linker| {
            linker.create_links(request, &mut **watch.borrow_mut())
        })?;
        // The weights of links, and their moments along the node's two axes.
        let parts = |_, links: &Vec<StoredLink>| {
            let all = |of: fn(&StoredLink) -> &[f32]| links.iter().flat_map(of).copied().collect();
            let values = [
                all(|stored| &stored.link.weight),
                all(|stored| &stored.link.along[0]),
                all(|stored| &stored.link.along[1]),
            ];
            let nodes = links.iter().map(|stored| stored.node).collect();
            BlockParts {
                decisions: ("node", nodes),
                values: ("weight", values.to_vec()),
                links: links.len(),
            }
        };
        if let Some(found) = found {
            (self.diff.borrow_mut().kept).count_blocks([&found, &expected], parts);
        }
        Ok(expected)
    }
}

/// Returns the largest |a − b| relative to the largest |b|.
fn relative_difference(a: &[f32], b: &[f32]) -> f64 {
    let largest = b.iter().fold(0.0f32, |largest, x| largest.max(x.abs()));
    let differences = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs());
    match differences.fold(0.0, larger_or_nan) {
        0.0 => 0.0,
        difference => difference / f64::from(largest),
    }
}
