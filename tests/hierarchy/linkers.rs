//! The CPU by rays and the GPU make the same decisions and find the same links, with the same bits on a software
//! adapter, and a fault in any shader shows at its own stage.

use common::Result;
use common::mesh::Mesh;
use common::scene::Scene;
use cpu::hierarchy::linker::LinkMethod;
use cpu::hierarchy::solver::{ErrorBudget, TexelSolution, solve_with_links};
use gpu::{ShaderFault, ShaderStage};
use oracle::compare::link_diff::{LinkDiff, LinkerPair};
use radiosity_tests::engines::shared_gpu;
use radiosity_tests::lit_room;
use radiosity_tests::shader_faults::assert_faults_noticed;
use radiosity_tests::solutions::{FACE_SHAPES, drawn_scene};
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::rc::Rc;

/// Solves once with both linkers and compares their results.
fn compare_linkers(scene: &Scene, error: f32, faults: &[ShaderFault]) -> (Result<TexelSolution>, LinkDiff) {
    let found = Rc::new(RefCell::new(LinkDiff::default()));
    let maker = LinkerPair::linker_factory(shared_gpu(), faults, &found);
    let mesh = Mesh::uniform(scene, 4, 1).unwrap();
    let mut on = |_| ControlFlow::Continue(());
    let goal = ErrorBudget::for_error(error);
    let outcome = solve_with_links(scene, &mesh, &[], goal, LinkMethod::Custom(&maker), &mut on);
    (outcome, found.take())
}

fn test_rooms() -> Vec<Scene> {
    let drawn = (771_401..).zip(FACE_SHAPES);
    let drawn = drawn.map(|(seed, faces)| drawn_scene(seed, faces));
    [lit_room()].into_iter().chain(drawn).collect()
}

#[test]
fn gpu_links_equal_cpu_ray_links() {
    for scene in test_rooms() {
        let (outcome, found) = compare_linkers(&scene, 0.02, &[]);
        outcome.unwrap();
        for criterion in found.criteria() {
            assert!(criterion.pass, "{}: {criterion:?}", scene.name);
        }
        // Hardware adapters fuse multiplications and additions.
        let same_bits = shared_gpu().line.software;
        for stage in &found.stages.checks {
            let exact = !same_bits || stage.differing == 0;
            assert!(stage.agree && exact, "{}: {stage:?}", scene.name);
            assert!(!ShaderStage::files_judged_by(&stage.name).is_empty(), "{}", stage.name);
        }
        assert_eq!(found.stages.unreached, [""; 0], "{}", scene.name);
        let LinkDiff { gathered, kept, .. } = found;
        assert!(gathered.links > 100 && kept.links > 100, "{}", scene.name);
        let unequal = gathered.blocks.unequal + kept.blocks.unequal;
        assert!(!same_bits || unequal == 0, "{}: {unequal} blocks", scene.name);
    }
}

/// Rounding decides whether a face lies above another that it touches. A shader agrees whatever it decides: here the sum
/// has another order, and is larger by less than its rounding.
#[test]
fn heights_that_round_otherwise_agree() {
    let rounded = ShaderFault {
        file: "link_bounds",
        from: "let height = dot(shots[node].normal, d);",
        to: "let n = shots[node].normal; let height = n.z * d.z + (n.y * d.y + n.x * d.x) + 1e-8;",
    };
    let mut differing = 0;
    for scene in test_rooms() {
        let (outcome, found) = compare_linkers(&scene, 0.02, &[rounded]);
        outcome.unwrap();
        let bounds = found
            .stages
            .checks
            .iter()
            .find(|stage| stage.name == "link_bounds")
            .unwrap();
        assert!(bounds.agree, "{}: {bounds:?}", scene.name);
        differing += bounds.differing;
    }
    assert!(differing > 0);
}

/// Links of other roundings are those that the comparison of solutions allows for.
#[test]
fn light_that_rounds_otherwise_is_allowed_for() {
    let rounded = ShaderFault {
        file: "add_links",
        from: "let sent = lanes[at].weight * radiosity[node].mean",
        to: "let sent = 1.000001 * lanes[at].weight * radiosity[node].mean",
    };
    let rounding_of = |faults: &[ShaderFault]| {
        let (outcome, found) = compare_linkers(&lit_room(), 0.02, faults);
        outcome.unwrap();
        let criteria = found.criteria();
        let light = (criteria.iter()).find(|criterion| criterion.name == "links: gathered light");
        assert!(light.unwrap().pass, "{light:?}");
        found.largest_rounding()
    };
    assert!(rounding_of(&[rounded]) > 1e-6);
    assert!(!shared_gpu().line.software || rounding_of(&[]) == 0.0);
}

#[test]
fn planted_fault_differs_at_its_own_stage() {
    let scene = &test_rooms()[1];
    assert_faults_noticed("links", |faults| {
        let (outcome, found) = compare_linkers(scene, 0.1, faults);
        outcome.unwrap();
        // The difference must exceed rounding, so that `compare` reports it on any adapter.
        let wrong = found.stages.checks.into_iter().filter(|stage| !stage.agree);
        wrong.map(|stage| stage.name).collect()
    });
}

/// The prefix sum writes what other lanes have read: each of its two barriers orders a memory of its own.
#[test]
fn removed_barrier_of_links_is_a_race() {
    let scene = &test_rooms()[1];
    for (from, variable) in [("workgroupBarrier();", "sums["), ("storageBarrier();", "totals[")] {
        let fault = ShaderFault {
            file: "prefix_sum",
            from,
            to: "",
        };
        let (_, found) = compare_linkers(scene, 0.02, &[fault]);
        let races = found
            .stages
            .checks
            .iter()
            .find(|stage| stage.name == "prefix_sum, races")
            .unwrap();
        let difference = races.difference.as_ref().unwrap().to_string();
        assert!(!races.agree && difference.starts_with(variable), "{difference}");
    }
}
