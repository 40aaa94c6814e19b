//! Single form factors: clamping, contact, clipping at the horizon, angles, the point source.

use approx::abs_diff_eq;
use common::constants::{CONTACT_DISTANCE, POINT_SOURCE_RADII};
use common::form_factor::{FormFactor, Shooter, arc_tangent, disc_factor, form_factor, polygon_factor, vector_angle};
use common::mesh::Mesh;
use common::scene::Face;
use glam::{DQuat, DVec3, EulerRot, Vec3};
use oracle::exact;
use proptest::prelude::*;
use radiosity_tests::bounds::{ANGLE_ROUNDING, ARCTANGENT_ROUNDING, U, assert_near, polygon_rounding};
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::named_scene;

const KINDS: [FormFactor; 3] = [FormFactor::Paper, FormFactor::Disc, FormFactor::Polygon];

/// Returns the square |x|, |y| ≤ ½, z = 0, with its front up.
fn square() -> Shooter {
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[x, y]| Vec3::new(x, y, 0.0));
    Shooter {
        centre: Vec3::ZERO,
        normal: Vec3::Z,
        area: 1.0,
        radius: 0.5f32.sqrt(),
        corners,
    }
}

#[test]
fn back_facing_cosines_give_zero_form_factor() {
    let shooter = square();
    let above = Vec3::new(0.1, 0.2, 1.0);
    for kind in KINDS {
        let factor = |p: Vec3, n: Vec3| form_factor(kind, &shooter, p, n, 0.01);
        assert!(factor(above, Vec3::NEG_Z) > 0.1, "{kind:?}: facing");
        assert_eq!(factor(above, Vec3::Z), 0.0, "{kind:?}: the receiver faces away");
        assert_eq!(factor(-above, Vec3::Z), 0.0, "{kind:?}: the shooter faces away");
        assert_eq!(factor(-above, Vec3::NEG_Z), 0.0, "{kind:?}: both face away");
    }
}

#[test]
fn coplanar_and_touching_fronts_have_zero_form_factor() {
    let shooter = square();
    for kind in KINDS {
        let factor = |p: Vec3, n: Vec3| form_factor(kind, &shooter, p, n, 0.01);
        assert_eq!(factor(Vec3::new(0.75, 0.0, 0.0), Vec3::Z), 0.0, "{kind:?}: coplanar");
        assert_eq!(factor(Vec3::new(0.1, 0.0, 0.0), Vec3::NEG_Z), 0.0, "{kind:?}: touching");
        assert_eq!(
            factor(Vec3::new(0.1, 0.0, CONTACT_DISTANCE), Vec3::NEG_Z),
            0.0,
            "{kind:?}: at the gap"
        );
        let near = factor(Vec3::new(0.1, 0.0, 2.0 * CONTACT_DISTANCE), Vec3::NEG_Z);
        assert!(near > 0.0 && near.is_finite(), "{kind:?}: {near} beyond the gap");
    }
    // The shooter fills the hemisphere there: the share beside it is 2h/√(¼ − 0.01)… < 1e−5.
    let near = polygon_factor(&shooter, Vec3::new(0.1, 0.0, 2.0 * CONTACT_DISTANCE), Vec3::NEG_Z);
    assert_near("near", f64::from(near), 1.0, 1e-5);
    // The same through a mesh: a sheet lies on the floor, and beside it.
    let quad = |x: f64, width: f64| {
        let corners = rectangle([x, 0.0, 0.3], [width, 0.0, 0.0], [0.0, 1.0, 0.0]);
        Face::quad("", corners, Vec3::ONE, Vec3::ZERO)
    };
    let (floor, sheet, beside) = (quad(0.0, 3.0), quad(1.0, 1.0).reversed(), quad(3.0, 1.0));
    let mesh = Mesh::uniform(&named_scene("contact", vec![floor, sheet, beside]), 5, 2).unwrap();
    for kind in KINDS {
        for patch in &mesh.patches {
            for texel in mesh.texels.iter().filter(|texel| texel.face != patch.face) {
                let normal = mesh.faces[texel.face as usize].normal;
                let f = form_factor(kind, &patch.shooter, texel.position, normal, texel.area);
                assert_eq!(f, 0.0, "{kind:?}: face {} to {}", patch.face, texel.face);
            }
        }
    }
}

