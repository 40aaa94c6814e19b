//! Numbers that the shaders and their twins share; `gpu` writes each into the WGSL it compiles.

/// π as both solvers round it.
pub const PI: f32 = std::f32::consts::PI;

/// A texel so many of its radii from a cell takes its light as its centre does.
pub const FAR: f32 = 6.0;

/// A texel nearer than that takes the mean of so many places a side.
pub const NEAR: u32 = 4;

/// Where in its step of the even grid such a place lies on a quad, and on a triangle: there the
/// grid, folded, is the centroids of NEAR² equal parts, whichever corner is first. At 1/2 four of
/// sixteen would lie on the edge u + v = 1, and see nothing of a wall that shares it.
pub const NEAR_QUAD: f32 = 0.5;
/// See [`NEAR_QUAD`].
pub const NEAR_TRIANGLE: f32 = 1.0 / 3.0;

/// A cell more than so many of its radii away shines as a point: that is off by (radius/distance)²,
/// here 2e−4, whereas the terms of Lambert's sum cancel and leave u·(distance/radius)², as much here,
/// and all of F for a cell of a thousandth of the scene.
pub const POINT: f32 = 64.0;

/// A cell that rises less than this share of its distance above a texel's horizon is summed from
/// what its edges' terms differ from those of its foot on the plane: Lambert's own are near 1 there
/// and leave u·(distance/height)² of F.
pub const LOW: f32 = 1.0 / 64.0;

/// Fronts closer than this exchange nothing (mesh units; 8 roundings of a coordinate): within it
/// nobody can tell which of two touching faces lies above the other.
pub const CONTACT: f32 = 1e-6;

/// A face's outline is this much wider for rays (mesh units, 8 roundings of a coordinate), so
/// that no ray slips between two faces that share an edge.
pub const OUTLINE: f32 = 1e-6;

/// The ray parameter of no hit: beyond every scene, and finite because WGSL has no infinity.
pub const MISS: f32 = 1e30;

/// The BVH's nodes ignore t < 1e−4, whatever the ray's length: rays run to t = 2¹⁶ instead of 1
/// so that this is 1.5e−9 of their length and near contact stays opaque.
pub const RAY_REACH: f32 = 65536.0;

/// Levels of the BVH that a ray on the GPU can hold open; a deeper tree is refused.
pub const RAY_STACK: u32 = 32;

/// An occluder ends this short of the texel (share of the way): a few roundings of t.
pub const END: f32 = 1.0 - 4.0 * f32::EPSILON;

/// Faces of which a block of the hierarchical solve is asked at a time, where rays alone tell.
pub const ROOTS: usize = 1024;

/// Pairs of points of what may be partly hidden: of little light, first of more, and at most where a node
/// can be cut and where not.
pub const SAMPLES: [u32; 4] = [1, 4, 16, 64];

/// One pair of points is enough where so few are needed: most links are so, and what they leave out adds up.
pub const LITTLE: f32 = 1.0 / 32.0;

/// No point of a spot receives this many times what it does in the mean.
pub const EDGE: f32 = 2.0;

/// Bytes of links that a solver keeps, or as many as the adapter binds.
pub const LINK_BYTES: u64 = 1 << 30;

/// Lanes of a sum over a cell's texels.
pub const LANES: usize = 64;

/// Lanes of the sum and the choice over all cells.
pub const SELECT_LANES: usize = 256;

/// Tessellation level l cuts each side of a face into 2^l parts; a face that would need more
/// keeps the last.
pub const LEVELS: u32 = 8;

/// The level of a face that is not drawn: below the horizon, the shooter itself, or the far side
/// of a two-sided sheet.
pub const HIDDEN: u32 = LEVELS;

/// Distances × this are depths: the mesh's diagonal is below 4.
pub const DEPTH_SCALE: f32 = 0.25;

/// The farthest depth that is still drawn.
pub const DEPTH_MAX: f32 = 0.999_999_9;

/// Triangles this far below the horizon (sine) are dropped: about the antipode they would cover
/// the disc from outside. Those that reach the disc stay above (their edges span < 0.13 rad).
pub const BELOW: f32 = -0.25;

/// The hemicube's sides go on for this many pixels beyond their folds: the 3×3 lookup, and what
/// explains its mistakes, look no farther.
pub const GUTTER: f32 = 4.0;

/// Table 3's near plane, scene units.
pub const PAPER_NEAR: f32 = 0.01;

/// Table 3's far plane, scene units.
pub const PAPER_FAR: f32 = 100.0;
