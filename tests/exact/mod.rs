//! Form factors and answers that are known in closed form.

mod form_factor_points;
mod form_factors;
mod furnace;
mod triangles;