/// Compares a point source at distance h above the centre of a facing square, 1/πh², with the area.
#[test]
fn near_point_source_has_printed_error() {
    let shooter = square();
    // Printed digits.
    for (h, percent, half) in [(5.0f32, 1.3, 0.05), (2.0, 8.3, 0.05), (1.0, 33.0, 0.5)] {
        let point = Vec3::new(0.0, 0.0, h);
        let corners = shooter.corners.map(|c| c.as_dvec3());
        let exact = exact::point_to_polygon(point.as_dvec3(), DVec3::NEG_Z, &corners);
        let excess = |f: f32| 100.0 * (f64::from(f) / exact - 1.0);
        let source = disc_factor(1.0, 1.0, h * h, 1.0, 0.0);
        assert_near(h, excess(source), percent, half);
        // Wallace's disc of the source's area has 1/(πh² + 1), too dark by the next order.
        let wallace = form_factor(FormFactor::Disc, &shooter, point, Vec3::NEG_Z, 0.01);
        assert_eq!(wallace, disc_factor(1.0, 1.0, h * h, 1.0, 1.0));
        let lambert = polygon_factor(&shooter, point, Vec3::NEG_Z);
        let bound = polygon_rounding(point.as_dvec3(), &corners);
        assert_near(h, f64::from(lambert), exact, bound);
    }
}

