//! What this machine cannot hold is refused before anything is allocated.

use super::Counts;
use super::memory::Memory;
use crate::solve::sides::solved_on;
use common::mesh::MAX_TEXELS;
use common::scene::Scene;
use common::settings::{Meshing, Settings};
use common::{Error, Result};
use cpu::matrix::memory;
use gpu::Gpu;
use std::path::Path;

/// Where the system does not say what it has.
const ASSUMED: u64 = 8 << 30;
/// Bytes of a file in which the system tells about itself, at most.
const MOST_TOLD: u64 = 1 << 20;
/// Addresses that threads reserve.
const RESERVED: u64 = 1 << 29;
/// Points of cells are numbered in 32 bits.
const MAX_POINTS: u64 = u32::MAX as u64;

/// Bytes that a hierarchical solve takes a texel, its nodes, blocks and links with it.
const TEXEL_BYTES: u64 = 2000;

/// Bytes that may be taken, and who says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    /// Bytes.
    pub bytes: u64,
    /// In words.
    pub source: &'static str,
}

impl Limit {
    /// What the system has left (Linux), or 8 GiB; what the process may have if that is less.
    pub fn of_this_machine() -> Self {
        let read = |file: &str| {
            let bytes = common::file::read(Path::new(file), MOST_TOLD).unwrap_or_default();
            String::from_utf8_lossy(&bytes).into_owned()
        };
        let system = match available(&read("/proc/meminfo")) {
            Some(bytes) => Self {
                bytes,
                source: "available now",
            },
            None => Self {
                bytes: ASSUMED,
                source: "assumed",
            },
        };
        let taken = field(&read("/proc/self/status"), "VmSize:").unwrap_or(0);
        match address_space(&read("/proc/self/limits")) {
            Some(most) if usable(most, taken) < system.bytes => Self {
                bytes: usable(most, taken),
                source: "allowed by ulimit",
            },
            _ => system,
        }
    }
}

/// `MemAvailable` of /proc/meminfo, in bytes.
fn available(text: &str) -> Option<u64> {
    field(text, "MemAvailable:")
}

/// A field of kibibytes, in bytes.
fn field(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find(|l| l.starts_with(name))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    kib.checked_mul(1 << 10)
}

/// A limit of addresses holds what threads reserve, half a gigabyte, and vectors that move when they
/// grow: half as much again as there are pages.
fn usable(most: u64, taken: u64) -> u64 {
    most.saturating_sub(taken).saturating_sub(RESERVED) / 3 * 2
}

/// The limit of /proc/self/limits in force; none where there is none.
fn address_space(text: &str) -> Option<u64> {
    let line = text.lines().find(|l| l.starts_with("Max address space"))?;
    line.split_whitespace().nth(3)?.parse().ok()
}

/// What a solve takes of the host: a software adapter's device is the host.
pub fn host_bytes(counts: &Counts, settings: &Settings, gpu: Option<&Gpu>) -> u64 {
    match gpu {
        None => Memory::cpu(counts, settings).bytes(),
        Some(gpu) if gpu.line.software => Memory::gpu(gpu, counts, settings).bytes(),
        // What is uploaded and what is read back is in the host's memory at some time.
        Some(gpu) => {
            let memory = Memory::gpu(gpu, counts, settings);
            let uploaded = memory.mesh.saturating_add(memory.state);
            memory.scene.saturating_add(uploaded.max(memory.look))
        }
    }
}

/// Why a solve cannot be held; none where it can.
fn reason(scene: &Scene, settings: &Settings, gpu: Option<&Gpu>, limit: Limit) -> Option<String> {
    let counts = Counts::new(scene, &settings.meshing);
    if counts.texels > MAX_TEXELS {
        return Some(format!(
            "{} faces would have {} texels, and {MAX_TEXELS} is the most",
            counts.faces, counts.texels
        ));
    }
    let points = counts.cells.saturating_mul(counts.samples);
    if points > MAX_POINTS {
        return Some(format!(
            "{} cells would have {points} points, and {MAX_POINTS} is the most",
            counts.cells
        ));
    }
    let bytes = host_bytes(&counts, settings, gpu);
    (bytes > limit.bytes).then(|| {
        format!(
            "{} texels and {} cells take {}, {} are {}",
            counts.texels,
            counts.cells,
            size(bytes),
            size(limit.bytes),
            limit.source
        )
    })
}

/// Refuses more texels than a solve to an error can hold.
pub fn check_texels(scene: &Scene, side: u32, limit: Limit) -> Result<()> {
    let texels =
        |side: u32| (scene.faces.len() as u64).saturating_mul(u64::from(solved_on(side)).pow(2));
    let bytes = |side: u32| texels(side).saturating_mul(TEXEL_BYTES);
    let fits = |side: u32| texels(side) <= MAX_TEXELS && bytes(side) <= limit.bytes;
    if fits(side) {
        return Ok(());
    }
    let advice = match largest(side, fits) {
        Some(side) => format!("--texels {side} would fit"),
        None => "no settings would fit".into(),
    };
    Err(Error::Usage(format!(
        "{}: {} texels take {}, {} are {}: {advice}",
        scene.name,
        texels(side),
        size(bytes(side)),
        size(limit.bytes),
        limit.source
    )))
}

