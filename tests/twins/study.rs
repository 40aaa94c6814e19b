//! The measurements behind the defaults keep the order that the defaults stand on.

use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::settings::{Lookup, Raster, Settings, Visibility};
use gpu::Gpu;
use oracle::study::converge::item_buffer::{Row, rows};
use radiosity_tests::box_in_room;

/// Share of the transfer that a row gets wrong.
fn wrong(rows: &[Row], visibility: Visibility, raster: Raster, size: u32, lookup: Lookup) -> f64 {
    let asked = (visibility, raster, size, lookup);
    let mut rows = rows.iter();
    let row = rows.find(|row| (row.visibility, row.raster, row.size, row.lookup) == asked);
    let row = row.expect("the table has this row");
    row.falsely_hidden + row.falsely_seen
}

#[test]
fn rays_of_pixels_and_nine_of_them_err_least() {
    let gpu = Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh");
    let settings = Settings {
        form_factor: FormFactor::Disc,
        ..Settings::default()
    };
    let mesh = Mesh::uniform(&box_in_room(), 16, 1).unwrap();
    let rows = rows(&gpu, &mesh, &settings, &[128, 512], &mut |_| ()).unwrap();
    assert_eq!(rows.len(), 24);
    assert!(
        rows.iter()
            .all(|row| row.facing > 0 && row.shot_seconds > 0.0)
    );
    let wrong = |v, r, size, lookup| wrong(&rows, v, r, size, lookup);
    use Lookup::{Exact, Neighbours};
    use Raster::{Pixel, Tessellated};
    for visibility in [
        Visibility::Hemisphere,
        Visibility::Stereographic,
        Visibility::Hemicube,
    ] {
        // More pixels, and nine of them instead of one.
        let few = wrong(visibility, Pixel, 128, Exact);
        assert!(wrong(visibility, Pixel, 512, Exact) < few);
        assert!(wrong(visibility, Pixel, 128, Neighbours) < 0.1 * few);
        assert!(wrong(visibility, Pixel, 512, Neighbours) < 1e-4);
    }
    for visibility in [Visibility::Hemisphere, Visibility::Stereographic] {
        for size in [128, 512] {
            let cut = wrong(visibility, Tessellated, size, Neighbours);
            assert!(wrong(visibility, Pixel, size, Neighbours) <= 1.5 * cut + 1e-6);
        }
    }
    // The rim of the orthographic disc is what it costs.
    let rim = wrong(Visibility::Hemisphere, Pixel, 512, Exact);
    assert!(wrong(Visibility::Stereographic, Pixel, 512, Exact) < rim);
    // Table 3 as printed: no resolution mends it.
    assert!(wrong(Visibility::Paper, Tessellated, 512, Neighbours) > 0.1);
}
