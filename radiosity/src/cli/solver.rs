//! `--solver`, and the GPU adapter.

use super::console::message;
use super::options::{Choice, CommonOptions};
use common::{Error, Result};
use gpu::{Gpu, list_adapters};
use oracle::solve::solver::SolverKind;

/// Values of `--solver` in a solve to an error.
pub const SOLVERS: [Choice<SolverKind>; 3] = [
    ("cpu", "The CPU: links by rays", SolverKind::Cpu),
    ("gpu", "The GPU: links by rays", SolverKind::Gpu),
    (
        "dense",
        "The dense linear system of all texels, up to about 10 000 texels",
        SolverKind::Dense,
    ),
];

/// Values of `--solver` in a solve by shooting.
pub const SHOOTING_SOLVERS: [Choice<SolverKind>; 2] = [
    ("cpu", "Rays, or the scalar twin of the item buffer", SolverKind::Cpu),
    ("gpu", "Item buffer, or rays", SolverKind::Gpu),
];

/// Returns the solver given, or the GPU where this machine has a hardware adapter, else the CPU.
///
/// Errors: an option of the GPU is given with another solver.
pub fn choose_solver(asked: Option<SolverKind>, common: &CommonOptions) -> Result<SolverKind> {
    let gpu_option = common.gpu_option();
    let solver = match asked {
        Some(solver) => solver,
        // An adapter given by name is to be used, even a software one.
        None if gpu_option.is_some() || list_adapters().iter().any(|line| !line.software) => SolverKind::Gpu,
        None => SolverKind::Cpu,
    };
    match gpu_option {
        Some(option) if solver != SolverKind::Gpu => Err(Error::Usage(format!(
            "{option} contradicts --solver {}: leave one of them out",
            solver.name().to_lowercase()
        ))),
        _ => Ok(solver),
    }
}

/// Opens the adapter if the solver is the GPU. Without one the CPU solves, and the error returned is the
/// command's after its results are written.
pub fn open_gpu(solver: SolverKind, common: &CommonOptions) -> Result<(Option<Gpu>, Option<Error>)> {
    if solver != SolverKind::Gpu {
        return Ok((None, None));
    }
    open_adapter(common.adapter.as_deref(), "solving on the CPU")
}

/// Opens an adapter; without one prints what is done `instead`, and returns the error.
pub fn open_adapter(name: Option<&str>, instead: &str) -> Result<(Option<Gpu>, Option<Error>)> {
    match Gpu::open(name) {
        Ok(gpu) => Ok((Some(gpu), None)),
        Err(error @ Error::NoAdapter(_)) => {
            message!("note: {error}; {instead}");
            Ok((None, Some(error)))
        }
        Err(error) => Err(error),
    }
}
