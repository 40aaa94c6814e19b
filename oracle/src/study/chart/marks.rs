//! What a point looks like: colour by who and how it sees, shape by form factor or iteration.

use super::Solver;
use super::methods::Method;
use super::study::Point;
use crate::show::chart::Shape;
use common::form_factor::FormFactor;
use common::settings::{Iteration, Projection};

/// A name in the legend and a CSS colour that is told apart on white and on black.
pub type Family = (&'static str, &'static str);

/// Other programs.
pub const PEERS: Family = ("other programs", "#828282");

/// What the others are judged by, on fewer texels: outlined, no series of its own.
pub const MATRIX: Family = ("matrix, fewer texels", "currentColor");

/// The families, in the legend's order.
pub const FAMILIES: [Family; 11] = [
    ("CPU, rays", "#2b7bba"),
    ("CPU, item buffer", "#19a3a8"),
    ("GPU, rays", "#7a4fd0"),
    ("GPU, stereographic", "#e07b00"),
    ("GPU, hemisphere", "#c4a000"),
    ("GPU, hemicube", "#b06ac8"),
    ("GPU, paper", "#9a6a4a"),
    MATRIX,
    ("CPU, to an error", "#e8459c"),
    ("GPU, to an error", "#5f9e2f"),
    PEERS,
];

/// Solver and visibility.
pub fn family(method: &Method) -> Family {
    if method.asked.is_some() {
        return FAMILIES[if method.solver == Solver::Gpu { 9 } else { 8 }];
    }
    let drawing = method.settings.transport.visibility.drawing();
    FAMILIES[match (method.solver, drawing.map(|drawing| drawing.projection)) {
        (Solver::Cpu, None) => 0,
        (Solver::Cpu, Some(_)) => 1,
        (Solver::Gpu, None) => 2,
        (Solver::Gpu, Some(Projection::Stereographic(_))) => 3,
        (Solver::Gpu, Some(Projection::Hemisphere(_))) => 4,
        (Solver::Gpu, Some(Projection::Hemicube)) => 5,
        (Solver::Gpu, Some(Projection::Paper)) => 6,
        (Solver::Matrix, _) => 7,
    }]
}

/// The shapes, as the legend names them.
pub const SHAPES: [(Shape, &str); 6] = [
    (Shape::Circle, "polygon, cg"),
    (Shape::Square, "disc"),
    (Shape::Triangle, "paper's factor"),
    (Shape::Diamond, "southwell"),
    (Shape::Down, "other iteration"),
    (Shape::Cross, "failed: point at it"),
];

/// The form factor's, or the iteration's where that is the exact one: what it was, not what was asked
/// for.
pub fn shape(point: &Point) -> Shape {
    let (Some(figures), settings) = (point.figures(), &point.method.settings) else {
        return Shape::Cross;
    };
    match (settings.transport.form_factor, settings.schedule.iteration) {
        _ if point.method.solver == Solver::Matrix || point.method.asked.is_some() => Shape::Circle,
        (FormFactor::Disc, _) => Shape::Square,
        (FormFactor::Paper, _) => Shape::Triangle,
        (FormFactor::Polygon, _) if figures.one_by_one => Shape::Diamond,
        (FormFactor::Polygon, Iteration::Cg) => Shape::Circle,
        (FormFactor::Polygon, Iteration::Southwell) => Shape::Diamond,
        (FormFactor::Polygon, _) => Shape::Down,
    }
}
