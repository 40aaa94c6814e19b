//! Panels as faces: quads, triangles, some of each.

use super::loft::{Panel, Sheet};
use super::{Faces, Source};
use common::scene::Face;
use glam::DVec3;
use rand::RngExt;

/// The faces of all panels; the backs of two-sided sheets come last, as an import has them.
pub fn of(source: &mut Source, panels: &[Panel], faces: Faces) -> Vec<Face> {
    let mut all: Vec<Face> = Vec::new();
    let mut backs: Vec<Face> = Vec::new();
    for panel in panels {
        let pieces = cut(source, panel, faces);
        for (k, piece) in (all.len() as u32..).zip(&pieces) {
            backs.extend((panel.two_sided == Some(Sheet::Partners)).then(|| Face {
                from: Some(k),
                partner: Some(k),
                ..piece.reversed()
            }));
        }
        all.extend(pieces);
        if panel.two_sided == Some(Sheet::Coinciding) {
            let [a, b, c, d] = panel.corners;
            let back = Panel {
                corners: [a, d, c, b],
                ..panel.clone()
            };
            all.extend(cut(source, &back, faces));
        }
    }
    for back in backs {
        let k = all.len() as u32;
        if let Some(front) = back.partner {
            all[front as usize].partner = Some(k);
        }
        all.push(back);
    }
    all
}

fn cut(source: &mut Source, panel: &Panel, faces: Faces) -> Vec<Face> {
    let whole = panel.face();
    let split = match faces {
        Faces::Quads => false,
        Faces::Triangles => true,
        Faces::Mixed => source.random_bool(0.5),
    };
    if !split {
        return vec![whole];
    }
    let [a, b, c, d] = whole.corners;
    let halves = if source.random_bool(0.5) {
        [[a, b, c], [a, c, d]]
    } else {
        [[a, b, d], [b, c, d]]
    };
    let mut half = |mut corners: [DVec3; 3]| {
        corners.rotate_left(source.random_range(0..3));
        Face::triangle(&whole.name, corners, whole.emission, whole.reflectance)
    };
    halves.map(&mut half).into()
}
