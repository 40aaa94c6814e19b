//! Labels beside marks, where there is room for them.

/// Width of a letter of the labels' font, pixels; most are narrower.
const LETTER: f64 = 6.4;
/// Height of a label.
const HEIGHT: f64 = 13.0;
/// From a mark to its label.
const GAP: f64 = 9.0;

/// Half the width of what is not to be covered.
const MARK: f64 = 5.0;

/// An axis-aligned box: left, top, right, bottom.
pub type Frame = [f64; 4];

/// A placed label: the left end of its baseline, and the text.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// x.
    pub x: f64,
    /// y.
    pub y: f64,
    /// The text.
    pub text: String,
}

/// Places each (x, y, text) beside its mark, below and to the left first, since a front has
/// nothing there; where it would cover something, it is left out.
pub fn place(wanted: &[(f64, f64, String)], area: Frame, marks: &[(f64, f64)]) -> Vec<Label> {
    let mut taken: Vec<Frame> = marks
        .iter()
        .map(|(x, y)| [x - MARK, y - MARK, x + MARK, y + MARK])
        .collect();
    let mut labels = Vec::new();
    for (x, y, text) in wanted {
        let width = LETTER * text.chars().count() as f64;
        let (left, right) = (x - GAP - width, x + GAP);
        let (above, below) = (y - GAP, y + GAP + 0.8 * HEIGHT);
        let beside = y + 0.3 * HEIGHT;
        let places = [
            (left, below),
            (left, beside),
            (right, below),
            (x - width / 2.0, below + 2.0),
            (right, beside),
            (left, above),
            (right, above),
        ];
        let frame = |(x, y): (f64, f64)| [x, y - 0.8 * HEIGHT, x + width, y + 0.2 * HEIGHT];
        let free = |place: &&(f64, f64)| {
            let f = frame(**place);
            let inside = f[0] >= area[0] && f[1] >= area[1] && f[2] <= area[2] && f[3] <= area[3];
            inside && !taken.iter().any(|t| overlap(f, *t))
        };
        if let Some((x, y)) = places.iter().find(free) {
            taken.push(frame((*x, *y)));
            labels.push(Label {
                x: *x,
                y: *y,
                text: text.clone(),
            });
        }
    }
    labels
}

/// Points of a line, so close that no label gets between them.
pub fn along(corners: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let part = |ends: &[(f64, f64)]| {
        let [(x, y), (to_x, to_y)] = [ends[0], ends[1]];
        let steps = ((to_x - x).hypot(to_y - y) / MARK).ceil().max(1.0) as usize;
        (0..=steps).map(move |k| {
            let t = k as f64 / steps as f64;
            (x + t * (to_x - x), y + t * (to_y - y))
        })
    };
    corners.windows(2).flat_map(part).collect()
}

fn overlap(a: Frame, b: Frame) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_neither_collide_nor_leave() {
        let area = [0.0, 0.0, 300.0, 200.0];
        let wanted: Vec<(f64, f64, String)> = (0..40)
            .map(|k| {
                let (x, y) = ((k * 67 % 300) as f64, (k * 41 % 200) as f64);
                (x, y, "x".repeat(5 + k % 9))
            })
            .collect();
        let marks: Vec<(f64, f64)> = wanted.iter().map(|(x, y, _)| (*x, *y)).collect();
        let labels = place(&wanted, area, &marks);
        assert!(labels.len() > 5);
        let frame = |l: &Label| {
            let width = LETTER * l.text.len() as f64;
            [l.x, l.y - 0.8 * HEIGHT, l.x + width, l.y + 0.2 * HEIGHT]
        };
        for (k, a) in labels.iter().enumerate() {
            let f = frame(a);
            assert!(f[0] >= 0.0 && f[1] >= 0.0 && f[2] <= 300.0 && f[3] <= 200.0);
            assert!(labels[..k].iter().all(|b| !overlap(f, frame(b))));
            assert!(marks.iter().all(|(x, y)| !overlap(f, [*x, *y, *x, *y])));
        }
    }

    #[test]
    fn below_to_the_left_comes_first() {
        let area = [0.0, 0.0, 300.0, 200.0];
        let labels = place(&[(150.0, 100.0, "ab".into())], area, &[(150.0, 100.0)]);
        assert!(labels[0].x < 150.0 - GAP && labels[0].y > 100.0);
    }
}
