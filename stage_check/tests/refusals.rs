//! What cannot be compared fails the check: nothing compared, nothing written, no end, no layout, no adapter.

use super::{plant_fault, shared_gpu};
use stage_check::{Bound, Case, Failure, Fault, Gpu, Report, Stage, values};
use std::time::{Duration, Instant};

const DOUBLE: &str = "
@group(0) @binding(0) var<storage, read> x: array<f32>;
@group(0) @binding(1) var<storage, read_write> y: array<f32>;
@compute @workgroup_size(4)
fn double(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&x) { y[id.x] = 2.0 * x[id.x]; }
}";

type MakeCase<'c> = &'c dyn Fn(&[f32]) -> Case;

fn stage_of(text: &str) -> Result<Stage, Failure> {
    Stage::new(shared_gpu(), "double.wgsl", text, "double").map(Stage::without_many_groups)
}

fn check_with(text: &str, case: impl Fn(&[f32]) -> Case) -> Result<Report, Failure> {
    stage_of(text)?.check(|size| case(&(0..size).map(|k| k as f32).collect::<Vec<_>>()))
}

fn doubled(x: &[f32]) -> Vec<f32> {
    x.iter().map(|x| 2.0 * x).collect()
}

fn doubled_case(x: &[f32], bound: Bound) -> Case {
    Case::new().input("x", x).output("y", &doubled(x), bound)
}

#[track_caller]
fn assert_refused<T>(checked: Result<T, Failure>, said: &str) {
    let failure = checked.err().expect("is refused").to_string();
    assert!(failure.contains(said), "no {said:?} in {failure}");
}

#[test]
fn right_stage_agrees_and_a_wrong_factor_does_not() {
    check_with(DOUBLE, |x| doubled_case(x, Bound::Exact)).unwrap();
    let wrong = plant_fault(DOUBLE, "2.0 *", "2.0000002 *");
    check_with(&wrong, |x| doubled_case(x, Bound::Ulps(2.0))).unwrap();
    assert_refused(
        check_with(&wrong, |x| doubled_case(x, Bound::Exact)),
        "double.wgsl: double, size 3: `y` differs in 2 of 3 values: elements 1 to 2\n  first: y[1] = 2.0000002, \
         the reference is 2.0: 1 ulp apart, 0 allowed\n  inputs of the first: x[1] = 1.0",
    );
}

#[test]
fn values_at_limits_agree_bit_by_bit() {
    let negated = |x: &[f32]| {
        let x = values::random_of(x.len() as u64, x.len(), &values::F32_LIMITS);
        let y: Vec<f32> = x.iter().map(|x| -x).collect();
        Case::new().input("x", &x).output("y", &y, Bound::Exact)
    };
    check_with(&plant_fault(DOUBLE, "2.0 * x", "-x"), negated).unwrap();
    let size = plant_fault(DOUBLE, "2.0 * x[id.x]", "abs(x[id.x])");
    let negative = |_: &[f32]| Case::new().input("x", &[0.0f32]).output("y", &[-0.0f32], Bound::Exact);
    let said = "y[0] = 0.0, the reference is -0.0: 1 ulp apart, 0 allowed";
    assert_refused(check_with(&size, negative), said);
}

#[test]
fn random_values_are_those_of_their_seed() {
    let [a, b, c] = [1, 1, 2].map(|seed| values::random_f32(seed, 1000, -1.0..3.0));
    assert!(a == b && a != c);
    assert!(a.iter().all(|x| (-1.0..3.0).contains(x)));
    let mean = a.iter().sum::<f32>() / 1000.0;
    // Six deviations of a mean of 1000: 4/√12/√1000 each.
    assert!((mean - 1.0).abs() < 0.22, "{mean}");
}

#[test]
fn comparisons_of_nothing_are_refused() {
    assert_refused(
        check_with(DOUBLE, |x| Case::new().input("x", x)),
        "neither fills `y` nor compares it",
    );
    let filled = |x: &[f32]| Case::new().input("x", x).input("y", x);
    assert_refused(check_with(DOUBLE, filled), "nothing was compared");
    let empty = |_: &[f32]| doubled_case(&[], Bound::Exact);
    assert_refused(
        check_with(DOUBLE, empty),
        "`y`: is written, but the reference has no value there",
    );
    let idle = plant_fault(DOUBLE, "id.x < arrayLength(&x)", "false");
    assert_refused(check_with(&idle, empty), "nothing was compared");
    let once = |x: &[f32]| doubled_case(if x.len() == 1 { &[] } else { x }, Bound::Exact);
    assert_refused(
        check_with(&idle, once),
        "size 1: nothing was compared: the reference has no values",
    );
    let none = stage_of(DOUBLE).unwrap().with_sizes(&[]).check(|_| Case::new());
    assert_refused(none, "nothing was compared");
    // The reference is what the buffer holds anyway.
    let kept = |x: &[f32]| filled(x).output("y", x, Bound::Exact);
    assert_refused(
        check_with(&plant_fault(DOUBLE, "2.0 *", "1.0 *"), kept),
        "a stage that does nothing would pass",
    );
}

