//! The choice of a solver; the only place where an engine is created.

use common::mesh::Mesh;
use common::passes::Engine;
use common::settings::{Settings, Transport, Visibility};
use common::{Error, Result};
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver};
use serde::Serialize;
use std::ops::RangeInclusive;

/// Kind of a solver, before its device is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SolverKind {
    /// CPU: rays, or the twin of the item buffer.
    Cpu,
    /// GPU: item buffer or rays.
    Gpu,
    /// Dense linear system.
    Dense,
}

impl SolverKind {
    /// Returns the name on pages.
    pub fn name(self) -> &'static str {
        ["CPU", "GPU", "dense"][self as usize]
    }
}

/// A requested error and the texels on which it holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorTarget {
    /// Relative RMS error.
    pub error: f64,
    /// Texels per side of each face; `None`: they follow from the light.
    pub texels: Option<u32>,
}

/// Requested error at draft quality.
pub const DRAFT_ERROR: f64 = 0.05;
/// Requested error by default.
pub const DEFAULT_ERROR: f64 = 0.01;
/// Requested error at reference quality, to which other results are compared.
pub const REFERENCE_ERROR: f64 = 0.003;

/// Smallest error that can be requested.
pub const MIN_ERROR: f64 = 0.002;
/// Largest error that can be requested.
pub const MAX_ERROR: f64 = 0.1;

/// Errors to which a solve comes to an end.
const SOLVABLE_ERRORS: RangeInclusive<f64> = 1e-4..=1.0;

/// A solver with its device and its error target.
#[derive(Clone, Copy)]
pub enum SolverChoice<'a> {
    /// Shooting on the CPU, with rays or the twin of the item buffer.
    Cpu,
    /// Shooting on the GPU, with an item buffer or rays.
    Gpu(&'a Gpu),
    /// The dense linear system, without shooting.
    Dense,
    /// Hierarchical radiosity on the CPU to an error, without shooting.
    Hierarchy(ErrorTarget),
    /// Hierarchical radiosity with links found on the GPU.
    GpuHierarchy(&'a Gpu, ErrorTarget),
}

impl<'a> SolverChoice<'a> {
    /// Chooses shooting on the GPU if there is one, else on the CPU.
    pub fn shooting_on(gpu: Option<&'a Gpu>) -> Self {
        gpu.map_or(Self::Cpu, Self::Gpu)
    }

    /// Chooses hierarchical radiosity, with links found on the GPU if there is one.
    pub fn to_error(gpu: Option<&'a Gpu>, target: ErrorTarget) -> Self {
        gpu.map_or(Self::Hierarchy(target), |gpu| Self::GpuHierarchy(gpu, target))
    }

    /// Chooses shooting on the GPU, if there is one, for an item buffer; on the CPU for rays.
    pub fn for_transport(gpu: Option<&'a Gpu>, transport: &Transport) -> Self {
        Self::shooting_on(gpu.filter(|_| transport.visibility != Visibility::Rays))
    }

    /// Name of the solver in `result.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu | Self::Hierarchy(_) => "cpu",
            Self::Gpu(_) | Self::GpuHierarchy(..) => "gpu",
            Self::Dense => "dense",
        }
    }

    /// Checks that the solver comes to an end with these settings.
    ///
    /// Errors: [`Error::Usage`] of an error target that cannot be reached; of an item buffer without pixels.
    pub fn check_settings(self, settings: &Settings) -> Result<()> {
        let drawing = settings.transport.visibility.item_buffer();
        if self.is_shooting() && drawing.is_some_and(|drawing| drawing.size == 0) {
            return Err(Error::Usage("an item buffer needs at least one pixel".into()));
        }
        match self.error_target() {
            Some(target) if !SOLVABLE_ERRORS.contains(&target.error) => Err(Error::Usage(format!(
                "an error of {} cannot be requested: it must be within {:e} to {}",
                target.error,
                SOLVABLE_ERRORS.start(),
                SOLVABLE_ERRORS.end()
            ))),
            _ => Ok(()),
        }
    }

    /// True for the solvers that shoot.
    pub fn is_shooting(self) -> bool {
        matches!(self, Self::Cpu | Self::Gpu(_))
    }

    /// Error target of a hierarchical solver.
    pub fn error_target(self) -> Option<ErrorTarget> {
        match self {
            Self::Hierarchy(target) | Self::GpuHierarchy(_, target) => Some(target),
            _ => None,
        }
    }

    /// GPU of the solver, if it uses one.
    pub fn gpu(self) -> Option<&'a Gpu> {
        match self {
            Self::Gpu(gpu) | Self::GpuHierarchy(gpu, _) => Some(gpu),
            Self::Cpu | Self::Dense | Self::Hierarchy(_) => None,
        }
    }

    /// Name of the GPU.
    pub fn adapter_name(self) -> Option<&'a str> {
        self.gpu().map(|gpu| gpu.line.name.as_str())
    }

    /// Creates the engine that shoots on `mesh`.
    ///
    /// Errors: [`Error::Device`]; [`Error::Usage`] for solvers that do not shoot.
    pub fn create_engine<'m>(self, mesh: &'m Mesh, transport: &Transport) -> Result<Box<dyn Engine + 'm>>
    where
        'a: 'm,
    {
        Ok(match self {
            Self::Cpu => Box::new(CpuSolver::new(mesh, transport)),
            Self::Gpu(gpu) => Box::new(GpuSolver::new(gpu, mesh, transport)?),
            Self::Dense | Self::Hierarchy(_) | Self::GpuHierarchy(..) => {
                return Err(Error::Usage(format!("{} does not shoot", self.name())));
            }
        })
    }
}
