//! Solves the dense linear system by LU decomposition with partial pivoting (faer).

use common::{Error, Result};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::{Mat, MatRef, get_global_parallelism};

/// Solves (I − W diag(scale)) x = right for several right-hand sides; `weights` is W, column after
/// column. The factors overwrite a copy of W.
///
/// Errors: the matrix is singular.
pub fn solve_dense(weights: &[f64], scale: &[f64], right: &mut Mat<f64>) -> Result<()> {
    let n = scale.len();
    let mut matrix = Mat::from_fn(n, n, |j, i| f64::from(u8::from(i == j)) - weights[i * n + j] * scale[i]);
    let parallel = get_global_parallelism();
    let (mut forward, mut backward) = (vec![0usize; n], vec![0usize; n]);
    let factor_space = factor::lu_in_place_scratch::<usize, f64>(n, n, parallel, Default::default());
    let solve_space = solve::solve_in_place_scratch::<usize, f64>(n, right.ncols(), parallel);
    let mut memory = MemBuffer::new(factor_space.or(solve_space));
    let stack = MemStack::new(&mut memory);
    let (_, rows) = factor::lu_in_place(
        matrix.as_mut(),
        &mut forward,
        &mut backward,
        parallel,
        stack,
        Default::default(),
    );
    let factors: MatRef<f64> = matrix.as_ref();
    solve::solve_in_place(factors, factors, rows, right.as_mut(), parallel, stack);
    if right.is_all_finite() {
        Ok(())
    } else {
        Err(Error::Usage(
            "the matrix is singular: fronts that lie on each other, or a reflectance of 1".into(),
        ))
    }
}
