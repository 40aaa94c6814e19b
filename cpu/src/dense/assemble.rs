//! Exchange areas of all texel pairs. The shaft between a texel and a face finds possible occluders, the shafts between
//! texels reduce them; each pair is then unoccluded (exact), hidden by one face (0), or sampled.

use super::exchange_area::{SurfacePiece, exchange_area, facing_parts};
use super::open_area::Element;
use super::visible_share::{received_share, visible_share};
use crate::occlusion::occluders::Occluders;
use crate::occlusion::shaft::Shaft;
use glam::DVec3;

/// Counts of the pairs that face each other, by the method that found their visibility.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairCounts {
    /// Unoccluded pairs: exact.
    pub exact: u64,
    /// Pairs that one face hides: exactly 0.
    pub hidden: u64,
    /// Other pairs: the visible share was sampled.
    pub sampled: u64,
}

impl std::ops::AddAssign for PairCounts {
    fn add_assign(&mut self, other: Self) {
        self.exact += other.exact;
        self.hidden += other.hidden;
        self.sampled += other.sampled;
    }
}

/// The elements, grouped by face.
pub struct Assembly<'a> {
    /// All faces.
    pub occluders: &'a Occluders,
    /// Elements in the mesh's order: those of a face are contiguous.
    pub elements: &'a [Element],
    /// Range of each face's elements.
    pub ranges: Vec<std::ops::Range<usize>>,
}

impl<'a> Assembly<'a> {
    /// Groups the elements by face.
    pub fn new(occluders: &'a Occluders, elements: &'a [Element]) -> Self {
        let mut ranges = vec![0..0; occluders.faces.len()];
        for (k, element) in elements.iter().enumerate() {
            let range = &mut ranges[element.face as usize];
            if range.start == range.end {
                *range = k..k + 1;
            }
            range.end = k + 1;
        }
        Self {
            occluders,
            elements,
            ranges,
        }
    }

    /// Fills `column` with G between element `i` and every element of later faces.
    pub fn fill_column(&self, i: usize, column: &mut [f64]) -> PairCounts {
        let mut pairs = PairCounts::default();
        let mut blockers = Vec::new();
        let first = self.elements[i].face as usize + 1;
        for piece in &self.elements[i].pieces {
            for face in first..self.occluders.faces.len() {
                self.fill_face(i, piece, face, column, &mut blockers, &mut pairs);
            }
        }
        pairs
    }

    fn fill_face(
        &self,
        i: usize,
        piece: &SurfacePiece,
        face: usize,
        column: &mut [f64],
        blockers: &mut Vec<u32>,
        pairs: &mut PairCounts,
    ) {
        let other = &self.occluders.faces[face];
        let ends = [self.occluders.faces[self.elements[i].face as usize].sheet, other.sheet];
        if ends[0] == ends[1] || other.plane.normal == DVec3::ZERO {
            return;
        }
        let Some((near, far)) = facing_parts(piece, &SurfacePiece::new(other.polygon, other.plane)) else {
            return;
        };
        let shaft = Shaft::new(&near.polygon, &near.plane, &far.polygon, &far.plane);
        blockers.clear();
        self.occluders.faces_entering(&shaft, ends, blockers);
        if self.occluders.one_hides(&shaft, blockers) {
            pairs.hidden += self.ranges[face].len() as u64;
            return;
        }
        for j in self.ranges[face].clone() {
            for target in &self.elements[j].pieces {
                if let Some(pair) = PiecePair::new(self.occluders, piece, target, blockers) {
                    column[j] += pair.exchange_area(self.occluders, pairs);
                }
            }
        }
    }

    /// Returns the largest |A_i F_ij − A_j F_ji|, relative to the unoccluded G, over about `count` pairs: of exact and of
    /// sampled visibility. Each direction is computed independently.
    pub fn max_asymmetry(&self, count: usize) -> [f64; 2] {
        let n = self.elements.len();
        let (mut exact, mut sampled) = (0.0f64, 0.0f64);
        let mut blockers = Vec::new();
        for k in 0..count {
            // Weyl sequences: pairs from everywhere, the same in every run.
            let at = |alpha: f64| ((k as f64 + 0.5) * alpha).fract() * n as f64;
            let (i, j) = (
                (at(0.754_877_666_246_693) as usize).min(n - 1),
                (at(0.569_840_290_998_053) as usize).min(n - 1),
            );
            let [a, b] = [&self.elements[i], &self.elements[j]];
            let ends = [a, b].map(|e| self.occluders.faces[e.face as usize].sheet);
            if ends[0] == ends[1] {
                continue;
            }
            for (p, q) in a.pieces.iter().flat_map(|p| b.pieces.iter().map(move |q| (p, q))) {
                let Some((p, q)) = facing_parts(p, q) else {
                    continue;
                };
                let shaft = Shaft::new(&p.polygon, &p.plane, &q.polygon, &q.plane);
                blockers.clear();
                self.occluders.faces_entering(&shaft, ends, &mut blockers);
                let whole = exchange_area(&p, &q);
                if blockers.is_empty() {
                    exact = exact.max((whole - exchange_area(&q, &p)).abs() / whole.max(f64::MIN_POSITIVE));
                } else if !self.occluders.one_hides(&shaft, &blockers) {
                    let share = received_share(self.occluders, &p, &q, &blockers)
                        - received_share(self.occluders, &q, &p, &blockers);
                    sampled = sampled.max(share.abs());
                }
            }
        }
        [exact, sampled]
    }
}

/// Two pieces that face each other, and their possible occluders; none if the pieces are hidden.
struct PiecePair {
    ends: (SurfacePiece, SurfacePiece),
    blockers: Option<Vec<u32>>,
}

impl PiecePair {
    fn new(occluders: &Occluders, a: &SurfacePiece, b: &SurfacePiece, candidates: &[u32]) -> Option<Self> {
        let (a, b) = facing_parts(a, b)?;
        if candidates.is_empty() {
            return Some(Self {
                ends: (a, b),
                blockers: Some(Vec::new()),
            });
        }
        let shaft = Shaft::new(&a.polygon, &a.plane, &b.polygon, &b.plane);
        let blockers: Vec<u32> = candidates
            .iter()
            .copied()
            .filter(|k| {
                let face = &occluders.faces[*k as usize];
                !shaft.misses_polygon(&face.polygon, &face.plane)
            })
            .collect();
        let hidden = occluders.one_hides(&shaft, &blockers);
        Some(Self {
            ends: (a, b),
            blockers: (!hidden).then_some(blockers),
        })
    }

    fn exchange_area(&self, occluders: &Occluders, pairs: &mut PairCounts) -> f64 {
        let (a, b) = &self.ends;
        let Some(blockers) = &self.blockers else {
            pairs.hidden += 1;
            return 0.0;
        };
        if blockers.is_empty() {
            pairs.exact += 1;
            return exchange_area(a, b);
        }
        pairs.sampled += 1;
        let share = visible_share(occluders, a, b, blockers);
        if share > 0.0 { share * exchange_area(a, b) } else { 0.0 }
    }
}
