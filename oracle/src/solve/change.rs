//! What a step of a solve to an error changed.

use super::check::NAMED;
use super::sides::{Asked, averaged, order, squares};
use super::step::Step;
use crate::judge::diff::reflected::offsets;
use common::scene::Scene;
use glam::DVec3;

/// What a step changed of B, of the RMS of B − E, in the worst channel.
pub struct Change {
    /// Of all.
    pub whole: f64,
    /// Squared, by face; they add up to the whole.
    pub faces: Vec<f64>,
    /// That channel, and 1/∫ (B − E)² dA of it.
    pub channel: usize,
    /// See `channel`.
    pub scale: f64,
    /// ∫ (B − E)² dA of each face in that channel.
    pub light: Vec<f64>,
    /// Texels a side of each face on which the two were compared.
    pub sides: Vec<u32>,
    /// The square of what changed of B on each, by channel.
    pub squares: Vec<DVec3>,
}

impl Change {
    /// From `before` to `after`; what differs within texels that are asked for is not asked.
    pub fn new(scene: &Scene, before: &Step, after: &Step, asked: Asked) -> Self {
        let firsts = [before, after].map(|step| offsets(&squares(&step.sides)));
        let (mut faces, mut lights) = (Vec::new(), Vec::new());
        let (mut sides, mut squares) = (Vec::new(), Vec::new());
        for (f, face) in scene.faces.iter().enumerate() {
            let side = before.sides[f].min(after.sides[f]);
            let side = asked(f).map_or(side, |texels| side.min(texels));
            let [a, b] = [(before, &firsts[0]), (after, &firsts[1])].map(|(step, first)| {
                let own = &step.radiosity[first[f]..first[f + 1]];
                averaged(own, face, step.sides[f], side)
            });
            let light = &after.reflected[firsts[1][f]..firsts[1][f + 1]];
            let light = averaged(light, face, after.sides[f], side);
            let area = face.area() / f64::from(side).powi(2);
            let changed = a.iter().zip(&b).map(|(a, b)| (b - a) * (b - a));
            squares.extend(changed);
            faces.push(area * squares[squares.len() - a.len()..].iter().sum::<DVec3>());
            lights.push(area * light.iter().map(|b| *b * *b).sum::<DVec3>());
            sides.push(side);
        }
        let light: DVec3 = lights.iter().sum();
        let share = |c: usize| {
            let all: f64 = faces.iter().map(|own: &DVec3| own[c]).sum();
            if all == 0.0 { 0.0 } else { all / light[c] }
        };
        let worst = (0..3)
            .max_by(|a, b| share(*a).total_cmp(&share(*b)))
            .unwrap_or(0);
        let scale = if light[worst] > 0.0 {
            1.0 / light[worst]
        } else {
            0.0
        };
        Self {
            whole: share(worst).sqrt(),
            faces: faces.iter().map(|own| own[worst] * scale).collect(),
            channel: worst,
            scale,
            light: lights.iter().map(|own: &DVec3| own[worst]).collect(),
            sides,
            squares,
        }
    }

    /// What changed of face `f`, of the RMS of its own light.
    pub fn own(&self, f: u32) -> f64 {
        let all = self.light[f as usize] * self.scale;
        let own = self.faces[f as usize];
        if all > 0.0 { (own / all).sqrt() } else { 0.0 }
    }

    /// The faces that changed most.
    pub fn worst(&self) -> Vec<u32> {
        let mut order = order(&self.faces);
        order.retain(|f| self.faces[*f as usize] > 0.0);
        order.truncate(NAMED);
        order
    }
}
