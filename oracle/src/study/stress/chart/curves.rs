//! The curves upon a case's axes: a line, marks and a name for each method and solver.

use super::{Plot, colour, shape};
use crate::show::chart::{Shape, line, path, px};
use crate::study::stress::outcome::{Half, error, value};
use crate::study::stress::{Row, Side, Study};
use maud::{Markup, html};

/// Height of a name, pixels.
const LINE: f64 = 17.0;

/// All of them.
pub fn curves(study: &Study, methods: &[&'static str], plot: &Plot) -> Markup {
    let both = |(k, method): (usize, &&'static str)| {
        let method = *method;
        Half::BOTH.map(|half| Curve::new(study, k, method, half))
    };
    let all = methods.iter().enumerate().flat_map(both);
    let curves: Vec<Curve> = all.filter(|curve| !curve.points.is_empty()).collect();
    // The first method is drawn last, upon the others; of each the GPU upon the CPU.
    let mut drawn: Vec<&Curve> = curves.iter().collect();
    drawn.sort_by_key(|curve| std::cmp::Reverse(curve.place));
    html! {
        @for curve in &drawn { (way(curve, plot)) }
        @for curve in &drawn { @for point in &curve.points { (mark(curve, point, plot)) } }
        (unanswered(&curves, plot))
        (names(&curves, plot))
    }
}

/// One method on one solver.
struct Curve<'a> {
    method: &'static str,
    place: usize,
    colour: &'static str,
    shape: Shape,
    half: Half,
    measure: &'static str,
    points: Vec<(&'a Row, &'a Side)>,
}

impl<'a> Curve<'a> {
    fn new(study: &'a Study, k: usize, method: &'static str, half: Half) -> Self {
        let rows = study.rows.iter().filter(|row| row.method == method);
        Self {
            method,
            place: k,
            colour: colour(k),
            shape: shape(k),
            half,
            measure: study.about.measure,
            points: rows.filter_map(|r| Some((r, half.of(r)?))).collect(),
        }
    }

    /// Where its name points to.
    fn end(&self, plot: &Plot) -> Option<(f64, f64)> {
        let (row, side) = self.points.last()?;
        let y = side.error.map_or(plot.strip(), |error| plot.y(error));
        Some((plot.x(row.value), y))
    }
}

/// Broken where there is no answer.
fn way(curve: &Curve, plot: &Plot) -> Markup {
    let parts = curve.points.split(|(_, side)| side.error.is_none());
    let at = |(row, side): &(&Row, &Side)| Some((plot.x(row.value), plot.y(side.error?)));
    let parts = parts.filter(|part| !part.is_empty());
    let data: String = parts.map(|part| path(part.iter().filter_map(at))).collect();
    // Thin and dashed upon broad: both are seen where they agree.
    let (width, opacity, dashes) = match curve.half {
        Half::Cpu => (4.5, 0.4, None),
        Half::Gpu => (1.8, 1.0, Some("6 4")),
    };
    html! { @if !data.is_empty() { (line(&data, curve.colour, width, opacity, dashes)) } }
}

/// Large and pale for the CPU, small and dark for the GPU upon it; hollow where it warned.
fn mark(curve: &Curve, (row, side): &(&Row, &Side), plot: &Plot) -> Markup {
    let (size, pale) = match curve.half {
        Half::Cpu => (6.0, 0.4),
        Half::Gpu => (3.2, 1.0),
    };
    let (fill, opacity) = if side.warned() {
        ("var(--card)", 1.0)
    } else {
        (curve.colour, pale)
    };
    html! {
        @if let Some(error) = side.error {
            g.mark {
                title { (about(curve, row, side)) }
                path d=(curve.shape.path((plot.x(row.value), plot.y(error)), size)) fill=(fill) fill-opacity=(opacity) stroke=(curve.colour) stroke-width="1.5" {}
            }
        }
    }
}

