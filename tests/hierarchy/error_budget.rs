//! Error budgets: a requested error is met, against exact solutions and the dense solver, also in a narrow gap and by the
//! residual. The energy balance closes, and the bits do not depend on the number of threads.

use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Settings;
use common::shooting::RadiosityField;
use cpu::dense::Matrix;
use cpu::hierarchy::residual::gather_residual;
use cpu::hierarchy::solver::{ErrorBudget, open_shares, solve_scene};
use glam::{DVec3, Vec3};
use oracle::solve::dense;
use oracle::solve::progress::without_progress;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::{SolveAnswer, SolveRequest, solve_request};
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::solutions::{
    FACE_SHAPES, dense_truth_on, drawn_scene, error_against, room_with_standing_box, solve_to_error,
};
use radiosity_tests::{box_faces, furnace, lit_room, named_scene};
use std::ops::ControlFlow;

fn energy_balance(answer: &SolveAnswer) -> EnergyBalance {
    let run = &answer.solved.run;
    EnergyBalance::new(&answer.solved.mesh, &run.field, &run.shots)
}

#[test]
fn furnace_radiosity_is_exact() {
    for reflectance in [0.5, 0.9] {
        let scene = furnace(reflectance);
        let answer = solve_to_error(&scene, 0.005, 8);
        let exact = 1.0 / (1.0 - reflectance);
        let texels = &answer.solved.run.field.radiosity;
        let squares = texels.iter().map(|b| (b.x / exact - 1.0).powi(2));
        let rms = (squares.sum::<f32>() / texels.len() as f32).sqrt();
        let energy = energy_balance(&answer);
        assert!(rms <= 0.005, "{rms}");
        assert_eq!(energy.escaped, [0.0; 3]);
    }
}

/// A long closed box whose end shines: the other end sees the bright part of walls that are dark in the mean.
#[test]
fn light_of_long_walls_reaches_their_ends() {
    let (low, high) = (DVec3::ZERO, DVec3::new(29.0, 0.8, 1.3));
    let mut faces = box_faces(low, high, true, Vec3::ZERO, Vec3::splat(0.1));
    let lamp = [[0.2, 0.3], [0.6, 0.3], [0.6, 1.0], [0.2, 1.0]].map(|[y, z]| DVec3::new(0.02, y, z));
    faces.push(Face::quad("lamp", lamp, Vec3::ONE, Vec3::ZERO));
    let scene = named_scene("corridor", faces);
    let answer = solve_to_error(&scene, 0.01, 8);
    let energy = energy_balance(&answer);
    let closure = energy.share_of_emitted(energy.closure);
    assert!(closure.abs() < 0.01, "{closure}");
}

#[test]
fn random_scenes_meet_requested_error() {
    for (k, faces) in FACE_SHAPES.into_iter().enumerate() {
        // Few faces, so that the dense solution on texels half as large is the reference.
        let mut drawn = (771_311 + k as u64..).step_by(100).map(|seed| drawn_scene(seed, faces));
        let scene = drawn.find(|scene| scene.faces.len() <= 20).unwrap();
        let requested = 0.02;
        let answer = solve_to_error(&scene, requested, 6);
        let off = error_against(&scene, &answer, &dense_truth_on(&scene, 12));
        let estimate = answer.estimate.as_ref().unwrap().error;
        assert!(off <= requested, "{}: {off}", scene.name);
        assert!(estimate <= requested, "{}: {estimate}", scene.name);
        // Sums of f32 over the texels, in f64.
        let imbalance = energy_balance(&answer).imbalance;
        assert!(imbalance <= 16.0 * f64::from(f32::EPSILON), "{imbalance:e}");
    }
}

