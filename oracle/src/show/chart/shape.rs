//! Marks.

use super::path;

/// A mark's outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// ●
    Circle,
    /// ■
    Square,
    /// ▲
    Triangle,
    /// ◆
    Diamond,
    /// ▼
    Down,
    /// ✖
    Cross,
    /// ○, as a ring that is filled.
    Ring,
    /// ▬
    Bar,
}

impl Shape {
    /// SVG path data about (x, y).
    pub fn path(self, (x, y): (f64, f64), r: f64) -> String {
        let polygon = |corners: &[(f64, f64)]| {
            let at = |(i, j): &(f64, f64)| (x + i * r, y + j * r);
            path(corners.iter().map(at)) + "Z"
        };
        match self {
            Self::Circle => {
                let (left, across) = (x - r, 2.0 * r);
                format!("M{left:.1} {y:.1}a{r} {r} 0 1 0 {across} 0a{r} {r} 0 1 0 -{across} 0Z")
            }
            Self::Ring => {
                let ring = |r: f64, turn: u8| {
                    let (left, across) = (x - r, 2.0 * r);
                    format!(
                        "M{left:.1} {y:.1}a{r} {r} 0 1 {turn} {across} 0a{r} {r} 0 1 {turn} -{across} 0Z"
                    )
                };
                // The hole runs the other way round.
                ring(1.1 * r, 0) + &ring(0.5 * r, 1)
            }
            Self::Bar => polygon(&[(-1.3, -0.5), (1.3, -0.5), (1.3, 0.5), (-1.3, 0.5)]),
            Self::Square => polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
            Self::Triangle => polygon(&[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)]),
            Self::Diamond => polygon(&[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)]),
            Self::Down => polygon(&[(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8)]),
            Self::Cross => {
                // A quarter of it, turned about its middle.
                let arm = [(0.0, -0.3), (0.7, -1.0), (1.0, -0.7)];
                let turned = |(i, j): (f64, f64), k| match k {
                    0 => (i, j),
                    1 => (-j, i),
                    2 => (-i, -j),
                    _ => (j, -i),
                };
                let corners = (0..4).flat_map(|k| arm.map(|corner| turned(corner, k)));
                polygon(&corners.collect::<Vec<_>>())
            }
        }
    }
}
