//! Links: closure seen from texels and from cells, reciprocity, convergence; and that a wrong form
//! factor shows in them, not in the balance.

use super::kit::{Way, all, every_engine, outline};
use super::places::{factor_rounding, grid, is_near, mean_factor, places};
use super::scenes::{Cut, convex, furnished};
use common::energy::Energy;
use common::mesh::{Cell, Mesh};
use common::settings::Iteration;
use common::texel;
use cpu::matrix::pair;
use glam::{DVec3, Vec3};
use gpu::Fault;
use oracle::judge::exact::point_to_polygon;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use radiosity_tests::bounds::{U, centroid_rule};
use std::ops::ControlFlow;

/// ΣF and the escaped share of each cell, and what all cells take of each: `taken[i][c]`, mesh units.
struct Taken {
    sums: Vec<f64>,
    escaped: Vec<f64>,
    taken: Vec<Vec<f64>>,
}

impl Taken {
    fn new(way: Way, mesh: &Mesh) -> Self {
        let mut engine = way.engine(mesh);
        let closures = engine
            .link(&all(mesh), &mut |_| ControlFlow::Continue(()))
            .unwrap();
        let mut row = |i: usize| -> Vec<f64> {
            let mut one = vec![Vec3::ZERO; mesh.cells.len()];
            one[i] = Vec3::ONE;
            let flux = engine.exchange(&one).unwrap();
            flux.iter().map(|f| f64::from(f.x)).collect()
        };
        Self {
            taken: (0..mesh.cells.len()).map(&mut row).collect(),
            sums: (closures.iter())
                .map(|c| f64::from(c.form_factor_sum))
                .collect(),
            escaped: closures.iter().map(|c| f64::from(c.escaped)).collect(),
        }
    }
}

