//! Three shaders, a prefix sum, a reduction and a matrix product: right ones pass, and a planted fault is named.

mod loops;
mod races;
mod refusals;

use stage_check::{Bound, Case, Difference, Failure, Fault, Gpu, Report, Stage, values};
use std::sync::OnceLock;

const BLOCK_SUMS: &str = include_str!("block_sums.wgsl");
const REDUCTION: &str = include_str!("reduction.wgsl");
const MATRIX_PRODUCT: &str = include_str!("matrix_product.wgsl");

/// Returns the process's GPU; a machine without one fails the test.
fn shared_gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh"))
}

/// Returns a shader in which the one place that reads `from` reads `to`.
fn plant_fault(text: &str, from: &str, to: &str) -> String {
    assert_eq!(text.matches(from).count(), 1, "{from}");
    text.replace(from, to)
}

/// Returns the difference that a check found; prints its message.
#[track_caller]
fn difference(checked: Result<Report, Failure>) -> Difference {
    let failure = checked.unwrap_err();
    println!("{failure}");
    match failure.fault {
        Fault::Difference(difference) => *difference,
        _ => panic!("no difference: {failure}"),
    }
}

fn check_block_sums(text: &str) -> Result<Report, Failure> {
    let stage = Stage::new(shared_gpu(), "block_sums.wgsl", text, "block_sums")?;
    stage.check(|size| {
        let x = values::random_f32(7, 2 * size, -1.0..1.0);
        let pairs: Vec<[f32; 2]> = x.chunks(2).map(|pair| [pair[0], pair[1]]).collect();
        let mut sums = Vec::new();
        let mut sizes = Vec::new();
        let mut totals = Vec::new();
        for block in pairs.chunks(64) {
            let (mut sum, mut terms) = ([0.0; 2], 0.0f32);
            for pair in block {
                sum = [sum[0] + pair[0], sum[1] + pair[1]];
                terms += pair[0].abs().max(pair[1].abs());
                sums.push(sum);
                sizes.push(terms);
            }
            totals.push(sum);
        }
        // 64 additions in Rust, 6 in the shader, each of half an ulp of the terms' sum at most.
        let bound = |sizes| Bound::UlpsOf(35.0, sizes);
        Case::new()
            .input("values", &pairs)
            .output("sums", &sums, bound(sizes))
            .output("totals", &totals, bound(vec![64.0; totals.len()]))
            .reads("values", |k| (k / 64 * 64..=k).collect())
    })
}

#[test]
fn prefix_sums_agree_at_all_sizes() {
    let report = check_block_sums(BLOCK_SUMS).unwrap();
    println!("{report}");
    assert_eq!(report.sizes, [1, 63, 64, 65, 321, 65_535 * 64 + 1]);
    assert!(report.nearest > 0.0 && report.nearest <= 1.0, "{report}");
}

#[test]
fn wrong_component_of_a_prefix_sum_is_named() {
    let fault = plant_fault(
        BLOCK_SUMS,
        "partial[lane] += before;",
        "partial[lane] += vec2f(before.x, before.x);",
    );
    let found = difference(check_block_sums(&fault));
    assert_eq!(
        (found.first.label.as_str(), found.pattern.as_str()),
        ("totals[0].y", "only element 0, only .y")
    );
    assert_eq!((found.count, found.values), (1, 2));
    assert!(found.first.error > found.bound);
    assert!(found.inputs[0].starts_with("values[0] = ("), "{:?}", found.inputs);
    let larger = "at size 321: `sums` differs in 315 of 642 values: elements 1 to 319, only .inclusive.y";
    assert!(found.other_sizes[0].contains(larger), "{:?}", found.other_sizes);
}

#[test]
fn prefix_sum_of_one_dimension_of_workgroups_is_found_beyond_65_535() {
    let fault = plant_fault(BLOCK_SUMS, "group.y * groups.x + group.x", "group.x");
    let found = difference(check_block_sums(&fault));
    assert_eq!(found.first.label, format!("sums[{}].inclusive.x", 32_768 * 64));
    assert!(found.pattern.contains("none of them written"), "{}", found.pattern);
}

