//! Compares a solve of the paper's room with its objects to 1 % with the time that Embree takes for
//! the rays of plain Southwell. Whole faces, disc factors between centres, two threads each.

use common::form_factor::{FormFactor, form_factor};
use common::mesh::Mesh;
use common::rays::Rays;
use cpu::CpuSolver;
use glam::Vec3;
use radiosity_benches::accuracy::AccuracyTarget;
use radiosity_benches::{median_and_range, whole_faces};
use radiosity_tests::bundled_scene;
use radiosity_tests::engines::solve_by_schedule;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

const TEXELS_PER_SIDE: u32 = 32;
const THREAD_COUNT: usize = 2;
const ERROR_BOUND: f64 = 0.01;
const TIMED_ROUNDS: usize = 5;

fn main() {
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/peers/embree_rays");
    if !program.exists() {
        println!("Embree's rays: skipped, `make peers` has not built target/peers/embree_rays");
        return;
    }
    let pool = ThreadPoolBuilder::new().num_threads(THREAD_COUNT);
    let pool = pool.build().expect("threads start");
    let result = pool.install(|| compare_with_embree(&program));
    let out = Path::new(env!("CARGO_MANIFEST_DIR")).join("../out");
    let text = serde_json::to_string_pretty(&result).expect("JSON is written");
    std::fs::create_dir_all(&out).expect("out/ can be made");
    std::fs::write(out.join("embree.json"), text).expect("out/ can be written");
}

fn compare_with_embree(program: &Path) -> Value {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let scene = bundled_scene("paper_room_objects.obj");
    let start = Instant::now();
    let mesh = Mesh::uniform(&scene, TEXELS_PER_SIDE, 1).expect("the scene is sound");
    let meshing = start.elapsed().as_secs_f64();
    let target = AccuracyTarget::new(mesh, whole_faces(TEXELS_PER_SIDE));
    let mesh = &target.mesh;
    let shots = target.southwell_shots(ERROR_BOUND);
    let rays = root.join("target/peers/rays.bin");
    dump_rays(&rays, mesh, &shots).expect("target/peers can be written");
    let settings = target.settings_to(ERROR_BOUND);
    println!(
        "{} faces, {} texels; plain Southwell to {} %: {} shots; texels made in {meshing:.3} s",
        mesh.faces.len(),
        mesh.texels.len(),
        ERROR_BOUND * 100.0,
        shots.len()
    );

    let rounds: Vec<Value> = (0..TIMED_ROUNDS)
        .map(|_| {
            let start = Instant::now();
            let run = solve_by_schedule(&mut CpuSolver::new(mesh, &settings.transport), mesh, &settings.schedule);
            let ours = start.elapsed().as_secs_f64();
            let theirs = run_embree(program, &rays, THREAD_COUNT);
            json!({
                "solve": ours,
                "shots": run.shooters,
                "passes": run.passes,
                "error": target.relative_rms(&run.field),
                "single": theirs["single"]["seconds"],
                "packets": theirs["packets"]["seconds"],
                "embree": theirs,
            })
        })
        .collect();
    for kind in ["packets", "single"] {
        print_report(kind, &rounds);
    }
    json!({ "faces": mesh.faces.len(), "texels": mesh.texels.len(), "mesh_seconds": meshing, "shots": shots.len(), "bound": ERROR_BOUND,
        "epsilon": settings.schedule.epsilon, "threads": THREAD_COUNT, "rounds": rounds })
}

fn print_report(kind: &str, rounds: &[Value]) {
    let show = |of: &dyn Fn(&Value) -> Option<f64>| {
        let [median, least, largest] = median_and_range(rounds.iter().map(|round| of(round).unwrap_or(f64::NAN)));
        format!("{median:.3} ({least:.3}, {largest:.3})")
    };
    println!(
        "Embree {kind}: solve {} s, rays {} s, ratio {}; {:.1} Mray/s, answers unlike ours {:.4} %",
        show(&|round| round["solve"].as_f64()),
        show(&|round| round[kind].as_f64()),
        show(&|round| Some(round["solve"].as_f64()? / round[kind].as_f64()?)),
        rounds[0]["embree"][kind]["mrays_per_second"]
            .as_f64()
            .unwrap_or(f64::NAN),
        rounds[0]["embree"][kind]["unlike_ours"].as_f64().unwrap_or(f64::NAN) * 100.0,
    );
}

/// Writes the rays of a solve's `shots`, from the centre of every shooter to the centre of every texel.
///
/// Format, little-endian: u32 counts of triangles, shooters, texels, shots; f32 corners of the triangles, centres of the
/// shooters, centres of the texels; u32 shooter of each shot; one byte for each (shooter, texel), the result of our
/// rays: 0 hidden, 1 visible, 2 not facing each other.
fn dump_rays(path: &Path, mesh: &Mesh, shots: &[u32]) -> std::io::Result<()> {
    let triangles = mesh_triangles(mesh);
    let mut file = BufWriter::new(File::create(path)?);
    for count in [triangles.len(), mesh.patches.len(), mesh.texels.len(), shots.len()] {
        file.write_all(&(count as u32).to_le_bytes())?;
    }
    let centres = mesh.patches.iter().map(|patch| patch.shooter.centre);
    let texels = mesh.texels.iter().map(|texel| texel.position);
    for point in triangles.into_iter().flatten().chain(centres).chain(texels) {
        for x in point.to_array() {
            file.write_all(&x.to_le_bytes())?;
        }
    }
    for shooter in shots {
        file.write_all(&shooter.to_le_bytes())?;
    }
    let rays = Rays::new(mesh);
    for shooter in 0..mesh.patches.len() {
        file.write_all(&trace_answers(mesh, &rays, shooter))?;
    }
    file.flush()
}

fn mesh_triangles(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for face in mesh.faces.iter().filter(|face| face.normal != Vec3::ZERO) {
        let [a, b, c, d] = face.corners;
        triangles.push([a, b, c]);
        if c != d {
            triangles.push([a, c, d]);
        }
    }
    triangles
}

fn trace_answers(mesh: &Mesh, rays: &Rays, shooter: usize) -> Vec<u8> {
    let patch = &mesh.patches[shooter];
    let answer = |k: usize| {
        let texel = &mesh.texels[k];
        let normal = mesh.faces[texel.face as usize].normal;
        let factor = form_factor(FormFactor::Disc, &patch.shooter, texel.position, normal, texel.area);
        if factor == 0.0 {
            return 2;
        }
        u8::from(rays.is_visible(patch.shooter.centre, texel.position, [patch.face, texel.face]))
    };
    (0..mesh.texels.len()).into_par_iter().map(answer).collect()
}

/// Runs Embree's program on the rays in `dump` and returns its JSON. Panics if it fails.
fn run_embree(program: &Path, dump: &Path, threads: usize) -> Value {
    let output = Command::new(program)
        .arg(dump)
        .arg(threads.to_string())
        .output()
        .expect("Embree's program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("Embree's program writes JSON")
}
