//! Who solves: the one place where an engine is chosen.

use common::mesh::Mesh;
use common::passes::Engine;
use common::settings::{Transport, Visibility};
use common::{Error, Result};
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver};

/// What is asked of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// A share.
    pub error: f64,
    /// Texels a side of each face; none: they follow from the light.
    pub texels: Option<u32>,
}

/// The errors of three qualities: of a first look, of an answer of which nothing is asked, and of one that
/// others are judged by.
pub const DRAFT: f64 = 0.05;
/// See [`DRAFT`].
pub const USUAL: f64 = 0.01;
/// See [`DRAFT`].
pub const REFERENCE: f64 = 0.003;

/// Errors that can be asked for.
pub const LEAST: f64 = 0.002;
/// See [`LEAST`].
pub const MOST: f64 = 0.1;

/// Who solves.
#[derive(Clone, Copy)]
pub enum Solver<'a> {
    /// Rays, or the twin of the item buffer.
    Cpu,
    /// Item buffer, or rays.
    Gpu(&'a Gpu),
    /// The dense linear system: it does not shoot.
    Matrix,
    /// The CPU, hierarchically, to an error: nor does it.
    Hierarchy(Asked),
    /// The same with links that the GPU finds.
    Linking(&'a Gpu, Asked),
}

impl<'a> Solver<'a> {
    /// The GPU, if there is one.
    pub fn on(gpu: Option<&'a Gpu>) -> Self {
        gpu.map_or(Self::Cpu, Self::Gpu)
    }

    /// To an error, with links that the GPU finds, if there is one.
    pub fn to_error(gpu: Option<&'a Gpu>, asked: Asked) -> Self {
        gpu.map_or(Self::Hierarchy(asked), |gpu| Self::Linking(gpu, asked))
    }

    /// The GPU, if there is one, where an item buffer is drawn; the CPU where rays are asked.
    pub fn drawing(gpu: Option<&'a Gpu>, transport: &Transport) -> Self {
        Self::on(gpu.filter(|_| transport.visibility != Visibility::Rays))
    }

    /// In `result.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu | Self::Hierarchy(_) => "cpu",
            Self::Gpu(_) | Self::Linking(..) => "gpu",
            Self::Matrix => "matrix",
        }
    }

    /// Whether cells shoot.
    pub fn shoots(self) -> bool {
        matches!(self, Self::Cpu | Self::Gpu(_))
    }

    /// What is asked of the answer.
    pub fn asked(self) -> Option<Asked> {
        match self {
            Self::Hierarchy(asked) | Self::Linking(_, asked) => Some(asked),
            _ => None,
        }
    }

    /// The device.
    pub fn gpu(self) -> Option<&'a Gpu> {
        match self {
            Self::Gpu(gpu) | Self::Linking(gpu, _) => Some(gpu),
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
            Self::Matrix | Self::Hierarchy(_) | Self::Linking(..) => {
                return Err(Error::Usage(format!("{} does not shoot", self.name())));
            }
        })
    }
}
