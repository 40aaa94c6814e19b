//! Runs the stages of links between nodes one at a time, each on input from the host, so that an error of one does not
//! reach the next.

use crate::adapter::Gpu;
use crate::bindings::{BindingTable, STORAGE};
use crate::compute_stage::PipelineMaker;
use crate::device_queue::DeviceQueue;
use crate::hierarchy::link_buffers::LinkBuffers;
use crate::link_records::PairRecord;
use crate::records::ShotRecord;
use crate::shaders::ShaderFault;
use bytemuck::{Pod, cast_slice, pod_collect_to_vec};
use common::mesh::Mesh;
use common::settings::Transport;
use common::{Error, Result};

/// Most pairs of a level that is probed.
pub const MAX_PROBED_PAIRS: usize = 1 << 10;
/// Words of a work list of so many pairs: two numbers, and the pairs.
pub const WORK_WORDS: usize = MAX_PROBED_PAIRS + 2;

/// Value of the words that a stage has not written; as a float it is NaN.
pub const UNWRITTEN: u32 = u32::MAX;

/// The stages, with buffers of their own.
pub struct LinkProbe {
    host: DeviceQueue,
    maker: PipelineMaker,
    /// `work`, `dispatches` and `next` are each one buffer, whichever the solve would bind.
    table: BindingTable,
}

impl LinkProbe {
    /// Creates a probe for the `nodes` over the faces of `mesh`; `faults` are planted in its shaders.
    ///
    /// Errors: [`Error::Device`] where the nodes do not fit.
    pub fn new(gpu: &Gpu, mesh: &Mesh, nodes: &[ShotRecord], faults: &[ShaderFault]) -> Result<Self> {
        let buffers = LinkBuffers::new(gpu, mesh, nodes)?;
        let own = [
            ("work", 4 * WORK_WORDS as u64, STORAGE),
            ("dispatches", 32, STORAGE),
            ("next", (MAX_PROBED_PAIRS * size_of::<PairRecord>()) as u64, STORAGE),
        ];
        let level = buffers.table.joined_with(&buffers.levels[0]);
        gpu.check_errors()?;
        Ok(Self {
            host: DeviceQueue::new(gpu),
            maker: PipelineMaker::new(gpu, &Transport::default(), faults),
            table: level.joined_with(&BindingTable::zeroed(&gpu.device, own)),
        })
    }

    /// Writes the beginnings of the buffers of these names, runs entry point `entry` of the shader `file` in so many
    /// workgroups at least, and returns the first words of the buffers `made`, which are [`UNWRITTEN`] before unless they are given.
    ///
    /// Errors: [`Error::Device`]; of a user's file that cannot be run.
    pub fn run_stage(
        &mut self,
        [file, entry]: [&'static str; 2],
        groups: usize,
        given: &[(&str, &[u32])],
        made: &[(&str, usize)],
    ) -> Result<Vec<Vec<u32>>> {
        for (name, words) in made {
            self.write_words(name, &vec![UNWRITTEN; *words])?;
        }
        for (name, words) in given {
            self.write_words(name, words)?;
        }
        let stage = self.maker.make_stage(file, entry, &self.table)?;
        let mut encoder = self.host.command_encoder();
        // In two rows, as a dispatch of many workgroups is split; there may be one more.
        let groups = [groups.div_ceil(2) as u32, groups.min(2) as u32, 1];
        stage.dispatch_groups(&mut encoder.begin_compute_pass(&Default::default()), groups);
        let ranges: Vec<_> = (made.iter())
            .map(|(name, words)| (&self.table[name], 0, 4 * *words as u64))
            .collect();
        let clock = self.host.gpu.call_clock.clone();
        let work = self.host.request_values(encoder, &ranges);
        let mut words: Vec<u32> = pollster::block_on(clock.await_stage(file, work))?;
        let split = made.iter().map(|(_, count)| {
            let rest = words.split_off(*count);
            std::mem::replace(&mut words, rest)
        });
        Ok(split.collect())
    }

    /// Returns the number of words that a buffer holds.
    pub fn buffer_words(&self, name: &str) -> usize {
        self.table[name].size() as usize / 4
    }

    fn write_words(&self, name: &str, words: &[u32]) -> Result<()> {
        let buffer = &self.table[name];
        if 4 * words.len() as u64 > buffer.size() {
            return Err(Error::Device(format!("{name} does not hold {} words", words.len())));
        }
        self.host.write(buffer, words);
        Ok(())
    }
}

/// Returns the words of records.
pub fn as_words<T: Pod>(records: &[T]) -> &[u32] {
    cast_slice(records)
}

/// Returns the records that words make up.
pub fn from_words<T: Pod>(words: &[u32]) -> Vec<T> {
    pod_collect_to_vec(words)
}
