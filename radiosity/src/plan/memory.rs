//! Memory of a solve, from the sizes of its records: one that does not fit is refused before anything is allocated.

use super::SceneCounts;
use crate::report::solution_view::PREVIEW_BYTES;
use common::mesh::{MAX_TEXELS, MeshFace, Patch, PatchPoint, Texel};
use common::scene::Scene;
use common::settings::{Meshing, Settings};
use common::{Error, Result, file};
use cpu::dense::memory::{MAX_MATRIX_BYTES, matrix_bytes};
use cpu::memory;
use oracle::solve::resolution::solved_texels;
use oracle::solve::solver::SolverChoice;
use std::path::Path;

/// Bytes of a face beside its record: name, text of the file, four trees, and its possible occluders.
/// Measured: 4.3 kB with 20 000 and with 100 000 triangles.
const BYTES_PER_FACE: u64 = 4400;
/// Bytes of a texel after the links are freed: result, error estimate and output files, each with its own copy.
/// Measured: 240 bytes with 6 million texels.
const ESTIMATE_BYTES_PER_TEXEL: usize = 240;
/// Bytes of the program itself.
const PROGRAM_BYTES: u64 = 12 << 20;
/// Bytes of a solve to an error per texel, with its nodes, blocks and links.
const ADAPTIVE_BYTES_PER_TEXEL: u64 = 2000;
/// Bytes of a solve to an error beside its records: the program's code and threads. Measured with its pictures: 75 MB.
const ADAPTIVE_PROGRAM_BYTES: u64 = 40 << 20;
/// Bytes of a solve by rays per texel, and per texel of its answer with its files. Measured: 300 and 400 bytes.
const RAY_BYTES_PER_TEXEL: [u64; 2] = [300, 400];
/// Bytes of a ray that is kept.
const BYTES_PER_RAY: u64 = 4;
/// Bytes of a relight beside its texels, the pictures among them. Measured: 150 MB.
const RELIGHT_BYTES: u64 = 150 << 20;
/// Bytes of a relight per texel, by shooting and to an error. Measured: 1 kB, and 3 to 9 kB.
const RELIGHT_BYTES_PER_TEXEL: [u64; 2] = [1000, 6000];
/// Sample points of patches are numbered in 32 bits.
const MAX_POINTS: u64 = u32::MAX as u64;

/// Memory assumed if the system does not say how much is available.
const ASSUMED_MEMORY_BYTES: u64 = 8 << 30;
/// Largest number of bytes read of a file in /proc.
const MAX_PROC_FILE_BYTES: u64 = 1 << 20;
/// Address space reserved by threads.
const RESERVED_THREAD_BYTES: u64 = 1 << 29;

/// Returns the largest number of bytes of this machine that a solve uses at one time.
pub fn solve_bytes(scene: &Scene, settings: &Settings, solver: SolverChoice) -> u64 {
    let SceneCounts {
        faces,
        texels,
        patches,
        samples,
    } = solved_counts(scene, settings, solver);
    if let SolverChoice::Dense = solver {
        return matrix_bytes(texels);
    }
    if solver.error_target().is_some() {
        return texels.saturating_mul(ADAPTIVE_BYTES_PER_TEXEL);
    }
    let schedule = &settings.schedule;
    let [state, links] = match solver.gpu() {
        None => {
            let shooters = patches.min(schedule.max_shots.into());
            let links = memory::link_bytes(shooters, texels, schedule.iteration);
            [memory::state_bytes(texels), links]
        }
        Some(gpu) => [
            gpu.state_bytes([faces, patches, texels], samples, &settings.transport),
            // A hardware adapter keeps the links in its own memory.
            if gpu.line.software {
                gpu.link_bytes(patches, texels)
            } else {
                0
            },
        ],
    };
    let sum = |first: u64, parts: &[(u64, usize)]| {
        let bytes = parts.iter().map(|(count, bytes)| count.saturating_mul(*bytes as u64));
        bytes.fold(first, u64::saturating_add)
    };
    let points = patches.saturating_mul(samples);
    let mesh = [
        (faces, size_of::<MeshFace>()),
        (patches, size_of::<Patch>()),
        (texels, size_of::<Texel>()),
        (points, size_of::<PatchPoint>()),
    ];
    // The error estimate makes three more meshes, when state and links are freed.
    let estimate = [
        (texels, ESTIMATE_BYTES_PER_TEXEL),
        (patches, 3 * size_of::<Patch>()),
        (points, 3 * size_of::<PatchPoint>()),
    ];
    let shooting = sum(state.saturating_add(links), &mesh);
    let scene = PROGRAM_BYTES.saturating_add(faces.saturating_mul(BYTES_PER_FACE));
    scene.saturating_add(shooting.max(sum(PREVIEW_BYTES, &estimate)))
}

