//! Loops that do not end are found on an adapter that ends them by itself.

use crate::{BLOCK_SUMS, check_block_sums, plant_fault, shared_gpu};
use stage_check::loops::MAX_SOFTWARE_TURNS;
use stage_check::{Bound, Case, Failure, Fault, Report, Stage};

/// Returns the line of the loop that a check found; prints its message.
#[track_caller]
fn endless_loop(checked: Result<Report, Failure>) -> String {
    let failure = checked.unwrap_err();
    println!("{failure}");
    match failure.fault {
        Fault::EndlessLoop(head) => format!("{}: {}", head.line_number, head.line),
        _ => panic!("no endless loop: {failure}"),
    }
}

/// Numbers of bits, summed over rows and rounded up to a multiple of 8.
const BITS_OF_ROWS: &str = "
@group(0) @binding(0) var<storage, read> x: array<u32>;
@group(0) @binding(1) var<storage, read_write> bits: array<u32>;
@compute @workgroup_size(8)
fn count_bits(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&x) { return; }
    var sum = 0u;
    for (var row = 0u; row < ROWS; row++) {
        var rest = x[id.x] ^ row;
        while rest != 0u {
            rest &= rest - 1u;
            sum += 1u;
        }
    }
    loop {
        if sum % 8u == 0u { break; }
        continuing { sum += 1u; }
    }
    bits[id.x] = sum;
}";

fn check_bits(text: &str, rows: u32) -> Result<Report, Failure> {
    let text = text.replace("ROWS", &format!("{rows}u"));
    let stage = Stage::new(shared_gpu(), "bits.wgsl", &text, "count_bits")?.without_many_groups();
    stage.check(|size| {
        let x: Vec<u32> = (0..size as u32).collect();
        let count = |x: &u32| -> u32 { (0..rows).map(|row| (x ^ row).count_ones()).sum() };
        let bits: Vec<u32> = x.iter().map(|x| count(x).next_multiple_of(8)).collect();
        Case::new().input("x", &x).output("bits", &bits, Bound::Exact)
    })
}

#[test]
fn each_kind_of_loop_is_found_and_long_ones_pass() {
    check_bits(BITS_OF_ROWS, 5).unwrap();
    // 4096 rows, and 6 bits of each in the mean: 28 672 turns.
    check_bits(BITS_OF_ROWS, MAX_SOFTWARE_TURNS / 8).unwrap();
    for (from, to, line) in [
        ("row < ROWS", "row >= 0u", "8: for (var row = 0u; row >= 0u; row++)"),
        ("rest &= rest - 1u;", "rest &= rest;", "10: while rest != 0u"),
        ("sum % 8u == 0u", "sum % 8u == 9u", "15: loop"),
    ] {
        let found = endless_loop(check_bits(&plant_fault(BITS_OF_ROWS, from, to), 5));
        assert_eq!(found, line);
    }
}

#[test]
fn loop_with_a_barrier_is_left_by_all_lanes() {
    let fault = plant_fault(BLOCK_SUMS, "step *= 2u", "step *= 1u");
    let found = endless_loop(check_block_sums(&fault));
    assert_eq!(found, "22: for (var step = 1u; step < 64u; step *= 1u)");
}
