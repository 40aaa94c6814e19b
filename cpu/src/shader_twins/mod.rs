//! Twins of the shaders: the file of a shader's name has a function for each of the shader's, of the same name,
//! in the same order and with the same order of operations. The GPU is compared with them. Functions that
//! other modules use as well are re-exported from there. Some compute for all lanes of a block together, which the
//! GPU computes in one invocation each.

pub mod add_links;
pub mod bvh;
pub mod clear_work_lists;
pub mod closure;
pub mod deposit;
pub mod escape;
pub mod exchange;
pub mod form_factor;
pub mod frame;
pub mod gather;
pub mod hemicube;
pub mod hierarchy_types;
pub mod image_bound;
pub mod intersect;
pub mod item_buffer;
pub mod item_buffer_paper;
pub mod link;
pub mod link_bounds;
pub mod link_factors;
pub mod lookup;
pub mod patch_transfer;
pub mod prefix_sum;
pub mod projection;
pub mod rays;
pub mod refine;
pub mod sample_links;
pub mod sampling;
pub mod select;
pub mod store_links;
pub mod subdivide_nodes;
pub mod surface_points;
pub mod texel_point;
pub mod types;
pub mod unshot_power;
pub mod view;
pub mod visibility_samples;
