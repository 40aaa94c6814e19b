//! The visible share of the exchange between two pieces past their occluders:
//!
//! ```text
//! V = Σ w f_visible(x) / Σ w f(x)
//! ```
//! over points x of one piece; f is the exact point-to-polygon form factor (Lambert 1760) of the other piece, and
//! f_visible that of its parts outside all occluders' shadow volumes. One side is thus exact, and only the motion of the
//! shadow across the other is sampled. V is applied to the exact unoccluded factor, so that the kernel's quadrature
//! error cancels.

use super::exchange_area::{SurfacePiece, for_each_node};
use crate::occlusion::occluders::Occluders;
use crate::occlusion::polygon::{ConvexPolygon, OrientedPlane};
use crate::occlusion::shaft::TOUCH_DISTANCE;
use glam::DVec3;
use std::f64::consts::PI;

/// The estimate has converged when cutting the receiver into four changes it by less than this share
/// of the unoccluded factor.
pub const VISIBILITY_TOLERANCE: f64 = 1e-3;
/// Maximum depth of cuts: 16 × 16 parts of 2 × 2 points.
const MAX_DEPTH: u32 = 4;

/// Returns the visible share V of the exchange between `a` and `b` past `blockers`.
pub fn visible_share(occluders: &Occluders, a: &SurfacePiece, b: &SurfacePiece, blockers: &[u32]) -> f64 {
    let clearance = |piece: &SurfacePiece| {
        blockers
            .iter()
            .map(|k| occluders.faces[*k as usize].plane.height_of(piece.centre).abs())
            .fold(f64::INFINITY, f64::min)
    };
    // A shadow moves slowly across the piece that is farther from its occluder. Equal clearances choose the first: the
    // two estimates may differ by several per cent of V, and rounding must not decide.
    if clearance(a) >= clearance(b) - TOUCH_DISTANCE {
        received_share(occluders, a, b, blockers)
    } else {
        received_share(occluders, b, a, blockers)
    }
}

/// Returns V with the points on `receiver`.
pub fn received_share(occluders: &Occluders, receiver: &SurfacePiece, source: &SurfacePiece, blockers: &[u32]) -> f64 {
    let mut scratch = ClipBuffers::default();
    let mut estimate = |quad: &[DVec3; 4]| {
        let mut sum = FactorIntegral::default();
        for_each_node(quad, 2, |x, weight| {
            let visible = scratch.visible_factor(occluders, x, receiver, source, blockers);
            sum.all += weight * point_form_factor(x, receiver.plane.normal, &source.polygon);
            sum.visible += weight * visible;
        });
        sum
    };
    let quads: Vec<([DVec3; 4], FactorIntegral)> = receiver
        .polygon
        .quad_pieces()
        .map(|quad| (quad, estimate(&quad)))
        .collect();
    let all: f64 = quads.iter().map(|(_, sum)| sum.all).sum();
    if all <= 0.0 {
        return 0.0;
    }
    let mut total = FactorIntegral::default();
    for (quad, coarse) in quads {
        total += refine_quad(&quad, coarse, VISIBILITY_TOLERANCE * all, MAX_DEPTH, &mut estimate);
    }
    (total.visible / total.all).clamp(0.0, 1.0)
}

/// Integrals of the visible and of the whole factor.
#[derive(Clone, Copy, Default)]
struct FactorIntegral {
    visible: f64,
    all: f64,
}

impl std::ops::AddAssign for FactorIntegral {
    fn add_assign(&mut self, other: Self) {
        self.visible += other.visible;
        self.all += other.all;
    }
}

/// Cuts `quad` into four until the visible integral converges within `tolerance`, which halves with each
/// cut, because the errors of the parts are independent.
fn refine_quad(
    [a, b, c, d]: &[DVec3; 4],
    coarse: FactorIntegral,
    tolerance: f64,
    depth: u32,
    estimate: &mut impl FnMut(&[DVec3; 4]) -> FactorIntegral,
) -> FactorIntegral {
    let (ab, bc, cd, da) = (a.midpoint(*b), b.midpoint(*c), c.midpoint(*d), d.midpoint(*a));
    let centre = ab.midpoint(cd);
    let parts = [
        [*a, ab, centre, da],
        [ab, *b, bc, centre],
        [centre, bc, *c, cd],
        [da, centre, cd, *d],
    ]
    .map(|part| (part, estimate(&part)));
    let mut fine = FactorIntegral::default();
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
    let mut sum = FactorIntegral::default();
    for (part, coarse) in &parts {
        sum += refine_quad(part, *coarse, tolerance / 2.0, depth - 1, estimate);
    }
    sum
}

/// Buffers for the visible pieces of a polygon, reused between points.
#[derive(Default)]
struct ClipBuffers {
    pieces: Vec<ConvexPolygon>,
    left: Vec<ConvexPolygon>,
}

impl ClipBuffers {
    /// Returns the factor from `x` on `receiver` to the part of `source` that it sees.
    fn visible_factor(
        &mut self,
        occluders: &Occluders,
        x: DVec3,
        receiver: &SurfacePiece,
        source: &SurfacePiece,
        blockers: &[u32],
    ) -> f64 {
        self.pieces.clear();
        self.pieces.push(source.polygon);
        for k in blockers {
            let face = &occluders.faces[*k as usize];
            let Some(shadow) = ShadowVolume::new(x, &face.polygon, &face.plane) else {
                continue;
            };
            self.left.clear();
            for piece in &self.pieces {
                shadow.append_visible(piece, &mut self.left);
            }
            std::mem::swap(&mut self.pieces, &mut self.left);
            if self.pieces.is_empty() {
                return 0.0;
            }
        }
        self.pieces
            .iter()
            .map(|piece| point_form_factor(x, receiver.plane.normal, piece))
            .sum()
    }
}

/// The shadow volume of a convex face from a point: behind its plane, within the pyramid through its edges.
struct ShadowVolume {
    planes: [OrientedPlane; 5],
    count: usize,
}

impl ShadowVolume {
    /// Returns the volume; none if the point sees the face edge-on.
    fn new(x: DVec3, polygon: &ConvexPolygon, plane: &OrientedPlane) -> Option<Self> {
        let height = plane.height_of(x);
        if height.abs() <= 1e-9 {
            return None;
        }
        let mut shadow = Self {
            planes: [OrientedPlane::default(); 5],
            count: 1,
        };
        shadow.planes[0] = if height > 0.0 { plane.reversed() } else { *plane };
        for [a, b] in polygon.edges().take(4) {
            // Seen from the front the outline is counter-clockwise, its cone's planes face out.
            let outward = (a - x).cross(b - x) * height.signum();
            shadow.planes[shadow.count] = OrientedPlane::through_point(x, -outward);
            shadow.count += 1;
        }
        Some(shadow)
    }

    /// Appends the parts of `piece` outside the shadow.
    fn append_visible(&self, piece: &ConvexPolygon, left: &mut Vec<ConvexPolygon>) {
        let planes = &self.planes[..self.count];
        // A piece that lies outside one plane stays whole instead of being cut by the others.
        if planes.iter().any(|plane| piece.height_range(plane)[1] <= 0.0) {
            left.push(*piece);
            return;
        }
        let mut rest = *piece;
        for plane in planes {
            let (hidden, seen) = rest.split_by(plane);
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

/// Returns F from a point to a polygon above its horizon: −1/2π Σ angle(R_k, R_k+1)·unit(R_k × R_k+1)·n.
fn point_form_factor(x: DVec3, normal: DVec3, polygon: &ConvexPolygon) -> f64 {
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
