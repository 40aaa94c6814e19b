//! Who solves: the one place where an engine is chosen.

use common::mesh::Mesh;
use common::passes::Engine;
use common::settings::{Transport, Visibility};
use common::{Error, Result};
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver};

/// One of four.
#[derive(Clone, Copy)]
pub enum Solver<'a> {
    /// Rays, or the twin of the item buffer.
    Cpu,
    /// Item buffer, or rays.
    Gpu(&'a Gpu),
    /// The dense linear system: it does not shoot.
    Matrix,
    /// The CPU, hierarchically, to that error: nor does it.
    Hierarchy(f64),
}

impl<'a> Solver<'a> {
    /// The GPU, if there is one.
    pub fn on(gpu: Option<&'a Gpu>) -> Self {
        gpu.map_or(Self::Cpu, Self::Gpu)
    }

    /// The GPU, if there is one, where an item buffer is drawn; the CPU where rays are asked.
    pub fn drawing(gpu: Option<&'a Gpu>, transport: &Transport) -> Self {
        Self::on(gpu.filter(|_| transport.visibility != Visibility::Rays))
    }

    /// In `result.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu | Self::Hierarchy(_) => "cpu",
            Self::Gpu(_) => "gpu",
            Self::Matrix => "matrix",
        }
    }

    /// Whether cells shoot.
    pub fn shoots(self) -> bool {
        matches!(self, Self::Cpu | Self::Gpu(_))
    }

    /// The error that is asked for.
    pub fn error(self) -> Option<f64> {
        match self {
            Self::Hierarchy(error) => Some(error),
            _ => None,
        }
    }

    /// The device.
    pub fn gpu(self) -> Option<&'a Gpu> {
        match self {
            Self::Gpu(gpu) => Some(gpu),
            Self::Cpu | Self::Matrix | Self::Hierarchy(_) => None,
        }
    }

    /// Its name.
    pub fn adapter(self) -> Option<&'a str> {
        self.gpu().map(|gpu| gpu.line.name.as_str())
    }

    /// What shoots on `mesh`.
    ///
    /// Errors: [`Error::Device`]; [`Error::Usage`] of those that do not shoot.
    pub fn engine<'m>(self, mesh: &'m Mesh, transport: &Transport) -> Result<Box<dyn Engine + 'm>>
    where
        'a: 'm,
    {
        Ok(match self {
            Self::Cpu => Box::new(CpuSolver::new(mesh, transport)),
            Self::Gpu(gpu) => Box::new(GpuSolver::new(gpu, mesh, transport)?),
            Self::Matrix | Self::Hierarchy(_) => {
                return Err(Error::Usage(format!("{} does not shoot", self.name())));
            }
        })
    }
}
