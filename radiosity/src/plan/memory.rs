//! Memory of a solve, from the sizes of its records: one that does not fit is refused before anything is allocated.

use super::SceneCounts;
use crate::report::preview::PREVIEW_BYTES;
use common::mesh::{MAX_TEXELS, MeshFace, Patch, PatchPoint, Texel};
use common::scene::Scene;
use common::settings::{Meshing, Settings};
use common::{Error, Result, file};
use cpu::{dense, memory};
use gpu::Gpu;
use oracle::solve::resolution::solved_texels;
use oracle::solve::solver::SolverChoice;
use std::path::Path;

/// Bytes of a face beside its record: name, text of the file, four trees, and its possible occluders.
/// Measured: 4.3 kB with 20 000 and with 100 000 triangles.
const BYTES_PER_FACE: u64 = 4400;
/// Bytes of a texel after the links are freed: result, error estimate and output files, each with its own copy.
/// Measured: 240 bytes with 6 million texels.
const ESTIMATE_BYTES_PER_TEXEL: u64 = 240;
/// Bytes of the program itself.
const PROGRAM_BYTES: u64 = 12 << 20;
/// Bytes of a solve to an error per texel, with its nodes, blocks and links.
const ADAPTIVE_BYTES_PER_TEXEL: u64 = 2000;
/// Sample points of patches are numbered in 32 bits.
const MAX_POINTS: u64 = u32::MAX as u64;

/// Memory assumed if the system does not say how much is available.
const ASSUMED_MEMORY_BYTES: u64 = 8 << 30;
/// Largest number of bytes read of a file in /proc.
const MAX_PROC_FILE_BYTES: u64 = 1 << 20;
/// Address space reserved by threads.
const RESERVED_THREAD_BYTES: u64 = 1 << 29;

/// Bytes of a solve by shooting.
#[derive(Clone, Copy, Debug)]
pub struct SolveMemory {
    /// The program and the scene.
    pub scene: u64,
    /// The mesh, and the state of the texels and of the engine without its links.
    pub state: u64,
    /// Links, and the power exchanged between patches.
    pub links: u64,
    /// Error estimate and output after shooting, when state and links are freed.
    pub estimate: u64,
}

impl SolveMemory {
    /// Returns the memory of a solve on `gpu`, or on the CPU.
    pub fn new(counts: &SceneCounts, settings: &Settings, gpu: Option<&Gpu>) -> Self {
        let SceneCounts {
            faces,
            texels,
            patches,
            samples,
        } = *counts;
        let of = |count: u64, bytes: usize| count.saturating_mul(bytes as u64);
        let points = patches.saturating_mul(samples);
        let mesh = [
            of(faces, size_of::<MeshFace>()),
            of(patches, size_of::<Patch>()),
            of(texels, size_of::<Texel>()),
            of(points, size_of::<PatchPoint>()),
        ];
        let (state, links) = match gpu {
            None => (
                memory::state_bytes(texels),
                memory::link_bytes(patches, texels, settings.schedule.iteration),
            ),
            Some(gpu) => (
                gpu.state_bytes([faces, patches, texels], samples, &settings.transport),
                gpu.link_bytes(patches, texels),
            ),
        };
        // The error estimate makes three more meshes.
        let estimate = [
            texels.saturating_mul(ESTIMATE_BYTES_PER_TEXEL),
            of(3 * patches, size_of::<Patch>()),
            of(points, 3 * size_of::<PatchPoint>()),
            PREVIEW_BYTES,
        ];
        let sum = |parts: [u64; 4]| parts.into_iter().fold(0, u64::saturating_add);
        Self {
            scene: PROGRAM_BYTES.saturating_add(faces.saturating_mul(BYTES_PER_FACE)),
            state: sum(mesh).saturating_add(state),
            links,
            estimate: sum(estimate),
        }
    }

    /// Returns the largest number of bytes in use at one time.
    pub fn peak_bytes(&self) -> u64 {
        let shooting = self.state.saturating_add(self.links);
        self.scene.saturating_add(shooting.max(self.estimate))
    }
}

