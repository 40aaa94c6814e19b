//! Requirements of what several readers return.

use common::mesh::Mesh;
use common::scene::{Scene, Shape};
use common::solution::StoredSolution;
use glam::Vec3;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// Largest number of faces of which a mesh is made: what is more takes too long for each of many inputs.
const MAX_MESHED_FACES: usize = 48;

/// Emitted radiosity that can be solved, W/m²; `common::import` states the reasons.
const SOLVABLE_EMISSION: RangeInclusive<f32> = 1e-12..=1e12;

/// Requires that an error is one line of visible text.
pub fn require_one_line(error: &dyn Display) {
    let text = error.to_string();
    assert!(!text.trim().is_empty() && !text.contains(char::is_control), "{text:?}");
}

/// Requires of a scene file's scene that faces, names and light are within their limits, and that a mesh can be made.
pub fn require_sound_scene(scene: &Scene) {
    require_sound_faces(scene);
    for face in &scene.faces {
        assert!(is_solvable(face.emission), "{face:?}");
        let [reflectance, emission] = face.mean_surface(face.outline());
        assert!(is_reflectance(reflectance) && is_emission(emission), "{face:?}");
    }
    for sun in scene.sky.iter().flat_map(|sky| &sky.suns) {
        assert!(sun.direction.is_normalized() && is_emission(sun.irradiance), "{sun:?}");
    }
    if scene.faces.len() <= MAX_MESHED_FACES {
        let mesh = Mesh::uniform(scene, 2, 1).expect("a mesh of a scene that was accepted");
        for texel in &mesh.texels {
            assert!(texel.position.abs().max_element() <= 1.001, "{texel:?}");
            assert!(texel.area >= 0.0 && texel.area.is_finite(), "{texel:?}");
            assert!(
                is_reflectance(texel.reflectance) && is_emission(texel.emission),
                "{texel:?}"
            );
        }
    }
}

/// Requires of any scene that was read that its corners, references, reflectances and names are within their limits.
pub fn require_sound_faces(scene: &Scene) {
    assert!(!scene.faces.is_empty());
    let texts = scene.notes.iter().chain([&scene.name]);
    let texts = texts.chain(scene.faces.iter().map(|face| &face.name));
    for text in texts {
        assert!(!text.contains(char::is_control), "{text:?}");
    }
    for (k, face) in scene.faces.iter().enumerate() {
        assert!(face.corners.iter().all(|corner| corner.is_finite()), "{face:?}");
        assert!(
            face.shape == Shape::Quad || face.corners[2] == face.corners[3],
            "{face:?}"
        );
        assert!(
            is_reflectance(face.reflectance) && face.emission.is_finite(),
            "{face:?}"
        );
        assert!(face.rounding >= 0.0 && face.vector_area().is_finite(), "{face:?}");
        let exists = |other: u32| (other as usize) < scene.faces.len();
        assert!(face.input_face.is_none_or(exists), "{face:?}");
        let back = |other: u32| scene.faces[other as usize].partner == Some(k as u32);
        assert!(
            face.partner.is_none_or(|other| exists(other) && back(other)),
            "{face:?}"
        );
    }
}

/// Requires of a stored solution that every texel has values that can be compared.
pub fn require_sound_solution(stored: &StoredSolution) {
    require_sound_faces(&stored.scene);
    let faces = stored.scene.faces.len();
    let count = stored.texel_range(faces - 1).end;
    assert_eq!((stored.resolutions.len(), stored.radiosity.len()), (faces, count));
    assert_eq!(stored.emission.len(), count);
    let others = stored.others.values().inspect(|values| assert_eq!(values.len(), count));
    let all = stored.radiosity.iter().chain(&stored.emission).chain(others.flatten());
    for value in all {
        assert!(value.is_finite() && value.length_squared().is_finite(), "{value}");
    }
}

/// Returns whether a reflectance is at least 0 and below 1 in every channel.
pub fn is_reflectance(reflectance: Vec3) -> bool {
    (reflectance.cmpge(Vec3::ZERO) & reflectance.cmplt(Vec3::ONE)).all()
}

fn is_emission(emission: Vec3) -> bool {
    emission.cmpge(Vec3::ZERO).all() && emission.is_finite()
}

fn is_solvable(emission: Vec3) -> bool {
    let largest = emission.max_element();
    is_emission(emission) && (largest == 0.0 || SOLVABLE_EMISSION.contains(&largest))
}
