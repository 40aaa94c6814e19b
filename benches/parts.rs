//! Benchmarks of the parts of a solve, each at three sizes: form factors of one shooter with all
//! texels, and the import of a scene.

use common::form_factor::{FormFactor, form_factor};
use common::import::{ImportOptions, load_scene};
use common::mesh::Mesh;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use radiosity_benches::bench_scenes;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Duration;

fn bench_form_factors(criterion: &mut Criterion) {
    for (name, kind) in [("disc", FormFactor::Disc), ("polygon", FormFactor::Polygon)] {
        let mut group = criterion.benchmark_group(format!("form factor, {name}"));
        group.measurement_time(Duration::from_secs(2));
        for (scene, texels) in bench_scenes() {
            let mesh = Mesh::uniform(&scene, texels, 1).expect("the rooms are sound");
            let shooter = mesh.patches[0].shooter;
            // The rate is that of single evaluations.
            group.throughput(Throughput::Elements(mesh.texels.len() as u64));
            group.bench_function(BenchmarkId::from_parameter(mesh.texels.len()), |bencher| {
                bencher.iter(|| {
                    let of = |texel: &common::mesh::Texel| {
                        let normal = mesh.faces[texel.face as usize].normal;
                        form_factor(kind, black_box(&shooter), texel.position, normal, texel.area)
                    };
                    mesh.texels.iter().map(of).sum::<f32>()
                });
            });
        }
        group.finish();
    }
}

fn bench_import(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("import of an OBJ");
    group.sample_size(20).measurement_time(Duration::from_secs(2));
    for side in [10, 32, 100] {
        let path = std::env::temp_dir().join(format!("radiosity-grid-{}.obj", std::process::id()));
        std::fs::write(&path, grid_obj(side)).expect("the temporary folder can be written");
        group.throughput(Throughput::Elements(u64::from(side * side)));
        group.bench_function(BenchmarkId::from_parameter(side * side), |bencher| {
            bencher.iter(|| load_scene(&path, &ImportOptions::default()).expect("the grid is sound"));
        });
        std::fs::remove_file(&path).expect("the grid was written");
    }
    group.finish();
}

/// Returns an OBJ of N×N unit squares.
fn grid_obj(side: u32) -> String {
    let mut text = String::new();
    for k in 0..(side + 1) * (side + 1) {
        let _ = writeln!(text, "v {} 0 {}", k % (side + 1), k / (side + 1));
    }
    for k in 0..side * side {
        let first = k / side * (side + 1) + k % side + 1;
        let above = first + side + 1;
        let _ = writeln!(text, "f {first} {above} {} {}", above + 1, first + 1);
    }
    text
}

criterion_group!(benches, bench_form_factors, bench_import);
criterion_main!(benches);
