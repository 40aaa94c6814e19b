//! Compares the links that the GPU makes with those that the CPU makes by rays from the same requests, stage by stage
//! ([`LinkStages`]) and as a whole.
//!
//! On an adapter without fused multiply-add all bits are equal. Elsewhere form factors and sums differ by
//! roundings. If a value is within rounding of a threshold, one side may subdivide a node that the other
//! links, or a ray may pass an edge that the other ray meets.

use super::link_stages::LinkStages;
use super::roundings::MAX_BLOCK_ROUNDINGS;
use super::statistics::describe_difference;
use super::turned_blocks::{BlockTask, MovedFaces};
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
use std::iter::repeat;
use std::rc::Rc;

/// Largest share of blocks that turn though none of [`MovedFaces`] turns them as much. Each block makes about a thousand
/// comparisons with a threshold or an edge, and one of 40 000 values is within [`MAX_BLOCK_ROUNDINGS`] of it.
const MAX_TURNED_SHARE: f64 = 0.05;
/// Largest share of blocks of a request that rounding may turn: where more differ, another cause is not looked for.
const MAX_EXPLAINED_SHARE: f64 = 0.25;

/// Differences of blocks in one kind of request.
#[derive(Clone, Debug)]
pub struct BlockStatistics {
    /// Blocks, with the largest difference of their values in units of 2⁻²⁴; one beyond the bound has turned. The label
    /// is the name of the value.
    pub blocks: Tally<&'static str>,
    /// Blocks that turn on the CPU, too, by rounding; they count as within the bound.
    pub explained: u64,
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
    /// Returns the error of a block, relative in each group to its largest value and its size, and the first value that differs:
    /// its name, and both sides.
    fn compare(&self, expected: &Self, sizes: &[f32]) -> (f64, Option<(&'static str, [Value; 2])>) {
        if let Some(values) = first_unequal(&self.decisions.1, &expected.decisions.1, |x| x) {
            return (f64::INFINITY, Some((self.decisions.0, values)));
        }
        let groups = || self.values.1.iter().zip(&expected.values.1);
        let unequal = groups().find_map(|(a, b)| first_unequal(a, b, f32::to_bits));
        let sizes = sizes.iter().copied().chain(repeat(0.0));
        let differences = groups()
            .zip(sizes)
            .map(|((a, b), size)| relative_difference(a, b, size) / UNIT_ROUNDOFF);
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
            explained: 0,
            links: 0,
        }
    }
}

impl BlockStatistics {
    /// Counts the blocks of a request. Of one that differs by more than the roundings of its largest values `judge` returns the
    /// error relative to the sizes of its terms, and what rounding makes of the block by turning the CPU's decisions, both in the
    /// same unit.
    ///
    /// Errors: those of `judge`.
    fn count_blocks(
        &mut self,
        [found, expected]: [&[BlockParts]; 2],
        judge: impl Fn(usize, [&BlockParts; 2]) -> Result<[f64; 2]>,
    ) -> Result<()> {
        let count = found.len().max(expected.len());
        let compared = |k: usize| match (found.get(k), expected.get(k)) {
            (Some(found), Some(expected)) => found.compare(expected, &[]),
            // Blocks without a result are wrong.
            _ => (f64::NAN, None),
        };
        let compared: Vec<_> = (0..count).map(compared).collect();
        let turned = compared
            .iter()
            .filter(|(error, _)| *error > MAX_BLOCK_ROUNDINGS)
            .count();
        let may_round = turned as f64 <= MAX_EXPLAINED_SHARE * count as f64;
        for (k, (mut error, unequal)) in compared.into_iter().enumerate() {
            self.links += expected.get(k).map_or(0, |block| block.links) as u64;
            if may_round && error > MAX_BLOCK_ROUNDINGS {
                let turned;
                [error, turned] = judge(k, [&found[k], &expected[k]])?;
                if error > MAX_BLOCK_ROUNDINGS && error <= turned {
                    self.explained += 1;
                    error = MAX_BLOCK_ROUNDINGS;
                }
            }
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
        Ok(())
    }

    /// Returns the share of blocks that differ by more than rounding.
    fn turned_share(&self) -> f64 {
        (self.blocks.beyond + self.explained) as f64 / self.blocks.values as f64
    }

    fn criterion(&self, name: &str, what: &str) -> Criterion {
        let worst = self.blocks.beyond as f64 / self.blocks.values as f64;
        let agree = self.links > 0 && worst <= MAX_TURNED_SHARE;
        let element = |block: &Compared<&str>| format!("{} of block {}", block.label, block.element);
        let difference = describe_difference(&self.blocks, [0, 1], |_| String::new(), element);
        Criterion {
            name: name.into(),
            value: worst,
            bound: MAX_TURNED_SHARE,
            reason: format!(
                "blocks, of {}, {what} by more than rounding; {} more differ so where faces move by rounding",
                self.blocks.values, self.explained
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
        let (blocks, beyond) = (sum(|s| s.blocks.values), sum(|s| s.blocks.beyond));
        let allowed = (MAX_TURNED_SHARE * blocks as f64) as u64;
        let turned = beyond + sum(|s| s.explained);
        let unexplained = beyond.saturating_sub(allowed);
        VisibilityStatistics {
            pairs: sum(|s| s.links),
            facing: blocks,
            mismatched: turned,
            explained: turned - unexplained,
            unexplained,
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
    moved: MovedFaces,
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
                moved: MovedFaces::default(),
                diff: diff.clone(),
            }))
        }
    }

