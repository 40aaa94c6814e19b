//! `compare` notices each planted fault, passes without one, and its bounds are of the size of the errors.

use common::scene::Scene;
use common::settings::Visibility;
use glam::Vec4;
use gpu::ShaderFault;
use oracle::compare::comparison::{Comparison, Criterion};
use oracle::diff::difference::compare_fields;
use radiosity_tests::engines::item_buffer;
use radiosity_tests::shader_faults::{assert_faults_noticed, compare_with_faults, failing_criteria, paper_settings};
use radiosity_tests::{box_in_room, furnace};

/// Compares the solvers by the paper's settings.
fn compare_scene(scene: &Scene, visibility: Visibility, texels: u32, faults: &[ShaderFault]) -> Comparison {
    compare_with_faults(scene, paper_settings(visibility, texels, 0.02, 200), faults).unwrap()
}

/// Compares the solvers on a box in a room, by an item buffer.
fn compare_box(texels: u32, faults: &[ShaderFault]) -> Comparison {
    compare_scene(&box_in_room(), item_buffer(512), texels, faults)
}

fn criterion<'c>(comparison: &'c Comparison, name: &str) -> &'c Criterion {
    let found = comparison.criteria.iter().find(|criterion| criterion.name == name);
    found.unwrap_or_else(|| panic!("no criterion {name}"))
}

#[test]
fn planted_faults_are_noticed() {
    assert_faults_noticed("compare", |faults| {
        // For a lookup one pixel off some texels must lie where one pixel decides.
        let one_pixel = faults.iter().any(|fault| fault.file == "lookup");
        failing_criteria(&compare_box(if one_pixel { 32 } else { 8 }, faults))
    });
}

#[test]
fn identical_fields_are_refused() {
    let comparison = compare_box(8, &[]);
    let field = &comparison.cpu.field;
    let same = compare_fields(&comparison.mesh, field, field);
    assert!(!Criterion::at_most("identical", same.relative_rms, 1.0, "").pass);
    let mut empty = field.clone();
    empty.origin = "empty".into();
    empty.radiosity.clear();
    assert!(compare_fields(&comparison.mesh, &empty, field).relative_rms.is_nan());
    let mut zero = field.clone();
    zero.origin = "zero".into();
    zero.radiosity.fill(Vec4::ZERO);
    assert!(compare_fields(&comparison.mesh, &zero, field).relative_rms > 0.5);
}

#[test]
fn energy_loss_of_a_thousandth_is_noticed() {
    let fault = ShaderFault {
        file: "deposit",
        from: "irradiance[k].xyz + received, f)",
        to: "irradiance[k].xyz + received * 1.001, f)",
    };
    let comparison = compare_box(8, &[fault]);
    assert!(!criterion(&comparison, "energy imbalance, GPU").pass);
    assert!(criterion(&comparison, "energy imbalance, CPU").pass);
}

/// The bound on errors of pixels follows from the scene: where no texel lies near a silhouette it is rounding.
#[test]
fn scene_without_silhouettes_allows_rounding_only() {
    let comparison = compare_scene(&furnace(0.5), item_buffer(512), 4, &[]);
    assert!(comparison.solvers_agree(), "{:?}", failing_criteria(&comparison));
    assert_eq!(comparison.pairs.explainable, 0);
    assert_eq!(criterion(&comparison, "visibility: mismatched share").bound, 0.0);
    assert!(criterion(&comparison, "lockstep: relative RMS").bound < 1e-4);
    // ε = 2 % is left unshot by either, and reflected by half.
    assert!(criterion(&comparison, "free: relative RMS").bound < 0.1);
}

/// The bound on radiosity is of the size of the errors.
#[test]
fn silhouette_bound_is_tight() {
    let comparison = compare_box(16, &[]);
    let lockstep = criterion(&comparison, "lockstep: relative RMS");
    assert!(lockstep.value <= lockstep.bound && lockstep.bound < 0.1);
}