fn check_reduction(text: &str, keys: impl Fn(usize) -> Vec<i32>, bound: Bound) -> Result<Report, Failure> {
    let stage = Stage::new(shared_gpu(), "reduction.wgsl", text, "find_largest")?;
    let stage = stage.with_dispatch(|_| [1, 1, 1]).without_many_groups().with_empty();
    stage.check(|size| {
        let keys = keys(size);
        let largest = keys.iter().max().copied().unwrap_or(i32::MIN);
        let index = keys.iter().position(|key| *key == largest).unwrap_or(0);
        Case::new()
            .input("params", &[[size as i32, i32::MIN]])
            .input("keys", &keys)
            .output("result", &[[largest, index as i32, size as i32]], bound.clone())
    })
}

/// Returns many equal keys.
fn tied_keys(size: usize) -> Vec<i32> {
    values::random_of(3, size, &[-5, 2, 9])
}

#[test]
fn reduction_agrees_with_ties_and_without_values() {
    let report = check_reduction(REDUCTION, tied_keys, Bound::Exact).unwrap();
    assert_eq!(report.sizes, [0, 1, 127, 128, 129, 641]);
    // i32::MIN is not above the floor: a key of that value has no index.
    let limits = |size| {
        values::random_of(5, size, &values::U32_LIMITS)
            .iter()
            .map(|bits| (*bits >> 1) as i32)
            .collect()
    };
    check_reduction(REDUCTION, limits, Bound::Exact).unwrap();
}

#[test]
fn wrong_tie_of_a_reduction_is_named() {
    let fault = plant_fault(REDUCTION, "other.y < best[lane].y", "other.y > best[lane].y");
    let found = difference(check_reduction(&fault, tied_keys, Bound::Exact));
    assert_eq!(found.first.label, "result.index");
    // Roundings are of numbers in f32: integers must be equal.
    difference(check_reduction(&fault, tied_keys, Bound::Ulps(1e9)));
    check_reduction(&fault, tied_keys, Bound::Absolute(641.0)).unwrap();
    assert_eq!(found.pattern, "only element 0, only .index");
    assert!(
        found.inputs[0].starts_with("params = (127, -2147483648)"),
        "{:?}",
        found.inputs
    );
}

fn check_matrix_product(text: &str) -> Result<Report, Failure> {
    let stage = Stage::new(shared_gpu(), "matrix_product.wgsl", text, "multiply")?;
    let tiles = |side: usize| side.div_ceil(8) as u32;
    let stage = stage.with_dispatch(move |side| [tiles(side), tiles(side), 1]);
    stage.with_sizes(&[1, 7, 8, 9, 33]).check(|side| {
        let [a, b] = [1, 2].map(|seed| values::random_f32(seed, side * side, -1.0..1.0));
        let sum = |k: usize, of: fn(f32) -> f32| {
            let terms = (0..side).map(|j| of(a[k / side * side + j] * b[j * side + k % side]));
            terms.fold(0.0, |sum, term| sum + term)
        };
        let product: Vec<f32> = (0..side * side).map(|k| sum(k, |term| term)).collect();
        let sizes = (0..side * side).map(|k| sum(k, f32::abs)).collect();
        // Same order of additions; a fused product saves half an ulp of each term.
        let bound = Bound::UlpsOf(side as f64, sizes);
        Case::new()
            .input("side", &[side as u32])
            .input("a", &a)
            .input("b", &b)
            .output("product", &product, bound)
            .reads("a", move |k| (0..side).map(|j| k / side * side + j).collect())
            .reads("b", move |k| (0..side).map(|j| j * side + k % side).collect())
    })
}

#[test]
fn matrix_product_agrees() {
    let report = check_matrix_product(MATRIX_PRODUCT).unwrap();
    assert_eq!(report.values, 1 + 49 + 64 + 81 + 1089);
}

