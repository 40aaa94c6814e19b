//! Settings that would have no effect are refused, not ignored.

use common::Error;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::settings::{Iteration, Schedule, Settings, Transport, Visibility};
use common::shooting::{Restart, Rule, Subtracted, initial, solve};
use cpu::CpuSolver;
use gpu::GpuSolver;
use oracle::solve::dense;
use oracle::solve::watch::unwatched;
use radiosity_tests::engines::{drawn, gpu, mesh_of};
use radiosity_tests::furnace;
use std::ops::ControlFlow;

fn refused<T>(result: Result<T, Error>) -> bool {
    matches!(result, Err(Error::Usage(_)))
}

#[test]
fn single_shots_have_no_other_iteration() {
    let mesh = mesh_of(&furnace(0.5));
    for iteration in [Iteration::Chebyshev, Iteration::Cg] {
        let schedule = Schedule {
            iteration,
            ..Schedule::default()
        };
        let mut engine = CpuSolver::new(&mesh, &Transport::default());
        let mut shoot = |schedule: &Schedule| {
            solve(&mut engine, schedule, &mut |_, _| ControlFlow::Continue(()))
        };
        assert!(refused(shoot(&schedule)), "{iteration:?}");
        assert!(shoot(&schedule.one_by_one()).is_ok());
    }
}

/// What a link was had another closure than what it is.
#[test]
fn links_that_are_compared_are_not_scaled() {
    let mesh = mesh_of(&furnace(0.5));
    let field = initial(&mesh, "");
    let black = vec![glam::Vec3::ZERO; mesh.texels.len()];
    let gpu = gpu();
    let compared = Rule {
        captured: true,
        subtracted: Subtracted::Before,
        keep: true,
    };
    for conserve in [false, true] {
        let transport = Transport {
            conserve,
            ..Transport::default()
        };
        let engines: [Box<dyn Restart>; 2] = [
            Box::new(CpuSolver::new(&mesh, &transport)),
            Box::new(GpuSolver::new(&gpu, &mesh, &transport).unwrap()),
        ];
        for mut engine in engines {
            assert!(engine.restart(Rule::PLAIN, &black, &field).is_ok());
            let restarted = engine.restart(compared, &black, &field);
            assert_eq!(refused(restarted), conserve);
        }
    }
}

#[test]
fn the_matrix_obeys_texels_alone() {
    let scene = furnace(0.5);
    let solve = |settings: &Settings| dense::solve(&scene, settings, &unwatched());
    let obeyed = dense::settings(2);
    assert!(solve(&obeyed).is_ok());
    let mut cells = obeyed;
    cells.meshing.cells = 2;
    let mut samples = obeyed;
    samples.meshing.samples = 4;
    let mut disc = obeyed;
    disc.transport.form_factor = FormFactor::Disc;
    let mut conserved = obeyed;
    conserved.transport.conserve = true;
    for settings in [cells, samples, disc, conserved, obeyed.by(drawn(64))] {
        assert!(refused(solve(&settings)), "{settings:?}");
    }
}

/// Rays draw nothing: there are no pixels to be read.
#[test]
fn rays_leave_no_item_buffer() {
    let mesh: Mesh = mesh_of(&furnace(0.5));
    let gpu = gpu();
    for (visibility, pixels) in [(Visibility::Rays, 0), (drawn(32), 32 * 32)] {
        let transport = Transport {
            visibility,
            ..Transport::default()
        };
        let mut engine = GpuSolver::new(&gpu, &mesh, &transport).unwrap();
        common::shooting::Shoot::shoot(&mut engine, 0).unwrap();
        assert_eq!(engine.item_buffer().unwrap().len(), pixels);
    }
}
