//! Solutions of replayed shots: superposition and monotonicity.

use super::scenes::any_scene;
use super::setups::{allow_dark, check_every_engine};
use properties::{check_linearity, check_monotonicity};
use proptest::prelude::*;
use radiosity_tests::bounds::U;

/// The same shots are sums of positive numbers. Each rounds what it adds 14 times (a flux of up to 64 texels 8, three
/// products, two quotients, the addition), and light may pass through all of the shots.
#[test]
fn replayed_shots_superpose() {
    check_every_engine(4, &any_scene(), |setup, scene| {
        let shots = 2 * scene.mesh()?.patches.len();
        let bound = 2.0 * (14 * shots + 2) as f64 * U;
        check_linearity(&|_, mesh| setup.shoot_rounds(mesh, 2).radiosity, &scene, bound)?;
        Ok(())
    });
}

/// Sums, products and quotients by the same numbers are monotone when rounded, too: no texel may be darker by one bit.
#[test]
fn replayed_shots_of_brighter_scene_darken_nothing() {
    check_every_engine(4, &(any_scene(), any::<usize>()), |setup, (scene, at)| {
        check_monotonicity(&|_, mesh| setup.shoot_rounds(mesh, 2).radiosity, &scene, at, 0.0)?;
        allow_dark(check_monotonicity(
            &|_, mesh| setup.shoot_rounds(mesh, 2).irradiance,
            &scene,
            at,
            0.0,
        ))?;
        Ok(())
    });
}
