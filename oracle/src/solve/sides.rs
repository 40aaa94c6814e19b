//! Texels a side of each face, as the steps of a solve to an error have them.

use super::near::{narrow, width_of};
use crate::judge::resample::{average, pieces};
use common::Result;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use glam::DVec3;

/// Texels of the first step are as wide as this, if that is cheap: the mesh is two units wide at most.
/// Two steps on a few texels may agree by chance.
const WIDTH: f64 = 0.25;
/// So many of them reach across the smaller of two faces with a narrow gap between, and half as many along the
/// foot of a sheet.
const ACROSS: f64 = 8.0;
/// But none is narrower for that than this share of the first step's width: of a mesh of many faces most have
/// a neighbour before them.
const LEAST: f64 = 0.0625;
/// Texels that are cheap.
const CHEAP: u64 = 1 << 15;
/// So many a side of a face at most, where they follow from the light.
pub const FINEST: u32 = 64;

/// Texels a side on which a face's light is asked for; none: they follow from the light.
pub type Asked<'a> = &'a dyn Fn(usize) -> Option<u32>;

/// How wide the texels of the first step are, in the scene's unit.
pub fn width(scene: &Scene) -> Result<f64> {
    let whole = 2.0 * Mesh::uniform(scene, 1, 1)?.unit;
    let mut width = WIDTH * whole / 2.0;
    while width < whole && count(&even(scene, width, |_| 1)) > CHEAP {
        width *= 2.0;
    }
    Ok(width)
}

/// Texels a side on which a face is solved where `asked` are asked for: those, or where a tree of them would have
/// nodes of many parts a power of two, of which the answer has means. Then both of the first two steps are finer
/// than the answer: what means over other texels get wrong shows in their difference.
pub fn solved_on(asked: u32) -> u32 {
    let mut rest = asked;
    for factor in [2, 3, 5, 7] {
        while rest > 1 && rest.is_multiple_of(factor) {
            rest /= factor;
        }
    }
    if rest == 1 {
        asked
    } else {
        let next = asked.checked_next_power_of_two();
        next.map_or(u32::MAX, |next| next.saturating_mul(2))
    }
}

/// Texels a side of the first step: half as many as are asked for, and more where they would be wide.
pub fn first(scene: &Scene, asked: Asked, width: f64) -> Vec<u32> {
    let least = |f: usize| match asked(f).map(solved_on) {
        Some(n) if n.is_multiple_of(2) => n / 2,
        Some(n) => n,
        None => 1,
    };
    in_gaps(scene, even(scene, width, least), (ACROSS, LEAST * width))
}

/// Texels a side of the second: at least as many as are asked for, and more than of the first.
pub fn second(scene: &Scene, asked: Asked, width: f64, first: &[u32]) -> Vec<u32> {
    let least = |f: usize| match asked(f).map(solved_on) {
        Some(n) if first[f] < n || (first[f] == n && n % 2 == 1 && n > 1) => 2 * first[f],
        _ => first[f],
    };
    let finer = (2.0 * ACROSS, 0.5 * LEAST * width);
    in_gaps(scene, even(scene, 0.5 * width, least), finer)
}

/// Texels a side of each face: `least`, or doubled until none is wider than `width`.
fn even(scene: &Scene, width: f64, least: impl Fn(usize) -> u32) -> Vec<u32> {
    let side = |(f, face): (usize, &Face)| {
        let mut side = least(f).max(1);
        while f64::from(side) * width < width_of(face) && side < FINEST {
            side *= 2;
        }
        side
    };
    scene.faces.iter().enumerate().map(side).collect()
}

/// The same, and more where a narrow gap would be lit by texels that reach out of it and where a sheet stands, as
/// far as that is cheap.
fn in_gaps(scene: &Scene, sides: Vec<u32>, wanted: (f64, f64)) -> Vec<u32> {
    let mut widths = vec![f64::INFINITY; sides.len()];
    narrow(&scene.faces, &sides, wanted, |f, width| {
        widths[f] = widths[f].min(width);
    });
    let most = CHEAP.max(2 * count(&sides));
    let mut wider = 1.0;
    loop {
        let mut finer = sides.clone();
        for ((face, side), width) in scene.faces.iter().zip(&mut finer).zip(&widths) {
            while f64::from(*side) * width * wider < width_of(face) && *side < FINEST {
                *side *= 2;
            }
        }
        if count(&finer) <= most {
            return finer;
        }
        wider *= 2.0;
    }
}

/// How many they are on quads: on triangles as many.
pub fn count(sides: &[u32]) -> u64 {
    sides.iter().map(|side| u64::from(*side).pow(2)).sum()
}

/// Texels half as large on the faces whose `squares` are most, until the rest has `left`.
pub fn halved(
    sides: &[u32],
    squares: &[f64],
    left: f64,
    may: impl Fn(usize, u32) -> bool,
) -> Vec<u32> {
    let mut sides = sides.to_vec();
    let mut rest: f64 = squares.iter().sum();
    for f in order(squares) {
        if rest <= left {
            break;
        }
        let side = &mut sides[f as usize];
        if may(f as usize, *side) {
            *side *= 2;
        }
        rest -= squares[f as usize];
    }
    sides
}

/// The faces, the largest first.
pub fn order(squares: &[f64]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..squares.len() as u32).collect();
    order.sort_by(|a, b| squares[*b as usize].total_cmp(&squares[*a as usize]));
    order
}

/// As a mesh wants them.
pub fn squares(sides: &[u32]) -> Vec<[u32; 2]> {
    sides.iter().map(|side| [*side; 2]).collect()
}

/// Values of a face's texels on another number of them: means over areas.
pub fn averaged(values: &[DVec3], face: &Face, from: u32, to: u32) -> Vec<DVec3> {
    if from == to {
        return values.to_vec();
    }
    average(values, &pieces(face, [from; 2], [to; 2]), [to; 2])
}

#[cfg(test)]
mod tests {
    use super::solved_on;

    #[test]
    fn nodes_have_few_parts() {
        for asked in [1, 7, 8, 10, 24, 90, 100, 512] {
            assert_eq!(solved_on(asked), asked);
        }
        for (asked, solved) in [(11, 32), (29, 64), (58, 128), (1021, 2048)] {
            assert_eq!(solved_on(asked), solved);
        }
    }
}
