//! Coarser defaults for scenes of many faces: 16×16 texels and 4×4 patches suit a few dozen faces.
//!
//! The number of links, patches × texels, grows with the square of the faces. Nothing changes while all links can be
//! kept ([`MAX_LINK_BYTES`], 256 faces at the defaults). Beyond, patches are made fewer first (many faces are patches
//! already), then texels, then samples. Options that were given stay. The decision depends on counts and not on time,
//! so that every machine chooses alike.

use super::SceneCounts;
use common::constants::MAX_LINK_BYTES;
use common::scene::Scene;
use common::settings::Meshing;

/// Largest number of links that can be kept.
const MAX_KEPT_LINKS: u64 = MAX_LINK_BYTES / 4;
/// Largest number of rays between pairs of faces with one texel each: half a minute on two processor cores.
const MAX_PAIR_RAYS: u64 = 1 << 26;

/// The options of meshing that the user gave.
#[derive(Clone, Copy, Debug, Default)]
pub struct GivenOptions {
    /// `--quality`, which sets all of them.
    pub quality: bool,
    /// `--texels`.
    pub texels: bool,
    /// `--patches`.
    pub patches: bool,
    /// `--samples`.
    pub samples: bool,
}

/// Returns `meshing` made coarser for a scene of many faces, and a note if it was changed.
pub fn coarsen_meshing(scene: &Scene, meshing: &Meshing, chosen: GivenOptions) -> (Meshing, Option<String>) {
    let mut found = *meshing;
    if chosen.quality {
        return (found, None);
    }
    while !chosen.patches && found.patches > 1 && count_links(scene, &found) > MAX_KEPT_LINKS {
        found.patches /= 2;
    }
    while !chosen.texels && found.texels > 1 && count_links(scene, &found) > MAX_KEPT_LINKS {
        found.texels -= 1;
    }
    let pairs = (scene.faces.len() as u64).saturating_pow(2);
    while !chosen.samples && found.samples > 1 && pairs.saturating_mul(found.samples.into()) > MAX_PAIR_RAYS {
        found.samples /= 2;
    }
    let note = (found != *meshing).then(|| {
        format!(
            "{} faces: {}, {} and {} a patch instead of {}, {} and {}; --texels, --patches and --samples set them",
            scene.faces.len(),
            format_grid(found.texels, "texel", "texels"),
            format_grid(found.patches, "patch", "patches"),
            format_samples(found.samples),
            format_grid(meshing.texels, "texel", "texels"),
            format_grid(meshing.patches, "patch", "patches"),
            meshing.samples,
        )
    });
    (found, note)
}

fn count_links(scene: &Scene, meshing: &Meshing) -> u64 {
    SceneCounts::new(scene, meshing).link_count()
}

fn format_grid(side: u32, singular: &str, plural: &str) -> String {
    format!("{side}×{side} {}", if side == 1 { singular } else { plural })
}

fn format_samples(samples: u32) -> String {
    format!("{samples} sample{}", if samples == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Face;
    use common::settings::SolveQuality;
    use glam::{DVec3, Vec3};

    fn scene_of_quads(count: usize) -> Scene {
        let c = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let face = Face::quad("", c, Vec3::ONE, Vec3::splat(0.5));
        Scene {
            faces: vec![face; count],
            ..Scene::default()
        }
    }

    fn normal_meshing() -> Meshing {
        SolveQuality::Normal.meshing()
    }

    fn coarsened_counts(count: usize) -> [u32; 3] {
        let (found, note) = coarsen_meshing(&scene_of_quads(count), &normal_meshing(), GivenOptions::default());
        assert_eq!(note.is_some(), found != normal_meshing());
        [found.texels, found.patches, found.samples]
    }

    #[test]
    fn the_links_of_any_number_of_faces_can_be_kept() {
        assert_eq!(coarsened_counts(10), [16, 4, 4]);
        assert_eq!(coarsened_counts(256), [16, 4, 4]);
        assert_eq!(coarsened_counts(257), [16, 2, 4]);
        assert_eq!(coarsened_counts(1024), [16, 1, 4]);
        assert_eq!(coarsened_counts(2188), [7, 1, 4]);
        assert_eq!(coarsened_counts(16_384), [1, 1, 1]);
        for count in [300, 1000, 5000, 16_000] {
            let [texels, patches, samples] = coarsened_counts(count);
            let found = Meshing {
                texels,
                patches,
                samples,
            };
            assert!(
                4 * count_links(&scene_of_quads(count), &found) <= MAX_LINK_BYTES,
                "{count}"
            );
        }
        // Nothing is coarser.
        assert_eq!(coarsened_counts(100_000), [1, 1, 1]);
    }

    #[test]
    fn what_was_given_stays() {
        let scene = scene_of_quads(5000);
        let given = |chosen| coarsen_meshing(&scene, &normal_meshing(), chosen).0;
        let quality = GivenOptions {
            quality: true,
            ..GivenOptions::default()
        };
        assert_eq!(given(quality), normal_meshing());
        let texels = GivenOptions {
            texels: true,
            ..GivenOptions::default()
        };
        assert_eq!((given(texels).texels, given(texels).patches), (16, 1));
        let patches = GivenOptions {
            patches: true,
            ..GivenOptions::default()
        };
        assert_eq!(given(patches).patches, 4);
        let samples = GivenOptions {
            samples: true,
            ..GivenOptions::default()
        };
        assert_eq!(given(samples).samples, 4);
    }
}
