//! The CPU by rays and the GPU make the same decisions and find the same bits, and a fault in any shader is detected.

use common::Result;
use common::mesh::Mesh;
use common::scene::Scene;
use cpu::hierarchy::linker::LinkMethod;
use cpu::hierarchy::solver::{ErrorBudget, HierarchicalSolution, solve_with_links};
use gpu::ShaderFault;
use oracle::compare::link_diff::{LinkDiff, LinkerPair};
use radiosity::studies::random::{FaceShapes, SceneOptions, draw_scene};
use radiosity_tests::engines::shared_gpu;
use radiosity_tests::lit_room;
use radiosity_tests::shader_faults::{assert_faults_noticed, shader_fault};
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::rc::Rc;

/// Solves once with both linkers and compares their results.
fn compare_linkers(scene: &Scene, error: f32, faults: &[ShaderFault]) -> (Result<HierarchicalSolution>, LinkDiff) {
    let found = Rc::new(RefCell::new(LinkDiff::default()));
    let maker = LinkerPair::linker_factory(shared_gpu(), faults, &found);
    let mesh = Mesh::uniform(scene, 4, 1).unwrap();
    let mut on = |_| ControlFlow::Continue(());
    let goal = ErrorBudget::for_error(error);
    let outcome = solve_with_links(scene, &mesh, &[], goal, LinkMethod::Custom(&maker), &mut on);
    let found = *found.borrow();
    (outcome, found)
}

fn test_rooms() -> Vec<Scene> {
    let drawn = |seed, faces| {
        let options = SceneOptions {
            faces,
            ..SceneOptions::default()
        };
        draw_scene(seed, options).scene
    };
    vec![
        lit_room(),
        drawn(771_401, FaceShapes::Quads),
        drawn(771_402, FaceShapes::Triangles),
        drawn(771_403, FaceShapes::Mixed),
    ]
}

#[test]
fn gpu_links_equal_cpu_ray_links() {
    for scene in test_rooms() {
        let (outcome, LinkDiff { gathered, kept }) = compare_linkers(&scene, 0.02, &[]);
        outcome.unwrap();
        println!("{}: {gathered:?} {kept:?}", scene.name);
        assert!(gathered.links > 100 && kept.links > 100, "{}", scene.name);
        assert_eq!((gathered.differing, kept.differing), (0, 0), "{}", scene.name);
    }
}

/// One fault or more in each shader: file, text, replacement.
const FAULTS: [(&str, &str, &str); 24] = [
    ("surface_points", "max(area, 1e-30)", "max(area, 1.0)"),
    (
        "surface_points",
        "vec2f((f32(k % n) + inset)",
        "vec2f((f32(k % n) + 0.4)",
    ),
    ("link_bounds", "0.5 * (own + radius)", "0.2 * (own + radius)"),
    ("link_bounds", "let up = own - dot", "let up = dot"),
    ("link_bounds", "max(kernel, before)", "kernel"),
    ("link_bounds", "max(factor, before)", "factor"),
    ("link_factors", "sum += edge_term(d, a, normal, false);", ""),
    ("link_factors", "= select(0.0, f, l <", "= select(f, 0.0, l <"),
    ("visibility_samples", "return x * fourth", "return fourth"),
    ("visibility_samples", "error < 10.0", "error < 50.0"),
    ("refine", "varies > request.source", "varies > 0.5 * request.source"),
    (
        "refine",
        "min(pairs[pair].factor, MAX_PEAK_TO_MEAN * most)",
        "MAX_PEAK_TO_MEAN * most",
    ),
    ("refine", "hides > 1.0", "hides > 0.1"),
    (
        "refine",
        "pairs[pair].known = SAMPLES_FIRST;",
        "pairs[pair].known = SAMPLES_SECOND;",
    ),
    ("sample_links", "s >= pairs[pair].known", "s > pairs[pair].known"),
    ("sample_links", "f * along.x", "f * along.y"),
    ("sample_links", ">= CONTACT_DISTANCE", ">= -0.2"),
    (
        "sampling",
        "return vec2f(sample_coordinate(s, STEP_PATCH_U, first)",
        "return vec2f(sample_coordinate(s, STEP_PATCH_V, first)",
    ),
    (
        "prefix_sum",
        "before += pair_counts(pair);",
        "before += 2u * pair_counts(pair);",
    ),
    ("subdivide_nodes", "shots[node].first + k", "shots[node].first"),
    (
        "add_links",
        "lanes[at].along.y * radiosity[node].slope_y",
        "lanes[at].along.y * radiosity[node].slope_x",
    ),
    ("add_links", "received.w = 1.0;", ""),
    (
        "store_links",
        "ends[link] = vec2u(pairs[pair].block",
        "ends[link] = vec2u(0u",
    ),
    ("clear_work_lists", "more_work[lane] = 0u;", ""),
];

#[test]
fn every_planted_shader_fault_is_detected() {
    let scene = &test_rooms()[1];
    let faults = FAULTS.map(|(file, from, to)| shader_fault(file, from, to));
    assert_faults_noticed(faults, |fault| {
        let (outcome, found) = compare_linkers(scene, 0.02, &[fault]);
        // The difference must exceed rounding, so that `compare` reports it on any adapter.
        outcome.is_err() || !found.stage_checks().iter().all(|stage| stage.agree)
    });
}