/// What pointing at a mark tells.
fn about(curve: &Curve, row: &Row, side: &Side) -> String {
    let (method, half) = (curve.method, curve.half.name());
    let mut text = format!(
        "{method}, {half}, at {}: {}",
        value(row.value),
        error(side, curve.measure)
    );
    if !side.warnings.is_empty() {
        text += &format!("\nwarned: {}", side.warnings.join(", "));
    }
    for line in side.notes.iter().chain(&side.message) {
        text += &format!("\n{line}");
    }
    text
}

/// Crosses in the strip, side by side where there are several: the CPU's above the GPU's.
fn unanswered(curves: &[Curve], plot: &Plot) -> Markup {
    let crosses = |value: f64, half: Half| {
        let of = curves.iter().filter(move |curve| curve.half == half);
        let points = of.flat_map(|curve| curve.points.iter().map(move |point| (curve, point)));
        let here = points.filter(move |(_, (row, _))| row.value == value);
        let here: Vec<_> = here.filter(|(_, (_, s))| s.error.is_none()).collect();
        let middle = (here.len() as f64 - 1.0) / 2.0;
        let marks = here.into_iter().enumerate();
        marks.map(move |(k, mark)| ((k as f64 - middle) * 8.0, mark))
    };
    let shift = |half| if half == Half::Cpu { -5.0 } else { 6.0 };
    html! {
        @for value in plot.values { @for half in Half::BOTH {
            @for (dx, (curve, (row, side))) in crosses(*value, half) {
                @let at = (plot.x(*value) + dx, plot.strip() + shift(half));
                g.mark {
                    title { (about(curve, row, side)) }
                    path d=(Shape::Cross.path(at, 4.5)) fill=(curve.colour) {}
                }
            }
        } }
    }
}

/// Beside the curves' ends; moved apart where they end together.
fn names(curves: &[Curve], plot: &Plot) -> Markup {
    // The CPU's curve names the method; where it ends without an answer, the GPU's.
    let answered = |curve: &&Curve| curve.points.last().is_some_and(|(_, s)| s.error.is_some());
    let mut ends: Vec<(&Curve, (f64, f64))> = Vec::new();
    for curve in curves.iter().filter(answered).chain(curves) {
        if ends.iter().all(|(c, _)| c.method != curve.method) {
            ends.extend(curve.end(plot).map(|end| (curve, end)));
        }
    }
    ends.sort_by(|a, b| a.1.1.total_cmp(&b.1.1));
    let wanted: Vec<f64> = ends.iter().map(|(_, (_, y))| *y).collect();
    let right = plot.frame.right;
    let lines = apart(&wanted, [plot.frame.top + LINE / 2.0, plot.frame.bottom]);
    html! {
        @for ((curve, (x, y)), at) in ends.iter().zip(lines) {
            @let leader = path([(x + 8.0, *y), (right + 6.0, at), (right + 14.0, at)]);
            (line(&leader, curve.colour, 1.0, 0.6, None))
            path d=(curve.shape.path((right + 20.0, at), 5.0)) fill=(curve.colour) {}
            text x=(right + 29.0) y=(px(at + 4.0)) { (curve.method) }
        }
    }
}

/// Rising places at least a line apart, near those wanted and between the ends.
fn apart(wanted: &[f64], [top, bottom]: [f64; 2]) -> Vec<f64> {
    let mut at: Vec<f64> = Vec::new();
    for y in wanted {
        let least = at.last().map_or(top, |last| last + LINE);
        at.push(y.max(least));
    }
    let mut most = bottom;
    for y in at.iter_mut().rev() {
        *y = y.min(most);
        most = *y - LINE;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_their_distance() {
        let places = apart(&[5.0, 6.0, 7.0, 100.0, 199.0, 200.0], [8.0, 200.0]);
        assert!(places.windows(2).all(|w| w[1] - w[0] >= LINE - 1e-9));
        assert!(places[0] >= 8.0 && places[5] <= 200.0);
        assert_eq!(places[3], 100.0);
    }
}
