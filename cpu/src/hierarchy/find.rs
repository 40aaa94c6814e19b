//! Who finds the links of a solve: one loop asks, and several ways answer.

use crate::hierarchy::block::Block;
use crate::hierarchy::coarse::Kept;
use crate::hierarchy::descent::Lit;
use crate::hierarchy::gather::{Gather, Made};
use crate::hierarchy::question::Question;
use crate::hierarchy::world::{Watch, World};
use crate::rows::receivers::LANES;
use common::{Error, Result};
use rayon::prelude::*;

/// Tasks between two looks at whether to go on.
const TASKS: usize = 256;

/// Finds links.
pub trait Finder {
    /// What arrives at each block's lanes.
    ///
    /// Errors: [`Error::Interrupted`]; of a device.
    fn gathered(&self, question: &Question, watch: Watch) -> Result<Vec<Lit>>;

    /// Each block's links themselves.
    ///
    /// Errors: [`Error::Interrupted`]; of a device.
    fn kept(&self, question: &Question, watch: Watch) -> Result<Vec<Vec<Kept>>>;
}

/// Makes a finder for a scene whose tree is there.
pub type Maker<'m> = &'m dyn for<'w> Fn(&World<'w>) -> Result<Box<dyn Finder + 'w>>;

/// By what links are found.
#[derive(Clone, Copy)]
pub enum Way<'m> {
    /// Shafts where they pay; faces cluster.
    Shafts,
    /// Rays alone, face by face, level by level: what a GPU does.
    Rays,
    /// Somebody else.
    By(Maker<'m>),
}

impl Way<'_> {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shafts => "shafts",
            Self::Rays => "rays",
            Self::By(_) => "a device",
        }
    }
}

/// The CPU.
pub struct OnCpu<'a> {
    /// The scene.
    pub world: World<'a>,
    /// Whether rays alone are asked.
    pub rays: bool,
}

impl Finder for OnCpu<'_> {
    fn gathered(&self, question: &Question, watch: Watch) -> Result<Vec<Lit>> {
        self.tasks(question, watch, |blocks| {
            let dark = Lit {
                sums: [[0.0; LANES]; 3],
                edge: false,
            };
            let mut lit = vec![dark; blocks.len()];
            self.links(question, blocks, |made| {
                let own = &mut lit[made.block];
                let glow = &question.glow[made.node as usize];
                made.link.add(glow, &mut own.sums);
                own.edge |= made.edge;
            });
            lit
        })
    }

    fn kept(&self, question: &Question, watch: Watch) -> Result<Vec<Vec<Kept>>> {
        self.tasks(question, watch, |blocks| {
            let mut kept: Vec<Vec<Kept>> = blocks.iter().map(|_| Vec::new()).collect();
            self.links(question, blocks, |made| {
                kept[made.block].push(Kept {
                    node: made.node,
                    link: made.link.clone(),
                });
            });
            kept
        })
    }
}

impl OnCpu<'_> {
    fn links(&self, question: &Question, blocks: &[Block], take: impl FnMut(Made)) {
        let gather = Gather::new(&self.world, question, blocks);
        match self.rays {
            true => gather.by_rays(take),
            false => gather.links(take),
        }
    }

    /// `task` of all blocks, in order.
    fn tasks<T: Send>(
        &self,
        question: &Question,
        watch: Watch,
        task: impl Fn(&[Block]) -> Vec<T> + Sync,
    ) -> Result<Vec<T>> {
        let (receivers, part) = (question.receivers, &question.part);
        let mut all = Vec::with_capacity(receivers.blocks.len());
        for some in receivers.tasks.chunks(TASKS) {
            let share = all.len() as f64 / receivers.blocks.len() as f64;
            if watch(part.start + share * (part.end - part.start)).is_break() {
                return Err(Error::Interrupted);
            }
            let parts = some
                .par_iter()
                .map(|blocks| task(&receivers.blocks[blocks.clone()]));
            all.extend(parts.collect::<Vec<_>>().into_iter().flatten());
        }
        Ok(all)
    }
}