/// Memory that a solve may use.
#[derive(Clone, Copy, Debug)]
pub struct MemoryLimit {
    /// Bytes.
    pub bytes: u64,
    /// Origin of the limit, for messages.
    pub source: &'static str,
}

impl MemoryLimit {
    /// Returns the memory that the system has available (Linux), else 8 GiB; less under a `ulimit`.
    pub fn of_this_machine() -> Self {
        let read = |file: &str, line: &str, column: usize| {
            let bytes = file::read(Path::new(file), MAX_PROC_FILE_BYTES).unwrap_or_default();
            find_number(&String::from_utf8_lossy(&bytes), line, column)
        };
        let system = match read("/proc/meminfo", "MemAvailable:", 1) {
            Some(kib) => Self {
                bytes: kib << 10,
                source: "available now",
            },
            None => Self {
                bytes: ASSUMED_MEMORY_BYTES,
                source: "assumed",
            },
        };
        let taken = read("/proc/self/status", "VmSize:", 1).unwrap_or(0) << 10;
        // Two thirds of what is free: vectors need half as much again while they move to grow.
        let usable = |most: u64| most.saturating_sub(taken).saturating_sub(RESERVED_THREAD_BYTES) / 3 * 2;
        match read("/proc/self/limits", "Max address space", 3).map(usable) {
            Some(bytes) if bytes < system.bytes => Self {
                bytes,
                source: "allowed by ulimit",
            },
            _ => system,
        }
    }
}

/// Returns the number in a column of the line that begins with `name`; none if there is no number.
fn find_number(text: &str, name: &str, column: usize) -> Option<u64> {
    let line = text.lines().find(|line| line.starts_with(name))?;
    line.split_whitespace().nth(column)?.parse().ok()
}

/// Refuses a solve that does not fit into `limit`, and names options that do.
///
/// Errors: [`Error::Usage`].
pub fn check_memory(scene: &Scene, settings: &Settings, solver: SolverChoice, limit: MemoryLimit) -> Result<()> {
    let mut asked = settings.meshing;
    if let SolverChoice::Dense = solver {
        return dense::memory::check_memory(scene, asked.texels).map_err(|error| {
            let advice = match dense::memory::max_texels_per_side(scene.faces.len() as u64) {
                0 => "use --solver cpu".to_owned(),
                most => format!("--texels {most} fits, or use --solver cpu"),
            };
            Error::Usage(format!("{error}: {advice}"))
        });
    }
    if let Some(target) = solver.error_target() {
        asked.texels = target.texels.unwrap_or(1);
    }
    let refusal = |meshing| refusal_reason(scene, &Settings { meshing, ..*settings }, solver, limit);
    let Some(reason) = refusal(asked) else {
        return Ok(());
    };
    let sides: Vec<u32> = (1..=asked.texels).collect();
    let ways = [(asked.patches, asked.samples, ""), (1, 1, " --patches 1 --samples 1")];
    let fitting = ways.into_iter().find_map(|(patches, samples, options)| {
        let with = |texels| Meshing {
            texels,
            patches,
            samples,
        };
        let count = sides.partition_point(|side| refusal(with(*side)).is_none());
        (count > 0).then(|| format!("--texels {count}{options} would fit"))
    });
    let advice = fitting.unwrap_or("no settings would fit".into());
    Err(Error::Usage(format!("{}: {reason}: {advice}", scene.name)))
}

