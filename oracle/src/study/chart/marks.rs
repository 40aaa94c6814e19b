//! What a point looks like: colour by who and how it sees, shape by form factor or iteration.

use super::Solver;
use super::methods::Method;
use common::form_factor::FormFactor;
use common::settings::{Iteration, Visibility};

/// A name in the legend and a CSS colour that is told apart on white and on black.
pub type Family = (&'static str, &'static str);

/// Solver and visibility.
pub fn family(method: &Method) -> Family {
    match (method.solver, method.settings.visibility) {
        (Solver::Matrix, _) => ("matrix", "#2c9650"),
        (Solver::Cpu, Visibility::Rays) => ("CPU, rays", "#2b7bba"),
        (Solver::Cpu, _) => ("CPU, item buffer", "#5fb3c4"),
        (Solver::Gpu, Visibility::Rays) => ("GPU, rays", "#cd3c3c"),
        (Solver::Gpu, Visibility::Stereographic) => ("GPU, stereographic", "#e07b00"),
        (Solver::Gpu, Visibility::Hemisphere) => ("GPU, hemisphere", "#c4a000"),
        (Solver::Gpu, Visibility::Hemicube) => ("GPU, hemicube", "#a05abe"),
        (Solver::Gpu, Visibility::Paper) => ("GPU, paper", "#9a6a4a"),
    }
}

/// Other programs.
pub const PEERS: Family = ("other programs", "#828282");

/// The families, in the legend's order.
pub const FAMILIES: [&str; 9] = [
    "CPU, rays",
    "CPU, item buffer",
    "GPU, rays",
    "GPU, stereographic",
    "GPU, hemisphere",
    "GPU, hemicube",
    "GPU, paper",
    "matrix",
    PEERS.0,
];

/// A mark's outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Polygons and conjugate gradients: the default.
    Circle,
    /// Disc form factors.
    Square,
    /// The paper's.
    Triangle,
    /// One cell after the other.
    Diamond,
    /// Another iteration.
    Down,
    /// Something that failed.
    Cross,
}

impl Shape {
    /// Those of points, in the legend's order.
    pub const ALL: [Self; 6] = [
        Self::Circle,
        Self::Square,
        Self::Triangle,
        Self::Diamond,
        Self::Down,
        Self::Cross,
    ];

    /// The form factor's, or the iteration's where that is the exact one.
    pub fn of(method: &Method) -> Self {
        match (method.settings.form_factor, method.settings.iteration) {
            _ if method.solver == Solver::Matrix => Self::Circle,
            (FormFactor::Disc, _) => Self::Square,
            (FormFactor::Paper, _) => Self::Triangle,
            (FormFactor::Polygon, Iteration::Cg) => Self::Circle,
            (FormFactor::Polygon, Iteration::Southwell) => Self::Diamond,
            (FormFactor::Polygon, _) => Self::Down,
        }
    }

    /// The same where the engine shot one cell after the other, whatever the iteration.
    pub fn of_single_shots(method: &Method) -> Self {
        match Self::of(method) {
            Self::Circle | Self::Down => Self::Diamond,
            other => other,
        }
    }

    /// In the legend.
    pub fn name(self) -> &'static str {
        match self {
            Self::Circle => "polygon, cg",
            Self::Square => "disc",
            Self::Triangle => "paper's factor",
            Self::Diamond => "southwell",
            Self::Down => "other iteration",
            Self::Cross => "failed: point at it",
        }
    }

    /// SVG path data about (x, y).
    pub fn path(self, (x, y): (f64, f64), r: f64) -> String {
        let polygon = |corners: &[(f64, f64)]| {
            let points: Vec<String> = corners
                .iter()
                .map(|(i, j)| format!("{:.1} {:.1}", x + i * r, y + j * r))
                .collect();
            format!("M{}Z", points.join("L"))
        };
        match self {
            Self::Circle => {
                let left = x - r;
                format!(
                    "M{left:.1} {y:.1}a{r} {r} 0 1 0 {0} 0a{r} {r} 0 1 0 -{0} 0Z",
                    2.0 * r
                )
            }
            Self::Square => polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
            Self::Triangle => polygon(&[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)]),
            Self::Diamond => polygon(&[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)]),
            Self::Down => polygon(&[(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8)]),
            Self::Cross => {
                let (s, l) = (0.3, 1.0);
                polygon(&[
                    (0.0, -s),
                    (l - s, -l),
                    (l, s - l),
                    (s, 0.0),
                    (l, l - s),
                    (l - s, l),
                    (0.0, s),
                    (s - l, l),
                    (-l, l - s),
                    (-s, 0.0),
                    (-l, s - l),
                    (s - l, -l),
                ])
            }
        }
    }
}
