//! The default projection and lookup of the item buffer err least against rays.

use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::settings::{ItemBufferProjection, ItemBufferSettings, Lookup, Transport, Visibility};
use radiosity_tests::box_in_room;
use radiosity_tests::shader_faults::visibility_statistics;

/// Returns the share of the transfer Σ F·A that an item buffer hides or lets through falsely.
fn wrong_share(mesh: &Mesh, projection: ItemBufferProjection, size: u32, lookup: Lookup) -> f64 {
    let transport = Transport {
        visibility: Visibility::ItemBuffer(ItemBufferSettings {
            projection,
            size,
            lookup,
        }),
        form_factor: FormFactor::Disc,
        conserve: false,
    };
    let pairs = visibility_statistics(mesh, &transport, &[]);
    assert!(pairs.facing > 0, "no pair faces each other");
    pairs.weighted_mismatch
}

#[test]
fn default_projection_and_lookup_err_least() {
    let mesh = Mesh::uniform(&box_in_room(), 16, 1).unwrap();
    let share_of = |projection, size, lookup| wrong_share(&mesh, projection, size, lookup);
    use ItemBufferProjection::{Hemicube, Hemisphere, Paper, Stereographic};
    use Lookup::{Exact, Neighbours};
    for projection in [Hemisphere, Stereographic, Hemicube] {
        // More pixels, and nine of them instead of one.
        let few = share_of(projection, 128, Exact);
        assert!(share_of(projection, 512, Exact) < few);
        assert!(share_of(projection, 128, Neighbours) < 0.1 * few);
        assert!(share_of(projection, 512, Neighbours) < 1e-4);
    }
    // The rim of the orthographic disc costs accuracy.
    let rim = share_of(Hemisphere, 512, Exact);
    assert!(share_of(Stereographic, 512, Exact) < rim);
    // Table 3 as printed: no resolution mends it.
    assert!(share_of(Paper, 512, Neighbours) > 0.1);
}