    /// Returns the radius of a node.
    fn node_radius(&self, node: usize) -> f32 {
        self.cpu.scene.tree.nodes[node].shooter.radius
    }

    /// Checks the stages at a request, compares what `find` finds on both sides by `parts` of each block, in the statistics that
    /// `kind` chooses, and returns the CPU's; `sizes` returns those of the groups of a block's values, from nodes and sizes of its links. The GPU is not asked once it is refused.
    ///
    /// Errors: those of `find`; the device fails.
    fn compare_results<T>(
        &self,
        request: &LinkRequest,
        kind: fn(&mut LinkDiff) -> &mut BlockStatistics,
        find: impl Fn(&dyn Linker, &LinkRequest) -> Result<Vec<T>>,
        parts: impl Fn(usize, &T) -> BlockParts,
        sizes: impl Fn(&[(usize, f32)]) -> Vec<f32>,
    ) -> Result<Vec<T>> {
        let mut checked = std::mem::take(&mut self.diff.borrow_mut().stages);
        let mut found = None;
        if checked.refusal.is_none() {
            let mut stages = self.stages.borrow_mut();
            let ended = stages.check_request(&self.cpu.scene, request);
            checked = stages.checked_stages()?;
            ended.or_else(|error| checked.take_refusal(error))?;
        }
        if checked.refusal.is_none() {
            match find(&self.gpu, request) {
                Ok(links) => found = Some(links),
                Err(error) => checked.take_refusal(error)?,
            }
        }
        self.diff.borrow_mut().stages = checked;
        let expected = find(&self.cpu, request)?;
        if let Some(found) = found {
            let all = |blocks: &[T]| -> Vec<BlockParts> {
                let parts = blocks.iter().enumerate().map(|(k, block)| parts(k, block));
                parts.collect()
            };
            let judge = |k: usize, [found, expected]: [&BlockParts; 2]| {
                let task = BlockTask::of_block(&self.cpu.scene, request, k);
                let sizes = sizes(&task.link_sizes()?);
                let error = |of: &BlockParts| of.compare(expected, &sizes).0;
                let mut turned = 0.0;
                if error(found) > MAX_BLOCK_ROUNDINGS {
                    task.find_moved(&self.moved, &find, |block| turned += error(&parts(k, block)))?;
                }
                Ok([error(found), turned])
            };
            let mut diff = self.diff.borrow_mut();
            kind(&mut diff).count_blocks([&all(&found), &all(&expected)], judge)?;
        }
        Ok(expected)
    }
}

