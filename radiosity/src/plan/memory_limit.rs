//! Refuses a solve that needs more memory than this machine has, before anything is allocated.

use super::SceneCounts;
use super::memory::SolveMemory;
use common::mesh::MAX_TEXELS;
use common::scene::Scene;
use common::settings::{Meshing, Settings};
use common::{Error, Result};
use cpu::dense::memory;
use gpu::Gpu;
use oracle::solve::resolution::solved_texels;
use std::path::Path;

/// Memory assumed if the system does not say how much is available.
const ASSUMED_MEMORY_BYTES: u64 = 8 << 30;
/// Largest number of bytes read of a file in /proc.
const MAX_PROC_FILE_BYTES: u64 = 1 << 20;
/// Address space reserved by threads.
const RESERVED_THREAD_BYTES: u64 = 1 << 29;
/// Sample points of patches are numbered in 32 bits.
const MAX_POINTS: u64 = u32::MAX as u64;

/// Bytes of a hierarchical solve per texel, with its nodes, blocks and links.
const BYTES_PER_TEXEL: u64 = 2000;

/// Memory that a solve may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryLimit {
    /// Bytes.
    pub bytes: u64,
    /// Origin of the limit, for messages.
    pub source: &'static str,
}

impl MemoryLimit {
    /// Returns the memory that the system has available (Linux), else 8 GiB; less under a `ulimit`.
    pub fn of_this_machine() -> Self {
        let read = |file: &str| {
            let bytes = common::file::read(Path::new(file), MAX_PROC_FILE_BYTES).unwrap_or_default();
            String::from_utf8_lossy(&bytes).into_owned()
        };
        let system = match parse_available(&read("/proc/meminfo")) {
            Some(bytes) => Self {
                bytes,
                source: "available now",
            },
            None => Self {
                bytes: ASSUMED_MEMORY_BYTES,
                source: "assumed",
            },
        };
        let taken = parse_kibibytes(&read("/proc/self/status"), "VmSize:").unwrap_or(0);
        match parse_address_limit(&read("/proc/self/limits")) {
            Some(most) if usable_bytes(most, taken) < system.bytes => Self {
                bytes: usable_bytes(most, taken),
                source: "allowed by ulimit",
            },
            _ => system,
        }
    }
}

/// Reads `MemAvailable` of /proc/meminfo, in bytes.
fn parse_available(text: &str) -> Option<u64> {
    parse_kibibytes(text, "MemAvailable:")
}

/// Reads a field given in kibibytes, in bytes.
fn parse_kibibytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find(|l| l.starts_with(name))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    kib.checked_mul(1 << 10)
}

/// Returns the memory that fits under a limit of the address space: without what is taken already and what threads
/// reserve (half a gigabyte), two thirds, since vectors need half as much again while they move to grow.
fn usable_bytes(most: u64, taken: u64) -> u64 {
    most.saturating_sub(taken).saturating_sub(RESERVED_THREAD_BYTES) / 3 * 2
}

/// Reads the soft limit of the address space in /proc/self/limits; none if unlimited.
fn parse_address_limit(text: &str) -> Option<u64> {
    let line = text.lines().find(|l| l.starts_with("Max address space"))?;
    line.split_whitespace().nth(3)?.parse().ok()
}

/// Returns the host memory of a solve. The device memory of a software adapter is the host's.
pub fn host_bytes(counts: &SceneCounts, settings: &Settings, gpu: Option<&Gpu>) -> u64 {
    match gpu {
        None => SolveMemory::on_cpu(counts, settings).peak_bytes(),
        Some(gpu) if gpu.line.software => SolveMemory::on_gpu(gpu, counts, settings).peak_bytes(),
        // Data uploaded or read back is in the host's memory, too, at some time.
        Some(gpu) => {
            let memory = SolveMemory::on_gpu(gpu, counts, settings);
            let uploaded = memory.mesh.saturating_add(memory.state);
            memory.scene.saturating_add(uploaded.max(memory.estimate))
        }
    }
}

/// Returns the reason to refuse a solve; none if it fits.
fn refusal_reason(scene: &Scene, settings: &Settings, gpu: Option<&Gpu>, limit: MemoryLimit) -> Option<String> {
    let counts = SceneCounts::new(scene, &settings.meshing);
    if counts.texels > MAX_TEXELS {
        return Some(format!(
            "{} faces would have {} texels, more than the limit of {MAX_TEXELS}",
            counts.faces, counts.texels
        ));
    }
    let points = counts.patches.saturating_mul(counts.samples);
    if points > MAX_POINTS {
        return Some(format!(
            "{} patches would have {points} points, more than the limit of {MAX_POINTS}",
            counts.patches
        ));
    }
    let bytes = host_bytes(&counts, settings, gpu);
    (bytes > limit.bytes).then(|| {
        format!(
            "{} texels and {} patches take {}, {} are {}",
            counts.texels,
            counts.patches,
            format_bytes(bytes),
            format_bytes(limit.bytes),
            limit.source
        )
    })
}

