//! Record of a solve by links: it changes nothing, and its links give the light that its receivers have.

use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Settings;
use glam::{DVec3, Vec3};
use gpu::link_records::BLOCK_SPOTS;
use oracle::solve::progress::without_progress;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::task::SolveTask;
use oracle::solve::{SolveAnswer, SolveRequest, solve_request};
use oracle::trace::links::{LinkRecord, LinkTrace, RecordedGather, TracedStep};
use oracle::trace::task::{SolveRecord, TracedScene};
use radiosity_tests::engines::shared_gpu;
use radiosity_tests::{bundled_scene, lit_room};
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

const ERROR_TARGET: ErrorTarget = ErrorTarget {
    error: 0.02,
    texels: None,
};

fn run_solver(task: &dyn SolveTask, solver: SolverChoice) -> SolveAnswer {
    let request = SolveRequest {
        task,
        settings: &Settings::default(),
        solver,
    };
    solve_request(&request, &without_progress()).unwrap()
}

/// Solves a scene with its links recorded.
fn record_solve(scene: &Scene, solver: SolverChoice, max_links: usize) -> (SolveAnswer, LinkTrace) {
    let record = LinkRecord::new(max_links);
    let linked = TracedScene {
        scene,
        record: SolveRecord::Links(Rc::clone(&record)),
    };
    (run_solver(&linked, solver), record.take_trace())
}

/// Returns H of each node that received light in a gather, from its links: w (B̄ + g·o), weighted by the shares of its spots.
fn light_of_links(gather: &RecordedGather) -> HashMap<u32, [Vec3; 2]> {
    let mut light: HashMap<u32, [Vec3; 2]> = HashMap::new();
    for block in &gather.blocks {
        let mut sums = [[0.0; BLOCK_SPOTS as usize]; 3];
        for stored in &block.links {
            stored
                .link
                .add_irradiance(&gather.radiosity[stored.node as usize], &mut sums);
        }
        for (l, spot) in block.spots.iter().enumerate() {
            let own = light.entry(spot.node).or_default();
            own[0] += spot.share * Vec3::from_array([0, 1, 2].map(|c| sums[c][l]));
            own[1] += spot.share * spot.irradiance;
        }
    }
    light
}

/// Checks one step; returns the number of texels that gathered direct and other light themselves.
fn check_step(scene: &Scene, step: &TracedStep) -> usize {
    let links = &step.links;
    let [direct, fine] = [&links.direct, &links.fine].map(|gather| {
        let light = light_of_links(gather);
        for (node, [summed, recorded]) in &light {
            let bound = 1e-5 * recorded.abs().max_element() + 1e-9;
            assert!(
                (*summed - *recorded).abs().max_element() <= bound,
                "node {node}: {summed} {recorded}"
            );
        }
        light
    });
    // Only lamps send direct light; the final gather has that of all surfaces, and the coarse links that of neither alone.
    let emits = |node: u32| scene.faces[links.nodes[node as usize].face as usize].emission != Vec3::ZERO;
    let sources = |gather: &RecordedGather| {
        gather
            .blocks
            .iter()
            .flat_map(|block| &block.links)
            .map(|own| own.node)
            .collect::<Vec<_>>()
    };
    assert!(sources(&links.direct).into_iter().all(emits));
    assert!(sources(&links.fine).into_iter().any(|node| !emits(node)));
    assert!(links.coarse.link_count() > 50, "{}", links.coarse.link_count());
    let (mut count, mut off, mut all) = (0, DVec3::ZERO, DVec3::ZERO);
    for (k, node) in links.nodes.iter().enumerate() {
        let Some(texel) = node.texel else { continue };
        let k = k as u32;
        let whole = step.irradiance[texel as usize].as_dvec3();
        let mut above = k;
        while !fine.contains_key(&above) && links.nodes[above as usize].parent != above {
            above = links.nodes[above as usize].parent;
        }
        // A body covers all other texels.
        assert!(
            fine.contains_key(&above) || whole == DVec3::ZERO,
            "texel {texel}: {whole}"
        );
        let (Some(direct), Some(fine)) = (direct.get(&k), fine.get(&k)) else {
            continue;
        };
        let rest = whole - (direct[1] + fine[1]).as_dvec3();
        off += rest * rest;
        all += whole * whole;
        count += 1;
    }
    // What is left are the corrections of the final gather, which are small beside the light.
    assert!((off / all).max_element().sqrt() < 0.1, "{off} of {all}");
    count
}

