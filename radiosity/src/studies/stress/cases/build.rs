//! Builds the trials of the cases.

use super::shapes::{
    box_faces, cut_face, grey_square, lamp_above, move_faces, plate_at, scene_of, tilt_faces, unit_floor, unit_room,
};
use crate::studies::stress::trial::{Trial, TrialTruth};
use common::Result;
use common::scene::Face;
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Texels per side in cases with an exact truth.
const TEXELS_PER_SIDE: u32 = 8;
/// Texels per side in cases whose truth is the dense solver's, or that are closed rooms.
const FEWER_TEXELS: u32 = 6;
/// Gap up to which the truth is that of a touching block, in sides of the room: there the dense solver
/// errs by several per cent, in the visible shares of texels that are half covered.
const TOUCHING_GAP: f64 = 1e-3;

/// Makes a trial of direct light without shadows.
pub fn direct_trial(faces: Vec<Face>) -> Result<Trial> {
    shadowed_trial(faces, 0..0)
}

/// Makes a trial of direct light in which `occluders` may hide the lamps.
pub fn shadowed_trial(faces: Vec<Face>, occluders: Range<usize>) -> Result<Trial> {
    Ok(Trial::new(
        scene_of(faces),
        TEXELS_PER_SIDE,
        TrialTruth::Direct(occluders),
    ))
}

/// Makes a trial whose truth is the dense solver's for `same`, which must have the same solution.
pub fn dense_trial(faces: Vec<Face>, same: Vec<Face>) -> Trial {
    Trial::new(scene_of(faces), FEWER_TEXELS, TrialTruth::Dense(scene_of(same)))
}

/// Builds a floor and a wall under a lamp with copies of the floor, which might exchange light twice.
pub fn copies_trial(count: f64) -> Result<Trial> {
    let wall = grey_square([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], 0.5);
    let plain = vec![unit_floor(), wall, lamp_above([0.5, 0.5, 1.0], [0.8; 2], 1.0)];
    let copies = vec![unit_floor(); count as usize];
    Ok(Trial {
        texels: TEXELS_PER_SIDE,
        judged: 0..2,
        ..dense_trial([plain.clone(), copies].concat(), plain)
    })
}

/// Builds a room under an emitting ceiling with one wall cut into strips; the other faces are judged.
pub fn strips_trial(count: f64) -> Result<Trial> {
    let mut faces = unit_room(0.6);
    faces[1].emission = Vec3::ONE;
    let wall = faces.remove(2);
    let room = |walls: Vec<Face>| tilt_faces([faces.clone(), walls].concat());
    Ok(Trial {
        judged: 0..5,
        ..dense_trial(room(cut_face(&wall, [count as usize, 1])), room(vec![wall]))
    })
}

/// Makes a floor, a lamp above it, and between them two plates that leave `width` open.
pub fn slit_faces(width: f64) -> Vec<Face> {
    let half = |x: f64| plate_at([x, 0.5, 0.5], [1.0, 2.0], 0.0);
    let lamp = lamp_above([0.5, 0.5, 1.0], [1.0; 2], 1.0);
    vec![unit_floor(), lamp, half(-width / 2.0), half(1.0 + width / 2.0)]
}

/// Builds two adjacent rooms with a door of full height between them. Only the far wall of the second
/// room reflects, and all its light comes through the door.
pub fn door_trial(width: f64) -> Result<Trial> {
    let mut first = unit_room(0.0);
    let mut second = box_faces([1.0, 0.0, 0.0], [2.0, 1.0, 1.0], true, 0.0);
    first[2].emission = Vec3::ONE;
    second[3].reflectance = Vec3::splat(0.5);
    let (up, across) = ([0.0, 0.0, 1.0], [0.0, (1.0 - width) / 2.0, 0.0]);
    let halves = [0.0, (1.0 + width) / 2.0].map(|y| grey_square([1.0, y, 0.0], up, across, 0.0));
    let backs = halves.each_ref().map(Face::reversed);
    first.remove(3);
    second.remove(2);
    shadowed_trial([halves.into(), backs.into(), first, second].concat(), 0..2)
}

