//! Who solves, and the adapter that it needs.

use super::options::Common;
use super::tell::say;
use clap::ValueEnum;
use common::{Error, Result};
use gpu::{Gpu, adapters};

/// `--solver`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SolverOption {
    /// Rays, or the scalar twin of the item buffer
    Cpu,
    /// Item buffer
    Gpu,
    /// The dense linear system over all texels, up to about 10 000 of them
    Matrix,
}

/// The solver asked for, or the one that this machine is best at.
pub fn choose(asked: Option<SolverOption>, common: &Common) -> Result<SolverOption> {
    let solver = match asked {
        Some(solver) => solver,
        // An adapter that is named is wanted.
        None if common.require_gpu
            || common.adapter.is_some()
            || adapters().iter().any(|line| !line.software) =>
        {
            SolverOption::Gpu
        }
        None => SolverOption::Cpu,
    };
    if solver == SolverOption::Cpu {
        common.not_for_cpu()?;
    }
    Ok(solver)
}

/// The GPU where it is the solver. Without an adapter the CPU does what it can, and the error says
/// in the end that it was not asked.
pub fn open(solver: SolverOption, common: &Common) -> Result<(Option<Gpu>, Option<Error>)> {
    if solver != SolverOption::Gpu {
        return Ok((None, None));
    }
    match Gpu::open(common.adapter.as_deref()) {
        Ok(gpu) => Ok((Some(gpu), None)),
        Err(error @ Error::NoAdapter(_)) => {
            say!("note: {error}; solving on the CPU");
            Ok((None, Some(error)))
        }
        Err(error) => Err(error),
    }
}

/// The GPU for a study of item buffers, which the CPU's twin can draw as well.
pub fn open_or_twin(adapter: Option<&str>) -> Result<Option<Gpu>> {
    match Gpu::open(adapter) {
        Ok(gpu) => Ok(Some(gpu)),
        Err(error @ Error::NoAdapter(_)) if adapter.is_none() => {
            say!("note: {error}; the CPU's twin draws the item buffers");
            Ok(None)
        }
        Err(error) => Err(error),
    }
}
