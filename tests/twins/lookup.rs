//! The 3×3 lookup corrects the errors of the exact one.

use common::mesh::Mesh;
use common::rays::Rays;
use common::settings::{ItemBufferSettings, Lookup};
use cpu::shader_twins::item_buffer::ItemBuffer;
use cpu::shader_twins::lookup::is_visible;
use cpu::shader_twins::projection::{pixel_position, project_direction};
use cpu::shader_twins::view::ShooterView;
use radiosity_tests::box_in_room;

fn stereographic_settings(size: u32) -> ItemBufferSettings {
    ItemBufferSettings {
        size,
        ..ItemBufferSettings::DEFAULT
    }
}

/// Lookups of the floor's texels from the ceiling's centre, against rays: (wrongly hidden, wrongly lit).
fn count_lookup_errors(lookup: Lookup) -> (usize, usize) {
    let scene = box_in_room();
    let mesh = Mesh::uniform(&scene, 64, 1).unwrap();
    let rays = Rays::new(&mesh);
    let cell = &mesh.patches[1];
    let view = ShooterView::new(&mesh, 1, 0, &stereographic_settings(256));
    let buffer = ItemBuffer::draw_faces(&mesh, &view, mesh.room_faces);
    let (mut hidden, mut lit) = (0, 0);
    for texel in mesh.texels.iter().filter(|texel| texel.face == 0) {
        let truth = rays.is_visible(cell.shooter.centre, texel.position, [1, 0]);
        let found = is_visible(&mesh, &buffer, &view, lookup, texel.position, 0);
        hidden += usize::from(truth && !found);
        lit += usize::from(!truth && found);
    }
    (hidden, lit)
}

#[test]
fn nine_pixel_lookup_corrects_one_pixel_lookup() {
    let (hidden, lit) = count_lookup_errors(Lookup::Exact);
    assert!(hidden + lit > 0, "one pixel must be wrong on silhouettes");
    assert_eq!(count_lookup_errors(Lookup::Neighbours), (0, 0));
}

#[test]
fn nine_pixel_lookup_finds_texel_beside_its_pixel() {
    let scene = box_in_room();
    let mesh = Mesh::uniform(&scene, 8, 1).unwrap();
    let view = ShooterView::new(&mesh, 1, 0, &stereographic_settings(64));
    let texel = mesh.texels.iter().find(|texel| texel.face == 0).unwrap();
    let p = pixel_position(
        project_direction(view.projection, view.frame.to_local(texel.position)),
        64,
    );
    let (x, y) = (p.x as usize, p.y as usize);
    let asked = |ids: &dyn Fn(usize, usize) -> u32, lookup| {
        let ids = (0..64 * 64).map(|k| ids(k % 64, k / 64)).collect();
        is_visible(&mesh, &ItemBuffer { size: 64, ids }, &view, lookup, texel.position, 0)
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