#[test]
fn wrong_edge_of_a_matrix_product_is_named() {
    let fault = plant_fault(MATRIX_PRODUCT, "tile < side;", "tile + 8u <= side;");
    let found = difference(check_matrix_product(&fault));
    assert_eq!(found.first.label, "product[0]");
    assert_eq!(found.pattern, "all of them");
    let fault = plant_fault(MATRIX_PRODUCT, "if place.x < side &&", "if place.x + 1u < side &&");
    let found = difference(check_matrix_product(&fault));
    assert_eq!(found.pattern, "all of them, none of them written");
    let fault = plant_fault(
        MATRIX_PRODUCT,
        "= sum;",
        "= sum * f32(1u + u32(place.x == 8u && place.y < 8u));",
    );
    let found = difference(check_matrix_product(&fault));
    assert_eq!(found.pattern, "only 1 element in 9, from 8 to 71");
    assert!(
        found.inputs.iter().any(|input| input.starts_with("b[8] = ")),
        "{:?}",
        found.inputs
    );
}

/// A header and an array of any length in one buffer; a `vec3f` takes 16 bytes, the last four of no meaning.
#[test]
fn headers_arrays_and_padding_have_the_layout_of_wgsl() {
    const COUNTED: &str = "
        struct List { count: atomic<u32>, items: array<vec3f> }
        @group(0) @binding(2) var<storage, read_write> list: List;
        @compute @workgroup_size(32)
        fn shrink(@builtin(global_invocation_id) id: vec3u) {
            if id.x < arrayLength(&list.items) {
                list.items[id.x] = 0.5 * list.items[id.x];
                atomicAdd(&list.count, 1u);
            }
        }";
    let check = |text: &str| {
        let stage = Stage::new(shared_gpu(), "list.wgsl", text, "shrink")?.without_many_groups();
        stage.check(|size| {
            let items = values::random_f32(5, 4 * size, 1.0..2.0);
            let halves = items
                .iter()
                .enumerate()
                .map(|(k, x)| if k % 4 == 3 { -1.0 } else { 0.5 * x });
            let list = |count: usize, items: Vec<f32>| {
                let header = [count as u32, 0, 0, 0].into_iter();
                header.chain(items.into_iter().map(f32::to_bits)).collect::<Vec<u32>>()
            };
            let after = list(size + 7, halves.collect());
            (Case::new().input("list", &list(7, items))).output("list", &after, Bound::Exact)
        })
    };
    assert_eq!(check(COUNTED).unwrap().values, (1 + 31 + 32 + 33 + 161) * 3 + 5);
    let wrong = difference(check(&plant_fault(COUNTED, "0.5 * ", "vec3f(0.5, 0.5, 0.25) * ")));
    assert_eq!(wrong.first.label, "list.items[0].z");
    let wrong = difference(check(&plant_fault(
        COUNTED,
        "atomicAdd(&list.count, 1u)",
        "atomicAdd(&list.count, 2u)",
    )));
    assert_eq!(
        (wrong.first.label.as_str(), wrong.pattern.as_str()),
        ("list.count", "all of them")
    );
}

/// The columns of a `mat2x3f` begin every 16 bytes.
#[test]
fn wrong_entry_of_a_matrix_is_named() {
    const COLUMNS: &str = "
        @group(0) @binding(0) var<uniform> scale: vec2f;
        @group(0) @binding(1) var<storage, read_write> found: array<mat2x3f>;
        @compute @workgroup_size(2)
        fn fill(@builtin(global_invocation_id) id: vec3u) {
            if id.x < arrayLength(&found) {
                found[id.x] = mat2x3f(scale.x, 2.0, 3.0, 4.0, 5.0, 6.0 * scale.y);
            }
        }";
    let check = |scale: &[f32], corner: f32| {
        let stage = Stage::new(shared_gpu(), "fill.wgsl", COLUMNS, "fill")?.without_many_groups();
        stage.check(|size| {
            let matrix = [1.0, 2.0, 3.0, 0.0, 4.0, 5.0, corner, 0.0f32];
            (Case::new().input("scale", scale)).output("found", &vec![matrix; size], Bound::Exact)
        })
    };
    assert_eq!(check(&[1.0, 1.0], 6.0).unwrap().values, (1 + 2 + 3 + 11) * 6);
    assert_eq!(difference(check(&[1.0, 1.0], 7.0)).first.label, "found[0][1][2]");
    let short = check(&[1.0], 6.0).unwrap_err().to_string();
    assert!(short.contains("`scale` has 4 bytes; its type in WGSL has 8"), "{short}");
}
