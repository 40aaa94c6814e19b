//! Times of the stages of a solve by passes, beside the least bytes and operations of each.
//!
//! `cargo run --release -p radiosity-gpu --example profile [SCENE] [TEXELS] [rays|stereographic|…] [polygon|disc]`

use common::Result;
use common::cover::sampled_mesh;
use common::form_factor::FormFactor;
use common::import::{ImportOptions, load_scene};
use common::mesh::Mesh;
use common::settings::{ItemBufferProjection, ItemBufferSettings, Meshing, Raster, Settings, Transport, Visibility};
use gpu::profile::{has_device_clock, measure_machine, profile_stages};
use gpu::{Gpu, GpuSolver};
use std::path::Path;

/// Passes of conjugate gradients in the reference room.
const PASSES: u32 = 8;
/// Runs of which each stage's least time counts.
const RUNS: usize = 3;
/// NVIDIA's figures for an H200 SXM: bytes and f32 operations a second.
const H200: [f64; 2] = [4.8e12, 67e12];

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |k: usize, default| arguments.get(k).map_or(default, String::as_str);
    let drawn = |projection| Visibility::with_item_buffer(projection, ItemBufferSettings::DEFAULT.size);
    let visibility = match argument(2, "stereographic") {
        "rays" => Visibility::Rays,
        "hemicube" => drawn(ItemBufferProjection::Hemicube),
        "hemisphere" => drawn(ItemBufferProjection::Hemisphere(Raster::Pixel)),
        _ => Visibility::ItemBuffer(ItemBufferSettings::DEFAULT),
    };
    let settings = Settings {
        meshing: Meshing {
            texels: argument(1, "32").parse().unwrap_or(32),
            patches: 1,
            ..Meshing::default()
        },
        transport: Transport {
            visibility,
            form_factor: match argument(3, "polygon") {
                "disc" => FormFactor::Disc,
                _ => FormFactor::Polygon,
            },
            ..Transport::default()
        },
        ..Settings::default()
    };
    let path = Path::new(argument(0, "scenes/paper_room_objects.obj"));
    let scene = load_scene(path, &ImportOptions::default())?;
    let mesh = sampled_mesh(&scene, &settings.meshing)?;
    let gpu = Gpu::open_timed(None)?;
    let here = measure_machine(&gpu)?;
    let clock = if has_device_clock(&gpu) { "device" } else { "host" };
    println!(
        "{}, {} faces, {} texels, {}, times by the {clock}'s clock",
        gpu.line.name,
        mesh.faces.len(),
        mesh.texels.len(),
        visibility.name(),
    );
    println!(
        "copies {:.1} GB/s, computes {:.1} GFLOP/s",
        here[0] / 1e9,
        here[1] / 1e9
    );
    let mut solver = GpuSolver::new(&gpu, &mesh, &settings.transport)?;
    let mut best = profile_stages(&mut solver, PASSES)?;
    for _ in 1..RUNS {
        for (best, again) in best.iter_mut().zip(profile_stages(&mut solver, PASSES)?) {
            best.1 = best.1.min(again.1);
        }
    }
    println!(
        "{:<10} {:>10} {:>10} {:>10} {:>11} {:>8} {:>11}",
        "stage", "ms", "MB", "MFLOP", "floor ms", "times", "H200 µs"
    );
    for ((stage, seconds), work) in best.iter().zip(floors(&mesh, &settings.transport)) {
        let floor = |machine: [f64; 2]| (work[0] / machine[0]).max(work[1] / machine[1]);
        println!(
            "{stage:<10} {:>10.3} {:>10.1} {:>10.1} {:>11.3} {:>8.1} {:>11.1}",
            seconds * 1e3,
            work[0] / 1e6,
            work[1] / 1e6,
            floor(here) * 1e3,
            seconds / floor(here),
            floor(H200) * 1e6,
        );
    }
    Ok(())
}

/// Bytes and operations of each stage, in the order of the profile; docs/measurements.md counts them.
fn floors(mesh: &Mesh, transport: &Transport) -> [[f64; 2]; 7] {
    let (patches, texels) = (mesh.patches.len() as f64, mesh.texels.len() as f64);
    let (pairs, faces) = (patches * texels, mesh.faces.len() as f64);
    let drawing = transport.visibility.item_buffer();
    let pixels = drawing.map_or(0.0, |drawing| patches * drawing.pixel_count() as f64);
    let rays = drawing.is_none();
    // A ray passes as many nodes of eight boxes as the tree has levels, twice over.
    let ray = 2.0 * (faces.log2() / 3.0).ceil().max(1.0) * 8.0 * 16.0 + 4.0 * 50.0;
    let draw = if rays {
        [0.0, 0.0]
    } else {
        [8.0 * pixels, 0.785 * 1.4 * 70.0 * pixels]
    };
    let link = if rays { ray } else { 36.0 * 4.0 + 100.0 };
    [
        draw,
        [4.0 * pairs + 48.0 * texels, (250.0 + link) * pairs],
        [0.0, patches * 1024.0 * ray],
        [4.0 * pairs + 4.0 * patches * patches, 2.0 * pairs],
        [
            f64::from(PASSES) * 4.0 * patches * patches,
            f64::from(PASSES) * 6.0 * patches * patches,
        ],
        [4.0 * pairs + 80.0 * texels, 6.0 * pairs],
        [48.0 * texels, 0.0],
    ]
}
