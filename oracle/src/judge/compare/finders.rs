//! Links found on the GPU against those that the CPU finds by rays, asked the same questions.
//!
//! On an adapter without fused multiply-add all bits are the same. Elsewhere a form factor, or a sum, may
//! differ by its roundings; and where what is compared with a threshold lies that near it, one side may cut
//! a node that the other takes whole, or a ray may pass an edge that the other meets.

use crate::judge::comparison::{Pairs, Stage};
use crate::solve::finder::OnGpu;
use common::Result;
use cpu::hierarchy::coarse::Kept;
use cpu::hierarchy::descent::Lit;
use cpu::hierarchy::find::{Finder, OnCpu};
use cpu::hierarchy::question::Question;
use cpu::hierarchy::world::{Watch, World};
use gpu::{Fault, Gpu};
use std::cell::RefCell;
use std::rc::Rc;

/// What rounding leaves of a block's sums and weights, as a share of its largest: those of a polygon's form
/// factor and of its moments, of a sum over its links, and the weaker divisions and roots of WGSL, in units
/// of 2⁻²⁴.
const ROUNDED: f64 = 384.0;
/// Blocks that rounding may turn: each makes some thousand comparisons with a threshold or an edge, and
/// what is compared is within [`ROUNDED`] of it in one of 40 000.
const TURNED: f64 = 0.05;

/// What was found about one question that both were asked.
#[derive(Clone, Copy, Debug, Default)]
pub struct Share {
    /// Blocks.
    pub blocks: u64,
    /// Blocks of which any bit differs.
    pub differing: u64,
    /// Blocks that differ by more than rounding.
    pub turned: u64,
    /// Light that arrives, or links that are kept.
    pub found: u64,
}

impl Share {
    /// Blocks of which there is no answer are wrong.
    fn missing(&mut self, found: usize, expected: usize) {
        let missing = expected.abs_diff(found) as u64;
        self.blocks += missing;
        self.differing += missing;
        self.turned += missing;
    }

    fn add(&mut self, exact: bool, off: f64, found: usize) {
        self.blocks += 1;
        self.differing += u64::from(!exact);
        // A NaN is no rounding.
        let rounded = off <= ROUNDED * f64::from(f32::EPSILON) / 2.0;
        self.turned += u64::from(!exact && !rounded);
        self.found += found as u64;
    }

    /// Blocks that differ by more than rounding, of all.
    pub fn of_all(&self) -> f64 {
        self.turned as f64 / self.blocks as f64
    }

    fn stage(&self, name: &str, what: &str) -> Stage {
        let worst = self.of_all();
        Stage {
            name: name.into(),
            values: self.found,
            differing: self.differing,
            worst,
            bound: TURNED,
            reason: format!(
                "blocks, of {}, {what} by more than rounding: a comparison that it decides may turn",
                self.blocks
            ),
            agree: self.found > 0 && worst <= TURNED,
        }
    }
}

/// Of a solve in which both were asked.
#[derive(Clone, Copy, Debug, Default)]
pub struct Found {
    /// What arrives at blocks.
    pub gathered: Share,
    /// Links themselves.
    pub kept: Share,
}

impl Found {
    /// One for each question.
    pub fn stages(&self) -> Vec<Stage> {
        vec![
            self.gathered.stage("gathered", "at which light differs"),
            self.kept.stage("kept", "whose links differ"),
        ]
    }

    /// Blocks in the place of pairs of points.
    pub fn pairs(&self) -> Pairs {
        let shares = [self.gathered, self.kept];
        let sum = |of: fn(&Share) -> u64| shares.iter().map(of).sum::<u64>();
        let (blocks, turned) = (sum(|s| s.blocks), sum(|s| s.turned));
        let may = (TURNED * blocks as f64) as u64;
        Pairs {
            pairs: sum(|s| s.found),
            facing: blocks,
            mismatched: turned,
            explained: turned.min(may),
            unexplained: turned.saturating_sub(may),
            explainable: may,
            weighted_mismatch: turned as f64 / blocks as f64,
            weighted_explainable: TURNED,
            ..Pairs::default()
        }
    }

