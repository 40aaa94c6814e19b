//! Coarser defaults for scenes of many faces: 16×16 texels and 4×4 cells are meant for a few dozen.
//!
//! Links grow with the square of the faces: cells × texels. As long as all of them can be kept
//! ([`LINK_BYTES`], 256 faces at the defaults), nothing changes; beyond, cells are left out first (many
//! faces are cells already), then texels, then samples. What was given stays. Counts decide and no
//! clock, so that every machine answers alike.

use super::Counts;
use common::constants::LINK_BYTES;
use common::scene::Scene;
use common::settings::Meshing;

/// Links that are kept.
const LINKS: u64 = LINK_BYTES / 4;
/// Rays of pairs of faces with one texel each: half a minute on two cores.
const RAYS: u64 = 1 << 26;

/// Which of the options in question the user gave.
#[derive(Clone, Copy, Debug, Default)]
pub struct Chosen {
    /// `--quality`: all of them.
    pub quality: bool,
    /// `--texels`.
    pub texels: bool,
    /// `--cells`.
    pub cells: bool,
    /// `--samples`.
    pub samples: bool,
}

/// `meshing` for `scene`, and what was changed.
pub fn adapted(scene: &Scene, meshing: &Meshing, chosen: Chosen) -> (Meshing, Option<String>) {
    let mut found = *meshing;
    if chosen.quality {
        return (found, None);
    }
    while !chosen.cells && found.cells > 1 && links(scene, &found) > LINKS {
        found.cells /= 2;
    }
    while !chosen.texels && found.texels > 1 && links(scene, &found) > LINKS {
        found.texels -= 1;
    }
    let pairs = (scene.faces.len() as u64).saturating_pow(2);
    while !chosen.samples && found.samples > 1 && pairs.saturating_mul(found.samples.into()) > RAYS
    {
        found.samples /= 2;
    }
    let note = (found != *meshing).then(|| {
        format!(
            "{} faces: {}, {} and {} a cell instead of {}, {} and {}; --texels, --cells and --samples set them",
            scene.faces.len(),
            squared(found.texels, "texel"),
            squared(found.cells, "cell"),
            counted(found.samples),
            squared(meshing.texels, "texel"),
            squared(meshing.cells, "cell"),
            meshing.samples,
        )
    });
    (found, note)
}

fn links(scene: &Scene, meshing: &Meshing) -> u64 {
    Counts::new(scene, meshing).links()
}

fn squared(side: u32, what: &str) -> String {
    format!("{side}×{side} {what}{}", if side == 1 { "" } else { "s" })
}

fn counted(samples: u32) -> String {
    format!("{samples} sample{}", if samples == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Face;
    use common::settings::Quality;
    use glam::{DVec3, Vec3};

    fn quads(count: usize) -> Scene {
        let c = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let face = Face::quad("", c, Vec3::ONE, Vec3::splat(0.5));
        Scene {
            faces: vec![face; count],
            ..Scene::default()
        }
    }

    fn normal() -> Meshing {
        Quality::Normal.meshing()
    }

    fn at(count: usize) -> [u32; 3] {
        let (found, note) = adapted(&quads(count), &normal(), Chosen::default());
        assert_eq!(note.is_some(), found != normal());
        [found.texels, found.cells, found.samples]
    }

    #[test]
    fn the_links_of_any_number_of_faces_can_be_kept() {
        assert_eq!(at(10), [16, 4, 4]);
        assert_eq!(at(256), [16, 4, 4]);
        assert_eq!(at(257), [16, 2, 4]);
        assert_eq!(at(1024), [16, 1, 4]);
        assert_eq!(at(2188), [7, 1, 4]);
        assert_eq!(at(16_384), [1, 1, 1]);
        for count in [300, 1000, 5000, 16_000] {
            let [texels, cells, samples] = at(count);
            let found = Meshing {
                texels,
                cells,
                samples,
            };
            assert!(4 * links(&quads(count), &found) <= LINK_BYTES, "{count}");
        }
        // There is nothing below.
        assert_eq!(at(100_000), [1, 1, 1]);
    }

    #[test]
    fn what_was_given_stays() {
        let scene = quads(5000);
        let given = |chosen| adapted(&scene, &normal(), chosen).0;
        let quality = Chosen {
            quality: true,
            ..Chosen::default()
        };
        assert_eq!(given(quality), normal());
        let texels = Chosen {
            texels: true,
            ..Chosen::default()
        };
        assert_eq!((given(texels).texels, given(texels).cells), (16, 1));
        let cells = Chosen {
            cells: true,
            ..Chosen::default()
        };
        assert_eq!(given(cells).cells, 4);
        let samples = Chosen {
            samples: true,
            ..Chosen::default()
        };
        assert_eq!(given(samples).samples, 4);
    }
}
