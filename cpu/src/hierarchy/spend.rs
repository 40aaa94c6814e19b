//! Light that goes round over kept links: x = K(s + ρx), bounce after bounce (Neumann's series); and where
//! little is lost a bounce, by GMRES (Saad & Schultz 1986).

use crate::hierarchy::cluster::Clusters;
use crate::hierarchy::coarse::{Coarse, Kept, exchange};
use crate::hierarchy::light::Glow;
use crate::hierarchy::tree::Tree;
use common::{Error, Result};
use glam::{DVec3, Vec3};

/// Bounces before anything else is tried: after half of them each has less light than the one before.
const PLAIN: usize = 24;
/// Directions of GMRES before it starts anew, and how often it does.
const DIRECTIONS: usize = 32;
/// See [`DIRECTIONS`].
const STARTS: usize = 8;

/// What goes round.
pub struct Bounces<'a> {
    /// Nodes.
    pub tree: &'a Tree,
    /// Clusters.
    pub clusters: &'a Clusters,
    /// What receives.
    pub coarse: &'a mut Coarse,
    /// By which links.
    pub kept: &'a [Vec<Kept>],
    /// s, of every node and cluster.
    pub glow: Vec<Glow>,
    /// How often light was sent.
    pub passes: u32,
}

/// What came of it, by coarse node.
#[derive(Clone)]
pub struct Over {
    /// H.
    pub received: Vec<Vec3>,
    /// What is not shot yet.
    pub unshot: Vec<Vec3>,
    /// Whether that is as little as was asked.
    pub done: bool,
}

