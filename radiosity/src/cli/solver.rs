//! `--solver`, and the GPU adapter.

use super::console::message;
use super::options::{Choice, CommonOptions};
use common::{Error, Result};
use gpu::{Gpu, list_adapters};

/// `--solver`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum SolverOption {
    /// The CPU.
    Cpu,
    /// The GPU.
    Gpu,
    /// The dense linear system.
    Dense,
}

/// Values of `--solver` in a solve to an error.
pub const SOLVERS: [Choice<SolverOption>; 3] = [
    ("cpu", "The CPU: links by rays", SolverOption::Cpu),
    ("gpu", "The GPU: links by rays", SolverOption::Gpu),
    (
        "dense",
        "The dense linear system of all texels, up to about 10 000 texels",
        SolverOption::Dense,
    ),
];

/// Values of `--solver` in a solve by shooting.
pub const SHOOTING_SOLVERS: [Choice<SolverOption>; 2] = [
    ("cpu", "Rays, or the scalar twin of the item buffer", SolverOption::Cpu),
    ("gpu", "Item buffer, or rays", SolverOption::Gpu),
];

/// Returns the solver given, or the GPU where this machine has a hardware adapter, else the CPU.
///
/// Errors: the solver is the CPU, and an option of the GPU is given.
pub fn choose_solver(asked: Option<SolverOption>, common: &CommonOptions) -> Result<SolverOption> {
    let gpu_option = common.gpu_option();
    let solver = match asked {
        Some(solver) => solver,
        // An adapter given by name is to be used, even a software one.
        None if gpu_option.is_some() || list_adapters().iter().any(|line| !line.software) => SolverOption::Gpu,
        None => SolverOption::Cpu,
    };
    match gpu_option {
        Some(option) if solver == SolverOption::Cpu => Err(Error::Usage(format!(
            "{option} contradicts --solver cpu: leave one of them out"
        ))),
        _ => Ok(solver),
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
