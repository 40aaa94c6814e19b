//! The paper's room with its objects solved to 1 %, over the time that Embree needs for the rays
//! that plain Southwell would ask on the way. Whole faces, disc factors, centres, two threads each.

use common::mesh::Mesh;
use cpu::CpuSolver;
use radiosity_benches::accuracy::{Target, run};
use radiosity_benches::rays::{dump, embree, trace};
use radiosity_benches::{bundled, whole_faces};
use rayon::ThreadPoolBuilder;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

const TEXELS: u32 = 32;
const THREADS: usize = 2;
const BOUND: f64 = 0.01;
const ROUNDS: usize = 5;

fn main() {
    let Some(program) = embree() else {
        println!("Embree's rays: skipped, `make peers` has not built target/peers/embree_rays");
        return;
    };
    let pool = ThreadPoolBuilder::new().num_threads(THREADS);
    let pool = pool.build().expect("threads start");
    let result = pool.install(|| measure(&program));
    let out = Path::new(env!("CARGO_MANIFEST_DIR")).join("../out");
    let text = serde_json::to_string_pretty(&result).expect("JSON is written");
    std::fs::create_dir_all(&out).expect("out/ can be made");
    std::fs::write(out.join("embree.json"), text).expect("out/ can be written");
}

fn measure(program: &Path) -> Value {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let scene = bundled("paper_room_objects.obj");
    let start = Instant::now();
    let mesh = Mesh::uniform(&scene, TEXELS, 1).expect("the scene is sound");
    let meshing = start.elapsed().as_secs_f64();
    let target = Target::new(mesh, whole_faces(TEXELS));
    let mesh = &target.mesh;
    let shots = target.southwell_shots(BOUND);
    let rays = root.join("target/peers/rays.bin");
    dump(&rays, mesh, &shots).expect("target/peers can be written");
    let settings = target.settings_to(BOUND);
    println!(
        "{} faces, {} texels; plain Southwell to {} %: {} shots; texels made in {meshing:.3} s",
        mesh.faces.len(),
        mesh.texels.len(),
        BOUND * 100.0,
        shots.len()
    );

    let rounds: Vec<Value> = (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            let run = run(
                &mut CpuSolver::new(mesh, &settings.transport),
                mesh,
                &settings,
            );
            let ours = start.elapsed().as_secs_f64();
            let theirs = trace(program, &rays, THREADS);
            json!({
                "solve": ours,
                "shots": run.shooters,
                "passes": run.passes,
                "error": target.error(&run.field),
                "single": seconds(&theirs, "single"),
                "packets": seconds(&theirs, "packets"),
                "embree": theirs,
            })
        })
        .collect();
    for kind in ["packets", "single"] {
        report(kind, &rounds);
    }
    json!({ "faces": mesh.faces.len(), "texels": mesh.texels.len(), "mesh_seconds": meshing, "shots": shots.len(), "bound": BOUND,
        "epsilon": settings.schedule.epsilon, "threads": THREADS, "rounds": rounds })
}

fn seconds(theirs: &Value, kind: &str) -> f64 {
    theirs[kind]["seconds"].as_f64().expect("seconds of Embree")
}

fn report(kind: &str, rounds: &[Value]) {
    let of = |key: &str| -> [f64; 3] {
        let values = rounds.iter().map(|round| match key {
            "ratio" => round["solve"].as_f64().zip(round[kind].as_f64()),
            _ => round[key].as_f64().zip(Some(1.0)),
        });
        let mut values: Vec<f64> = values.map(|v| v.map_or(f64::NAN, |(a, b)| a / b)).collect();
        values.sort_by(f64::total_cmp);
        [values[ROUNDS / 2], values[0], values[ROUNDS - 1]]
    };
    let show =
        |[median, least, largest]: [f64; 3]| format!("{median:.3} ({least:.3}, {largest:.3})");
    println!(
        "Embree {kind}: solve {} s, rays {} s, ratio {}; {:.1} Mray/s, answers unlike ours {:.4} %",
        show(of("solve")),
        show(of(kind)),
        show(of("ratio")),
        rounds[0]["embree"][kind]["mrays_per_second"]
            .as_f64()
            .unwrap_or(f64::NAN),
        rounds[0]["embree"][kind]["unlike_ours"]
            .as_f64()
            .unwrap_or(f64::NAN)
            * 100.0,
    );
}
