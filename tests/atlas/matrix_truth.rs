//! The dense solver against a path tracer's radiosity of the Cornell box, area means per texel, in the folder `truth/`
//! of RADIOSITY_DATA.

use common::import::{ImportOptions, load_scene};
use common::mesh::Mesh;
use cpu::dense::Matrix;
use exr::prelude::read_first_flat_layer_from_file;
use glam::DVec3;
use radiosity_tests::dense::solve_matrix;
use radiosity_tests::radiance_files::data_folder;
use serde_json::Value;
use std::ops::ControlFlow;
use std::path::Path;

/// Reflected radiosity of each texel by the path tracer, and its standard error.
struct Truth {
    values: Vec<DVec3>,
    errors: Vec<DVec3>,
}

fn read_truth(folder: &Path, mesh: &Mesh) -> Truth {
    let text = std::fs::read(folder.join("result.json")).unwrap();
    let result: Value = serde_json::from_slice(&text).unwrap();
    let layer = read_first_flat_layer_from_file(folder.join("lightmap.exr"))
        .unwrap()
        .layer_data;
    let channel = |name: &str| -> Vec<f64> {
        let found = layer.channel_data.list.iter().find(|c| c.name.to_string() == name);
        let samples = &found.unwrap_or_else(|| panic!("no channel {name}")).sample_data;
        samples.values_as_f32().map(f64::from).collect()
    };
    let pick = |prefix: &str| -> Vec<DVec3> {
        let [r, g, b] = ["R", "G", "B"].map(|c| channel(&format!("{prefix}{c}")));
        mesh.texels
            .iter()
            .map(|texel| {
                let rect = &result["faces"][texel.face as usize]["rect"];
                let at = |k: usize| rect[k].as_u64().unwrap() as usize;
                let index = texel.index as usize;
                let pixel = (at(1) + index / at(2)) * layer.size.width() + at(0) + index % at(2);
                DVec3::new(r[pixel], g[pixel], b[pixel])
            })
            .collect()
    };
    let emitted = mesh.texels.iter().map(|t| t.emission.as_dvec3());
    Truth {
        values: pick("").iter().zip(emitted).map(|(b, e)| b - e).collect(),
        errors: pick("error."),
    }
}

#[test]
fn dense_cornell_box_agrees_with_path_tracer() {
    let Some(data) = data_folder() else {
        return;
    };
    let folder = data.join("truth");
    let scene = load_scene(&folder.join("cornell.obj"), &ImportOptions::default()).unwrap();
    let mesh = Mesh::uniform(&scene, 16, 1).unwrap();
    let truth = read_truth(&folder.join("cornell_16"), &mesh);
    let (matrix, _) = Matrix::assemble(&scene, &mesh, &mut |_, _| ControlFlow::Continue(())).unwrap();
    let answer = solve_matrix(&mesh, &matrix);
    let (mut square, mut scale, mut noise) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    let (mut bias, mut sum) = (DVec3::ZERO, DVec3::ZERO);
    for (k, b) in truth.values.iter().enumerate() {
        let area = matrix.areas[k];
        let difference = answer.radiosity[k] - mesh.texels[k].emission.as_dvec3() - b;
        square += difference * difference * area;
        scale += b * b * area;
        noise += truth.errors[k] * truth.errors[k] * area;
        bias += difference * area;
        sum += b * area;
    }
    let rms = (
        (square / scale).map(f64::sqrt),
        (noise / scale).map(f64::sqrt),
        bias / sum,
    );
    println!("RMS {} (noise of the truth {}), bias {}", rms.0, rms.1, rms.2);
    assert!(rms.0.max_element() <= 5e-3, "{rms:?}");
    assert!(rms.2.abs().max_element() <= 2e-3, "{rms:?}");
}