/// Builds a lit room and a dark one beside it, which is judged.
pub fn wall_trial(thickness: f64) -> Result<Trial> {
    let mut faces = unit_room(0.0);
    faces[1].emission = Vec3::ONE;
    faces[3].reflectance = Vec3::splat(0.7);
    let (low, high) = ([1.0 + thickness, 0.0, 0.0], [2.0 + thickness, 1.0, 1.0]);
    faces.extend(box_faces(low, high, true, 0.9));
    Ok(dark_trial(faces, 6..12))
}

/// Builds a closed box under a lamp, its left wall in strips; the inside is judged.
pub fn cracks_trial(count: f64) -> Result<Trial> {
    let mut faces = unit_room(0.9);
    let wall = faces.remove(2);
    faces.extend(cut_face(&wall, [count as usize, 1]));
    let inside = 0..faces.len();
    faces.push(lamp_above([0.2, 0.4, 2.0], [3.0; 2], 1.0));
    Ok(dark_trial(faces, inside))
}

fn dark_trial(faces: Vec<Face>, judged: Range<usize>) -> Trial {
    Trial {
        judged,
        ..Trial::new(scene_of(tilt_faces(faces)), FEWER_TEXELS, TrialTruth::Dark)
    }
}

/// Builds a unit cube whose walls, n×n faces each, all emit 1 and have one reflectance.
pub fn furnace_trial(n: usize, reflectance: f32, texels: u32) -> Result<Trial> {
    let walls = unit_room(reflectance);
    let mut faces: Vec<Face> = walls.iter().flat_map(|wall| cut_face(wall, [n; 2])).collect();
    for face in &mut faces {
        face.emission = Vec3::ONE;
    }
    // B − E = ρE/(1 − ρ), with ρ rounded to f32 as in the solvers.
    let rho = f64::from(reflectance);
    let truth = TrialTruth::Constant(DVec3::splat(rho / (1.0 - rho)));
    Ok(Trial::new(scene_of(faces), texels, truth))
}

/// Builds a room under an emitting ceiling with a plate in it, moved; its truth is that of the room at
/// its place. Some walls are black, since each shooting face costs an item buffer per patch and sample.
pub fn plain_trial(to: impl Fn(DVec3) -> DVec3) -> Result<Trial> {
    let mut room = unit_room(0.0);
    room[1].emission = Vec3::ONE;
    room[0].reflectance = Vec3::splat(0.6);
    room[2].reflectance = Vec3::splat(0.6);
    room.push(plate_at([0.47, 0.54, 0.37], [0.4; 2], 0.6));
    Ok(dense_trial(move_faces(room.clone(), to), room))
}

/// Makes a floor, a wall and an emitting ceiling, which take half the time of a closed room.
pub fn open_room() -> Vec<Face> {
    let mut faces = unit_room(0.5);
    faces[1].emission = Vec3::ONE;
    faces[1].reflectance = Vec3::ZERO;
    let back = faces.remove(5);
    faces.truncate(2);
    faces.push(back);
    faces
}

/// Makes a block of side 0.3 whose bottom is at `height`.
pub fn relit_block(height: f64, reflectance: f32) -> Vec<Face> {
    box_faces([0.31, 0.37, height], [0.61, 0.67, height + 0.3], false, reflectance)
}

/// Makes a trial of an object in a room.
pub fn relight_trial(room: Vec<Face>, object: Vec<Face>) -> Result<Trial> {
    let first = room.len();
    let all = [room, object].concat();
    Ok(Trial {
        room: first,
        ..dense_trial(all.clone(), all)
    })
}

/// Builds the trial of a block at a gap above the floor.
pub fn object_on_floor(gap: f64) -> Result<Trial> {
    let trial = relight_trial(open_room(), relit_block(gap, 0.5))?;
    if gap > TOUCHING_GAP {
        return Ok(trial);
    }
    let touching = [open_room(), relit_block(0.0, 0.5)].concat();
    Ok(Trial {
        truth: TrialTruth::Dense(scene_of(touching)),
        ..trial
    })
}