/// Lambert's terms cancel to a small shooter's solid angle: for a shooter a thousandth of the scene wide the
/// rounding of a term, u, is all of F. The engines use a point source for such a shooter.
#[test]
fn small_shooter_form_factor_is_precise() {
    let wall = rectangle([-1.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    let turn = DQuat::from_euler(EulerRot::XYZ, 2.9, 0.3, 0.7);
    for exponent in 2..13 {
        let side = 10f64.powf(-0.5 * f64::from(exponent));
        let square = rectangle([0.0; 3], [side, 0.0, 0.0], [0.0, side, 0.0]);
        let square = square.map(|p| DVec3::new(0.31, -0.17, 0.43) + turn * p);
        let faces = [wall, square].map(|c| Face::quad("", c, Vec3::ONE, Vec3::ZERO));
        let mesh = Mesh::uniform(&named_scene("small", faces.into()), 8, 1).unwrap();
        let shooter = &mesh.patches[1].shooter;
        let outline = square.map(|p| mesh.local_point(p));
        let mut worst = 0.0f64;
        for texel in mesh.texels.iter().filter(|texel| texel.face == 0) {
            let (p, normal) = (texel.position, mesh.faces[0].normal);
            let f = form_factor(FormFactor::Polygon, shooter, p, normal, texel.area);
            let exact = exact::point_to_polygon(p.as_dvec3(), normal.as_dvec3(), &outline);
            let d = (p - shooter.centre).as_dvec3();
            let facing = f64::from(shooter.area) / (std::f64::consts::PI * d.length_squared());
            let share = (f64::from(shooter.radius) / d.length()).powi(2);
            // A point source: Taylor's second term, ≤ 6/r² times half the square of the distance. Centre
            // and corners are rounded (√3 u), which moves the centre and scales the square. The exact value
            // is Lambert's sum in f64.
            let bound = if share < f64::from(POINT_SOURCE_RADII).powi(-2) {
                facing * (3.0 * share + 20.0 * U + 16.0 * f64::EPSILON / share)
            } else {
                polygon_rounding(p.as_dvec3(), &outline)
            };
            assert_near(side, f64::from(f), exact, bound);
            worst = worst.max((f64::from(f) - exact).abs() / facing);
        }
        println!("{side:.1e}: off by {worst:.1e}");
        // The error of Lambert's sum at 64 radii, the worst distance: four terms of 2u over 2/(π·64²).
        assert!(worst < 4e-3, "{side:e}: {worst:e}");
    }
}

/// A lamp on the receiver's plane, of `height`: its edges' terms are near 1, F is about height²/2. Each
/// vertex is exact in f32; the exact sum in f64 is precise enough down to a height of 1e−5.
#[test]
fn low_shooter_form_factor_is_precise() {
    for height in [0.3f32, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5] {
        let corners = [[-0.25, 0.0], [0.25, 0.0], [0.25, height], [-0.25, height]].map(|[x, z]| Vec3::new(x, 0.0, z));
        let centre = Vec3::new(0.0, 0.0, 0.5 * height);
        let shooter = Shooter {
            centre,
            normal: Vec3::NEG_Y,
            area: 0.5 * height,
            radius: corners[2].distance(centre),
            corners,
        };
        for position in [Vec3::new(0.0, -0.5, 0.0), Vec3::new(0.3, -0.9, 0.0)] {
            let found = f64::from(polygon_factor(&shooter, position, Vec3::Z));
            let outline = corners.map(|c| c.as_dvec3());
            let truth = exact::point_to_polygon(position.as_dvec3(), DVec3::Z, &outline);
            // Some forty operations round the result. Above MAX_GRAZING_HEIGHT_RATIO it is a difference of terms
            // near 1, and F is (height/distance)²/2; near the ratio 1/64 either formula may be used.
            let slope = f64::from(position.length() / height);
            let cancelled = if slope > 96.0 { 0.0 } else { 4.0 * slope * slope };
            let bound = (100.0 + cancelled) * U * truth + 4.0 * f64::EPSILON;
            assert_near(format_args!("{height} at {position}"), found, truth, bound);
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
    #![proptest_config(radiosity_tests::random_cases(4096))]

    /// Compares any parallelogram or triangle, wholly or partly above the receiver's horizon.
    #[test]
    fn polygon_factor_equals_lamberts_sum(
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
        // Rounding bends a sliver's plane; the f32 corners of other shapes lie in theirs to 1e−6.
        prop_assume!(area.length() > 0.05 * sides[0] * sides[1]);
        // The front faces the receiver; another test covers backs.
        let distance = area.normalize().dot(-c);
        let (a, b) = if distance > 0.0 { (a, b) } else { (b, a) };
        prop_assume!(distance.abs() > 1e-3);
        let third = if is_triangle { c + b } else { c + a + b };
        let corners = [c, c + a, third, c + b];
        let shooter = Shooter { centre: c, normal: a.cross(b).normalize(), area: area.length(), radius: 2.0, corners };
        let outline: Vec<DVec3> = corners[..if is_triangle { 3 } else { 4 }].iter().map(|c| c.as_dvec3()).collect();
        let up = normal.as_dvec3().normalize();
        let exact = exact::point_to_polygon(DVec3::ZERO, up, &outline);
        let seen = common::polygon::clip_by_plane(&outline, DVec3::ZERO, up);
        let bound = polygon_rounding(DVec3::ZERO, &seen);
        let value = f64::from(polygon_factor(&shooter, Vec3::ZERO, normal));
        prop_assert!(abs_diff_eq!(value, exact, epsilon = bound), "{value} is not {exact} ± {bound}");
    }

    #[test]
    fn vector_angle_equals_atan2(exponent in -12.0f32..12.0, negative: bool, scale in 1e-6f32..1e6) {
        let (s, c) = (exponent.exp2() * scale, if negative { -scale } else { scale });
        let exact = f64::from(s).atan2(f64::from(c));
        let error = (f64::from(vector_angle(s, c)) - exact).abs();
        prop_assert!(error <= ANGLE_ROUNDING, "{s} {c}: {} u", error / U);
        // A small angle has a small relative error: quotient, 1 + 1/3·z·x of the polynomial, result.
        if c > 0.0 && s < 0.4 * c {
            prop_assert!(error <= 3.0 * U * exact, "{s} {c}: {} u", error / exact / U);
        }
    }
}

#[test]
fn vector_angle_of_parallel_and_perpendicular_edges() {
    assert_eq!(vector_angle(0.0, 1.0), 0.0);
    assert_eq!(vector_angle(0.0, -1.0), std::f32::consts::PI);
    assert_eq!(vector_angle(1.0, 0.0), std::f32::consts::FRAC_PI_2);
}

#[test]
fn arc_tangent_equals_atan() {
    // A prime stride over all floats of 0…1.
    let largest = (0..=1.0f32.to_bits())
        .step_by(997)
        .map(f32::from_bits)
        .map(|q| (f64::from(arc_tangent(q)) - f64::from(q).atan()).abs())
        .fold(0.0, f64::max);
    assert!(largest <= ARCTANGENT_ROUNDING, "{} u", largest / U);
}
