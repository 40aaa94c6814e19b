//! Links: closure of texels and of patches, reciprocity, convergence. A wrong form factor shows in them and not in the
//! energy balance.

use super::pairing::{factor_rounding, is_near, mean_factor, receiver_points, texel_grid};
use super::scenes::convex_room;
use super::setups::{SolverSetup, check_every_engine, patch_outline};
use common::energy::EnergyBalance;
use common::mesh::{Mesh, Patch};
use common::settings::Iteration;
use common::texel;
use cpu::dense::exchange_area;
use glam::{DVec3, Vec3};
use oracle::exact::point_to_polygon;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use radiosity_tests::bounds::{U, centroid_rule};
use radiosity_tests::engines::{all_patches, make_links};
use radiosity_tests::random_rooms::RandomRoom;
use radiosity_tests::shader_faults::assert_faults_noticed;

/// ΣF and escaped share of each patch, and the power that patch c receives from patch i: `taken[i][c]`, mesh units.
struct Taken {
    sums: Vec<f64>,
    escaped: Vec<f64>,
    taken: Vec<Vec<f64>>,
}

impl Taken {
    fn new(way: SolverSetup, mesh: &Mesh) -> Self {
        let mut engine = way.fresh_engine(mesh);
        let closures = make_links(engine.as_mut(), &all_patches(mesh));
        let mut row = |i: usize| -> Vec<f64> {
            let mut one = vec![Vec3::ZERO; mesh.patches.len()];
            one[i] = Vec3::ONE;
            let flux = engine.exchange_flux(&one).unwrap();
            flux.iter().map(|f| f64::from(f.x)).collect()
        };
        Self {
            taken: (0..mesh.patches.len()).map(&mut row).collect(),
            sums: (closures.iter()).map(|c| f64::from(c.form_factor_sum)).collect(),
            escaped: closures.iter().map(|c| f64::from(c.escaped)).collect(),
        }
    }
}

/// Splits a parallelogram or triangle into four equal ones.
fn split_in_quarters(corners: &[DVec3]) -> Vec<Vec<DVec3>> {
    let n = corners.len();
    let middle = |k: usize| 0.5 * (corners[k % n] + corners[(k + 1) % n]);
    let mut parts: Vec<Vec<DVec3>> = (0..n)
        .map(|k| match n {
            3 => vec![corners[k], middle(k), middle(k + 2)],
            _ => {
                let centre = 0.5 * (corners[0] + corners[2]);
                vec![corners[k], middle(k), centre, middle(k + 3)]
            }
        })
        .collect();
    if n == 3 {
        parts.push((0..3).map(middle).collect());
    }
    parts
}

/// Returns a bound of the error of a texel's A·F of patch `i` against the integral: its difference from the centroid rule
/// on quarters of the texel, the error of that rule, and rounding.
fn texel_bound(cut: &RandomRoom, mesh: &Mesh, i: usize, k: usize) -> f64 {
    let (texel, polygon) = (&mesh.texels[k], patch_outline(mesh, i));
    let face = &mesh.faces[texel.face as usize];
    let normal = face.normal.as_dvec3();
    let f = |p: DVec3| point_to_polygon(p, normal, &polygon);
    let input = &cut.scene.faces[texel.face as usize];
    let corners: Vec<DVec3> = texel::texel_outline(input, face.resolution, texel.index)
        .corners()
        .iter()
        .map(|p| mesh.local_point(*p))
        .collect();
    let area = f64::from(texel.area);
    let (mut finer, mut bound) = (0.0, 0.0);
    for part in split_in_quarters(&corners) {
        let centre = part.iter().sum::<DVec3>() / part.len() as f64;
        finer += f(centre) / 4.0;
        bound += centroid_rule(&part, centre, area / 4.0, &f);
    }
    let mean = mean_factor(mesh, i, k, &receiver_points(mesh, i, k));
    bound + area * ((mean - finer).abs() + factor_rounding(mesh, i, k))
}

/// Returns bounds of the error of Σ A_j F(x_j → i) over the texels of each patch against A_i F_ic, without occluders.
fn quadrature_bounds(cut: &RandomRoom, mesh: &Mesh, i: usize) -> Vec<f64> {
    let own = mesh.patches[i].face;
    let bound = |patch: &Patch| -> f64 {
        let others = patch.texels().filter(|_| patch.face != own);
        others.map(|k| texel_bound(cut, mesh, i, k)).sum()
    };
    mesh.patches.iter().map(bound).collect()
}

/// Returns the expected sum of a texel's links to all patches. Lambert's factors from a point to a closed surrounding sum
/// to 1; the sum differs where near patches use the texel's grid and far ones its centre.
fn expected_link_sum(mesh: &Mesh, k: usize) -> f64 {
    let others = |i: &usize| mesh.patches[*i].face != mesh.texels[k].face;
    let patches: Vec<usize> = (0..mesh.patches.len()).filter(others).collect();
    if patches.iter().all(|i| !is_near(mesh, *i, k)) {
        return 1.0;
    }
    let (centre, grid) = ([mesh.texels[k].position.as_dvec3()], texel_grid(mesh, k));
    let far = patches.iter().filter(|i| !is_near(mesh, **i, k));
    let apart = far.map(|i| mean_factor(mesh, *i, k, &centre) - mean_factor(mesh, *i, k, &grid));
    1.0 + apart.sum::<f64>()
}

