//! Compares a solve of the paper's room with its objects to 1 % with the time that Embree takes for
//! the rays of plain Southwell. Whole faces, disc factors between centres, two threads each.

use common::mesh::Mesh;
use cpu::CpuSolver;
use radiosity_benches::accuracy::{AccuracyTarget, run_solve};
use radiosity_benches::rays::{dump_rays, embree_program, run_embree};
use radiosity_benches::{bundled_scene, whole_faces};
use rayon::ThreadPoolBuilder;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

const TEXELS_PER_SIDE: u32 = 32;
const THREAD_COUNT: usize = 2;
const ERROR_BOUND: f64 = 0.01;
const TIMED_ROUNDS: usize = 5;

fn main() {
    let Some(program) = embree_program() else {
        println!("Embree's rays: skipped, `make peers` has not built target/peers/embree_rays");
        return;
    };
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
            let run = run_solve(&mut CpuSolver::new(mesh, &settings.transport), mesh, &settings);
            let ours = start.elapsed().as_secs_f64();
            let theirs = run_embree(program, &rays, THREAD_COUNT);
            json!({
                "solve": ours,
                "shots": run.shooters,
                "passes": run.passes,
                "error": target.relative_rms(&run.field),
                "single": embree_seconds(&theirs, "single"),
                "packets": embree_seconds(&theirs, "packets"),
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

fn embree_seconds(theirs: &Value, kind: &str) -> f64 {
    theirs[kind]["seconds"].as_f64().expect("seconds of Embree")
}

fn print_report(kind: &str, rounds: &[Value]) {
    let of = |key: &str| -> [f64; 3] {
        let values = rounds.iter().map(|round| match key {
            "ratio" => round["solve"].as_f64().zip(round[kind].as_f64()),
            _ => round[key].as_f64().zip(Some(1.0)),
        });
        let mut values: Vec<f64> = values.map(|v| v.map_or(f64::NAN, |(a, b)| a / b)).collect();
        values.sort_by(f64::total_cmp);
        [values[TIMED_ROUNDS / 2], values[0], values[TIMED_ROUNDS - 1]]
    };
    let show = |[median, least, largest]: [f64; 3]| format!("{median:.3} ({least:.3}, {largest:.3})");
    println!(
        "Embree {kind}: solve {} s, rays {} s, ratio {}; {:.1} Mray/s, answers unlike ours {:.4} %",
        show(of("solve")),
        show(of(kind)),
        show(of("ratio")),
        rounds[0]["embree"][kind]["mrays_per_second"]
            .as_f64()
            .unwrap_or(f64::NAN),
        rounds[0]["embree"][kind]["unlike_ours"].as_f64().unwrap_or(f64::NAN) * 100.0,
    );
}
