//! Checks of the source text against the documentation.

mod layout;
mod paper;
mod shader_operators;
mod shader_twins;
mod source;
mod your_shader;
