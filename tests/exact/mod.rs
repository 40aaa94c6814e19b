//! Tests against form factors and solutions in closed form.

mod form_factor_points;
mod form_factors;
mod rays;
mod triangles;
