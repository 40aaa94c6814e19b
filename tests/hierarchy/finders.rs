//! Who finds the links makes no difference: by rays alone the CPU and the GPU take the same decisions and
//! find the same bits, and a fault in any of the shaders shows.

use common::Result;
use common::mesh::Mesh;
use common::scene::Scene;
use cpu::hierarchy::find::Way;
use cpu::hierarchy::solve::{Goal, Outcome, solve_by};
use gpu::Fault;
use oracle::judge::compare::finders::{Both, Found};
use oracle::study::random::{Faces, Options, scene};
use radiosity_tests::engines::shared_gpu;
use radiosity_tests::lit_room;
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::rc::Rc;

/// One solve in which both are asked.
fn compared(scene: &Scene, error: f32, faults: &[Fault]) -> (Result<Outcome>, Found) {
    let found = Rc::new(RefCell::new(Found::default()));
    let maker = Both::maker(shared_gpu(), faults, &found);
    let mesh = Mesh::uniform(scene, 4, 1).unwrap();
    let mut on = |_| ControlFlow::Continue(());
    let goal = Goal::of(error);
    let outcome = solve_by(scene, &mesh, &[], goal, Way::By(&maker), &mut on);
    let found = *found.borrow();
    (outcome, found)
}

fn rooms() -> Vec<Scene> {
    let drawn = |seed, faces| {
        let options = Options {
            faces,
            ..Options::default()
        };
        scene(seed, options).scene
    };
    vec![
        lit_room(),
        drawn(771_401, Faces::Quads),
        drawn(771_402, Faces::Triangles),
        drawn(771_403, Faces::Mixed),
    ]
}

#[test]
fn the_gpu_finds_what_the_cpu_finds_by_rays() {
    for scene in rooms() {
        let (outcome, Found { gathered, kept }) = compared(&scene, 0.02, &[]);
        outcome.unwrap();
        println!("{}: {gathered:?} {kept:?}", scene.name);
        assert!(gathered.found > 100 && kept.found > 100, "{}", scene.name);
        assert_eq!(
            (gathered.differing, kept.differing),
            (0, 0),
            "{}",
            scene.name
        );
    }
}

/// One in each shader, or more.
const FAULTS: [(&str, &str, &str); 24] = [
    ("spots", "max(area, 1e-30)", "max(area, 1.0)"),
    (
        "spots",
        "vec2f((f32(k % n) + inset)",
        "vec2f((f32(k % n) + 0.4)",
    ),
    ("bounds", "0.5 * (own + radius)", "0.2 * (own + radius)"),
    ("bounds", "let up = own - dot", "let up = dot"),
    ("bounds", "max(kernel, before)", "kernel"),
    ("bounds", "max(factor, before)", "factor"),
    ("factors", "sum += edge(d, a, normal, false);", ""),
    ("factors", "= select(0.0, f, l <", "= select(f, 0.0, l <"),
    ("doubt", "return x * fourth", "return fourth"),
    ("doubt", "left < 10.0", "left < 50.0"),
    (
        "choose",
        "varies > asked.source",
        "varies > 0.5 * asked.source",
    ),
    (
        "choose",
        "min(pairs[pair].factor, EDGE * most)",
        "EDGE * most",
    ),
    ("choose", "hides > 1.0", "hides > 0.1"),
    (
        "choose",
        "pairs[pair].known = SAMPLES_FIRST;",
        "pairs[pair].known = SAMPLES_MORE;",
    ),
    ("sampled", "s >= pairs[pair].known", "s > pairs[pair].known"),
    ("sampled", "f * along.x", "f * along.y"),
    ("sampled", ">= CONTACT", ">= -0.2"),
    (
        "sampling",
        "return vec2f(coordinate(s, STEP_CELL_U, first)",
        "return vec2f(coordinate(s, STEP_CELL_V, first)",
    ),
    (
        "scan",
        "before += made(pair);",
        "before += 2u * made(pair);",
    ),
    ("parts", "shots[node].first + k", "shots[node].first"),
    (
        "add",
        "lanes[at].along.y * glows[node].slope_y",
        "lanes[at].along.y * glows[node].slope_x",
    ),
    ("add", "received.w = 1.0;", ""),
    (
        "pack",
        "ends[link] = vec2u(pairs[pair].block",
        "ends[link] = vec2u(0u",
    ),
    ("reset", "again[lane] = 0u;", ""),
];

#[test]
fn a_fault_in_any_shader_shows() {
    let scene = &rooms()[1];
    let unnoticed = FAULTS.into_iter().filter(|(file, from, to)| {
        let (outcome, found) = compared(scene, 0.02, &[Fault { file, from, to }]);
        // Beyond what rounding may turn, too, so that `compare` says so on any adapter.
        outcome.is_ok() && found.stages().iter().all(|stage| stage.agree)
    });
    let unnoticed: Vec<_> = unnoticed.collect();
    assert!(unnoticed.is_empty(), "{unnoticed:#?}");
}