/// Returns the largest number of bytes that a solve to an error uses at one time, which ends on these `texels` of `faces`
/// and keeps `rays`; without rays it keeps links.
pub fn adaptive_bytes(faces: u64, [texels, rays]: [u64; 2]) -> u64 {
    let [solved, written] = RAY_BYTES_PER_TEXEL.map(|bytes| texels.saturating_mul(bytes));
    let most = match rays {
        0 => texels
            .saturating_mul(ADAPTIVE_BYTES_PER_TEXEL)
            .saturating_add(PREVIEW_BYTES),
        _ => (rays.saturating_mul(BYTES_PER_RAY).saturating_add(solved)).max(written.saturating_add(PREVIEW_BYTES)),
    };
    let scene = ADAPTIVE_PROGRAM_BYTES.saturating_add(faces.saturating_mul(BYTES_PER_FACE));
    scene.saturating_add(most)
}

/// Counts a solve with the texels on which it is done.
fn solved_counts(scene: &Scene, settings: &Settings, solver: SolverChoice) -> SceneCounts {
    let mut meshing = settings.meshing;
    if solver.error_target().is_some() {
        meshing.texels = solved_texels(meshing.texels);
    }
    SceneCounts::new(scene, &meshing)
}

/// Returns the bytes that a solve may use, and their origin: the limit of the dense matrix, or what the system has
/// available (Linux), else 8 GiB; less under a `ulimit`.
pub fn memory_limit(solver: SolverChoice) -> (u64, &'static str) {
    if let SolverChoice::Dense = solver {
        return (MAX_MATRIX_BYTES, "allowed for the matrix");
    }
    let read = |file: &str, line: &str, column: usize| {
        let bytes = file::read(Path::new(file), MAX_PROC_FILE_BYTES).unwrap_or_default();
        find_number(&String::from_utf8_lossy(&bytes), line, column)
    };
    let system = match read("/proc/meminfo", "MemAvailable:", 1) {
        Some(kib) => (kib << 10, "available now"),
        None => (ASSUMED_MEMORY_BYTES, "assumed"),
    };
    let taken = read("/proc/self/status", "VmSize:", 1).unwrap_or(0) << 10;
    // Two thirds of what is free: vectors need half as much again while they move to grow.
    let usable = |most: u64| most.saturating_sub(taken).saturating_sub(RESERVED_THREAD_BYTES) / 3 * 2;
    match read("/proc/self/limits", "Max address space", 3).map(usable) {
        Some(bytes) if bytes < system.0 => (bytes, "allowed by ulimit"),
        _ => system,
    }
}

/// Refuses to solve where a `ulimit` leaves nothing beside the program and its threads: allocations would fail anywhere.
///
/// Errors: [`Error::Usage`].
pub fn require_address_space() -> Result<()> {
    match memory_limit(SolverChoice::Cpu) {
        (0, source) => Err(Error::Usage(format!(
            "the memory {source} is taken by the program and its threads: allow 1 GB at least (ulimit -v 1000000)"
        ))),
        _ => Ok(()),
    }
}