impl Linker for LinkerPair<'_> {
    fn gather_irradiance(&self, request: &LinkRequest, watch: ProgressCallback) -> Result<Vec<BlockIrradiance>> {
        let watch = RefCell::new(watch);
        let find =
            |linker: &dyn Linker, request: &LinkRequest| linker.gather_irradiance(request, &mut **watch.borrow_mut());
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
        let sizes = |links: &[(usize, f32)]| {
            let light = links.iter().map(|(node, size)| {
                let (radiosity, radius) = (&request.radiosity[*node], self.node_radius(*node));
                let slopes = radiosity.slope.map(|slope| slope.abs().max_element() * radius);
                size * (radiosity.mean.abs().max_element() + slopes[0] + slopes[1])
            });
            vec![light.sum()]
        };
        self.compare_results(request, |diff| &mut diff.gathered, find, parts, sizes)
    }

    fn create_links(&self, request: &LinkRequest, watch: ProgressCallback) -> Result<Vec<Vec<StoredLink>>> {
        let watch = RefCell::new(watch);
        let find = |linker: &dyn Linker, request: &LinkRequest| linker.create_links(request, &mut **watch.borrow_mut());
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
        let sizes = |links: &[(usize, f32)]| {
            let most = |of: &dyn Fn(usize) -> f32| {
                let sizes = links.iter().map(|(node, size)| size * of(*node));
                sizes.fold(0.0f32, f32::max)
            };
            let along = most(&|node| self.node_radius(node));
            vec![most(&|_| 1.0), along, along]
        };
        self.compare_results(request, |diff| &mut diff.kept, find, parts, sizes)
    }
}

/// Returns the largest |a − b| relative to the largest |b|, or to `size` if that is larger.
fn relative_difference(a: &[f32], b: &[f32], size: f32) -> f64 {
    let largest = b.iter().fold(size, |largest, x| largest.max(x.abs()));
    let differences = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs());
    match differences.fold(0.0, larger_or_nan) {
        0.0 => 0.0,
        difference => difference / f64::from(largest),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a block of one value.
    fn block(value: f32) -> BlockParts {
        BlockParts {
            decisions: ("node", vec![7]),
            values: ("weight", vec![vec![value]]),
            links: 1,
        }
    }

    /// Counts ten blocks, of which the first `wrong` differ by about a thousand roundings and are judged so.
    fn count_ten_blocks(wrong: usize, judged: [f64; 2]) -> BlockStatistics {
        let expected: Vec<BlockParts> = (0..10).map(|_| block(1.0)).collect();
        let found: Vec<BlockParts> = (0..10).map(|k| block(if k < wrong { 1.0001 } else { 1.0 })).collect();
        let mut statistics = BlockStatistics::default();
        statistics.count_blocks([&found, &expected], |_, _| Ok(judged)).unwrap();
        statistics
    }

    #[test]
    fn blocks_that_rounding_explains_are_within_the_bound() {
        let within_sizes = count_ten_blocks(1, [100.0, 0.0]);
        assert_eq!((within_sizes.blocks.beyond, within_sizes.explained), (0, 0));
        let turned_by_moves = count_ten_blocks(1, [1000.0, 2000.0]);
        assert_eq!((turned_by_moves.blocks.beyond, turned_by_moves.explained), (0, 1));
        assert_eq!(turned_by_moves.turned_share(), 0.1);
        for judged in [[1000.0, 500.0], [f64::NAN, 2000.0], [1000.0, f64::NAN]] {
            let unexplained = count_ten_blocks(1, judged);
            assert_eq!((unexplained.blocks.beyond, unexplained.explained), (1, 0), "{judged:?}");
        }
        assert_eq!(count_ten_blocks(3, [0.0, 0.0]).blocks.beyond, 3);
    }

    #[test]
    fn missing_blocks_are_wrong() {
        let mut statistics = BlockStatistics::default();
        let expected = [block(1.0)];
        statistics
            .count_blocks([&[], &expected], |_, _| Ok([0.0, 0.0]))
            .unwrap();
        assert_eq!(statistics.blocks.beyond, 1);
    }
}
