//! Surfaces as files have them: on each other, through each other, without thickness, bent, without
//! area, or missing.

use super::shapes::{cuboid, imported, lamp_above, plate, scene, square, tilted, unit};
use super::{FINER, LAMBERT, SHADOWS, case};
use crate::study::stress::trial::{Case, Trial, Truth};
use common::Result;
use common::scene::{Face, Scene};
use glam::{DVec3, Vec3};

const TEXELS: u32 = 8;
/// Of those whose truth is the matrix's.
const FEWER: u32 = 6;

/// The cases.
pub const CASES: &[Case] = &[
    case(
        ["coplanar", "distance of two fronts / size"],
        "which of two fronts at one place is lit",
        SHADOWS,
        &[0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
        |distance| {
            let patch = plate([0.45, 0.55, distance], [0.5; 2], 0.5);
            let faces = vec![unit(), patch, lamp_above([0.5, 0.5, 1.0], [0.8; 2], 1.0)];
            shaded(faces, vec![1])
        },
    ),
    case(
        ["duplicate", "copies of the floor"],
        "the same face twice",
        "the matrix solver without the copies, on texels twice as fine, averaged",
        &[0.0, 1.0, 2.0, 4.0, 9.0],
        copies,
    ),
    case(
        ["intersecting", "walls through the floor"],
        "texels that a wall cuts in two",
        SHADOWS,
        &[1.0, 2.0, 4.0, 8.0, 16.0],
        |walls| {
            let mut faces = vec![unit(), lamp_above([0.5, 0.5, 1.0], [0.6; 2], 1.0)];
            for k in 0..walls as usize {
                let x = (k as f64 + 0.43) / walls;
                faces.push(square(
                    [x, -0.1, -0.2],
                    [0.0, 1.2, 0.0],
                    [0.02, 0.0, 0.4],
                    0.0,
                ));
            }
            let occluders = (2..faces.len()).collect();
            shaded(faces, occluders)
        },
    ),
    case(
        ["thin-sheet", "thickness / size"],
        "two fronts back to back: light through the sheet",
        LAMBERT,
        &[0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 0.0],
        |thickness| {
            let mut faint = unit();
            (faint.emission, faint.reflectance) = (Vec3::splat(0.01), Vec3::ZERO);
            let above = plate([0.5, 0.5, 0.5 + thickness / 2.0], [0.6; 2], 0.5);
            let below = plate([0.5, 0.5, 0.5 - thickness / 2.0], [0.6; 2], 0.5).reversed();
            let faces = vec![
                faint,
                lamp_above([0.5, 0.5, 1.0], [0.8; 2], 1.0),
                above,
                below,
            ];
            Ok(Trial::new(scene("sheet", faces), TEXELS, Truth::Direct).judging([3]))
        },
    ),
    case(
        ["back-face", "height of the blocker / size"],
        "black backs that must block, down to contact",
        SHADOWS,
        &[0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        |height| {
            let blocker = plate([0.47, 0.54, height], [0.4; 2], 0.0);
            let faces = vec![unit(), blocker, lamp_above([0.5, 0.5, 1.0], [0.3; 2], 1.0)];
            shaded(faces, vec![1])
        },
    ),
    case(
        ["t-vertices", "strips of a wall"],
        "cracks where the edges of neighbours do not meet at corners",
        "the matrix solver with the wall in one piece, on texels twice as fine, averaged",
        &[2.0, 3.0, 4.0, 6.0, 8.0],
        strips,
    ),
    case(
        ["non-planar", "a corner below the plane / size"],
        "quads whose corners are not in one plane",
        LAMBERT,
        &[0.0, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.3],
        |bend| {
            let obj = format!(
                "mtllib m.mtl\nv 0 0 0\nv 1 0 -{bend}\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 0 1 1\nv 1 1 1\nv 1 0 1\n\
                 usemtl floor\nf 1 2 3 4\nusemtl lamp\nf 5 6 7 8\n"
            );
            let mtl = "newmtl floor\nKd .5 .5 .5\nnewmtl lamp\nKd 0 0 0\nKe 1 1 1\n";
            let scene = imported("non-planar", &obj, mtl)?;
            Ok(Trial::new(scene, TEXELS, Truth::Direct))
        },
    ),
    case(
        ["degenerate", "height of a triangle / its base"],
        "faces with no area, or nearly none",
        SHADOWS,
        &[0.1, 1e-3, 1e-6, 1e-9, 1e-12, 0.0],
        |height| {
            let corners = [[0.2, 0.5, 0.3], [0.8, 0.5, 0.3], [0.5, 0.5 + height, 0.3]];
            let thin = Face::triangle("thin", corners.map(DVec3::from), Vec3::ZERO, Vec3::ZERO);
            let faces = vec![unit(), lamp_above([0.5, 0.5, 1.0], [0.8; 2], 1.0), thin];
            shaded(faces, vec![2])
        },
    ),
    case(
        ["open", "faces missing of six"],
        "open scenes, a single face, and none",
        FINER,
        &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        |missing| {
            let mut faces = cuboid([0.0; 3], [1.0; 3], true, 0.6);
            faces.swap(0, 1);
            faces[0].emission = Vec3::ONE;
            faces.truncate(6 - missing as usize);
            Ok(Trial::new(scene("open", faces), FEWER, Truth::Matrix(2)))
        },
    ),
];

fn shaded(faces: Vec<Face>, occluders: Vec<usize>) -> Result<Trial> {
    let truth = Truth::Shadowed(occluders);
    Ok(Trial::new(scene("surfaces", faces), TEXELS, truth))
}

/// A floor and a wall under a lamp, and the floor once more: it would be lit twice, and light the wall
/// twice.
fn copies(count: f64) -> Result<Trial> {
    let wall = square([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], 0.5);
    let plain = vec![unit(), wall, lamp_above([0.5, 0.5, 1.0], [0.8; 2], 1.0)];
    let mut faces = plain.clone();
    faces.extend(vec![unit(); count as usize]);
    let truth = Truth::Alike(scene("without copies", plain), 2);
    Ok(Trial::new(scene("duplicate", faces), TEXELS, truth).judging([0, 1]))
}

/// A room under a shining ceiling, one wall of it in strips; the other faces are judged.
fn strips(count: f64) -> Result<Trial> {
    let mut faces = cuboid([0.0; 3], [1.0; 3], true, 0.6);
    faces[1].emission = Vec3::ONE;
    let wall = faces.remove(2);
    let room =
        |walls: Vec<Face>| -> Scene { tilted(scene("strips", [faces.clone(), walls].concat())) };
    let strip = |k: usize| {
        let side = |v: f64| {
            [
                wall.point(k as f64 / count, v),
                wall.point((k as f64 + 1.0) / count, v),
            ]
        };
        let ([a, b], [d, c]) = (side(0.0), side(1.0));
        Face {
            corners: [a, b, c, d],
            ..wall.clone()
        }
    };
    let cut = room((0..count as usize).map(strip).collect());
    let truth = Truth::Alike(room(vec![wall.clone()]), 2);
    Ok(Trial::new(cut, FEWER, truth).judging(0..5))
}
