use super::{Mutation, MutationOperator, are_same_modules, list_mutations};
use crate::wgsl::compile;

const TEXT: &str = "
@group(0) @binding(0) var<storage, read_write> x: array<f32>;
var<workgroup> sums: array<f32, 64>;
fn blend(a: f32, b: f32, v: vec3f) -> f32 { return max(a - b, 0.0) * v.xy.y + select(v.z, 0.5, a < b && b != -a); }
@compute @workgroup_size(64)
fn scan(@builtin(local_invocation_index) lane: u32) {
    if lane >= arrayLength(&x) { return; }
    sums[lane] = blend(x[lane], x[0], vec3f(1.0, x[1], 3.0));
    workgroupBarrier();
    for (var k = 0u; k < lane; k++) { x[lane] += sums[k]; }
}
";

fn mutations() -> Vec<Mutation> {
    let Ok((module, info)) = compile(TEXT, "scan.wgsl") else {
        panic!("the text is WGSL");
    };
    list_mutations(TEXT, 0..TEXT.len(), &module, &info)
}

#[test]
fn each_operator_makes_its_mutants() {
    let found = mutations();
    let all: Vec<String> = found
        .iter()
        .map(|m| format!("{}: {} → {}", m.operator.name(), &TEXT[m.range.clone()], m.replacement))
        .collect();
    let expected = [
        "arithmetic: - → +",
        "arithmetic: * → /",
        "arithmetic: + → -",
        "logic: a < b && b != -a → ((a < b) || (b != -a))",
        "comparison: < → <=",
        "comparison: < → >",
        "comparison: != → ==",
        "constant: 0.5 → 1.0",
        "constant: 0u → 1u",
        "clamp dropped: max(a - b, 0.0) → (a - b)",
        "guard dropped: lane >= arrayLength(&x) → false",
        "index: 0 → 1",
        "index: lane → (lane) + 1",
        "index: k → (k) - 1",
        "swizzle: xy → yx",
        "swizzle: z → x",
        "condition negated: k < lane → !(k < lane)",
        "sign dropped: - → ",
        "barrier removed: workgroupBarrier() → ",
        "arguments swapped: v.z, 0.5 → 0.5, v.z",
        "arguments swapped: x[lane], x[0] → x[0], x[lane]",
    ];
    for text in expected {
        assert!(all.iter().any(|found| found == text), "no {text:?} in {all:#?}");
    }
    let removed = found.iter().filter(|m| m.operator == MutationOperator::Statement);
    assert_eq!(removed.count(), 3, "{all:#?}");
}

#[test]
fn mutants_are_valid_and_differ() {
    let Ok((original, _)) = compile(TEXT, "scan.wgsl") else {
        panic!("the text is WGSL");
    };
    assert!(are_same_modules(&original, &original));
    for mutation in mutations() {
        let mutant = mutation.apply(TEXT);
        match compile(&mutant, "mutant.wgsl") {
            Ok((module, _)) => assert!(!are_same_modules(&module, &original), "{mutation:?}"),
            Err(error) => panic!("{mutation:?}: {}", error.listing),
        }
    }
}

#[test]
fn ranges_count_from_the_part() {
    let Ok((module, info)) = compile(TEXT, "scan.wgsl") else {
        panic!("the text is WGSL");
    };
    let start = TEXT.find("fn blend").unwrap();
    let part = start..TEXT.find("@compute").unwrap();
    let found = list_mutations(TEXT, part.clone(), &module, &info);
    assert!(found.len() > 10 && found.len() < mutations().len());
    assert!(
        found
            .iter()
            .any(|m| &TEXT[part.clone()][m.range.clone()] == "max(a - b, 0.0)")
    );
}
