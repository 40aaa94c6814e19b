//! How much of what two patches would exchange gets past the faces in between.
//!
//! ```text
//! V = Σ w f_visible(x) / Σ w f(x)
//! ```
//! over points x of one patch, f the exact point-to-polygon form factor (Lambert 1760) of the
//! other: whole, and what is left of it when the shadow of each blocker is cut out. One side is
//! thus exact, and only the way the shadow moves across the other one is sampled; the ratio is
//! applied to the exact unobstructed factor, so that the kernel's quadrature error cancels.

use super::pair::{Patch, each_node};
use crate::occlusion::occluders::Occluders;
use crate::occlusion::polygon::{Plane, Polygon};
use crate::occlusion::shaft::TOUCH;
use glam::DVec3;
use std::f64::consts::PI;

/// The estimate has settled when cutting the receiver into four changes it by less than this share
/// of the unobstructed factor.
pub const SETTLED: f64 = 1e-3;
/// Cuts of the receiver at most: 16 × 16 parts of 2 × 2 points.
const DEPTH: u32 = 4;

/// The visible share V of what `a` and `b` would exchange, past `blockers`.
pub fn visible_share(occluders: &Occluders, a: &Patch, b: &Patch, blockers: &[u32]) -> f64 {
    let clearance = |patch: &Patch| {
        blockers
            .iter()
            .map(|k| {
                occluders.faces[*k as usize]
                    .plane
                    .height(patch.centre)
                    .abs()
            })
            .fold(f64::INFINITY, f64::min)
    };
    // A shadow moves slowly across the patch that is farther from what casts it. Of equals the first:
    // the two estimates may differ by several per cent of V, and rounding must not choose.
    if clearance(a) >= clearance(b) - TOUCH {
        received_share(occluders, a, b, blockers)
    } else {
        received_share(occluders, b, a, blockers)
    }
}

/// V with the points on `receiver`.
pub fn received_share(
    occluders: &Occluders,
    receiver: &Patch,
    source: &Patch,
    blockers: &[u32],
) -> f64 {
    let mut scratch = Scratch::default();
    let mut estimate = |quad: &[DVec3; 4]| {
        let mut sum = Sum::default();
        each_node(quad, 2, |x, weight| {
            let visible = scratch.visible(occluders, x, receiver, source, blockers);
            sum.all += weight * from_point(x, receiver.plane.normal, &source.polygon);
            sum.visible += weight * visible;
        });
        sum
    };
    let quads: Vec<([DVec3; 4], Sum)> = receiver
        .polygon
        .quads()
        .map(|quad| (quad, estimate(&quad)))
        .collect();
    let all: f64 = quads.iter().map(|(_, sum)| sum.all).sum();
    if all <= 0.0 {
        return 0.0;
    }
    let mut total = Sum::default();
    for (quad, coarse) in quads {
        total += refine(&quad, coarse, SETTLED * all, DEPTH, &mut estimate);
    }
    (total.visible / total.all).clamp(0.0, 1.0)
}

/// ∫ of the visible and of the whole factor.
#[derive(Clone, Copy, Default)]
struct Sum {
    visible: f64,
    all: f64,
}

impl std::ops::AddAssign for Sum {
    fn add_assign(&mut self, other: Self) {
        self.visible += other.visible;
        self.all += other.all;
    }
}

