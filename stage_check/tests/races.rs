//! Races within a workgroup are found where no value shows them.

use crate::{BLOCK_SUMS, MATRIX_PRODUCT, REDUCTION, check_block_sums, check_matrix_product, check_reduction};
use crate::{plant_fault, shared_gpu, tied_keys};
use stage_check::races::RaceReport;
use stage_check::{Bound, Case, Failure, Fault, Report, Stage};

/// Returns the races that a check found; prints its message.
#[track_caller]
fn races(checked: Result<Report, Failure>) -> RaceReport {
    let failure = checked.unwrap_err();
    println!("{failure}");
    match failure.fault {
        Fault::Race(report) => report,
        _ => panic!("no race: {failure}"),
    }
}

/// Removes the barrier number `k` of a text.
fn remove_barrier(text: &str, k: usize) -> String {
    let (at, barrier) = text.match_indices("workgroupBarrier();").nth(k).unwrap();
    [&text[..at], &text[at + barrier.len()..]].concat()
}

#[test]
fn each_barrier_of_three_shaders_is_missed() {
    for k in 0..2 {
        let first = races(check_block_sums(&remove_barrier(BLOCK_SUMS, k))).first.unwrap();
        assert_eq!(first.variable, "partial");
        let first = races(check_matrix_product(&remove_barrier(MATRIX_PRODUCT, k)))
            .first
            .unwrap();
        assert!(["tile_a", "tile_b"].contains(&first.variable.as_str()));
        assert!(first.element < 64 && first.lanes.iter().all(|lane| *lane < 64));
        assert_ne!(first.lanes[0], first.lanes[1]);
    }
    let fault = remove_barrier(REDUCTION, 0);
    let report = races(check_reduction(&fault, tied_keys, Bound::Exact));
    assert_eq!(report.first.unwrap().variable, "best");
    assert!(0 < report.races && report.races < report.accesses);
}

#[test]
fn lane_too_many_races_though_the_values_agree() {
    let fault = plant_fault(REDUCTION, "if lane < half {", "if lane <= half {");
    let report = races(check_reduction(&fault, tied_keys, Bound::Exact));
    assert_eq!(report.first.unwrap().variable, "best");
}

/// A sum that lane 0 stores in a single value, and that the others read behind the barrier.
const SHARED_VALUE: &str = "
struct Ids { @builtin(local_invocation_id) place: vec3u, @builtin(workgroup_id) group: vec3u }
@group(0) @binding(0) var<storage, read> x: array<u32>;
@group(0) @binding(1) var<storage, read_write> shares: array<u32>;
@group(0) @binding(2) var<storage, read_write> header: array<u32>;
var<workgroup> sum: u32;
var<workgroup> highest: atomic<u32>;
@compute @workgroup_size(4, 2)
fn divide(ids: Ids) {
    let lane = ids.place.x + 4u * ids.place.y;
    let k = 8u * ids.group.x + lane;
    if lane == 0u {
        for (var j = 8u * ids.group.x; j < min(8u * ids.group.x + 8u, arrayLength(&x)); j++) { sum += x[j]; }
    }
    atomicMax(&highest, lane);
    workgroupBarrier();
    let offset = header[0];
    storageBarrier();
    if lane == 0u && ids.group.x == 0u { header[0] = 7u; }
    if k < arrayLength(&x) { shares[k] = sum - x[k] + offset; }
}";

fn check_shared_value(text: &str) -> Result<Report, Failure> {
    // More workgroups would read what the first writes.
    let stage = Stage::new(shared_gpu(), "divide.wgsl", text, "divide")?.with_sizes(&[1, 7, 8]);
    stage.check(|size| {
        let x: Vec<u32> = (1..=size as u32).collect();
        let sum: u32 = x.iter().sum();
        let shares: Vec<u32> = x.iter().map(|x| sum - x + 5).collect();
        Case::new()
            .input("x", &x)
            .input("header", &[5u32])
            .output("shares", &shares, Bound::Exact)
            .output("header", &[7u32], Bound::Exact)
    })
}

#[test]
fn single_values_and_elements_of_storage_are_watched() {
    check_shared_value(SHARED_VALUE).unwrap();
    let first = races(check_shared_value(&remove_barrier(SHARED_VALUE, 0)))
        .first
        .unwrap();
    assert_eq!((first.variable.as_str(), first.element), ("sum", 0));
    let fault = plant_fault(SHARED_VALUE, "    storageBarrier();\n", "");
    let first = races(check_shared_value(&fault)).first.unwrap();
    assert_eq!((first.variable.as_str(), first.element), ("header", 0));
}

#[test]
fn several_readers_are_all_beside_the_writer() {
    // Every lane reads, lane 3 twice and last: only the readers before it tell.
    let fault = plant_fault(
        SHARED_VALUE,
        "    let offset",
        "    if lane == 3u { let a = sum; let b = sum; sum = (a + b) / 2u; }\n    let offset",
    );
    let first = races(check_shared_value(&fault)).first.unwrap();
    assert_eq!(first.variable, "sum");
}

#[test]
fn what_cannot_be_followed_is_no_race() {
    // Components of one element are places of their own.
    let text = SHARED_VALUE
        .replace("var<workgroup> sum: u32;", "var<workgroup> sum: vec2u;")
        .replace("sum += x[j]", "sum.x += x[j]")
        .replace("sum - x[k]", "sum.x - x[k]")
        .replace("atomicMax(&highest, lane);", "if lane == 1u { sum.y = 1u; }");
    check_shared_value(&text).unwrap();
    // So are values behind pointers.
    let text = SHARED_VALUE.replace(
        "let offset = header[0];",
        "let p = &sum; let offset = header[0] + 0u * *p;",
    );
    check_shared_value(&text).unwrap();
}