/// A panel hangs under the ceiling, which sees its black back: there it is dark and sends nothing.
#[test]
fn escaped_light_equals_dense_solution() {
    let mut room = lit_room();
    room.faces[1].emission = Vec3::ZERO;
    let panel = [[1., 1.], [2., 1.], [2., 2.5], [1., 2.5]].map(|[x, z]| DVec3::new(x, 1.9, z));
    room.faces.push(Face::quad("panel", panel, Vec3::ONE, Vec3::ZERO));
    let answer = solve_to_error(&room, 0.005, 16);
    let mesh = Mesh::uniform(&room, 12, 1).unwrap();
    let go_on = &mut |_, _| ControlFlow::Continue(());
    let (matrix, _) = Matrix::assemble(&room, &mesh, go_on).unwrap();
    let run = dense::solve_system(&mesh, &matrix).unwrap().0;
    let exact = EnergyBalance::new(&mesh, &run.field, &run.shots);
    let found = energy_balance(&answer);
    let [escaped, exactly] = [&found, &exact].map(|energy| energy.share_of_emitted(energy.escaped));
    let closure = found.share_of_emitted(found.closure);
    // From 131 072 rays and from a thousand per texel: 0.03 % each; the requested error adds up to seven times that.
    assert!((escaped - exactly).abs() < 0.0025, "{escaped} {exactly}");
    assert!(exactly > 0.004 && closure.abs() < 0.005, "{exactly} {closure}");
}

fn radiosity_bits(field: &RadiosityField) -> Vec<[u32; 3]> {
    let bits = |b: &glam::Vec4| b.truncate().to_array().map(f32::to_bits);
    field.radiosity.iter().map(bits).collect()
}

#[test]
fn thread_count_changes_no_bit() {
    let scene = room_with_standing_box();
    let by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| solve_to_error(&scene, 0.02, 8))
    };
    let [one, three] = [1, 3].map(by);
    let lit = one.solved.run.field.irradiance.iter().filter(|h| h.x > 0.0);
    assert!(lit.count() > 100);
    assert_eq!(
        radiosity_bits(&one.solved.run.field),
        radiosity_bits(&three.solved.run.field)
    );
}

/// Solves a scene on texels that follow from its light.
fn solve_on_texels_by_light(scene: &Scene, error: f64) -> SolveAnswer {
    let target = ErrorTarget { error, texels: None };
    let question = SolveRequest {
        task: scene,
        settings: &Settings::default(),
        solver: SolverChoice::Hierarchy(target),
    };
    solve_request(&question, &without_progress()).unwrap()
}

/// A body hangs under a lamp that is smaller than a texel of the walls: in its wide penumbra visibility takes many samples.
#[test]
fn half_hidden_lamp_meets_requested_error() {
    let wood = Vec3::new(0.5, 0.35, 0.2);
    let mut faces = box_faces(
        DVec3::ZERO,
        DVec3::new(4.295, 3.122, 5.052),
        true,
        Vec3::ZERO,
        Vec3::splat(0.7),
    );
    for [low, high] in [
        [[0.473, 0.0, 2.188], [1.195, 0.243, 3.601]],
        [[1.779, 0.886, 1.25], [2.282, 2.084, 3.013]],
        [[3.389, 0.0, 0.72], [4.073, 1.009, 2.295]],
    ] {
        faces.extend(box_faces(DVec3::from(low), DVec3::from(high), false, Vec3::ZERO, wood));
    }
    let lamp = rectangle([2.905, 3.102, 1.789], [0.344, 0.0, 0.0], [0.0, 0.0, 0.344]);
    faces.push(Face::quad("lamp", lamp, Vec3::splat(60.0), Vec3::ZERO));
    let answer = solve_on_texels_by_light(&named_scene("a body under a lamp", faces), 0.005);
    let (texels, estimate) = (answer.solved.mesh.texels.len(), answer.estimate.unwrap().error);
    assert!(
        estimate > 0.0 && estimate <= 0.005 && texels < 200_000,
        "{estimate} {texels}"
    );
}