#[test]
fn what_is_not_written_is_named() {
    let wrong = plant_fault(DOUBLE, "id.x < arrayLength(&x)", "id.x + 1u < arrayLength(&x)");
    let checked = check_with(&wrong, |x| doubled_case(x, Bound::Absolute(1e30)));
    assert_refused(
        checked,
        "all of them, none of them written\n  first: y[0] = not written, the reference is 0.0",
    );
    let beyond = stage_of(&plant_fault(DOUBLE, "id.x < arrayLength(&x)", "true")).unwrap();
    assert_refused(
        beyond.with_empty().check(|_| doubled_case(&[], Bound::Exact)),
        "`y`: is written, but",
    );
}

#[test]
fn nan_is_right_only_where_the_case_expects_it() {
    let wrong = plant_fault(
        DOUBLE,
        "2.0 * x[id.x]",
        "bitcast<f32>(bitcast<u32>(x[id.x]) | 0x7fc00000u)",
    );
    let checked = check_with(&wrong, |x| doubled_case(x, Bound::Absolute(1e30)));
    assert_refused(checked, "first: y[0] = NaN, the reference is 0.0");
    let nan = |x: &[f32]| {
        Case::new()
            .input("x", x)
            .output("y", &vec![f32::NAN; x.len()], Bound::Exact)
    };
    assert_refused(check_with(&wrong, nan), "the reference is NaN at y[0]");
    check_with(&wrong, |x| nan(x).allow_nan()).unwrap();
    assert_refused(
        check_with(DOUBLE, |x| nan(x).allow_nan()),
        "first: y[0] = 0.0, the reference is NaN",
    );
}

#[test]
fn cases_that_do_not_fit_the_shader_are_refused() {
    let half = |x: &[f32]| {
        Case::new()
            .input("x", x)
            .input("y", &[0.0f32; 9])
            .output("y", x, Bound::Exact)
    };
    let wide = |_: &[f32]| Case::new().input("x", &[[0u8; 3]; 4]);
    let typed = |_: &[f32]| Case::new().input("x", &[1u32]).output("y", &[2.0f32], Bound::Exact);
    let refused: [(MakeCase, &str); 9] = [
        (&half, "`y` has 36 bytes, the reference 4"),
        (
            &wide,
            "`x` has 12 bytes in values of 3; its elements in WGSL have 4 bytes",
        ),
        (&typed, "`x` is given as Uint, which its type in WGSL has not"),
        (
            &|x| doubled_case(x, Bound::Ulps(f64::INFINITY)),
            "a bound of inf is no bound",
        ),
        (
            &|x| doubled_case(x, Bound::UlpsOf(1.0, vec![])),
            "element 0 has no size",
        ),
        (
            &|x| doubled_case(x, Bound::UlpsOf(1.0, vec![f32::INFINITY; x.len()])),
            "element 0 has no size, or one that is not finite",
        ),
        (
            &|x| doubled_case(x, Bound::Exact).input("z", x),
            "does not use a buffer `z`; it uses: x, y",
        ),
        (&|x| doubled_case(x, Bound::Exact).input("x", x), "`x` is given twice"),
        (
            &|x| Case::new().output("x", x, Bound::Exact).input("y", x),
            "the shader only reads it",
        ),
    ];
    for (case, said) in refused {
        assert_refused(check_with(DOUBLE, case), said);
    }
    let groups = stage_of(DOUBLE).unwrap().with_dispatch(|_| [70_000, 1, 1]);
    assert_refused(
        groups.check(|_| doubled_case(&[1.0], Bound::Exact)),
        "[70000, 1, 1] workgroups",
    );
}

#[test]
fn errors_of_wgsl_have_file_line_and_column() {
    assert_refused(
        stage_of(&plant_fault(DOUBLE, "[id.x]; }", "[id.x] }")),
        "┌─ double.wgsl:6:57",
    );
    assert_refused(stage_of(&plant_fault(DOUBLE, "2.0 *", "2u *")), "┌─ double.wgsl:6:43");
    let other = Stage::new(shared_gpu(), "double.wgsl", DOUBLE, "triple");
    assert_refused(other, "has no compute entry point `triple`; there are: double");
    assert_refused(
        Gpu::open(Some("no such adapter")),
        "no GPU adapter no such adapter; there are: ",
    );
}

#[test]
fn loop_without_an_end_is_given_up() {
    // Of its own, since it is given up.
    let gpu = Gpu::open(None).unwrap();
    let endless = plant_fault(DOUBLE, "{ y[id.x]", "{ while x[id.x] > 0.0 { y[id.x] += 1.0; } y[id.x]");
    let stage = Stage::new(&gpu, "double.wgsl", &endless, "double").unwrap();
    // lavapipe leaves a loop after 65 535 rounds: many workgroups make minutes of them on any machine.
    let stage = stage.with_dispatch(|_| [65_535, 8192, 1]).with_sizes(&[1]);
    let stage = stage.with_time_limit(Duration::from_secs(2));
    let start = Instant::now();
    let case = || stage.check(|_| doubled_case(&[1.0], Bound::Exact));
    let failure = case().unwrap_err();
    assert!(matches!(failure.fault, Fault::TimeLimit(_)), "{failure}");
    assert_eq!(failure.to_string(), "double.wgsl: double, size 1: no end after 2 s");
    assert_refused(case(), "given up, since an earlier run did not end");
    assert!(start.elapsed() < Duration::from_secs(30));
}
