//! Coarser defaults for scenes of many faces: 16×16 texels and 4×4 patches suit a few dozen faces.
//!
//! Nothing changes while all links, patches × texels, can be kept ([`MAX_LINK_BYTES`], 256 faces at the defaults). Beyond,
//! patches are made fewer first (many faces are patches already), then texels, then samples. The decision depends on
//! counts and not on time, so that every machine chooses alike.

use super::SceneCounts;
use common::constants::MAX_LINK_BYTES;
use common::scene::Scene;
use common::settings::Meshing;

/// Largest number of links that can be kept.
pub const MAX_KEPT_LINKS: u64 = MAX_LINK_BYTES / 4;
/// Largest number of rays between pairs of faces with one texel each: half a minute on two processor cores.
const MAX_PAIR_RAYS: u64 = 1 << 26;

/// Returns `meshing` made coarser for a scene of many faces, and a note if it was changed. `given` tells which of
/// texels, patches and samples the user gave: these stay.
pub fn coarsen_meshing(scene: &Scene, meshing: &Meshing, given: [bool; 3]) -> (Meshing, Option<String>) {
    let [texels_given, patches_given, samples_given] = given;
    let mut found = *meshing;
    let links = |meshing: &Meshing| SceneCounts::new(scene, meshing).link_count();
    while !patches_given && found.patches > 1 && links(&found) > MAX_KEPT_LINKS {
        found.patches /= 2;
    }
    while !texels_given && found.texels > 1 && links(&found) > MAX_KEPT_LINKS {
        found.texels -= 1;
    }
    let pairs = (scene.faces.len() as u64).saturating_pow(2);
    while !samples_given && found.samples > 1 && pairs.saturating_mul(found.samples.into()) > MAX_PAIR_RAYS {
        found.samples /= 2;
    }
    let note = (found != *meshing).then(|| {
        let [now, before] = [found, *meshing].map(|m| (m.texels, m.patches, m.samples));
        let (faces, (texels, patches, samples)) = (scene.faces.len(), now);
        let options = format!("--texels {texels} --patches {patches} --samples {samples}");
        format!(
            "{faces} faces: {options} instead of {}, {} and {}",
            before.0, before.1, before.2
        )
    });
    (found, note)
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Face;
    use common::settings::SolveQuality;
    use glam::{DVec3, Vec3};

    /// Faces, the options given, and the texels, patches and samples of normal quality made coarser.
    const COARSER: &[(usize, [bool; 3], [u32; 3])] = &[
        (256, [false; 3], [16, 4, 4]),
        (257, [false; 3], [16, 2, 4]),
        (1024, [false; 3], [16, 1, 4]),
        (2188, [false; 3], [7, 1, 4]),
        (16_384, [false; 3], [1, 1, 1]),
        (100_000, [false; 3], [1, 1, 1]),
        (5000, [true, false, false], [16, 1, 2]),
        (5000, [false, true, false], [1, 4, 2]),
        (5000, [false, false, true], [3, 1, 4]),
        (5000, [true; 3], [16, 4, 4]),
    ];

    #[test]
    fn defaults_are_coarser_for_many_faces_and_given_options_stay() {
        let c = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let normal = SolveQuality::Normal.meshing();
        for (count, given, expected) in COARSER {
            let scene = Scene {
                faces: vec![Face::quad("", c, Vec3::ONE, Vec3::splat(0.5)); *count],
                ..Scene::default()
            };
            let (found, note) = coarsen_meshing(&scene, &normal, *given);
            assert_eq!(note.is_some(), found != normal);
            let found = [found.texels, found.patches, found.samples];
            assert_eq!(found, *expected, "{count} faces, {given:?} given");
        }
    }
}
