//! Numbers that the shaders and their twins share, so that both can be compared: `gpu` writes them into the WGSL that it
//! compiles, except [`ROOTS_PER_BATCH`] and [`MAX_LINK_BYTES`], which limit work and memory on both sides. u = 2⁻²⁴ is the
//! unit roundoff; "the paper" is Kim, Hwang & Hong.

/// π as both solvers round it.
pub const PI: f32 = std::f32::consts::PI;

/// Distance from a patch, in texel radii, beyond which a texel's form factor is that of its centre.
pub const FAR_DISTANCE_RADII: f32 = 6.0;

/// Points per side of the grid over which a nearer texel's form factor is averaged.
pub const NEAR_POINTS_PER_SIDE: u32 = 4;

/// Offset of such a point within its grid step, on a quad. On a triangle, [`NEAR_OFFSET_TRIANGLE`] places
/// the points, folded onto the triangle, at the centroids of equal parts, whichever corner is first. At
/// 1/2 four of sixteen would lie on the edge u + v = 1 and see nothing of a wall that shares this edge.
pub const NEAR_OFFSET_QUAD: f32 = 0.5;
/// See [`NEAR_OFFSET_QUAD`].
pub const NEAR_OFFSET_TRIANGLE: f32 = 1.0 / 3.0;

/// Distance, in patch radii, beyond which a patch is a point source. The relative error of a point source
/// is (radius/distance)², here 2e−4. The terms of Lambert's sum cancel, which leaves the error
/// u·(distance/radius)²: as much here, and all of F for a patch a thousandth of the scene wide.
pub const POINT_SOURCE_RADII: f32 = 64.0;

/// Height above a texel's horizon, as a share of the distance, below which a patch's form factor is summed
/// from the differences between its edges' terms and those of their projections onto the texel's plane.
/// Lambert's own terms are near 1 there; their rounding leaves u·(distance/height)² of F.
pub const MAX_GRAZING_HEIGHT_RATIO: f32 = 1.0 / 64.0;

/// Distance below which fronts exchange no light (mesh units; 8 roundings of a coordinate): closer faces
/// have no order that the coordinates can show.
pub const CONTACT_DISTANCE: f32 = 1e-6;

/// Width by which a face's outline is enlarged for rays (mesh units, 8 roundings of a coordinate), so
/// that no ray passes between two faces that share an edge.
pub const OUTLINE_MARGIN: f32 = 1e-6;

/// Ray parameter of a miss: beyond every scene, and finite because WGSL has no infinity.
pub const MISS_DISTANCE: f32 = 1e30;

/// Ray parameter at the end of a segment. The BVH's nodes ignore t < 1e−4, whatever the ray's length; with
/// t = 2¹⁶ instead of 1 at the end this is 1.5e−9 of the length, and near contact stays opaque.
pub const RAY_REACH: f32 = 65536.0;

/// Maximum levels of the BVH on a ray's stack on the GPU; a deeper tree is an error.
pub const RAY_STACK_LEVELS: u32 = 32;

/// Share of a segment up to which a face is an occluder: 1 less a few roundings of t.
pub const SEGMENT_END_FRACTION: f32 = 1.0 - 4.0 * f32::EPSILON;

/// Source roots that a receiver block of the hierarchical solve is linked to in one batch, where visibility
/// is by rays alone.
pub const ROOTS_PER_BATCH: usize = 1024;

/// Numbers of visibility samples between a receiver and a source that may be partly occluded: for a source
/// of little light, the first try for more light, the maximum where the source can be subdivided, and the
/// maximum where it cannot.
pub const VISIBILITY_SAMPLE_COUNTS: [u32; 4] = [1, 4, 16, 64];

/// Number of required visibility samples up to which one sample is taken. The limit is far below 1 because
/// most links are such, and their errors add up.
pub const ONE_SAMPLE_LIMIT: f32 = 1.0 / 32.0;

/// Least area of a quad over its squared radius that counts as compact: that of one of 3.3 : 1.
pub const MIN_COMPACT_AREA: f32 = 1.1;

/// Upper bound on the irradiance at a point of a receiver block over the block's mean.
pub const MAX_PEAK_TO_MEAN: f32 = 2.0;

/// Maximum bytes of links that a solver stores; the adapter's binding limit may be lower.
pub const MAX_LINK_BYTES: u64 = 1 << 30;

/// Lanes of a sum over a patch's texels.
pub const PATCH_SUM_LANES: usize = 64;

/// Lanes of the sum over all patches and of the choice of the next shooter.
pub const SELECT_LANES: usize = 256;

/// Depth per distance: the mesh's diagonal is below 4.
pub const DEPTH_SCALE: f32 = 0.25;

/// Largest depth that is drawn.
pub const MAX_DEPTH: f32 = 0.999_999_9;

/// Pixels by which the hemicube's sides continue beyond their edges: the 3×3 lookup and the explanation of
/// its errors read no farther.
pub const GUTTER_PIXELS: f32 = 4.0;

/// Near plane of the paper's Table 3, scene units.
pub const PAPER_NEAR_PLANE: f32 = 0.01;

/// Far plane of the paper's Table 3, scene units.
pub const PAPER_FAR_PLANE: f32 = 100.0;
