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
        format!(
            "{} faces: --texels {} --patches {} --samples {} instead of {}, {} and {}",
            scene.faces.len(),
            found.texels,
            found.patches,
            found.samples,
            meshing.texels,
            meshing.patches,
            meshing.samples,
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

    fn coarsen(count: usize, given: [bool; 3]) -> [u32; 3] {
        let c = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let scene = Scene {
            faces: vec![Face::quad("", c, Vec3::ONE, Vec3::splat(0.5)); count],
            ..Scene::default()
        };
        let normal = SolveQuality::Normal.meshing();
        let (found, note) = coarsen_meshing(&scene, &normal, given);
        assert_eq!(note.is_some(), found != normal);
        let kept = SceneCounts::new(&scene, &found).link_count() <= MAX_KEPT_LINKS;
        assert!(kept || found.texels == 1 || given != [false; 3], "{count}: {found:?}");
        [found.texels, found.patches, found.samples]
    }

    #[test]
    fn links_of_any_number_of_faces_can_be_kept() {
        for (count, found) in [
            (10, [16, 4, 4]),
            (256, [16, 4, 4]),
            (257, [16, 2, 4]),
            (300, [16, 2, 4]),
            (1024, [16, 1, 4]),
            (2188, [7, 1, 4]),
            (16_384, [1, 1, 1]),
            // Nothing is coarser.
            (100_000, [1, 1, 1]),
        ] {
            assert_eq!(coarsen(count, [false; 3]), found, "{count} faces");
        }
    }

    #[test]
    fn given_options_stay() {
        assert_eq!(coarsen(5000, [true, false, false])[..2], [16, 1]);
        assert_eq!(coarsen(5000, [false, true, false])[1], 4);
        assert_eq!(coarsen(5000, [false, false, true])[2], 4);
        assert_eq!(coarsen(5000, [true; 3]), [16, 4, 4]);
    }
}