/// Cuts `quad` into four until what is visible settles within `tolerance`, which halves with each
/// cut: the errors of the parts are independent.
fn refine(
    [a, b, c, d]: &[DVec3; 4],
    coarse: Sum,
    tolerance: f64,
    depth: u32,
    estimate: &mut impl FnMut(&[DVec3; 4]) -> Sum,
) -> Sum {
    let (ab, bc, cd, da) = (
        a.midpoint(*b),
        b.midpoint(*c),
        c.midpoint(*d),
        d.midpoint(*a),
    );
    let centre = ab.midpoint(cd);
    let parts = [
        [*a, ab, centre, da],
        [ab, *b, bc, centre],
        [centre, bc, *c, cd],
        [da, centre, cd, *d],
    ]
    .map(|part| (part, estimate(&part)));
    let mut fine = Sum::default();
    for (_, sum) in &parts {
        fine += *sum;
    }
    let expected = if coarse.all > 0.0 {
        coarse.visible / coarse.all * fine.all
    } else {
        0.0
    };
    if (fine.visible - expected).abs() <= tolerance || depth <= 1 {
        return fine;
    }
    let mut sum = Sum::default();
    for (part, coarse) in &parts {
        sum += refine(part, *coarse, tolerance / 2.0, depth - 1, estimate);
    }
    sum
}

/// The pieces of a polygon that are still visible, kept between points.
#[derive(Default)]
struct Scratch {
    pieces: Vec<Polygon>,
    left: Vec<Polygon>,
}

impl Scratch {
    /// The factor from `x` on `receiver` to what it sees of `source`.
    fn visible(
        &mut self,
        occluders: &Occluders,
        x: DVec3,
        receiver: &Patch,
        source: &Patch,
        blockers: &[u32],
    ) -> f64 {
        self.pieces.clear();
        self.pieces.push(source.polygon);
        for k in blockers {
            let face = &occluders.faces[*k as usize];
            let Some(shadow) = Shadow::new(x, &face.polygon, &face.plane) else {
                continue;
            };
            self.left.clear();
            for piece in &self.pieces {
                shadow.cut(piece, &mut self.left);
            }
            std::mem::swap(&mut self.pieces, &mut self.left);
            if self.pieces.is_empty() {
                return 0.0;
            }
        }
        self.pieces
            .iter()
            .map(|piece| from_point(x, receiver.plane.normal, piece))
            .sum()
    }
}

/// What a convex face hides from a point: behind its plane, within the cone of its edges.
struct Shadow {
    planes: [Plane; 5],
    count: usize,
}

impl Shadow {
    /// None where the point sees the face edge-on.
    fn new(x: DVec3, polygon: &Polygon, plane: &Plane) -> Option<Self> {
        let height = plane.height(x);
        if height.abs() <= 1e-9 {
            return None;
        }
        let mut shadow = Self {
            planes: [Plane::default(); 5],
            count: 1,
        };
        shadow.planes[0] = if height > 0.0 {
            plane.reversed()
        } else {
            *plane
        };
        for [a, b] in polygon.edges().take(4) {
            // Seen from the front the outline is counter-clockwise, its cone's planes face out.
            let outward = (a - x).cross(b - x) * height.signum();
            shadow.planes[shadow.count] = Plane::through(x, -outward);
            shadow.count += 1;
        }
        Some(shadow)
    }

    /// Appends what the shadow leaves of `piece`.
    fn cut(&self, piece: &Polygon, left: &mut Vec<Polygon>) {
        let planes = &self.planes[..self.count];
        // A piece that lies outside one plane stays whole instead of being cut by the others.
        if planes.iter().any(|plane| piece.heights(plane)[1] <= 0.0) {
            left.push(*piece);
            return;
        }
        let mut rest = *piece;
        for plane in planes {
            let (hidden, seen) = rest.split(plane);
            if !seen.is_empty() {
                left.push(seen);
            }
            rest = hidden;
            if rest.is_empty() {
                return;
            }
        }
    }
}

/// F from a point to a polygon above its horizon: −1/2π Σ angle(R_k, R_k+1)·unit(R_k × R_k+1)·n.
fn from_point(x: DVec3, normal: DVec3, polygon: &Polygon) -> f64 {
    let sum: f64 = polygon
        .edges()
        .map(|[a, b]| {
            let (a, b) = (a - x, b - x);
            let c = a.cross(b);
            let sine = c.length();
            if sine > 0.0 {
                sine.atan2(a.dot(b)) / sine * c.dot(normal)
            } else {
                0.0
            }
        })
        .sum();
    (-sum / (2.0 * PI)).max(0.0)
}
