//! WGSL and its scalar twins agree stage by stage, for every projection, lookup and form factor;
//! and the lookup does what it says.

use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::rays::Rays;
use common::settings::{Drawing, Lookup, Projection, Raster, Transport, Visibility};
use cpu::twin::item_buffer::ItemBuffer;
use cpu::twin::lookup::visible;
use cpu::twin::projection::{pixels, project};
use cpu::twin::view::View;
use gpu::{Gpu, GpuSolver};
use oracle::judge::compare::stages::stages;
use radiosity_tests::box_in_room;

#[test]
fn every_stage_equals_its_twin() {
    let scene = box_in_room();
    let gpu = Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh");
    let projections = [
        Projection::Paper,
        Projection::Hemisphere(Raster::Tessellated),
        Projection::Stereographic(Raster::Tessellated),
        Projection::Hemisphere(Raster::Pixel),
        Projection::Stereographic(Raster::Pixel),
        Projection::Hemicube,
    ];
    let kinds = [FormFactor::Paper, FormFactor::Disc, FormFactor::Polygon];
    for (n, projection) in projections.into_iter().enumerate() {
        for (m, form_factor) in kinds.into_iter().enumerate() {
            let transport = Transport {
                visibility: Visibility::Drawn(Drawing {
                    projection,
                    size: 256,
                    lookup: [Lookup::Exact, Lookup::Neighbours][(n + m) % 2],
                }),
                form_factor,
                conserve: false,
            };
            let mesh = Mesh::uniform(&scene, 6, 2).unwrap();
            let mut solver = GpuSolver::new(&gpu, &mesh, &transport).unwrap();
            for stage in stages(&mesh, &transport, &Rays::new(&mesh), &mut solver).unwrap() {
                assert!(stage.agree, "{transport:?} {stage:?}");
            }
        }
    }
}

fn stereographic(size: u32) -> Drawing {
    Drawing {
        size,
        ..Drawing::DEFAULT
    }
}

/// Lookups of the floor's texels from the ceiling's centre, against rays: (wrongly hidden, wrongly lit).
fn mistakes(lookup: Lookup) -> (usize, usize) {
    let scene = box_in_room();
    let mesh = Mesh::uniform(&scene, 64, 1).unwrap();
    let rays = Rays::new(&mesh);
    let cell = &mesh.cells[1];
    let view = View::new(&mesh, 1, 0, &stereographic(256));
    let buffer = ItemBuffer::draw(&mesh, &view, mesh.room);
    let (mut hidden, mut lit) = (0, 0);
    for texel in mesh.texels.iter().filter(|texel| texel.face == 0) {
        let truth = rays.visible(cell.shooter.centre, texel.position, [1, 0]);
        let found = visible(&mesh, &buffer, &view, lookup, texel.position, 0);
        hidden += usize::from(truth && !found);
        lit += usize::from(!truth && found);
    }
    (hidden, lit)
}

#[test]
fn nine_pixels_mend_what_one_gets_wrong() {
    let (hidden, lit) = mistakes(Lookup::Exact);
    assert!(hidden + lit > 0, "one pixel must be wrong on silhouettes");
    assert_eq!(mistakes(Lookup::Neighbours), (0, 0));
}

#[test]
fn a_texel_whose_pixel_shows_its_neighbour_is_found_in_the_nine() {
    let scene = box_in_room();
    let mesh = Mesh::uniform(&scene, 8, 1).unwrap();
    let view = View::new(&mesh, 1, 0, &stereographic(64));
    let texel = mesh.texels.iter().find(|texel| texel.face == 0).unwrap();
    let p = pixels(
        project(view.projection, view.frame.to_local(texel.position)),
        64,
    );
    let (x, y) = (p.x as usize, p.y as usize);
    let asked = |ids: &dyn Fn(usize, usize) -> u32, lookup| {
        let ids = (0..64 * 64).map(|k| ids(k % 64, k / 64)).collect();
        visible(
            &mesh,
            &ItemBuffer { size: 64, ids },
            &view,
            lookup,
            texel.position,
            0,
        )
    };
    // Its own pixel shows nothing, the one beside it shows the floor (ID 1).
    let beside = |i: usize, j: usize| u32::from((i, j) == (x + 1, y));
    assert!(!asked(&beside, Lookup::Exact));
    assert!(asked(&beside, Lookup::Neighbours));
    // Two pixels away is too far.
    let far = |i: usize, j: usize| u32::from((i, j) == (x + 2, y));
    assert!(!asked(&far, Lookup::Neighbours));
    // A wall (ID 3) in the nine does not lie in between, so it does not hide the texel.
    let wall = |i: usize, j: usize| if (i, j) == (x, y) { 1 } else { 3 };
    assert!(asked(&wall, Lookup::Neighbours));
}