/// Returns the reason to refuse a solve; none if it fits.
fn refusal_reason(scene: &Scene, settings: &Settings, solver: SolverChoice, limit: MemoryLimit) -> Option<String> {
    let mut counts = SceneCounts::new(scene, &settings.meshing);
    let points = counts.patches.saturating_mul(counts.samples);
    let bytes = if solver.error_target().is_some() {
        counts.texels = counts.faces * u64::from(solved_texels(settings.meshing.texels)).pow(2);
        counts.texels.saturating_mul(ADAPTIVE_BYTES_PER_TEXEL)
    } else if points > MAX_POINTS {
        return Some(format!(
            "{} patches would have {points} points, more than the limit of {MAX_POINTS}",
            counts.patches
        ));
    } else {
        let mut memory = SolveMemory::new(&counts, settings, solver.gpu());
        if solver.gpu().is_some_and(|gpu| !gpu.line.software) {
            // These links are in the memory of the device.
            memory.links = 0;
        }
        memory.peak_bytes()
    };
    let texels = counts.texels;
    if texels > MAX_TEXELS {
        return Some(format!(
            "{} faces would have {texels} texels, more than the limit of {MAX_TEXELS}",
            counts.faces
        ));
    }
    let [needed, usable] = [bytes, limit.bytes].map(format_bytes);
    (bytes > limit.bytes).then(|| format!("{texels} texels take {needed}, {usable} are {}", limit.source))
}

/// Formats bytes in kB, MB or GB.
pub fn format_bytes(bytes: u64) -> String {
    match bytes as f64 {
        x if x < 1e6 => format!("{:.0} kB", x / 1e3),
        x if x < 1e9 => format!("{:.1} MB", x / 1e6),
        x => format!("{:.1} GB", x / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Face;
    use glam::{DVec3, Vec3};

    /// Six quads, and the settings to solve them.
    fn scene_and_settings(texels: u32, patches: u32, samples: u32) -> (Scene, Settings) {
        let c = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let quad = Face::quad("quad", c, Vec3::ONE, Vec3::splat(0.5));
        let scene = Scene {
            faces: vec![quad; 6],
            ..Scene::default()
        };
        let meshing = Meshing {
            texels,
            patches,
            samples,
        };
        let settings = Settings {
            meshing,
            ..Settings::default()
        };
        (scene, settings)
    }

    /// Returns the message of a refusal; empty if the solve fits into `bytes`.
    fn refusal_message(meshing: [u32; 3], bytes: u64) -> String {
        let (scene, settings) = scene_and_settings(meshing[0], meshing[1], meshing[2]);
        let limit = MemoryLimit { bytes, source: "given" };
        match check_memory(&scene, &settings, SolverChoice::Cpu, limit) {
            Ok(()) => String::new(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn refusal_names_finest_texels_that_fit() {
        let (scene, settings) = scene_and_settings(64, 4, 4);
        let counts = SceneCounts::new(&scene, &settings.meshing);
        let needed = SolveMemory::new(&counts, &settings, None).peak_bytes();
        for (meshing, bytes, said) in [
            ([64, 4, 4], needed, ""),
            ([64, 4, 4], needed - 1, "--texels 63 would fit"),
            ([65, 4, 4], needed, "--texels 64 would fit"),
            ([200, 4, 4], needed, "--texels 64 would fit"),
            ([8192, 4, 1], u64::MAX, "--texels 3344 would fit"),
            ([3344, 4, 1], u64::MAX, ""),
            ([1024, 512, 4096], u64::MAX, "points, more than the limit"),
            ([1024, 512, 4096], u64::MAX, "--texels 418 would fit"),
            ([4, 1, 1], 1000, "no settings would fit"),
        ] {
            let message = refusal_message(meshing, bytes);
            assert!(message.contains(said), "{meshing:?}: {message}");
            assert_eq!(message.is_empty(), said.is_empty(), "{meshing:?}: {message}");
        }
    }

    #[test]
    fn numbers_of_proc_files_are_found() {
        let text = "MemTotal:       100 kB\nMemAvailable:     64 kB\n";
        assert_eq!(find_number(text, "MemAvailable:", 1), Some(64));
        assert_eq!(find_number("MemTotal: 1 kB", "MemAvailable:", 1), None);
        let limits = |n: &str| format!("Limit  Soft  Hard  Units\nMax address space  {n}  unlimited  bytes\n");
        assert_eq!(find_number(&limits("4096000"), "Max address space", 3), Some(4_096_000));
        assert_eq!(find_number(&limits("unlimited"), "Max address space", 3), None);
    }
}
