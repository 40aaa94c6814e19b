//! Faults to plant in shaders, and the comparison of the solvers that has to notice some of them.

use crate::engines::{gpu_solver, settings_of, shared_gpu};
use common::Result;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::{Settings, Transport, Visibility};
use cpu::CpuSolver;
use gpu::ShaderFault;
use oracle::compare::comparison::{Comparison, VisibilityStatistics};
use oracle::compare::visibility::check_visibility;
use oracle::compare::{ComparisonRequest, compare_shooting};
use oracle::solve::progress::without_progress;
use std::ops::ControlFlow;

/// A row for each fault: the check that must notice it, the shader, its text and the replacement, and what the check
/// finds wrong (`any`: something).
const TABLE: &str = include_str!("shader_faults.tsv");

/// Returns the faults that `check` must notice, each with what the check finds wrong.
fn planted_faults(check: &str) -> Vec<(ShaderFault, &'static str)> {
    let rows = TABLE.lines().skip(1).map(|line| {
        let [by, file, from, to, expected] = line.split('\t').collect::<Vec<_>>()[..] else {
            panic!("not five columns: {line}");
        };
        (by, ShaderFault { file, from, to }, expected)
    });
    let own = rows.filter(|(by, ..)| *by == check);
    own.map(|(_, fault, expected)| (fault, expected)).collect()
}

/// Asserts that `find_wrong` finds nothing without a fault, and what the table says with each fault of `check`.
pub fn assert_faults_noticed(check: &str, find_wrong: impl Fn(&[ShaderFault]) -> Vec<String>) {
    assert_eq!(find_wrong(&[]), Vec::<String>::new(), "{check} without a fault");
    let faults = planted_faults(check);
    assert!(!faults.is_empty(), "{check} has no faults");
    let mut unexpected = Vec::new();
    for (fault, expected) in faults {
        let found = find_wrong(&[fault]).join("; ");
        println!("{check} {:16} {:40} {found}", fault.file, fault.from);
        let noticed = if expected == "any" {
            !found.is_empty()
        } else {
            found == expected
        };
        if !noticed {
            unexpected.push(format!("{fault:?}: {found:?}, not {expected:?}"));
        }
    }
    assert!(unexpected.is_empty(), "{check}: {unexpected:#?}");
}

/// Returns settings like the paper's: whole faces, disc form factor, single shots.
pub fn paper_settings(visibility: Visibility, texels: u32, epsilon: f64, max_shots: u32) -> Settings {
    let mut settings = settings_of([texels, 1, 1], visibility, epsilon);
    settings.transport.form_factor = FormFactor::Disc;
    // A fault that keeps the residual would never converge.
    settings.schedule.max_shots = max_shots;
    settings
}

/// Compares the solvers on `scene` with `faults` planted in the shaders.
///
/// Errors: the host refuses a result of the faulty shaders.
pub fn compare_with_faults(scene: &Scene, settings: Settings, faults: &[ShaderFault]) -> Result<Comparison> {
    let request = ComparisonRequest {
        settings,
        gpu: shared_gpu(),
        faults,
    };
    compare_shooting(scene, &request, &without_progress())
}

/// Compares the links of both engines, with `faults` planted in the shaders.
pub fn visibility_statistics(mesh: &Mesh, transport: &Transport, faults: &[ShaderFault]) -> VisibilityStatistics {
    let mut cpu = CpuSolver::new(mesh, transport);
    let mut gpu = gpu_solver(mesh, transport, faults);
    let go_on = &mut || ControlFlow::Continue(());
    let check = check_visibility(mesh, transport, &mut cpu, &mut gpu, go_on).unwrap();
    check.statistics
}

/// Returns name, value and bound of each criterion that fails.
pub fn failing_criteria(comparison: &Comparison) -> Vec<String> {
    let failing = comparison.criteria.iter().filter(|criterion| !criterion.pass);
    failing
        .map(|c| format!("{}: {:.3e} > {:.3e}", c.name, c.value, c.bound))
        .collect()
}
