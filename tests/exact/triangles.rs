//! Triangles: independence of the first corner, shared edges, and sheets of them.

use approx::abs_diff_eq;
use common::constants::NEAR_POINTS_PER_SIDE;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Face;
use common::settings::Visibility;
use cpu::dense::exchange_area;
use cpu::shader_twins::link::texel_form_factor;
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use radiosity_tests::bounds::polygon_rounding;
use radiosity_tests::engines::{mesh_scene, settings_of};
use radiosity_tests::{named_scene, random_cases, rotate_triangle};

/// Returns Σ A_t F_tc over the patches of face 0 and the texels of face 1, and its rounding bound: the near
/// points of a texel are up to NEAR_POINTS_PER_SIDE times as near to the patch as its centre.
fn flux(wall: &Face, triangle: &Face, texels: u32) -> [f64; 2] {
    let pair = named_scene("pair", vec![wall.clone(), triangle.clone()]);
    let mesh = mesh_scene(&pair, &settings_of([texels, 4, 4], Visibility::Rays, 1e-3));
    let (mut sum, mut rounding) = (0.0, 0.0);
    for (i, patch) in (0..).zip(&mesh.patches).filter(|(_, patch)| patch.face == 0) {
        for (k, texel) in (0..).zip(&mesh.texels).filter(|(_, texel)| texel.face == 1) {
            let area = f64::from(texel.area);
            sum += area * f64::from(texel_form_factor(&mesh, FormFactor::Polygon, i, k));
            let corners = patch.shooter.corners.map(|c| c.as_dvec3());
            let position = texel.position.as_dvec3();
            rounding += area * f64::from(NEAR_POINTS_PER_SIDE) * polygon_rounding(position, &corners);
        }
    }
    [sum, rounding].map(|x| x * mesh.area_unit())
}

/// Generates a unit wall x = 0, seen from +x, and a triangle on or near one of its edges, at an angle
/// between 20° and 160°.
fn hinged() -> impl Strategy<Value = (Face, Face)> {
    let angle = 0.35f64..2.8;
    let lift = prop_oneof![2 => Just(0.0), 1 => 0.0f64..0.3];
    (angle, lift, 0.2f64..1.5, -0.5f64..1.5).prop_map(|(angle, lift, reach, along)| {
        let wall = [DVec3::ZERO, DVec3::Y, DVec3::Y + DVec3::Z, DVec3::Z];
        let out = DVec3::new(angle.sin(), 0.0, angle.cos()) * reach;
        let up = DVec3::new(lift, 0.0, 0.0);
        let corners = [up, up + out + DVec3::Y * along, up + DVec3::Y];
        let face = |c| Face::triangle("triangle", c, Vec3::ZERO, Vec3::ZERO);
        let triangle = face(corners);
        // The triangle's front faces the wall.
        let seen = triangle.vector_area().dot(DVec3::new(0.0, 0.5, 0.5) - corners[1]) > 0.0;
        let triangle = if seen { triangle } else { triangle.reversed() };
        let wall = Face::quad("wall", wall, Vec3::ZERO, Vec3::ZERO);
        (wall, triangle)
    })
}

proptest! {
    #![proptest_config(random_cases(48))]

    /// Compares the sum with the contour integral. F is discontinuous at the ends of the shared edge only:
    /// there, of a texel's NEAR² parts, a line crosses NEAR at most, each with an error of one half.
    #[test]
    fn form_factor_across_shared_edge_equals_contour_integral((wall, triangle) in hinged(), by in 0usize..3) {
        let triangle = rotate_triangle(&triangle, by);
        let [of_wall, outline] = [&wall, &triangle].map(|face| face.outline());
        let exact = triangle.area() * exchange_area::form_factor(outline, of_wall);
        for texels in [4, 16] {
            let [flux, rounding] = flux(&wall, &triangle, texels);
            let texel = triangle.area() / f64::from(texels * texels);
            let bound = 2.0 * 0.5 * texel / f64::from(NEAR_POINTS_PER_SIDE) + rounding;
            prop_assert!(abs_diff_eq!(flux, exact, epsilon = bound), "{flux} is not {exact} ± {bound}");
        }
    }
}

/// A thin wall whose sides are divided along different diagonals: a ray meets the side that faces it, not
/// the coincident one.
#[test]
fn ray_meets_the_facing_side_of_a_sheet() {
    let corner = |x: f64, y: f64| DVec3::new(0.3 * x + 0.1, 0.7 * y - 0.2, 0.4 * x + 0.9 * y);
    let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| corner(x, y));
    let triangle = |corners| Face::triangle("sheet", corners, Vec3::ZERO, Vec3::ZERO);
    let above = [[a, b, c], [a, c, d]].map(triangle);
    let below = [[b, a, d], [b, d, c]].map(triangle);
    let sheet = named_scene("sheet", [above, below].concat());
    let mesh = Mesh::uniform(&sheet, 1, 1).unwrap();
    let rays = Rays::new(&mesh);
    for k in 0..1000 {
        let [u, v] = [0.754_877_7, 0.569_840_3].map(|step| (f64::from(k) * step).fract());
        let on = mesh.local_point(corner(u, v)).as_vec3();
        for side in [0, 2] {
            let normal = mesh.faces[side].normal;
            let from = on + normal + 0.5 * mesh.faces[side].tangent;
            let (met, t) = rays.nearest_face(from, on - from, u32::MAX).unwrap();
            assert_eq!(met as usize / 2 * 2, side, "{u} {v}");
            assert!(abs_diff_eq!(t, 1.0, epsilon = 1e-5), "{t}");
        }
    }
}
