//! What the documentation says of the code.

mod paper;
