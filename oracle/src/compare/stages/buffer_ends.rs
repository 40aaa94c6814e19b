//! Checks that stages write nothing behind the ends of their buffers.

use super::Tallies;
use crate::compare::statistics::{ErrorTally, ValueSource};
use common::Result;
use gpu::GpuSolver;
use gpu::buffer_ends::{END_MARK, MarkedBuffer};
use stage_check::tally::Value;

/// Components of a vector in a buffer.
const VECTOR: usize = 4;

/// Marks the ends of buffers.
pub fn mark_ends(solver: &GpuSolver, buffers: &[MarkedBuffer]) {
    for which in buffers {
        solver.mark_end(*which);
    }
}

/// Checks that the marks are still there, each by the tally of the stage that writes the buffer.
///
/// Errors: the device fails.
pub async fn check_ends(solver: &mut GpuSolver<'_>, buffers: &[MarkedBuffer], tallies: &mut Tallies) -> Result<()> {
    let mesh = solver.mesh();
    let is_pass = buffers.contains(&MarkedBuffer::Flux);
    for which in buffers {
        let texel_tally = if is_pass {
            &mut tallies.collect
        } else {
            &mut tallies.deposit
        };
        // First and last component of the buffer's values in the tally.
        let (tally, [first, last], components): (&mut ErrorTally, _, _) = match which {
            MarkedBuffer::Radiosity => (texel_tally, [0, 2], VECTOR),
            MarkedBuffer::Residual => (texel_tally, [3, 5], VECTOR),
            MarkedBuffer::Irradiance => (texel_tally, [6, 9], VECTOR),
            MarkedBuffer::PatchPower => (&mut tallies.power, [0, 3], VECTOR),
            MarkedBuffer::Transfers => (&mut tallies.received, [0, 0], 1),
            MarkedBuffer::Flux => (&mut tallies.exchange, [0, 2], VECTOR),
        };
        let end = match which {
            MarkedBuffer::Radiosity | MarkedBuffer::Residual | MarkedBuffer::Irradiance => mesh.texels.len(),
            MarkedBuffer::PatchPower | MarkedBuffer::Transfers | MarkedBuffer::Flux => mesh.patches.len(),
        };
        for (k, word) in solver.request_end(*which).await?.into_iter().enumerate() {
            let place = [end + k / components, (first + k % components).min(last)];
            let found = if word == END_MARK {
                Value::Unwritten
            } else {
                Value::Float(f32::from_bits(word))
            };
            let wrong = if word == END_MARK { 0.0 } else { f64::INFINITY };
            tally.add(ValueSource::default(), place, [found, Value::Unwritten], wrong);
        }
    }
    Ok(())
}