    /// Blocks that differ by more than rounding, of all.
    pub fn turned(&self) -> f64 {
        self.gathered.of_all().max(self.kept.of_all())
    }
}

/// Asks both, and goes on with what the CPU says: what one question turns does not reach the next.
pub struct Both<'w> {
    cpu: OnCpu<'w>,
    gpu: OnGpu,
    found: Rc<RefCell<Found>>,
}

impl Both<'_> {
    /// Makes it, and counts in `found`; shaders are wrong where `faults` say so.
    pub fn maker<'m>(
        gpu: &'m Gpu,
        faults: &'m [Fault],
        found: &'m Rc<RefCell<Found>>,
    ) -> impl for<'w> Fn(&World<'w>) -> Result<Box<dyn Finder + 'w>> + 'm {
        move |world| {
            Ok(Box::new(Both {
                cpu: OnCpu {
                    world: *world,
                    rays: true,
                },
                gpu: OnGpu::new(gpu, world, faults)?,
                found: found.clone(),
            }))
        }
    }
}

impl Finder for Both<'_> {
    fn gathered(&self, question: &Question, watch: Watch) -> Result<Vec<Lit>> {
        let found = self.gpu.gathered(question, watch)?;
        let expected = self.cpu.gathered(question, watch)?;
        let share = &mut self.found.borrow_mut().gathered;
        share.missing(found.len(), expected.len());
        let pairs = found.iter().zip(&expected);
        for ((found, expected), block) in pairs.zip(&question.receivers.blocks) {
            // Spots that there are not receive what nobody asks for.
            let own = |lit: &Lit| lit.sums.map(|lane| lane[..block.count].to_vec()).concat();
            let (found, expected) = ((own(found), found.edge), (own(expected), expected.edge));
            let light = expected.0.iter().filter(|h| **h > 0.0).count();
            share.add(
                found.1 == expected.1 && alike(&found.0, &expected.0),
                off(&found.0, &expected.0) + f64::from(u8::from(found.1 != expected.1)),
                light,
            );
        }
        Ok(expected)
    }

    fn kept(&self, question: &Question, watch: Watch) -> Result<Vec<Vec<Kept>>> {
        let found = self.gpu.kept(question, watch)?;
        let expected = self.cpu.kept(question, watch)?;
        let share = &mut self.found.borrow_mut().kept;
        share.missing(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            let nodes = |links: &[Kept]| links.iter().map(|kept| kept.node).collect::<Vec<_>>();
            let [a, b] = [found, expected].map(|links| parts(links));
            let same = nodes(found) == nodes(expected);
            let off = (0..3).map(|k| off(&a[k], &b[k])).fold(0.0, f64::max);
            let exact = (0..3).all(|k| alike(&a[k], &b[k]));
            let off = if same { off } else { f64::INFINITY };
            share.add(same && exact, off, expected.len());
        }
        Ok(expected)
    }
}

/// Weights, and what they are along a node's two axes.
fn parts(links: &[Kept]) -> [Vec<f32>; 3] {
    let all = |of: &dyn Fn(&Kept) -> Vec<f32>| links.iter().flat_map(of).collect();
    [
        all(&|kept| kept.link.weight.to_vec()),
        all(&|kept| kept.link.along[0].to_vec()),
        all(&|kept| kept.link.along[1].to_vec()),
    ]
}

fn alike(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

/// How far a is from b, of the largest of b.
fn off(a: &[f32], b: &[f32]) -> f64 {
    let largest = b.iter().fold(0.0f32, |most, x| most.max(x.abs()));
    let pairs = a.iter().zip(b);
    let off = pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs());
    // A NaN must stay: f64::max would drop it.
    let off = off.fold(0.0, |most: f64, x| if x <= most { most } else { x });
    if off == 0.0 {
        0.0
    } else {
        off / f64::from(largest)
    }
}
