//! Single form factors: clamping, contact, clipping at the horizon, the angle, the point source.

use approx::abs_diff_eq;
use common::constants::{CONTACT, POINT};
use common::form_factor::{FormFactor, Shooter, angle, arctangent, disc, form_factor, polygon};
use common::mesh::Mesh;
use common::scene::Face;
use glam::{DQuat, DVec3, EulerRot, Vec3};
use oracle::judge::exact;
use proptest::prelude::*;
use radiosity_tests::bounds::{ANGLE, ARCTANGENT, U, polygon_rounding};
use radiosity_tests::scene;

const KINDS: [FormFactor; 3] = [FormFactor::Paper, FormFactor::Disc, FormFactor::Polygon];

/// The square |x|, |y| ≤ ½, z = 0, its front up.
fn square() -> Shooter {
    let corners =
        [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[x, y]| Vec3::new(x, y, 0.0));
    Shooter {
        centre: Vec3::ZERO,
        normal: Vec3::Z,
        area: 1.0,
        radius: 0.5f32.sqrt(),
        corners,
    }
}

#[test]
fn each_cosine_is_clamped_on_its_own() {
    let shooter = square();
    let above = Vec3::new(0.1, 0.2, 1.0);
    for kind in KINDS {
        let factor = |p: Vec3, n: Vec3| form_factor(kind, &shooter, p, n, 0.01);
        assert!(factor(above, Vec3::NEG_Z) > 0.1, "{kind:?}: facing");
        assert_eq!(
            factor(above, Vec3::Z),
            0.0,
            "{kind:?}: the receiver faces away"
        );
        assert_eq!(
            factor(-above, Vec3::Z),
            0.0,
            "{kind:?}: the shooter faces away"
        );
        assert_eq!(factor(-above, Vec3::NEG_Z), 0.0, "{kind:?}: both face away");
    }
}

#[test]
fn coplanar_and_touching_fronts_exchange_nothing() {
    let shooter = square();
    for kind in KINDS {
        let factor = |p: Vec3, n: Vec3| form_factor(kind, &shooter, p, n, 0.01);
        assert_eq!(
            factor(Vec3::new(0.75, 0.0, 0.0), Vec3::Z),
            0.0,
            "{kind:?}: coplanar"
        );
        assert_eq!(
            factor(Vec3::new(0.1, 0.0, 0.0), Vec3::NEG_Z),
            0.0,
            "{kind:?}: touching"
        );
        assert_eq!(
            factor(Vec3::new(0.1, 0.0, CONTACT), Vec3::NEG_Z),
            0.0,
            "{kind:?}: at the gap"
        );
        let near = factor(Vec3::new(0.1, 0.0, 2.0 * CONTACT), Vec3::NEG_Z);
        assert!(
            near > 0.0 && near.is_finite(),
            "{kind:?}: {near} beyond the gap"
        );
    }
    // Lambert sees nothing but the shooter from there: what passes it is 2h/√(¼ − 0.01)… < 1e−5.
    let near = polygon(&shooter, Vec3::new(0.1, 0.0, 2.0 * CONTACT), Vec3::NEG_Z);
    assert!(abs_diff_eq!(near, 1.0, epsilon = 1e-5), "{near}");
    // The same through a mesh: a sheet lies on the floor, and beside it.
    let p = |x: f64, y: f64| DVec3::new(x, y, 0.3);
    let quad = |c: [DVec3; 4]| Face::quad("", c, Vec3::ONE, Vec3::ZERO);
    let floor = quad([p(0.0, 0.0), p(3.0, 0.0), p(3.0, 1.0), p(0.0, 1.0)]);
    let sheet = quad([p(1.0, 0.0), p(2.0, 0.0), p(2.0, 1.0), p(1.0, 1.0)]).reversed();
    let beside = quad([p(3.0, 0.0), p(4.0, 0.0), p(4.0, 1.0), p(3.0, 1.0)]);
    let mesh = Mesh::uniform(&scene("contact", vec![floor, sheet, beside]), 5, 2).unwrap();
    for kind in KINDS {
        for cell in &mesh.cells {
            for texel in mesh.texels.iter().filter(|texel| texel.face != cell.face) {
                let normal = mesh.faces[texel.face as usize].normal;
                let f = form_factor(kind, &cell.shooter, texel.position, normal, texel.area);
                assert_eq!(f, 0.0, "{kind:?}: face {} to {}", cell.face, texel.face);
            }
        }
    }
}

