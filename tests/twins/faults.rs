//! `compare` notices each planted fault, and passes without one.

use common::scene::Scene;
use common::settings::{ItemBufferProjection, Visibility};
use gpu::{Gpu, ShaderFault};
use oracle::compare::comparison::{Comparison, Criterion};
use oracle::diff::difference::compare_fields;
use radiosity_tests::engines::item_buffer;
use radiosity_tests::shader_faults::{
    DEPOSIT_FAULTS, FORM_FACTOR_FAULTS, ITEM_BUFFER_FAULTS, NamedFault, assert_faults_noticed, compare_with_faults,
    failing_criteria, paper_settings, shader_fault,
};
use radiosity_tests::{box_in_room, furnace};

/// Compares the solvers on a box in a room, by an item buffer.
fn compare_box(texels: u32, faults: &[ShaderFault]) -> Comparison {
    compare_scene(&box_in_room(), item_buffer(512), texels, faults)
}

/// Compares the solvers by the paper's settings.
fn compare_scene(scene: &Scene, visibility: Visibility, texels: u32, faults: &[ShaderFault]) -> Comparison {
    let gpu = Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh");
    let settings = paper_settings(visibility, texels, 0.02, 200);
    compare_with_faults(scene, settings, &gpu, faults).unwrap()
}

fn assert_noticed(name: &str, faults: &[ShaderFault]) {
    // For a fault of one pixel some texels must lie where one pixel decides.
    let texels = if faults.iter().any(|fault| fault.from.contains("p.x")) {
        32
    } else {
        8
    };
    let comparison = compare_box(texels, faults);
    println!("{name}: {:?}", failing_criteria(&comparison));
    assert!(!comparison.solvers_agree(), "{name} was not noticed");
}

fn assert_each_noticed(faults: &[NamedFault]) {
    for NamedFault { name, fault } in faults {
        assert_noticed(name, &[*fault]);
    }
}

#[test]
fn solvers_without_fault_agree() {
    let comparison = compare_box(8, &[]);
    assert!(comparison.solvers_agree(), "{:?}", failing_criteria(&comparison));
}

#[test]
fn form_factor_faults_are_noticed() {
    assert_each_noticed(&FORM_FACTOR_FAULTS);
}

#[test]
fn deposit_faults_are_noticed() {
    assert_each_noticed(&DEPOSIT_FAULTS);
}

#[test]
fn item_buffer_faults_are_noticed() {
    assert_each_noticed(&ITEM_BUFFER_FAULTS);
}

#[test]
fn hemicube_faults_are_noticed() {
    let hemicube = Visibility::with_item_buffer(ItemBufferProjection::Hemicube, 512);
    let comparison = compare_scene(&box_in_room(), hemicube, 8, &[]);
    assert!(comparison.solvers_agree(), "{:?}", failing_criteria(&comparison));
    let faults = [
        shader_fault("hemicube", "select(2u, 1u, p.x >= 0.0)", "select(1u, 2u, p.x >= 0.0)"),
        shader_fault("hemicube", "select(-1.0, 1.0, (side", "select(1.0, -1.0, (side"),
        shader_fault(
            "item_buffer",
            "index / 6u % IMAGE_PLANES",
            "index / 6u % (IMAGE_PLANES - 1u)",
        ),
        shader_fault("item_buffer", "unfold_side(side, p)", "unfold_side(side, p.yx)"),
        // Sides are planes: their bounds are tight.
        shader_fault("image_bound", "limits.xy - pixel", "limits.xy + pixel"),
        shader_fault("image_bound", "limits.zw + pixel", "limits.zw - pixel"),
        shader_fault("projection", "v.z >= max(", "v.z >= 2.0 * max("),
    ];
    assert_faults_noticed(faults, |fault| {
        let comparison = compare_scene(&box_in_room(), hemicube, 8, &[fault]);
        println!("{}, {}: {:?}", fault.file, fault.to, failing_criteria(&comparison));
        !comparison.solvers_agree()
    });
}

#[test]
fn tie_to_highest_patch_is_noticed() {
    let faults = [
        shader_fault("select", "if power > best {", "if power >= best {"),
        shader_fault("select", "other < lane_patch[lane]", "other > lane_patch[lane]"),
    ];
    assert_noticed("a tie to the highest", &faults);
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
    zero.radiosity.iter_mut().for_each(|b| *b = glam::Vec4::ZERO);
    assert!(compare_fields(&comparison.mesh, &zero, field).relative_rms > 0.5);
}

#[test]
fn energy_loss_of_a_thousandth_is_noticed() {
    let fault = shader_fault(
        "deposit",
        "irradiance[k].xyz + received, f)",
        "irradiance[k].xyz + received * 1.001, f)",
    );
    let comparison = compare_box(8, &[fault]);
    let failing = failing_criteria(&comparison);
    let fails = |name: &str| failing.iter().any(|text| text.starts_with(name));
    assert!(fails("energy imbalance, GPU:"), "{failing:?}");
    assert!(!fails("energy imbalance, CPU:"), "{failing:?}");
}

/// The bound on errors of pixels follows from the scene: where no texel lies near a silhouette it is rounding.
#[test]
fn scene_without_silhouettes_allows_rounding_only() {
    let comparison = compare_scene(&furnace(0.5), item_buffer(512), 4, &[]);
    assert!(comparison.solvers_agree(), "{:?}", failing_criteria(&comparison));
    assert_eq!(comparison.pairs.explainable, 0);
    let bound = |name: &str| {
        let gate = comparison.criteria.iter().find(|gate| gate.name == name);
        gate.unwrap_or_else(|| panic!("{name}")).bound
    };
    assert_eq!(bound("visibility: mismatched share"), 0.0);
    assert!(bound("lockstep: relative RMS") < 1e-4);
    // ε = 2 % is left unshot by either, and reflected by half.
    assert!(bound("free: relative RMS") < 0.1);
}

/// The bound on radiosity is of the size of the errors.
#[test]
fn silhouette_bound_is_tight() {
    let comparison = compare_box(16, &[]);
    let gate = |name: &str| {
        let gate = comparison.criteria.iter().find(|gate| gate.name == name);
        gate.unwrap_or_else(|| panic!("{name}"))
    };
    let lockstep = gate("lockstep: relative RMS");
    println!("{:.3e} of {:.3e}", lockstep.value, lockstep.bound);
    assert!(lockstep.value <= lockstep.bound && lockstep.bound < 0.1);
}