/// Returns the largest difference of a texel's sum of links from that, divided by its rounding bound.
fn largest_link_sum_error(way: SolverSetup, mesh: &Mesh) -> f64 {
    let mut engine = way.fresh_engine(mesh);
    make_links(engine.as_mut(), &all_patches(mesh));
    let n = mesh.patches.len();
    engine.gather_field(&vec![Vec3::ONE; n], &vec![Vec3::ZERO; n]).unwrap();
    let field = engine.read_field().unwrap();
    let off = field.irradiance.iter().enumerate().map(|(k, h)| {
        let others = (0..n).filter(|i| mesh.patches[*i].face != mesh.texels[k].face);
        let rounding: f64 = others.map(|i| factor_rounding(mesh, i, k)).sum();
        let bound = rounding + n as f64 * U;
        let expected = expected_link_sum(mesh, k) as f32;
        f64::from((h.truncate() - Vec3::splat(expected)).abs().max_element()) / bound
    });
    off.fold(0.0, f64::max)
}

/// Returns the largest errors of reciprocity, of exchange against the contour integral, and of ΣF against 1 − escaped,
/// each divided by the quadrature bound.
fn largest_pair_errors(way: SolverSetup, cut: &RandomRoom, mesh: &Mesh) -> [f64; 3] {
    let Taken { sums, escaped, taken } = Taken::new(way, mesh);
    let bounds: Vec<Vec<f64>> = (0..mesh.patches.len())
        .map(|i| quadrature_bounds(cut, mesh, i))
        .collect();
    let [mut reciprocity, mut exchange, mut closure] = [0f64; 3];
    for (i, patch) in mesh.patches.iter().enumerate() {
        let area = f64::from(patch.shooter.area);
        for (c, other) in mesh.patches.iter().enumerate().skip(i + 1) {
            if other.face == patch.face {
                continue;
            }
            let difference = (taken[i][c] - taken[c][i]).abs();
            reciprocity = reciprocity.max(difference / (bounds[i][c] + bounds[c][i]));
            let exact = area * exchange_area::form_factor(&patch_outline(mesh, i), &patch_outline(mesh, c));
            exchange = exchange.max((taken[i][c] - exact).abs() / bounds[i][c]);
        }
        let lost = area * (1.0 - sums[i] - escaped[i]);
        closure = closure.max(lost.abs() / bounds[i].iter().sum::<f64>());
    }
    [reciprocity, exchange, closure]
}

#[test]
fn links_of_a_texel_sum_to_one() {
    check_every_engine(8, &convex_room(), |way, cut| {
        let off = largest_link_sum_error(way, &cut.sampled_mesh(way.samples));
        prop_assert!(off <= 1.0, "{off} of what rounding allows");
        Ok(())
    });
}

#[test]
fn patches_are_reciprocal_and_closed() {
    check_every_engine(4, &convex_room(), |way, cut| {
        let mesh = cut.sampled_mesh(way.samples);
        let [reciprocity, exchange, closure] = largest_pair_errors(way, &cut, &mesh);
        prop_assert!(reciprocity <= 1.0, "reciprocity: {reciprocity}");
        prop_assert!(exchange <= 1.0, "against the contour integral: {exchange}");
        prop_assert!(closure <= 1.0, "closure: {closure}");
        Ok(())
    });
}

/// The energy balance uses the same form factors and does not notice a wrong one. Closure does, and reciprocity if the
/// two directions are not wrong alike.
#[test]
fn a_wrong_form_factor_shows_in_closure_and_reciprocity_alone() {
    let cut = convex_room()
        .new_tree(&mut TestRunner::deterministic())
        .unwrap()
        .current();
    for samples in [1, 4] {
        let mesh = cut.sampled_mesh(samples);
        assert_faults_noticed("closure", |faults| {
            let way = SolverSetup {
                on_gpu: true,
                samples,
                iteration: Iteration::Cg,
                fault: faults.first().copied(),
            };
            let run = way.solve_mesh(&mesh);
            let energy = EnergyBalance::new(&mesh, &run.field, &run.shots);
            let [reciprocity, exchange, patches] = largest_pair_errors(way, &cut, &mesh);
            let errors = [
                ("energy", energy.imbalance / 1e-5),
                ("exchange", exchange),
                ("patches", patches),
                ("reciprocity", reciprocity),
                ("texels", largest_link_sum_error(way, &mesh)),
            ];
            println!("{samples} samples, of what is allowed: {errors:.1?}");
            // A tenth too much is wrong both ways alike: reciprocity holds or not.
            let alike = faults.first().is_some_and(|fault| fault.to.contains("1.1 *"));
            let mut wrong: Vec<&str> = (errors.into_iter())
                .filter_map(|(name, error)| (error > 1.0).then_some(name))
                .collect();
            wrong.retain(|name| !(alike && *name == "reciprocity"));
            wrong.into_iter().map(ToOwned::to_owned).collect()
        });
    }
}
