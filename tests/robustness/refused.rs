//! Settings without effect are refused, not ignored.

use common::Error;
use common::form_factor::FormFactor;
use common::settings::{Iteration, Schedule, Settings, Transport, Visibility};
use common::shooting::{DepositRule, Shoot, SubtractedLink, initial_field, shoot_until_converged};
use cpu::CpuSolver;
use oracle::solve::dense;
use oracle::solve::progress::without_progress;
use radiosity_tests::engines::{both_engines, gpu_solver, item_buffer, mesh_of};
use radiosity_tests::furnace;
use std::ops::ControlFlow;

fn is_usage_error<T>(result: Result<T, Error>) -> bool {
    matches!(result, Err(Error::Usage(_)))
}

#[test]
fn single_shots_refuse_other_iterations() {
    let mesh = mesh_of(&furnace(0.5));
    for iteration in [Iteration::Chebyshev, Iteration::Cg] {
        let schedule = Schedule {
            iteration,
            ..Schedule::default()
        };
        let mut engine = CpuSolver::new(&mesh, &Transport::default());
        let mut shoot =
            |schedule: &Schedule| shoot_until_converged(&mut engine, schedule, &mut |_, _| ControlFlow::Continue(()));
        assert!(is_usage_error(shoot(&schedule)), "{iteration:?}");
        assert!(shoot(&schedule.with_southwell()).is_ok());
    }
}

/// A link without objects has another closure than the same link with them, so both cannot be scaled alike.
#[test]
fn comparing_links_refuses_conserve() {
    let mesh = mesh_of(&furnace(0.5));
    let field = initial_field(&mesh, "");
    let black = vec![glam::Vec3::ZERO; mesh.texels.len()];
    let compared = DepositRule {
        captured: true,
        subtracted: SubtractedLink::Before,
        reshoot: true,
    };
    for conserve in [false, true] {
        let transport = Transport {
            conserve,
            ..Transport::default()
        };
        for mut engine in both_engines(&mesh, &transport) {
            assert!(engine.restart_from(DepositRule::FULL_DEPOSIT, &black, &field).is_ok());
            let restarted = engine.restart_from(compared, &black, &field);
            assert_eq!(is_usage_error(restarted), conserve);
        }
    }
}

#[test]
fn dense_solver_refuses_settings_other_than_texels() {
    let scene = furnace(0.5);
    let solve = |settings: &Settings| dense::solve_dense(&scene, settings, &without_progress());
    let obeyed = dense::dense_settings(2);
    assert!(solve(&obeyed).is_ok());
    let changes: [fn(&mut Settings); 5] = [
        |settings| settings.meshing.patches = 2,
        |settings| settings.meshing.samples = 4,
        |settings| settings.transport.form_factor = FormFactor::Disc,
        |settings| settings.transport.conserve = true,
        |settings| settings.transport.visibility = item_buffer(64),
    ];
    for change in changes {
        let mut settings = obeyed;
        change(&mut settings);
        assert!(is_usage_error(solve(&settings)), "{settings:?}");
    }
}

/// Rays draw no item buffer, so no pixels can be read.
#[test]
fn item_buffer_is_empty_with_rays() {
    let mesh = mesh_of(&furnace(0.5));
    for (visibility, pixels) in [(Visibility::Rays, 0), (item_buffer(32), 32 * 32)] {
        let transport = Settings::default().with_visibility(visibility).transport;
        let mut engine = gpu_solver(&mesh, &transport, &[]);
        engine.shoot(0).unwrap();
        assert_eq!(engine.read_item_buffer().unwrap().len(), pixels);
    }
}
