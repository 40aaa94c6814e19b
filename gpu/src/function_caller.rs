//! Runs calls of single WGSL functions.

use crate::adapter::Gpu;
use crate::bindings::{BindingTable, STORAGE, UNIFORM};
use crate::compute_stage::PipelineMaker;
use crate::device_queue::DeviceQueue;
use crate::function_calls::{CallArguments, FunctionCall};
use crate::shaders::ShaderFault;
use common::constants::PATCH_SUM_LANES;
use common::settings::Transport;
use common::{Error, Result};
use glam::Vec4;

/// Bytes of a buffer that is bound and not read: more than a record.
const UNREAD_BYTES: u64 = 1024;

/// Calls functions of the solvers' shaders.
pub struct FunctionCaller {
    host: DeviceQueue,
    maker: PipelineMaker,
}

impl FunctionCaller {
    /// Creates a caller; `faults` are planted in the shaders.
    pub fn new(gpu: &Gpu, transport: &Transport, faults: &[ShaderFault]) -> Self {
        Self {
            host: DeviceQueue::new(gpu),
            maker: PipelineMaker::new(gpu, transport, faults),
        }
    }

    /// Calls a function with each of these arguments; awaits the results, NaN where none was written. None where a user's
    /// file has no such function, or one of other parameters.
    ///
    /// Errors: the device fails.
    pub async fn request_results(
        &mut self,
        call: &FunctionCall,
        arguments: &[CallArguments],
    ) -> Result<Option<Vec<Vec4>>> {
        let gpu = self.host.gpu.clone();
        // What `image_bound` and `closure` declare; the functions do not read it.
        let unread = [
            ("faces", UNREAD_BYTES, STORAGE),
            ("shots", UNREAD_BYTES, STORAGE),
            ("transfers", UNREAD_BYTES, STORAGE),
            ("escape_counts", UNREAD_BYTES, STORAGE),
            ("rows", UNREAD_BYTES, STORAGE),
            ("params", UNREAD_BYTES, UNIFORM),
        ];
        let mut table = BindingTable::zeroed(&gpu.device, unread);
        let unwritten = vec![Vec4::NAN; arguments.len()];
        table.add_filled(&gpu.device, "inputs", arguments, STORAGE);
        table.add_filled(&gpu.device, "results", &unwritten, STORAGE);
        let stage = match self.maker.make_call(call, &table) {
            Err(Error::Shader { .. }) => return Ok(None),
            made => made?,
        };
        let mut encoder = self.host.command_encoder();
        let groups = arguments.len().div_ceil(PATCH_SUM_LANES) as u32;
        stage.dispatch_groups(&mut encoder.begin_compute_pass(&Default::default()), [groups, 1, 1]);
        let results = &table["results"];
        let range = (results, 0, results.size());
        let clock = gpu.call_clock.clone();
        let ranges = [range];
        let work = self.host.request_values(encoder, &ranges);
        let found = clock.await_stage(call.files[0], work).await?;
        Ok(Some(found))
    }
}
