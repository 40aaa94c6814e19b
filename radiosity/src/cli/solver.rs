//! `--solver`, and the GPU adapter.

use super::console::message;
use super::options::CommonOptions;
use clap::ValueEnum;
use common::{Error, Result};
use gpu::{Gpu, list_adapters};

/// `--solver`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SolverOption {
    /// The CPU: links by rays; when shooting, rays or the twin of the item buffer
    Cpu,
    /// The GPU: links by rays; when shooting, the item buffer or rays
    Gpu,
    /// The dense linear system of all texels, up to about 10 000 texels
    #[value(alias = "matrix")]
    Dense,
}

/// Returns the solver given, or the GPU where this machine has a hardware adapter, else the CPU.
pub fn choose_solver(asked: Option<SolverOption>, common: &CommonOptions) -> Result<SolverOption> {
    let solver = match asked {
        Some(solver) => solver,
        // An adapter given by name is to be used, even a software one.
        None if common.require_gpu || common.adapter.is_some() || list_adapters().iter().any(|line| !line.software) => {
            SolverOption::Gpu
        }
        None => SolverOption::Cpu,
    };
    if solver == SolverOption::Cpu {
        common.refuse_gpu_options()?;
    }
    Ok(solver)
}

/// Returns the solver for `--error`.
///
/// Errors: an option contradicts it.
pub fn choose_solver_for_error(asked: Option<SolverOption>, common: &CommonOptions) -> Result<SolverOption> {
    match asked {
        None | Some(SolverOption::Cpu) => {
            common.refuse_gpu_options()?;
            Ok(SolverOption::Cpu)
        }
        Some(SolverOption::Gpu) => Ok(SolverOption::Gpu),
        Some(SolverOption::Dense) => Err(Error::Usage(
            "--solver dense solves as exactly as its texels allow: leave --error out".into(),
        )),
    }
}

/// Opens the adapter if the solver is the GPU. Without one the CPU solves, and the error returned is the
/// command's after its results are written.
pub fn open_gpu(solver: SolverOption, common: &CommonOptions) -> Result<(Option<Gpu>, Option<Error>)> {
    if solver != SolverOption::Gpu {
        return Ok((None, None));
    }
    match Gpu::open(common.adapter.as_deref()) {
        Ok(gpu) => Ok((Some(gpu), None)),
        Err(error @ Error::NoAdapter(_)) => {
            message!("note: {error}; solving on the CPU");
            Ok((None, Some(error)))
        }
        Err(error) => Err(error),
    }
}

/// Opens the adapter for a study of item buffers; without one the CPU's twin draws them.
pub fn open_gpu_or_twin(adapter: Option<&str>) -> Result<Option<Gpu>> {
    match Gpu::open(adapter) {
        Ok(gpu) => Ok(Some(gpu)),
        Err(error @ Error::NoAdapter(_)) if adapter.is_none() => {
            message!("note: {error}; the CPU's twin draws the item buffers");
            Ok(None)
        }
        Err(error) => Err(error),
    }
}