/// Refuses what does not fit, and says what does.
pub fn check(scene: &Scene, settings: &Settings, gpu: Option<&Gpu>, limit: Limit) -> Result<()> {
    let Some(reason) = reason(scene, settings, gpu, limit) else {
        return Ok(());
    };
    let advice = match would_fit(scene, settings, gpu, limit) {
        Some(options) => format!("{options} would fit"),
        None => "no settings would fit".into(),
    };
    Err(Error::Usage(format!("{}: {reason}: {advice}", scene.name)))
}

/// The finest that fits, of one option if that suffices.
fn would_fit(
    scene: &Scene,
    settings: &Settings,
    gpu: Option<&Gpu>,
    limit: Limit,
) -> Option<String> {
    let fits = |settings: &Settings| reason(scene, settings, gpu, limit).is_none();
    let least = |texels: u32, cells, samples| Settings {
        meshing: Meshing {
            texels,
            cells: settings.meshing.cells.min(cells),
            samples: settings.meshing.samples.min(samples),
        },
        ..*settings
    };
    let all = u32::MAX;
    let ways: [(&str, u32, u32); 3] = [
        ("", all, all),
        (" --samples 1", all, 1),
        (" --cells 1 --samples 1", 1, 1),
    ];
    for (options, cells, samples) in ways {
        if fits(&least(settings.meshing.texels, cells, samples)) {
            return Some(options.trim_start().to_owned());
        }
        let found = largest(settings.meshing.texels, |n| fits(&least(n, cells, samples)));
        if let Some(texels) = found {
            return Some(format!("--texels {texels}{options}"));
        }
    }
    None
}

/// The largest n < `end` with `fits(n)`, which holds for all smaller ones as well.
fn largest(end: u32, fits: impl Fn(u32) -> bool) -> Option<u32> {
    let (mut low, mut high) = (0, end);
    while low + 1 < high {
        let middle = low + (high - low) / 2;
        if fits(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    (low > 0).then_some(low)
}

/// Bytes as people read them.
pub fn size(bytes: u64) -> String {
    let x = bytes as f64;
    if x < 1e6 {
        format!("{:.0} kB", x / 1e3)
    } else if x < 1e9 {
        format!("{:.1} MB", x / 1e6)
    } else {
        format!("{:.1} GB", x / 1e9)
    }
}

/// Refuses a matrix that would not fit, with what to do.
pub fn check_matrix(scene: &Scene, texels: u32) -> Result<()> {
    memory::check(scene, texels).map_err(|error| {
        let advice = match memory::fitting(scene.faces.len() as u64) {
            0 => "use --solver cpu".to_owned(),
            most => format!("--texels {most} fits, or use --solver cpu"),
        };
        Error::Usage(format!("{error}: {advice}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Face;
    use glam::{DVec3, Vec3};

    fn scene() -> Scene {
        let c = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let quad = Face::quad("quad", c, Vec3::ONE, Vec3::splat(0.5));
        Scene {
            name: "six".into(),
            faces: vec![quad; 6],
            ..Scene::default()
        }
    }

    fn with(texels: u32, cells: u32, samples: u32) -> Settings {
        Settings {
            meshing: Meshing {
                texels,
                cells,
                samples,
            },
            ..Settings::default()
        }
    }

    fn told(settings: &Settings, bytes: u64) -> String {
        let limit = Limit {
            bytes,
            source: "given",
        };
        match check(&scene(), settings, None, limit) {
            Ok(()) => String::new(),
            Err(Error::Usage(text)) => text,
            Err(other) => panic!("{other}"),
        }
    }

    #[test]
    fn what_fits_is_let_through_and_what_does_not_is_told_the_finest_that_does() {
        let settings = with(64, 4, 4);
        let needs = host_bytes(&Counts::new(&scene(), &settings.meshing), &settings, None);
        assert_eq!(told(&settings, needs), "");
        assert!(told(&settings, needs - 1).contains("--texels 63 would fit"));
        // The advice holds, and one texel more does not.
        let finer = with(200, 4, 4);
        let text = told(&finer, needs);
        assert!(text.contains("--texels 64 would fit"), "{text}");
        assert!(told(&with(65, 4, 4), needs).contains("--texels 64 would fit"));
    }

    #[test]
    fn too_many_texels_and_points_are_told() {
        let text = told(&with(8192, 4, 1), u64::MAX);
        assert!(text.contains("--texels 3344 would fit"), "{text}");
        assert_eq!(told(&with(3344, 4, 1), u64::MAX), "");
        let text = told(&with(1024, 512, 4096), u64::MAX);
        assert!(
            text.contains("points") && text.contains("would fit"),
            "{text}"
        );
        assert!(told(&settings_that_never_fit(), 1000).contains("no settings"));
    }

    fn settings_that_never_fit() -> Settings {
        with(4, 1, 1)
    }

    #[test]
    fn the_system_says_what_it_has() {
        let text = "MemTotal:       100 kB\nMemAvailable:     64 kB\n";
        assert_eq!(available(text), Some(65536));
        assert_eq!(available("MemTotal: 1 kB"), None);
        let limits = |n: &str| {
            format!("Limit  Soft  Hard  Units\nMax address space  {n}  unlimited  bytes\n")
        };
        assert_eq!(address_space(&limits("4096000")), Some(4_096_000));
        assert_eq!(address_space(&limits("unlimited")), None);
    }
}
