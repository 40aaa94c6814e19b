//! The measurements behind the defaults keep the order that the defaults stand on.

use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::settings::{Lookup, Projection, Raster};
use gpu::Gpu;
use oracle::study::converge::item_buffer::{Row, rows};
use radiosity_tests::box_in_room;

/// Share of the transfer that a row gets wrong.
fn wrong(rows: &[Row], projection: Projection, size: u32, lookup: Lookup) -> f64 {
    let asked = (projection.name(), projection.raster(), size, lookup);
    let mut rows = rows.iter();
    let row = rows.find(|row| (row.visibility, row.raster, row.size, row.lookup) == asked);
    let row = row.expect("the table has this row");
    row.falsely_hidden + row.falsely_seen
}

#[test]
fn rays_of_pixels_and_nine_of_them_err_least() {
    let gpu = Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh");
    let mesh = Mesh::uniform(&box_in_room(), 16, 1).unwrap();
    let rows = rows(&gpu, &mesh, FormFactor::Disc, &[128, 512], &mut |_| ()).unwrap();
    assert_eq!(rows.len(), 24);
    assert!(
        rows.iter()
            .all(|row| row.facing > 0 && row.shot_seconds > 0.0)
    );
    let wrong = |projection, size, lookup| wrong(&rows, projection, size, lookup);
    use Lookup::{Exact, Neighbours};
    use Projection::{Hemicube, Hemisphere, Paper, Stereographic};
    use Raster::{Pixel, Tessellated};
    for projection in [Hemisphere(Pixel), Stereographic(Pixel), Hemicube] {
        // More pixels, and nine of them instead of one.
        let few = wrong(projection, 128, Exact);
        assert!(wrong(projection, 512, Exact) < few);
        assert!(wrong(projection, 128, Neighbours) < 0.1 * few);
        assert!(wrong(projection, 512, Neighbours) < 1e-4);
    }
    for projection in [Hemisphere, Stereographic] {
        for size in [128, 512] {
            let cut = wrong(projection(Tessellated), size, Neighbours);
            assert!(wrong(projection(Pixel), size, Neighbours) <= 1.5 * cut + 1e-6);
        }
    }
    // The rim of the orthographic disc is what it costs.
    let rim = wrong(Hemisphere(Pixel), 512, Exact);
    assert!(wrong(Stereographic(Pixel), 512, Exact) < rim);
    // Table 3 as printed: no resolution mends it.
    assert!(wrong(Paper, 512, Neighbours) > 0.1);
}
