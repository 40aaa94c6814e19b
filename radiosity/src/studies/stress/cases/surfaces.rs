//! Cases of defective surfaces: coincident, intersecting, without thickness, bent, without area, or
//! missing.

use super::shapes::{
    box_faces, grey_square, import_text, lamp_above, plate_at, scene_of, tilt_scene, unit_floor, wall_strips,
};
use super::{FINER_TRUTH, LAMBERT_TRUTH, SHADOW_TRUTH, rms_case};
use crate::studies::stress::trial::{Case, Trial, TrialTruth};
use common::Result;
use common::scene::{Face, Scene};
use glam::{DVec3, Vec3};

const TEXELS_PER_SIDE: u32 = 8;
/// Texels per side in cases whose truth is the dense solver's.
const FEWER_TEXELS: u32 = 6;

/// The cases of this file.
pub const SURFACE_CASES: &[Case] = &[
    rms_case(
        ["coplanar", "distance of two fronts / size"],
        "which of two fronts at one place is lit",
        SHADOW_TRUTH,
        &[0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
        |distance| {
            let patch = plate_at([0.45, 0.55, distance], [0.5; 2], 0.5);
            let faces = vec![unit_floor(), patch, lamp_above([0.5, 0.5, 1.0], [0.8; 2], 1.0)];
            shadowed_trial(faces, vec![1])
        },
    ),
    rms_case(
        ["duplicate", "copies of the floor"],
        "the same face twice",
        "the matrix solver without the copies, on texels twice as fine, averaged",
        &[0.0, 1.0, 2.0, 4.0, 9.0],
        copies_trial,
    ),
    rms_case(
        ["intersecting", "walls through the floor"],
        "texels that a wall cuts in two",
        SHADOW_TRUTH,
        &[1.0, 2.0, 4.0, 8.0, 16.0],
        |walls| {
            let mut faces = vec![unit_floor(), lamp_above([0.5, 0.5, 1.0], [0.6; 2], 1.0)];
            for k in 0..walls as usize {
                let x = (k as f64 + 0.43) / walls;
                faces.push(grey_square([x, -0.1, -0.2], [0.0, 1.2, 0.0], [0.02, 0.0, 0.4], 0.0));
            }
            let occluders = (2..faces.len()).collect();
            shadowed_trial(faces, occluders)
        },
    ),
    rms_case(
        ["thin-sheet", "thickness / size"],
        "two fronts back to back: light through the sheet",
        LAMBERT_TRUTH,
        &[0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 0.0],
        |thickness| {
            let mut faint = unit_floor();
            (faint.emission, faint.reflectance) = (Vec3::splat(0.01), Vec3::ZERO);
            let above = plate_at([0.5, 0.5, 0.5 + thickness / 2.0], [0.6; 2], 0.5);
            let below = plate_at([0.5, 0.5, 0.5 - thickness / 2.0], [0.6; 2], 0.5).reversed();
            let faces = vec![faint, lamp_above([0.5, 0.5, 1.0], [0.8; 2], 1.0), above, below];
            Ok(Trial::new(scene_of("sheet", faces), TEXELS_PER_SIDE, TrialTruth::Direct).with_judged([3]))
        },
    ),
    rms_case(
        ["back-face", "height of the blocker / size"],
        "black backs that must block, down to contact",
        SHADOW_TRUTH,
        &[0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        |height| {
            let blocker = plate_at([0.47, 0.54, height], [0.4; 2], 0.0);
            let faces = vec![unit_floor(), blocker, lamp_above([0.5, 0.5, 1.0], [0.3; 2], 1.0)];
            shadowed_trial(faces, vec![1])
        },
    ),
    rms_case(
        ["t-vertices", "strips of a wall"],
        "cracks where the edges of neighbours do not meet at corners",
        "the matrix solver with the wall in one piece, on texels twice as fine, averaged",
        &[2.0, 3.0, 4.0, 6.0, 8.0],
        strips_trial,
    ),
    rms_case(
        ["non-planar", "a corner below the plane / size"],
        "quads whose corners are not in one plane",
        LAMBERT_TRUTH,
        &[0.0, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.3],
        |bend| {
            let obj = format!(
                "mtllib m.mtl\nv 0 0 0\nv 1 0 -{bend}\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 0 1 1\nv 1 1 1\nv 1 0 1\n\
                 usemtl floor\nf 1 2 3 4\nusemtl lamp\nf 5 6 7 8\n"
            );
            let mtl = "newmtl floor\nKd .5 .5 .5\nnewmtl lamp\nKd 0 0 0\nKe 1 1 1\n";
            let scene = import_text("non-planar", &obj, mtl)?;
            Ok(Trial::new(scene, TEXELS_PER_SIDE, TrialTruth::Direct))
        },
    ),
    rms_case(
        ["degenerate", "height of a triangle / its base"],
        "faces with no area, or nearly none",
        SHADOW_TRUTH,
        &[0.1, 1e-3, 1e-6, 1e-9, 1e-12, 0.0],
        |height| {
            let corners = [[0.2, 0.5, 0.3], [0.8, 0.5, 0.3], [0.5, 0.5 + height, 0.3]];
            let thin = Face::triangle("thin", corners.map(DVec3::from), Vec3::ZERO, Vec3::ZERO);
            let faces = vec![unit_floor(), lamp_above([0.5, 0.5, 1.0], [0.8; 2], 1.0), thin];
            shadowed_trial(faces, vec![2])
        },
    ),
    rms_case(
        ["open", "faces missing of six"],
        "open scenes, a single face, and none",
        FINER_TRUTH,
        &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        |missing| {
            let mut faces = box_faces([0.0; 3], [1.0; 3], true, 0.6);
            faces.swap(0, 1);
            faces[0].emission = Vec3::ONE;
            faces.truncate(6 - missing as usize);
            Ok(Trial::new(scene_of("open", faces), FEWER_TEXELS, TrialTruth::Matrix(2)))
        },
    ),
];

fn shadowed_trial(faces: Vec<Face>, occluders: Vec<usize>) -> Result<Trial> {
    let truth = TrialTruth::Shadowed(occluders);
    Ok(Trial::new(scene_of("surfaces", faces), TEXELS_PER_SIDE, truth))
}

/// Builds a floor and a wall under a lamp with copies of the floor, which might exchange light twice.
fn copies_trial(count: f64) -> Result<Trial> {
    let wall = grey_square([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], 0.5);
    let plain = vec![unit_floor(), wall, lamp_above([0.5, 0.5, 1.0], [0.8; 2], 1.0)];
    let mut faces = plain.clone();
    faces.extend(vec![unit_floor(); count as usize]);
    let truth = TrialTruth::Alike(scene_of("without copies", plain), 2);
    Ok(Trial::new(scene_of("duplicate", faces), TEXELS_PER_SIDE, truth).with_judged([0, 1]))
}

/// Builds a room under an emitting ceiling with one wall cut into strips; the other faces are judged.
fn strips_trial(count: f64) -> Result<Trial> {
    let mut faces = box_faces([0.0; 3], [1.0; 3], true, 0.6);
    faces[1].emission = Vec3::ONE;
    let wall = faces.remove(2);
    let room = |walls: Vec<Face>| -> Scene { tilt_scene(scene_of("strips", [faces.clone(), walls].concat())) };
    let cut = room(wall_strips(&wall, count));
    let truth = TrialTruth::Alike(room(vec![wall.clone()]), 2);
    Ok(Trial::new(cut, FEWER_TEXELS, truth).with_judged(0..5))
}
