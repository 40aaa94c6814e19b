//! The dense solver against a path tracer's radiosity of the Cornell box, area means per texel, in the folder `truth/`
//! of RADIOSITY_DATA.

use common::import::{ImportOptions, load_scene};
use common::solution::StoredSolution;
use oracle::diff::pair::GridPair;
use oracle::diff::reflected::ReflectedField;
use radiosity_tests::radiance_files::data_folder;
use radiosity_tests::solutions::dense_truth_on;

#[test]
fn dense_cornell_box_agrees_with_path_tracer() {
    let Some(data) = data_folder() else {
        return;
    };
    let folder = data.join("truth");
    let scene = load_scene(&folder.join("cornell.obj"), &ImportOptions::default()).unwrap();
    let (mesh, field) = dense_truth_on(&scene, 16);
    let traced = StoredSolution::read(&folder.join("cornell_16")).unwrap();
    let dense = ReflectedField::from_field(&scene, &mesh, &field);
    let (rms, bias) = GridPair::new(&dense, &ReflectedField::from(&traced), None)
        .unwrap()
        .worst_channel();
    println!("RMS {rms}, bias {bias}");
    assert!(rms <= 5e-3, "{rms}");
    assert!(bias.abs() <= 2e-3, "{bias}");
}