/// A parallelogram or triangle as four equal ones.
fn quarters(corners: &[DVec3]) -> Vec<Vec<DVec3>> {
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

/// What a texel's A·F of cell `i` may be off by from the integral: what it differs by from the
/// centroid rule on its quarters, and the error of that; and rounding.
fn texel_bound(cut: &Cut, mesh: &Mesh, i: usize, k: usize) -> f64 {
    let (texel, polygon) = (&mesh.texels[k], outline(mesh, i));
    let face = &mesh.faces[texel.face as usize];
    let normal = face.normal.as_dvec3();
    let f = |p: DVec3| point_to_polygon(p, normal, &polygon);
    let input = &cut.scene.faces[texel.face as usize];
    let corners: Vec<DVec3> = texel::outline(input, face.resolution, texel.index)
        .corners()
        .iter()
        .map(|p| mesh.local(*p))
        .collect();
    let area = f64::from(texel.area);
    let (mut finer, mut bound) = (0.0, 0.0);
    for part in quarters(&corners) {
        let centre = part.iter().sum::<DVec3>() / part.len() as f64;
        finer += f(centre) / 4.0;
        bound += centroid_rule(&part, centre, area / 4.0, &f);
    }
    let mean = mean_factor(mesh, i, k, &places(mesh, i, k));
    bound + area * ((mean - finer).abs() + factor_rounding(mesh, i, k))
}

/// What Σ A_j F(x_j → i) over the texels of each cell may be off by from A_i F_ic where nothing is in
/// between.
fn quadrature(cut: &Cut, mesh: &Mesh, i: usize) -> Vec<f64> {
    let own = mesh.cells[i].face;
    let bound = |cell: &Cell| -> f64 {
        let others = cell.texels().filter(|_| cell.face != own);
        others.map(|k| texel_bound(cut, mesh, i, k)).sum()
    };
    mesh.cells.iter().map(bound).collect()
}

/// What a texel's links to all cells sum to: Lambert's factors from a point to all that surrounds it
/// are 1, wherever it lies and however large they are. Far cells are looked at from the centre alone,
/// also where near ones are from the texel's grid.
fn hemisphere(mesh: &Mesh, k: usize) -> f64 {
    let others = |i: &usize| mesh.cells[*i].face != mesh.texels[k].face;
    let cells: Vec<usize> = (0..mesh.cells.len()).filter(others).collect();
    if cells.iter().all(|i| !is_near(mesh, *i, k)) {
        return 1.0;
    }
    let (centre, grid) = ([mesh.texels[k].position.as_dvec3()], grid(mesh, k));
    let far = cells.iter().filter(|i| !is_near(mesh, **i, k));
    let apart = far.map(|i| mean_factor(mesh, *i, k, &centre) - mean_factor(mesh, *i, k, &grid));
    1.0 + apart.sum::<f64>()
}

/// The most by which a texel's links differ from that, over what rounding allows.
fn hemispheres(way: Way, mesh: &Mesh) -> f64 {
    let mut engine = way.engine(mesh);
    engine
        .link(&all(mesh), &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let n = mesh.cells.len();
    engine
        .gather(&vec![Vec3::ONE; n], &vec![Vec3::ZERO; n])
        .unwrap();
    let field = engine.field().unwrap();
    let off = field.irradiance.iter().enumerate().map(|(k, h)| {
        let others = (0..n).filter(|i| mesh.cells[*i].face != mesh.texels[k].face);
        let rounding: f64 = others.map(|i| factor_rounding(mesh, i, k)).sum();
        let bound = rounding + n as f64 * U;
        let expected = hemisphere(mesh, k) as f32;
        f64::from((h.truncate() - Vec3::splat(expected)).abs().max_element()) / bound
    });
    off.fold(0.0, f64::max)
}

/// The most by which two cells take differently of each other, and by which either takes what the
/// contour integral does not give it, over what the quadrature allows; then the same of ΣF against
/// 1 − escaped.
fn pairs(way: Way, cut: &Cut, mesh: &Mesh) -> [f64; 3] {
    let Taken {
        sums,
        escaped,
        taken,
    } = Taken::new(way, mesh);
    let bounds: Vec<Vec<f64>> = (0..mesh.cells.len())
        .map(|i| quadrature(cut, mesh, i))
        .collect();
    let [mut reciprocity, mut exchange, mut closure] = [0f64; 3];
    for (i, cell) in mesh.cells.iter().enumerate() {
        let area = f64::from(cell.shooter.area);
        for (c, other) in mesh.cells.iter().enumerate().skip(i + 1) {
            if other.face == cell.face {
                continue;
            }
            let difference = (taken[i][c] - taken[c][i]).abs();
            reciprocity = reciprocity.max(difference / (bounds[i][c] + bounds[c][i]));
            let exact = area * pair::form_factor(&outline(mesh, i), &outline(mesh, c));
            exchange = exchange.max((taken[i][c] - exact).abs() / bounds[i][c]);
        }
        let lost = area * (1.0 - sums[i] - escaped[i]);
        closure = closure.max(lost.abs() / bounds[i].iter().sum::<f64>());
    }
    [reciprocity, exchange, closure]
}

#[test]
fn the_links_of_a_texel_close() {
    every_engine(8, &convex(), |way, cut| {
        let off = hemispheres(way, &cut.mesh(way.samples));
        prop_assert!(off <= 1.0, "{off} of what rounding allows");
        Ok(())
    });
}

#[test]
fn cells_give_each_other_what_they_take_and_close() {
    every_engine(4, &convex(), |way, cut| {
        let mesh = cut.mesh(way.samples);
        let [reciprocity, exchange, closure] = pairs(way, &cut, &mesh);
        prop_assert!(reciprocity <= 1.0, "reciprocity: {reciprocity}");
        prop_assert!(exchange <= 1.0, "against the contour integral: {exchange}");
        prop_assert!(closure <= 1.0, "closure: {closure}");
        Ok(())
    });
}

/// Whatever stands in a closed room, nothing leaves it.
#[test]
fn nothing_escapes_from_a_closed_room() {
    let rooms = furnished().prop_filter("closed", |cut| cut.closed);
    every_engine(8, &rooms, |way, cut| {
        let mesh = cut.mesh(way.samples);
        let closures = (way.engine(&mesh))
            .link(&all(&mesh), &mut |_| ControlFlow::Continue(()))
            .unwrap();
        let lost = closures.iter().position(|closure| closure.escaped != 0.0);
        prop_assert!(
            lost.is_none(),
            "cell {lost:?}: {:?}",
            closures[lost.unwrap()]
        );
        Ok(())
    });
}

/// Σ|A_i F_ij taken − exact| over all pairs of faces, over the area of all.
fn face_error(way: Way, cut: &Cut, side: u32) -> f64 {
    let cut = Cut {
        resolutions: vec![[side; 2]; cut.scene.faces.len()],
        ..cut.clone()
    };
    let mesh = cut.mesh(way.samples);
    let taken = Taken::new(way, &mesh).taken;
    let n = cut.scene.faces.len();
    let mut flux = vec![vec![0.0; n]; n];
    for (from, row) in mesh.cells.iter().zip(&taken) {
        for (to, taken) in mesh.cells.iter().zip(row) {
            flux[from.face as usize][to.face as usize] += taken * mesh.area_unit();
        }
    }
    let (mut off, mut area) = (0.0, 0.0);
    for (from, row) in cut.scene.faces.iter().zip(&flux) {
        area += from.area();
        for (to, flux) in cut.scene.faces.iter().zip(row) {
            let exact = from.area() * pair::form_factor(from.outline(), to.outline());
            off += (flux - exact).abs();
        }
    }
    off / area
}

/// The centroid rule is of second order but at the ends of shared edges, where F jumps: there whole
/// texels are wrong, whose area falls by 4 with each halving. Each halving must bring 2 at least.
#[test]
fn finer_texels_are_nearer_to_the_truth() {
    every_engine(3, &convex(), |way, cut| {
        let errors = [2, 4, 8].map(|side| face_error(way, &cut, side));
        let falls = errors.windows(2).all(|pair| pair[1] < pair[0] / 2.0);
        prop_assert!(falls && errors[0] > 0.0, "{errors:?}");
        Ok(())
    });
}

/// A wrong form factor is not lost light to the balance, which counts by the same factors: closure
/// sees it, and reciprocity where it is not wrong both ways alike.
#[test]
fn a_wrong_form_factor_shows_in_closure_and_reciprocity_alone() {
    const FACTOR: &str = "return polygon(position, normal);";
    const FAULTS: [(&str, [Fault; 1]); 3] = [
        (
            "a tenth too much",
            [fault("return 1.1 * polygon(position, normal);")],
        ),
        (
            "a disc",
            [fault(
                "return disc(cos_i, cos_j, r2, shots[slot].area, shots[slot].area);",
            )],
        ),
        (
            "a cosine too many",
            [fault("return cos_j * polygon(position, normal);")],
        ),
    ];
    const fn fault(to: &'static str) -> Fault {
        Fault {
            file: "form_factor",
            from: FACTOR,
            to,
        }
    }
    let mut runner = TestRunner::deterministic();
    let cut = convex().new_tree(&mut runner).unwrap().current();
    for samples in [1, 4] {
        let mesh = cut.mesh(samples);
        for (name, faults) in &FAULTS {
            let way = Way {
                on_gpu: true,
                samples,
                iteration: Iteration::Cg,
                faults,
            };
            let run = way.solve(&mesh);
            let energy = Energy::new(&mesh, &run.field, &run.shots);
            let hemispheres = hemispheres(way, &mesh);
            let [reciprocity, exchange, closure] = pairs(way, &cut, &mesh);
            println!(
                "{name}, {samples}: imbalance {:.1e}; of what is allowed: closure of texels {hemispheres:.1}, of cells {closure:.2}, exchange {exchange:.1}, reciprocity {reciprocity:.1}",
                energy.imbalance
            );
            assert!(energy.imbalance < 1e-5, "{name}: {energy:?}");
            assert!(
                hemispheres > 10.0 && exchange > 1.0 && closure > 1.0,
                "{name}"
            );
            // A tenth too much is wrong both ways alike.
            assert!(reciprocity > 1.0 || *name == FAULTS[0].0, "{name}");
        }
    }
}
