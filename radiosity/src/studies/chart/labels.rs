//! Places text labels beside chart marks without overlap.

/// Width of a wide letter of the labels' font, pixels.
const LETTER_WIDTH: f64 = 6.4;
/// Height of a label, pixels.
const LABEL_HEIGHT: f64 = 13.0;
/// Distance from a mark to its label, pixels.
const LABEL_GAP: f64 = 9.0;

/// Half the side of the square that a mark occupies, pixels.
const MARK_HALF_WIDTH: f64 = 5.0;

/// An axis-aligned box: left, top, right, bottom, pixels.
pub type LabelBox = [f64; 4];

/// A placed label: the left end of its baseline, pixels, and its text.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedLabel {
    /// Left end of the baseline.
    pub x: f64,
    /// Height of the baseline.
    pub y: f64,
    /// The text.
    pub text: String,
}

/// Places each (x, y, text) of `wanted` beside its mark, trying below left first, where a Pareto
/// front has no points. A label that would cover another label or one of `marks` is omitted.
pub fn place_labels(wanted: &[(f64, f64, String)], area: LabelBox, marks: &[(f64, f64)]) -> Vec<PlacedLabel> {
    let mut taken: Vec<LabelBox> = marks
        .iter()
        .map(|(x, y)| {
            [
                x - MARK_HALF_WIDTH,
                y - MARK_HALF_WIDTH,
                x + MARK_HALF_WIDTH,
                y + MARK_HALF_WIDTH,
            ]
        })
        .collect();
    let mut labels = Vec::new();
    for (x, y, text) in wanted {
        let width = LETTER_WIDTH * text.chars().count() as f64;
        let (left, right) = (x - LABEL_GAP - width, x + LABEL_GAP);
        let (above, below) = (y - LABEL_GAP, y + LABEL_GAP + 0.8 * LABEL_HEIGHT);
        let beside = y + 0.3 * LABEL_HEIGHT;
        let places = [
            (left, below),
            (left, beside),
            (right, below),
            (x - width / 2.0, below + 2.0),
            (right, beside),
            (left, above),
            (right, above),
        ];
        let frame = |(x, y): (f64, f64)| [x, y - 0.8 * LABEL_HEIGHT, x + width, y + 0.2 * LABEL_HEIGHT];
        let free = |place: &&(f64, f64)| {
            let f = frame(**place);
            let inside = f[0] >= area[0] && f[1] >= area[1] && f[2] <= area[2] && f[3] <= area[3];
            inside && !taken.iter().any(|t| boxes_overlap(f, *t))
        };
        if let Some((x, y)) = places.iter().find(free) {
            taken.push(frame((*x, *y)));
            labels.push(PlacedLabel {
                x: *x,
                y: *y,
                text: text.clone(),
            });
        }
    }
    labels
}

/// Samples a polyline so densely that no label fits between two samples.
pub fn sample_polyline(corners: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let part = |ends: &[(f64, f64)]| {
        let [(x, y), (to_x, to_y)] = [ends[0], ends[1]];
        let steps = ((to_x - x).hypot(to_y - y) / MARK_HALF_WIDTH).ceil().max(1.0) as usize;
        (0..=steps).map(move |k| {
            let t = k as f64 / steps as f64;
            (x + t * (to_x - x), y + t * (to_y - y))
        })
    };
    corners.windows(2).flat_map(part).collect()
}

fn boxes_overlap(a: LabelBox, b: LabelBox) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_stay_apart_and_inside_the_area() {
        let area = [0.0, 0.0, 300.0, 200.0];
        let wanted: Vec<(f64, f64, String)> = (0..40)
            .map(|k| {
                let (x, y) = ((k * 67 % 300) as f64, (k * 41 % 200) as f64);
                (x, y, "x".repeat(5 + k % 9))
            })
            .collect();
        let marks: Vec<(f64, f64)> = wanted.iter().map(|(x, y, _)| (*x, *y)).collect();
        let labels = place_labels(&wanted, area, &marks);
        assert!(labels.len() > 5);
        let frame = |l: &PlacedLabel| {
            let width = LETTER_WIDTH * l.text.len() as f64;
            [l.x, l.y - 0.8 * LABEL_HEIGHT, l.x + width, l.y + 0.2 * LABEL_HEIGHT]
        };
        for (k, a) in labels.iter().enumerate() {
            let f = frame(a);
            assert!(f[0] >= 0.0 && f[1] >= 0.0 && f[2] <= 300.0 && f[3] <= 200.0);
            assert!(labels[..k].iter().all(|b| !boxes_overlap(f, frame(b))));
            assert!(marks.iter().all(|(x, y)| !boxes_overlap(f, [*x, *y, *x, *y])));
        }
    }

    #[test]
    fn label_is_placed_below_left_first() {
        let area = [0.0, 0.0, 300.0, 200.0];
        let labels = place_labels(&[(150.0, 100.0, "ab".into())], area, &[(150.0, 100.0)]);
        assert!(labels[0].x < 150.0 - LABEL_GAP && labels[0].y > 100.0);
    }
}
