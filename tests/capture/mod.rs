//! Captured rooms: radiance maps, and the walls that they light.

mod brackets;
mod maps;
mod openexr;
mod projection;
mod radiance;
mod room;