/// Refuses a relight that does not fit into the memory; `resolutions` are those of all faces.
///
/// Errors: [`Error::Usage`].
pub fn check_relight_memory(resolutions: &[[u32; 2]], to_error: bool) -> Result<()> {
    let texels: u64 = resolutions.iter().map(|[w, h]| u64::from(*w) * u64::from(*h)).sum();
    let each = RELIGHT_BYTES_PER_TEXEL[usize::from(to_error)];
    let bytes = texels.saturating_mul(each).saturating_add(RELIGHT_BYTES);
    let (most, source) = memory_limit(SolverChoice::Cpu);
    let [needed, usable] = [bytes, most].map(format_bytes);
    match bytes > most {
        true => Err(Error::Usage(format!(
            "{texels} texels of room and objects take {needed}, {usable} are {source}: use fewer --texels"
        ))),
        false => Ok(()),
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
pub fn check_memory(scene: &Scene, settings: &Settings, solver: SolverChoice, limit: (u64, &str)) -> Result<()> {
    let asked = settings.meshing;
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
    let mut advice = fitting.unwrap_or("no settings would fit".into());
    if let SolverChoice::Dense = solver {
        advice += ", or use --solver cpu";
    }
    Err(Error::Usage(format!("{}: {reason}: {advice}", scene.name)))
}

/// Returns the reason to refuse a solve; none if it fits.
fn refusal_reason(scene: &Scene, settings: &Settings, solver: SolverChoice, limit: (u64, &str)) -> Option<String> {
    let counts = solved_counts(scene, settings, solver);
    let (texels, points) = (counts.texels, counts.patches.saturating_mul(counts.samples));
    let bytes = solve_bytes(scene, settings, solver);
    if texels > MAX_TEXELS {
        Some(format!(
            "{} faces would have {texels} texels, more than the limit of {MAX_TEXELS}",
            counts.faces
        ))
    } else if solver.is_shooting() && points > MAX_POINTS {
        Some(format!(
            "{} patches would have {points} points, more than the limit of {MAX_POINTS}",
            counts.patches
        ))
    } else {
        let (most, source) = limit;
        let [needed, usable] = [bytes, most].map(format_bytes);
        (bytes > most).then(|| format!("{texels} texels take {needed}, {usable} are {source}"))
    }
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

    /// Texels, patches and samples, bytes more or less than the first solve needs, and part of the refusal.
    const REFUSALS: &[([u32; 3], i64, &str)] = &[
        ([64, 4, 4], 0, ""),
        ([64, 4, 4], -1, "--texels 63 would fit"),
        ([65, 4, 4], 0, "--texels 64 would fit"),
        ([200, 4, 4], 0, "--texels 64 would fit"),
        ([8192, 4, 1], i64::MAX, "--texels 3344 would fit"),
        ([3344, 4, 1], i64::MAX, ""),
        ([1024, 512, 4096], i64::MAX, "points, more than the limit"),
        ([1024, 512, 4096], i64::MAX, "--texels 418 would fit"),
        ([4, 1, 1], i64::MIN, "no settings would fit"),
    ];

    #[test]
    fn refusal_names_finest_texels_that_fit() {
        let c = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let scene = Scene {
            faces: vec![Face::quad("quad", c, Vec3::ONE, Vec3::splat(0.5)); 6],
            ..Scene::default()
        };
        let settings = |[texels, patches, samples]: [u32; 3]| Settings {
            meshing: Meshing {
                texels,
                patches,
                samples,
            },
            ..Settings::default()
        };
        let first = settings(REFUSALS[0].0);
        let needed = solve_bytes(&scene, &first, SolverChoice::Cpu);
        for (meshing, more, said) in REFUSALS {
            let limit = (needed.saturating_add_signed(*more), "given");
            let refused = check_memory(&scene, &settings(*meshing), SolverChoice::Cpu, limit);
            let message = refused.map_or_else(|error| error.to_string(), |()| String::new());
            assert!(message.contains(said), "{meshing:?}: {message}");
            assert_eq!(message.is_empty(), said.is_empty(), "{meshing:?}: {message}");
        }
    }
}
