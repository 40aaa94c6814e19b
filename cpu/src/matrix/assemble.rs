//! All pairs: the shaft between a texel and a face finds what may block, the shafts between the
//! texels thin it out, and the rest is exact, hidden by one face, or sampled.

use super::open::Element;
use super::pair::{Patch, exchange, facing};
use super::share::{received_share, visible_share};
use crate::occlusion::occluders::Occluders;
use crate::occlusion::shaft::Shaft;
use glam::DVec3;

/// How the pairs that face each other were decided.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pairs {
    /// Nothing in between: exact.
    pub exact: u64,
    /// Wholly hidden by one face: exactly 0.
    pub hidden: u64,
    /// Partly hidden, perhaps: the visible share was sampled.
    pub sampled: u64,
}

impl std::ops::AddAssign for Pairs {
    fn add_assign(&mut self, other: Self) {
        self.exact += other.exact;
        self.hidden += other.hidden;
        self.sampled += other.sampled;
    }
}

/// The elements by face.
pub struct Assembly<'a> {
    /// All faces.
    pub occluders: &'a Occluders,
    /// In the mesh's order: those of a face are contiguous.
    pub elements: &'a [Element],
    /// The elements of each face.
    pub ranges: Vec<std::ops::Range<usize>>,
}

impl<'a> Assembly<'a> {
    /// Finds each face's elements.
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

    /// G between element `i` and every element of the faces after its own, into `column`.
    pub fn fill(&self, i: usize, column: &mut [f64]) -> Pairs {
        let mut pairs = Pairs::default();
        let mut blockers = Vec::new();
        let first = self.elements[i].face as usize + 1;
        for patch in &self.elements[i].patches {
            for face in first..self.occluders.faces.len() {
                self.fill_face(i, patch, face, column, &mut blockers, &mut pairs);
            }
        }
        pairs
    }

    fn fill_face(
        &self,
        i: usize,
        patch: &Patch,
        face: usize,
        column: &mut [f64],
        blockers: &mut Vec<u32>,
        pairs: &mut Pairs,
    ) {
        let other = &self.occluders.faces[face];
        let ends = [
            self.occluders.faces[self.elements[i].face as usize].sheet,
            other.sheet,
        ];
        if ends[0] == ends[1] || other.plane.normal == DVec3::ZERO {
            return;
        }
        let Some((near, far)) = facing(patch, &Patch::new(other.polygon, other.plane)) else {
            return;
        };
        let shaft = Shaft::new(&near.polygon, &near.plane, &far.polygon, &far.plane);
        blockers.clear();
        self.occluders.entering(&shaft, ends, blockers);
        if self.occluders.one_hides(&shaft, blockers) {
            pairs.hidden += self.ranges[face].len() as u64;
            return;
        }
        for j in self.ranges[face].clone() {
            for target in &self.elements[j].patches {
                if let Some(pair) = Pair::new(self.occluders, patch, target, blockers) {
                    column[j] += pair.exchange(self.occluders, pairs);
                }
            }
        }
    }

    /// Max of |A_i F_ij − A_j F_ji| over about `count` of the pairs of exact, and of sampled
    /// visibility, each relative to the unobstructed G: both ends are computed on their own.
    pub fn reciprocity(&self, count: usize) -> [f64; 2] {
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
            for (p, q) in a
                .patches
                .iter()
                .flat_map(|p| b.patches.iter().map(move |q| (p, q)))
            {
                let Some((p, q)) = facing(p, q) else { continue };
                let shaft = Shaft::new(&p.polygon, &p.plane, &q.polygon, &q.plane);
                blockers.clear();
                self.occluders.entering(&shaft, ends, &mut blockers);
                let whole = exchange(&p, &q);
                if blockers.is_empty() {
                    exact =
                        exact.max((whole - exchange(&q, &p)).abs() / whole.max(f64::MIN_POSITIVE));
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

/// Two patches that face each other, and what may be in between.
struct Pair {
    ends: (Patch, Patch),
    blockers: Option<Vec<u32>>,
}

impl Pair {
    fn new(occluders: &Occluders, a: &Patch, b: &Patch, candidates: &[u32]) -> Option<Self> {
        let (a, b) = facing(a, b)?;
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
                !shaft.misses(&face.polygon, &face.plane)
            })
            .collect();
        let hidden = occluders.one_hides(&shaft, &blockers);
        Some(Self {
            ends: (a, b),
            blockers: (!hidden).then_some(blockers),
        })
    }

    fn exchange(&self, occluders: &Occluders, pairs: &mut Pairs) -> f64 {
        let (a, b) = &self.ends;
        let Some(blockers) = &self.blockers else {
            pairs.hidden += 1;
            return 0.0;
        };
        if blockers.is_empty() {
            pairs.exact += 1;
            return exchange(a, b);
        }
        pairs.sampled += 1;
        let share = visible_share(occluders, a, b, blockers);
        if share > 0.0 {
            share * exchange(a, b)
        } else {
            0.0
        }
    }
}
