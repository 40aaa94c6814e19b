//! Table 4 again, on few texels: the paper's shot counts, the order of its methods' errors, the page.

use common::import::{ImportOptions, load};
use common::scene::Scene;
use gpu::Gpu;
use oracle::study::table4::grid::Grid;
use oracle::study::table4::{Image, Row, Table, page};
use std::ops::ControlFlow;
use std::path::Path;

fn scene(name: &str) -> Scene {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes"));
    load(&folder.join(name), &ImportOptions::default()).unwrap()
}

/// One cell of the grid, 4×4 texels and 128² pixels.
fn table() -> Table {
    let (room, objects) = (scene("paper_room.obj"), scene("paper_objects.obj"));
    let joined = Scene::joined(&[room.clone(), objects.clone()]);
    let gpu = Gpu::open(None).unwrap();
    let grid = Grid {
        scene: &joined,
        room: room.faces.len(),
        device: Some(&gpu),
        show: &|_, _| ControlFlow::Continue(()),
    };
    let mut table = Table {
        faces: [joined.faces.len(), objects.faces.len()],
        ..Table::default()
    };
    let rays = grid.by_rays(4).unwrap();
    grid.cell(&mut table, 4, 128, &rays).unwrap();
    table
}

#[test]
fn the_paper_and_what_mends_it() {
    let table = table();
    assert_eq!(table.faces, [168, 12]);
    assert_eq!(table.rows.len(), Image::ALL.len());
    let row = |image: Image| -> &Row {
        let found = table.rows.iter().find(|row| row.image == image);
        found.unwrap()
    };
    for row in &table.rows {
        println!(
            "{}: {} + {} of {} shots, error {:.4}, to rays {:.4}, power {:.1e}",
            row.image.name(),
            row.map_shots,
            row.object_shots,
            row.shots,
            row.error,
            row.error_rays,
            row.imbalance
        );
        // Rows of nothing, or of the truth itself, are no rows.
        assert!(
            row.error.is_finite() && row.error > 0.0,
            "{}",
            row.image.name()
        );
        assert!(row.error_rays.is_finite() && row.error_rays > 0.0);
    }
    // Whole faces to 5 % unshot: 300 to 350 shots (reference.md §1: two programs), the paper's 322.
    let reference = row(Image::Reference).shots;
    assert!((300..=350).contains(&reference), "{reference}");
    // Each face of the room once, but for those that so few texels and pixels leave dark; then the
    // objects' own.
    assert!((150..=156).contains(&row(Image::Paper).map_shots));
    assert!((1..=32).contains(&row(Image::Paper).object_shots));
    // Each mend takes error away, and only the signed form keeps the balance of power.
    let error = |image| row(image).error;
    assert!(error(Image::Mended) < error(Image::Paper));
    assert!(error(Image::SignedEarly) < error(Image::Mended));
    assert!(error(Image::Signed) < error(Image::Mended));
    assert!(row(Image::Signed).imbalance < 1e-3 && row(Image::Paper).imbalance > 1e-2);
    let html = page::html(&table);
    assert!(
        html.contains("were chosen"),
        "the page says what was chosen"
    );
    assert_eq!(html.matches("data:image/png").count(), table.shown.len());
}