/// Refuses more texels than memory allows in a solve to an error, and names the largest side that fits.
///
/// Errors: [`Error::Usage`].
pub fn check_texels(scene: &Scene, side: u32, limit: MemoryLimit) -> Result<()> {
    let texels = |side: u32| (scene.faces.len() as u64).saturating_mul(u64::from(solved_texels(side)).pow(2));
    let bytes = |side: u32| texels(side).saturating_mul(BYTES_PER_TEXEL);
    let fits = |side: u32| texels(side) <= MAX_TEXELS && bytes(side) <= limit.bytes;
    if fits(side) {
        return Ok(());
    }
    let advice = match largest_fitting(side, fits) {
        Some(side) => format!("--texels {side} would fit"),
        None => "no settings would fit".into(),
    };
    Err(Error::Usage(format!(
        "{}: {} texels take {}, {} are {}: {advice}",
        scene.name,
        texels(side),
        format_bytes(bytes(side)),
        format_bytes(limit.bytes),
        limit.source
    )))
}

/// Refuses a solve by shooting that does not fit, and names options that do.
///
/// Errors: [`Error::Usage`].
pub fn check_memory(scene: &Scene, settings: &Settings, gpu: Option<&Gpu>, limit: MemoryLimit) -> Result<()> {
    let Some(reason) = refusal_reason(scene, settings, gpu, limit) else {
        return Ok(());
    };
    let advice = match fitting_options(scene, settings, gpu, limit) {
        Some(options) => format!("{options} would fit"),
        None => "no settings would fit".into(),
    };
    Err(Error::Usage(format!("{}: {reason}: {advice}", scene.name)))
}

/// Returns the finest options that fit, a single one if that suffices.
fn fitting_options(scene: &Scene, settings: &Settings, gpu: Option<&Gpu>, limit: MemoryLimit) -> Option<String> {
    let fits = |settings: &Settings| refusal_reason(scene, settings, gpu, limit).is_none();
    let least = |texels: u32, patches, samples| Settings {
        meshing: Meshing {
            texels,
            patches: settings.meshing.patches.min(patches),
            samples: settings.meshing.samples.min(samples),
        },
        ..*settings
    };
    let all = u32::MAX;
    let ways: [(&str, u32, u32); 3] = [
        ("", all, all),
        (" --samples 1", all, 1),
        (" --patches 1 --samples 1", 1, 1),
    ];
    for (options, patches, samples) in ways {
        if fits(&least(settings.meshing.texels, patches, samples)) {
            return Some(options.trim_start().to_owned());
        }
        let found = largest_fitting(settings.meshing.texels, |n| fits(&least(n, patches, samples)));
        if let Some(texels) = found {
            return Some(format!("--texels {texels}{options}"));
        }
    }
    None
}

/// Returns the largest n < `end` with `fits(n)` by bisection; `fits` must hold for all smaller n as well.
fn largest_fitting(end: u32, fits: impl Fn(u32) -> bool) -> Option<u32> {
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

/// Formats bytes in kB, MB or GB.
pub fn format_bytes(bytes: u64) -> String {
    let x = bytes as f64;
    if x < 1e6 {
        format!("{:.0} kB", x / 1e3)
    } else if x < 1e9 {
        format!("{:.1} MB", x / 1e6)
    } else {
        format!("{:.1} GB", x / 1e9)
    }
}

/// Refuses a dense matrix that would not fit, and names the texels that do.
///
/// Errors: [`Error::Usage`].
pub fn check_dense_memory(scene: &Scene, texels: u32) -> Result<()> {
    memory::check_memory(scene, texels).map_err(|error| {
        let advice = match memory::max_texels_per_side(scene.faces.len() as u64) {
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

    fn with(texels: u32, patches: u32, samples: u32) -> Settings {
        Settings {
            meshing: Meshing {
                texels,
                patches,
                samples,
            },
            ..Settings::default()
        }
    }

    fn told(settings: &Settings, bytes: u64) -> String {
        let limit = MemoryLimit { bytes, source: "given" };
        match check_memory(&scene(), settings, None, limit) {
            Ok(()) => String::new(),
            Err(Error::Usage(text)) => text,
            Err(other) => panic!("{other}"),
        }
    }

    #[test]
    fn what_fits_is_let_through_and_what_does_not_is_told_the_finest_that_does() {
        let settings = with(64, 4, 4);
        let needs = host_bytes(&SceneCounts::new(&scene(), &settings.meshing), &settings, None);
        assert_eq!(told(&settings, needs), "");
        assert!(told(&settings, needs - 1).contains("--texels 63 would fit"));
        // The advised side fits, and one texel more does not.
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
        assert!(text.contains("points") && text.contains("would fit"), "{text}");
        assert!(told(&settings_that_never_fit(), 1000).contains("no settings"));
    }

    fn settings_that_never_fit() -> Settings {
        with(4, 1, 1)
    }

    #[test]
    fn the_system_says_what_it_has() {
        let text = "MemTotal:       100 kB\nMemAvailable:     64 kB\n";
        assert_eq!(parse_available(text), Some(65536));
        assert_eq!(parse_available("MemTotal: 1 kB"), None);
        let limits = |n: &str| format!("Limit  Soft  Hard  Units\nMax address space  {n}  unlimited  bytes\n");
        assert_eq!(parse_address_limit(&limits("4096000")), Some(4_096_000));
        assert_eq!(parse_address_limit(&limits("unlimited")), None);
    }
}
