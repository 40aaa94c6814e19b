//! Converts panels to faces: quads, triangles or both.

use super::loft::{Panel, SheetSides};
use super::{FaceShapes, RandomSource};
use common::scene::Face;
use glam::DVec3;
use rand::RngExt;

/// Returns the faces of all panels, the backs of two-sided sheets last, as an import does.
pub fn faces_of_panels(source: &mut RandomSource, panels: &[Panel], faces: FaceShapes) -> Vec<Face> {
    let mut all: Vec<Face> = Vec::new();
    let mut backs: Vec<Face> = Vec::new();
    for panel in panels {
        let pieces = split_panel(source, panel, faces);
        for (k, piece) in (all.len() as u32..).zip(&pieces) {
            backs.extend((panel.two_sided == Some(SheetSides::Partners)).then(|| Face {
                input_face: Some(k),
                partner: Some(k),
                ..piece.reversed()
            }));
        }
        all.extend(pieces);
        if panel.two_sided == Some(SheetSides::Coinciding) {
            let [a, b, c, d] = panel.corners;
            let back = Panel {
                corners: [a, d, c, b],
                ..panel.clone()
            };
            all.extend(split_panel(source, &back, faces));
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

fn split_panel(source: &mut RandomSource, panel: &Panel, faces: FaceShapes) -> Vec<Face> {
    let whole = panel.to_face();
    let split = match faces {
        FaceShapes::Quads => false,
        FaceShapes::Triangles => true,
        FaceShapes::Mixed => source.random_bool(0.5),
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