#[test]
fn recorded_solve_has_the_bits_of_another() {
    for scene in [lit_room(), bundled_scene("cornell_box.obj")] {
        let plain = run_solver(&scene, SolverChoice::Hierarchy(ERROR_TARGET));
        let (recorded, trace) = record_solve(&scene, SolverChoice::Hierarchy(ERROR_TARGET), usize::MAX);
        assert_eq!(plain.solved.run.field.radiosity, recorded.solved.run.field.radiosity);
        assert!(
            trace.steps.len() >= 2 && trace.steps.len() == trace.step_count,
            "{}",
            trace.step_count
        );
        assert_eq!(trace.steps[0].goal, ERROR_TARGET.error);
        // Light that is gathered on smaller texels afterwards falls on each face as in the last step that is recorded.
        let last = trace.steps.last().unwrap();
        let solved = &recorded.solved;
        assert!(last.mesh.texels.len() <= solved.mesh.texels.len());
        let light = |mesh: &Mesh, irradiance: &dyn Fn(usize) -> Vec3| {
            let mut sums = vec![0.0; scene.faces.len()];
            for (k, texel) in mesh.texels.iter().enumerate() {
                sums[texel.face as usize] += texel.area * irradiance(k).x;
            }
            sums
        };
        let before = light(&last.mesh, &|k| last.irradiance[k]);
        let after = light(&solved.mesh, &|k| solved.run.field.irradiance[k].truncate());
        let most = before.iter().copied().fold(0.0, f32::max);
        assert!(most > 0.0);
        for (before, after) in before.iter().zip(&after) {
            assert!(
                (before - after).abs() <= ERROR_TARGET.error as f32 * most,
                "{before} {after}"
            );
        }
    }
}

#[test]
fn links_give_the_light_of_their_receivers() {
    for scene in [lit_room(), bundled_scene("cornell_box.obj")] {
        let (_, trace) = record_solve(&scene, SolverChoice::Hierarchy(ERROR_TARGET), usize::MAX);
        let texels: usize = trace.steps.iter().map(|step| check_step(&scene, step)).sum();
        assert!(texels > 100, "{}: {texels}", scene.name);
    }
}

/// The estimate is gathered at the coarse nodes, direct light at finer ones: the one is not taken for the other.
#[test]
fn direct_light_is_not_the_estimate() {
    let (_, trace) = record_solve(
        &bundled_scene("cornell_box.obj"),
        SolverChoice::Hierarchy(ERROR_TARGET),
        usize::MAX,
    );
    let receivers = |gather: &RecordedGather| {
        let spots = gather.blocks.iter().flat_map(|block| &block.spots);
        spots.map(|spot| spot.node).collect::<HashSet<u32>>()
    };
    let links = &trace.steps.last().unwrap().links;
    assert_ne!(receivers(&links.direct), receivers(&links.coarse));
}

#[test]
fn links_of_a_gpu_are_recorded() {
    let scene = lit_room();
    let solver = SolverChoice::GpuHierarchy(shared_gpu(), ERROR_TARGET);
    let (_, trace) = record_solve(&scene, solver, usize::MAX);
    assert!(trace.steps.len() >= 2);
    assert!(check_step(&scene, &trace.steps[0]) > 20);
}

#[test]
fn record_ends_before_the_step_that_exceeds_its_limit() {
    let scene = lit_room();
    let (_, whole) = record_solve(&scene, SolverChoice::Hierarchy(ERROR_TARGET), usize::MAX);
    let first = whole.steps[0].links.link_count();
    // Blocks of nodes that were divided count as well until a step ends.
    let (_, part) = record_solve(&scene, SolverChoice::Hierarchy(ERROR_TARGET), 2 * first);
    assert!(part.steps.len() < whole.steps.len() && part.step_count == whole.step_count);
    let (_, none) = record_solve(&scene, SolverChoice::Hierarchy(ERROR_TARGET), 10);
    assert_eq!((none.steps.len(), none.step_count), (0, whole.step_count));
}
