//! The twins: each file has the functions of the shader of the same name, in the same order of
//! statements. The GPU is judged by them; the CPU solver's fast version is in `rows`.

pub mod accumulate;
pub mod bound;
pub mod closure;
pub mod deposit;
pub mod escape;
pub mod frame;
pub mod hemicube;
pub mod item_buffer;
mod item_buffer_tessellated;
pub mod link;
pub mod lookup;
pub mod power;
pub mod projection;
pub mod received;
pub mod tessellate;
pub mod texel_point;
pub mod view;
