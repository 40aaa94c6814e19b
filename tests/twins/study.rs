//! The default projection and lookup have the smallest measured errors.

use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::settings::{ItemBufferProjection, Lookup, Raster};
use gpu::Gpu;
use radiosity::studies::chart::vary::item_buffer::{ItemBufferRow, measure_rows};
use radiosity_tests::box_in_room;

/// Share of the transfer that a row gets wrong.
fn wrong_share(rows: &[ItemBufferRow], projection: ItemBufferProjection, size: u32, lookup: Lookup) -> f64 {
    let asked = (projection.name(), projection.raster_method(), size, lookup);
    let mut rows = rows.iter();
    let row = rows.find(|row| (row.visibility, row.raster, row.size, row.lookup) == asked);
    let row = row.expect("the table has this row");
    row.falsely_hidden + row.falsely_seen
}

#[test]
fn default_projection_and_lookup_err_least() {
    let gpu = Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh");
    let mesh = Mesh::uniform(&box_in_room(), 16, 1).unwrap();
    let rows = measure_rows(&gpu, &mesh, FormFactor::Disc, &[128, 512], &mut |_| ()).unwrap();
    assert_eq!(rows.len(), 24);
    assert!(rows.iter().all(|row| row.facing > 0 && row.shot_seconds > 0.0));
    let share_of = |projection, size, lookup| wrong_share(&rows, projection, size, lookup);
    use ItemBufferProjection::{Hemicube, Hemisphere, Paper, Stereographic};
    use Lookup::{Exact, Neighbours};
    use Raster::{Pixel, Tessellated};
    for projection in [Hemisphere(Pixel), Stereographic(Pixel), Hemicube] {
        // More pixels, and nine of them instead of one.
        let few = share_of(projection, 128, Exact);
        assert!(share_of(projection, 512, Exact) < few);
        assert!(share_of(projection, 128, Neighbours) < 0.1 * few);
        assert!(share_of(projection, 512, Neighbours) < 1e-4);
    }
    for projection in [Hemisphere, Stereographic] {
        for size in [128, 512] {
            let cut = share_of(projection(Tessellated), size, Neighbours);
            assert!(share_of(projection(Pixel), size, Neighbours) <= 1.5 * cut + 1e-6);
        }
    }
    // The rim of the orthographic disc costs accuracy.
    let rim = share_of(Hemisphere(Pixel), 512, Exact);
    assert!(share_of(Stereographic(Pixel), 512, Exact) < rim);
    // Table 3 as printed: no resolution mends it.
    assert!(share_of(Paper, 512, Neighbours) > 0.1);
}