/// A point instead of the area, at distance h above the centre of a facing square: 1/πh².
#[test]
fn a_point_source_is_too_bright_near_by() {
    let shooter = square();
    // Printed digits.
    for (h, percent, half) in [(5.0f32, 1.3, 0.05), (2.0, 8.3, 0.05), (1.0, 33.0, 0.5)] {
        let point = Vec3::new(0.0, 0.0, h);
        let corners = shooter.corners.map(|c| c.as_dvec3());
        let exact = exact::point_to_polygon(point.as_dvec3(), DVec3::NEG_Z, &corners);
        let excess = |f: f32| 100.0 * (f64::from(f) / exact - 1.0);
        let source = disc(1.0, 1.0, h * h, 1.0, 0.0);
        assert!(
            abs_diff_eq!(excess(source), percent, epsilon = half),
            "h = {h}: {} %",
            excess(source)
        );
        // Wallace's disc of the source's area has 1/(πh² + 1): too dark by its next order.
        let wallace = form_factor(FormFactor::Disc, &shooter, point, Vec3::NEG_Z, 0.01);
        assert_eq!(wallace, disc(1.0, 1.0, h * h, 1.0, 1.0));
        let lambert = polygon(&shooter, point, Vec3::NEG_Z);
        let bound = polygon_rounding(point.as_dvec3(), &corners);
        assert!(
            abs_diff_eq!(f64::from(lambert), exact, epsilon = bound),
            "h = {h}: {lambert} {exact}"
        );
    }
}

/// Lambert's terms cancel to a small shooter's solid angle: the rounding of a term, u, is all of F
/// where that is a thousandth of the scene wide. The engines take such a shooter as a point.
#[test]
fn small_shooters_keep_their_digits() {
    let wall = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let wall = wall.map(|[x, y]| DVec3::new(x, y, -1.0));
    let turn = DQuat::from_euler(EulerRot::XYZ, 2.9, 0.3, 0.7);
    for exponent in 2..13 {
        let side = 10f64.powf(-0.5 * f64::from(exponent));
        let corner = |x: f64, y: f64| DVec3::new(0.31, -0.17, 0.43) + turn * DVec3::new(x, y, 0.0);
        let square = [
            corner(0.0, 0.0),
            corner(side, 0.0),
            corner(side, side),
            corner(0.0, side),
        ];
        let faces = [wall, square].map(|c| Face::quad("", c, Vec3::ONE, Vec3::ZERO));
        let mesh = Mesh::uniform(&scene("small", faces.into()), 8, 1).unwrap();
        let shooter = &mesh.cells[1].shooter;
        let outline = square.map(|p| mesh.local(p));
        let mut worst = 0.0f64;
        for texel in mesh.texels.iter().filter(|texel| texel.face == 0) {
            let (p, normal) = (texel.position, mesh.faces[0].normal);
            let f = form_factor(FormFactor::Polygon, shooter, p, normal, texel.area);
            let exact = exact::point_to_polygon(p.as_dvec3(), normal.as_dvec3(), &outline);
            let d = (p - shooter.centre).as_dvec3();
            let facing = f64::from(shooter.area) / (std::f64::consts::PI * d.length_squared());
            let share = (f64::from(shooter.radius) / d.length()).powi(2);
            // A point: Taylor's second term, ≤ 6/r² times half the square of the way; centre and
            // corners are rounded (√3 u), which moves the one and stretches the others' square. What is
            // called exact is Lambert's sum in f64.
            let bound = if share < f64::from(POINT).powi(-2) {
                facing * (3.0 * share + 20.0 * U + 16.0 * f64::EPSILON / share)
            } else {
                polygon_rounding(p.as_dvec3(), &outline)
            };
            assert!(
                abs_diff_eq!(f64::from(f), exact, epsilon = bound),
                "{side:e}: {f} {exact} {bound:e}"
            );
            worst = worst.max((f64::from(f) - exact).abs() / facing);
        }
        println!("{side:.1e}: off by {worst:.1e}");
        // What Lambert's sum leaves at 64 radii, the worst place: four terms of 2u over 2/(π·64²).
        assert!(worst < 4e-3, "{side:e}: {worst:e}");
    }
}

