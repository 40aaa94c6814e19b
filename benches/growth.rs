//! Growth of time and memory of a first shot with faces and texels: a room of N×N faces per wall
//! around a box. Prints the slopes of the logarithms.

use common::mesh::Mesh;
use common::passes::Engine;
use common::scene::Scene;
use common::settings::Transport;
use common::shooting::ShotOrder;
use cpu::CpuSolver;
use glam::{DVec3, Vec3};
use gpu::{Gpu, GpuSolver};
use radiosity_tests::engines::run_shots;
use radiosity_tests::{box_faces, divide_faces};
use std::time::Instant;

/// Faces per side of a wall and texels per side of a face: growing faces with 10⁵ texels.
const FACE_SIZES: [[u32; 2]; 4] = [[4, 32], [13, 10], [41, 3], [129, 1]];
const TEXEL_SIZES: [[u32; 2]; 4] = [[4, 10], [4, 32], [4, 100], [4, 316]];
/// Timed first shots.
const TIMED_SHOTS: usize = 4;
/// Most texels on a GPU, for software adapters.
const MAX_GPU_TEXELS: usize = 2_000_000;

fn main() {
    let gpu = Gpu::open(None).ok();
    for (name, sizes) in [("faces", FACE_SIZES), ("texels", TEXEL_SIZES)] {
        for on_gpu in [false, true] {
            let adapter = gpu.as_ref().filter(|_| on_gpu);
            if on_gpu && adapter.is_none() {
                println!("no adapter: the GPU is left out");
                continue;
            }
            println!("{name}, {}", adapter.map_or("CPU", |gpu| &gpu.line.name));
            let points = sizes.iter().filter_map(|size| measure_growth(name, *size, adapter));
            let points: Vec<[f64; 3]> = points.collect();
            for pair in points.windows(2) {
                let [from, to] = [pair[0], pair[1]];
                let slope = |k: usize| (to[k] / from[k]).ln() / (to[0] / from[0]).ln();
                println!(
                    "  {:.0} to {:.0} {name}: slope {:.2} of time, {:.2} of memory",
                    from[0],
                    to[0],
                    slope(1),
                    slope(2),
                );
            }
        }
    }
}

fn room_of_faces(side: u32) -> Scene {
    let grey = Vec3::splat(0.7);
    let walls = box_faces(DVec3::ZERO, DVec3::ONE, true, Vec3::ONE, grey);
    let mut faces = divide_faces(&walls, side);
    let (low, high) = (DVec3::splat(0.3), DVec3::splat(0.6));
    faces.extend(box_faces(low, high, false, Vec3::ZERO, grey));
    Scene {
        faces,
        ..Scene::default()
    }
}

/// Returns the number of faces or texels, the seconds of a first shot, and the bytes.
fn measure_growth(name: &str, [side, texels]: [u32; 2], gpu: Option<&Gpu>) -> Option<[f64; 3]> {
    let before = resident_bytes();
    let start = Instant::now();
    let mesh = Mesh::uniform(&room_of_faces(side), texels, 1).expect("the room is sound");
    if gpu.is_some() && mesh.texels.len() > MAX_GPU_TEXELS {
        return None;
    }
    let transport = Transport::default();
    let mut engine: Box<dyn Engine> = match gpu {
        Some(gpu) => Box::new(GpuSolver::new(gpu, &mesh, &transport).expect("it fits")),
        None => Box::new(CpuSolver::new(&mesh, &transport)),
    };
    let prepare = start.elapsed().as_secs_f64();
    let every = mesh.patches.len() / TIMED_SHOTS;
    let log: Vec<u32> = (0..TIMED_SHOTS).map(|k| (k * every) as u32).collect();
    let start = Instant::now();
    run_shots(&mut *engine, ShotOrder::Replay(&log), TIMED_SHOTS as u32);
    let shot = start.elapsed().as_secs_f64() / TIMED_SHOTS as f64;
    let bytes = resident_bytes() - before;
    println!(
        "  {:6} faces {:9} texels: prepared in {prepare:.3} s, a first shot {:.2} ms, {:.0} MB",
        mesh.faces.len(),
        mesh.texels.len(),
        shot * 1e3,
        bytes / 1e6
    );
    let (faces, texels) = (mesh.faces.len(), mesh.texels.len());
    let size = if name == "faces" { faces } else { texels };
    Some([size as f64, shot, bytes.max(1.0)])
}

/// Returns the resident memory of the process, bytes; 0 if unknown.
fn resident_bytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmRSS:"));
    let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok());
    kilobytes.unwrap_or(0.0) * 1024.0
}