/// Pictures of a result use the solver's open shares instead of finding them again; a result on other texels than the
/// solver's has none.
#[test]
fn open_shares_are_those_of_the_result() {
    let scene = room_with_standing_box();
    let known = solve_on_texels_by_light(&scene, 0.05).solved;
    let averaged = solve_to_error(&scene, 0.05, 8).solved;
    let found = open_shares(&scene, &known.mesh);
    assert!(found.contains(&0.0) && found.iter().any(|open| (0.1..0.9).contains(open)));
    assert_eq!(known.open, Some(found));
    assert_eq!(averaged.open, None);
}

const EMITTED: f32 = 4.0;
const REFLECTANCES: [f32; 2] = [0.6, 0.7];
const GAP_WIDTH: f64 = 0.05;
const TEXELS_PER_SIDE: u32 = 32;

/// A plate close to an emitting wall, which covers 4×16 texels of the wall's 32×32, far from its centre.
fn wall_and_plate() -> Scene {
    let face = |corner, u, v, emission, reflectance| {
        let corners = rectangle(corner, u, v);
        Face::quad("", corners, Vec3::splat(emission), Vec3::splat(reflectance))
    };
    let wall = face([0.0; 3], [96., 0., 0.], [0., 24., 0.], EMITTED, REFLECTANCES[0]);
    let plate = face([12., 6., GAP_WIDTH], [0., 12., 0.], [12., 0., 0.], 0.0, REFLECTANCES[1]);
    named_scene("gap", vec![wall, plate])
}

/// Interreflection is as between infinite planes, H = E/(1 − ρρ′) on the plate.
#[test]
fn gap_narrower_than_nodes_is_lit_as_infinite_planes() {
    let scene = wall_and_plate();
    let mesh = Mesh::uniform(&scene, TEXELS_PER_SIDE, 1).unwrap();
    let mut go_on = |_| ControlFlow::Continue(());
    let found = solve_scene(&scene, &mesh, &[], ErrorBudget::for_error(0.01), &mut go_on).unwrap();
    let expected = EMITTED / (1.0 - REFLECTANCES[0] * REFLECTANCES[1]);
    // Light leaves through the edges within a few gap widths: less than a texel, which is 7 gaps wide.
    let inside = |k: &usize| {
        let texel = &mesh.texels[*k];
        let within = texel.lattice_corner.map(|i| (1..TEXELS_PER_SIDE - 1).contains(&i));
        texel.face == 1 && within == [true; 2]
    };
    let texels: Vec<usize> = (0..mesh.texels.len()).filter(inside).collect();
    assert_eq!(texels.len(), 30 * 30);
    // 1 % of the RMS of all reflected light, which is a third of that in the gap, and the average over the wall's texels
    // at the edge.
    for k in texels {
        let h = found.irradiance[k].x;
        let off = (h / expected - 1.0).abs();
        assert!(off < 0.02, "{h} instead of {expected}: {:?}", mesh.texels[k]);
    }
}

#[test]
fn residual_of_dark_solution_is_all_reflected_light() {
    let scene = lit_room();
    let mesh = Mesh::uniform(&scene, 8, 1).unwrap();
    let goal = ErrorBudget::for_error(0.005);
    let mut go_on = |_| ControlFlow::Continue(());
    let whole = solve_scene(&scene, &mesh, &[], goal, &mut go_on).unwrap().irradiance;
    let dark = vec![Vec3::ZERO; mesh.texels.len()];
    let gathered = gather_residual(&scene, &mesh, &dark, goal, &mut go_on).unwrap();
    let (mut off, mut all, mut later) = (0.0, 0.0, 0.0);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let total = gathered.irradiance[k] + gathered.later[k];
        off += texel.area * (total - whole[k]).length_squared();
        all += texel.area * whole[k].length_squared();
        later += texel.area * gathered.later[k].length_squared();
    }
    let [off, later] = [off / all, later / all].map(f32::sqrt);
    // Further bounces use coarse links, whose error is 2 % at most, without correction.
    assert!(later > 0.2 && off <= 0.02 * later, "{off} of {later}");
}