/// A lamp that stands on the receiver's plane and rises to `height`: its edges' terms are near 1, F is
/// height²/2 or so. Each vertex is a float; the exact sum in f64 has digits enough down to 1e−5.
#[test]
fn low_shooters_keep_their_digits() {
    for height in [0.3f32, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5] {
        let corners = [[-0.25, 0.0], [0.25, 0.0], [0.25, height], [-0.25, height]]
            .map(|[x, z]| Vec3::new(x, 0.0, z));
        let centre = Vec3::new(0.0, 0.0, 0.5 * height);
        let shooter = Shooter {
            centre,
            normal: Vec3::NEG_Y,
            area: 0.5 * height,
            radius: corners[2].distance(centre),
            corners,
        };
        for position in [Vec3::new(0.0, -0.5, 0.0), Vec3::new(0.3, -0.9, 0.0)] {
            let found = f64::from(polygon(&shooter, position, Vec3::Z));
            let outline = corners.map(|c| c.as_dvec3());
            let truth = exact::point_to_polygon(position.as_dvec3(), DVec3::Z, &outline);
            // Some forty operations round what is left. Above LOW that is a difference of terms near 1,
            // of which F is (height/distance)²/2; near LOW = 1/64 either may be taken.
            let slope = f64::from(position.length() / height);
            let cancelled = if slope > 96.0 {
                0.0
            } else {
                4.0 * slope * slope
            };
            let bound = (100.0 + cancelled) * U * truth + 4.0 * f64::EPSILON;
            assert!(
                abs_diff_eq!(found, truth, epsilon = bound),
                "{height} at {position}: {found:e}, exact {truth:e}"
            );
        }
    }
}

fn direction() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-1.0f32..1.0)
        .prop_map(Vec3::from)
        .prop_filter("has a direction", |v| v.length() > 0.1)
        .prop_map(Vec3::normalize)
}

proptest! {
    #![proptest_config(radiosity_tests::cases(4096))]

    /// Any parallelogram or triangle, wholly or partly above the receiver's horizon.
    #[test]
    fn polygon_is_lamberts(
        normal in direction(),
        u in direction(),
        v in direction(),
        sides in prop::array::uniform2(0.01f32..1.0),
        offset in prop::array::uniform3(-1.0f32..1.0),
        is_triangle: bool,
    ) {
        let (a, b) = (u * sides[0], v * sides[1]);
        let c = Vec3::from(offset);
        let area = a.cross(b);
        // A sliver's plane is lost in rounding; elsewhere the f32 corners lie in it to 1e−6.
        prop_assume!(area.length() > 0.05 * sides[0] * sides[1]);
        // The front to the receiver; the back is another test.
        let distance = area.normalize().dot(-c);
        let (a, b) = if distance > 0.0 { (a, b) } else { (b, a) };
        prop_assume!(distance.abs() > 1e-3);
        let third = if is_triangle { c + b } else { c + a + b };
        let corners = [c, c + a, third, c + b];
        let shooter = Shooter { centre: c, normal: a.cross(b).normalize(), area: area.length(), radius: 2.0, corners };
        let outline: Vec<DVec3> = corners[..if is_triangle { 3 } else { 4 }].iter().map(|c| c.as_dvec3()).collect();
        let up = normal.as_dvec3().normalize();
        let exact = exact::point_to_polygon(DVec3::ZERO, up, &outline);
        let seen = exact::clip(&outline, DVec3::ZERO, up);
        let bound = polygon_rounding(DVec3::ZERO, &seen);
        let value = f64::from(polygon(&shooter, Vec3::ZERO, normal));
        prop_assert!(abs_diff_eq!(value, exact, epsilon = bound), "{value} is not {exact} ± {bound}");
    }

    #[test]
    fn angle_is_atan2(exponent in -12.0f32..12.0, negative: bool, scale in 1e-6f32..1e6) {
        let (s, c) = (exponent.exp2() * scale, if negative { -scale } else { scale });
        let exact = f64::from(s).atan2(f64::from(c));
        let error = (f64::from(angle(s, c)) - exact).abs();
        prop_assert!(error <= ANGLE, "{s} {c}: {} u", error / U);
        // A small angle keeps its digits: quotient, 1 + 1/3·z·x of the polynomial, result.
        if c > 0.0 && s < 0.4 * c {
            prop_assert!(error <= 3.0 * U * exact, "{s} {c}: {} u", error / exact / U);
        }
    }
}

#[test]
fn angle_of_parallel_and_perpendicular_edges() {
    assert_eq!(angle(0.0, 1.0), 0.0);
    assert_eq!(angle(0.0, -1.0), std::f32::consts::PI);
    assert_eq!(angle(1.0, 0.0), std::f32::consts::FRAC_PI_2);
}

#[test]
fn arctangent_is_atan() {
    // A prime stride over all floats of 0…1.
    let largest = (0..=1.0f32.to_bits())
        .step_by(997)
        .map(f32::from_bits)
        .map(|q| (f64::from(arctangent(q)) - f64::from(q).atan()).abs())
        .fold(0.0, f64::max);
    assert!(largest <= ARCTANGENT, "{} u", largest / U);
}
