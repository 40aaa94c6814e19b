//! What the documentation says of the code.

mod layout;
mod paper;
mod source;