impl Bounces<'_> {
    /// Until what is unshot, with all its bounces, is `spent` of what was first reflected. Where light
    /// grows nodes shine evenly.
    ///
    /// Errors: those of `go_on`, asked before each bounce.
    pub fn spend(&mut self, spent: f64, go_on: &mut dyn FnMut() -> Result<()>) -> Result<Over> {
        let source = self.glow.clone();
        if let Some(over) = self.bounces(spent, go_on)? {
            return Ok(over);
        }
        self.coarse.flat = true;
        self.glow = source;
        let over = self.bounces(spent, go_on)?;
        over.ok_or_else(|| Error::Fault("light grows from bounce to bounce".into()))
    }

    /// The same; none where it grows.
    fn bounces(
        &mut self,
        spent: f64,
        go_on: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Option<Over>> {
        let mut received = self.arrived();
        let mut unshot = self.coarse.reflected(&received);
        let first = self.coarse.power(&unshot);
        let (mut left, mut share) = (first, 0.0);
        for bounce in 0..PLAIN {
            // What is unshot counts with all its bounces: 1 + q + q² + …
            if left <= spent * first * (1.0 - share) {
                return Ok(Some(Over {
                    received,
                    unshot,
                    done: true,
                }));
            }
            go_on()?;
            let step = self.sent(&unshot);
            received = sum(&received, &step);
            unshot = self.coarse.reflected(&step);
            let next = self.coarse.power(&unshot);
            // Nothing reflects all of it.
            if !next.is_finite() || bounce >= PLAIN / 2 && next >= left {
                return Ok(None);
            }
            share = (next / left).min(0.99);
            left = next;
        }
        let rest = self.rest(&unshot, spent * first, go_on)?;
        Ok(Some(Over {
            received: sum(&received, &rest.received),
            ..rest
        }))
    }

    /// What arrives of the glow.
    fn arrived(&mut self) -> Vec<Vec3> {
        self.passes += 1;
        self.coarse.received(&exchange(self.kept, &self.glow))
    }

    /// What arrives of `unshot`.
    fn sent(&mut self, unshot: &[Vec3]) -> Vec<Vec3> {
        self.coarse.glow(self.tree, unshot, &mut self.glow);
        self.clusters.pull(self.tree, &mut self.glow);
        self.arrived()
    }

    /// All that arrives of `unshot` in the end: (1 − Kρ) x = K·unshot, each channel by itself.
    fn rest(
        &mut self,
        unshot: &[Vec3],
        enough: f64,
        go_on: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Over> {
        let b = in_f64(&self.sent(unshot));
        let mut x = vec![DVec3::ZERO; b.len()];
        let mut left = b.clone();
        for _ in 0..STARTS {
            if self.power(&left) <= enough {
                break;
            }
            let step = self.directions(&left, enough, go_on)?;
            x = x.iter().zip(step).map(|(x, step)| *x + step).collect();
            let again = self.without_sent(&x);
            left = b.iter().zip(again).map(|(b, own)| *b - own).collect();
        }
        Ok(Over {
            done: self.power(&left) <= enough,
            received: in_f32(&x),
            unshot: self.coarse.reflected(&in_f32(&left)),
        })
    }

    /// (1 − Kρ) x.
    fn without_sent(&mut self, x: &[DVec3]) -> Vec<DVec3> {
        let reflected = self.coarse.reflected(&in_f32(x));
        let sent = self.sent(&reflected);
        x.iter()
            .zip(sent)
            .map(|(x, sent)| *x - sent.as_dvec3())
            .collect()
    }

    fn power(&self, received: &[DVec3]) -> f64 {
        self.coarse.power(&self.coarse.reflected(&in_f32(received)))
    }

    /// The x of a few directions that leaves least of `b`.
    fn directions(
        &mut self,
        b: &[DVec3],
        enough: f64,
        go_on: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Vec<DVec3>> {
        let length = norm(b);
        let first = self.power(b);
        let mut basis = vec![scaled(b, inverse(length))];
        let mut columns: Vec<Vec<DVec3>> = Vec::new();
        let mut turns: Vec<[DVec3; 2]> = Vec::new();
        let mut right = vec![length];
        for j in 0..DIRECTIONS {
            go_on()?;
            let mut w = self.without_sent(&basis[j]);
            let mut column = Vec::with_capacity(j + 2);
            for v in &basis {
                let h = dot(&w, v);
                w = w.iter().zip(v).map(|(w, v)| *w - h * *v).collect();
                column.push(h);
            }
            let h = norm(&w);
            basis.push(scaled(&w, inverse(h)));
            column.push(h);
            for (i, [c, s]) in turns.iter().enumerate() {
                let (above, below) = (column[i], column[i + 1]);
                column[i] = *c * above + *s * below;
                column[i + 1] = *c * below - *s * above;
            }
            let (above, below) = (column[j], column[j + 1]);
            let turn = inverse((above * above + below * below).map(f64::sqrt));
            let [c, s] = [above * turn, below * turn];
            column[j] = c * above + s * below;
            column.truncate(j + 1);
            columns.push(column);
            turns.push([c, s]);
            right.push(-s * right[j]);
            right[j] *= c;
            let share = (right[j + 1].abs() * inverse(length)).max_element();
            if share * first <= enough {
                break;
            }
        }
        let mut y = vec![DVec3::ZERO; columns.len()];
        for i in (0..columns.len()).rev() {
            let known: DVec3 = (i + 1..columns.len()).map(|k| columns[k][i] * y[k]).sum();
            y[i] = (right[i] - known) * inverse(columns[i][i]);
        }
        let mut x = vec![DVec3::ZERO; b.len()];
        for (y, v) in y.iter().zip(&basis) {
            x = x.iter().zip(v).map(|(x, v)| *x + *y * *v).collect();
        }
        Ok(x)
    }
}

/// 1/v; 0 of 0.
fn inverse(v: DVec3) -> DVec3 {
    v.map(|v| if v == 0.0 { 0.0 } else { 1.0 / v })
}

fn dot(a: &[DVec3], b: &[DVec3]) -> DVec3 {
    a.iter().zip(b).map(|(a, b)| *a * *b).sum()
}

fn norm(a: &[DVec3]) -> DVec3 {
    dot(a, a).map(f64::sqrt)
}

fn scaled(a: &[DVec3], by: DVec3) -> Vec<DVec3> {
    a.iter().map(|a| *a * by).collect()
}

fn in_f64(a: &[Vec3]) -> Vec<DVec3> {
    a.iter().map(|a| a.as_dvec3()).collect()
}

fn in_f32(a: &[DVec3]) -> Vec<Vec3> {
    a.iter().map(|a| a.as_vec3()).collect()
}

fn sum(a: &[Vec3], b: &[Vec3]) -> Vec<Vec3> {
    a.iter().zip(b).map(|(a, b)| *a + *b).collect()
}
