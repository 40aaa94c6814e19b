//! Numbers that the text works out by hand, checked by exact functions.

use crate::Result;
use common::form_factor::disc_factor;
use glam::DVec3;
use oracle::exact::{furnace_radiosity, parallel_rectangles, perpendicular_rectangles, point_to_polygon};

/// Checks that the number `printed` is the value of a function, rounded to as many decimals as are printed.
///
/// Errors: it is not, or there is no such function of so many arguments.
pub fn check_number(printed: &str, function: &str, arguments: &[f64]) -> Result<()> {
    let value = evaluate_function(function, arguments)?;
    let decimals = printed.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    match format!("{value:.decimals$}") == printed {
        true => Ok(()),
        false => Err(format!(
            "{printed} is not {function} of {arguments:?}, which is {value}"
        )),
    }
}

/// Evaluates an exact function.
fn evaluate_function(function: &str, arguments: &[f64]) -> Result<f64> {
    Ok(match (function, arguments) {
        ("furnace_radiosity", &[emission, reflectance]) => furnace_radiosity(emission, reflectance),
        ("parallel_rectangles", &[a, b, distance]) => parallel_rectangles(a, b, distance),
        ("perpendicular_rectangles", &[edge, width, height]) => perpendicular_rectangles(edge, width, height),
        ("disc_factor", &[cos_i, cos_j, r2, shooter_area, disc_area]) => {
            let given = [cos_i, cos_j, r2, shooter_area, disc_area].map(|value| value as f32);
            f64::from(disc_factor(given[0], given[1], given[2], given[3], given[4]))
        }
        ("point_below_square", &[width, height]) => point_below_square(width, height),
        _ => {
            return Err(format!(
                "there is no function {function} of {} numbers",
                arguments.len()
            ));
        }
    })
}

/// Returns the form factor from a point to a square of this `width` that faces it, `height` above it.
fn point_below_square(width: f64, height: f64) -> f64 {
    let half = width / 2.0;
    // Counter-clockwise as seen from the point below.
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, z)| DVec3::new(x, height, z));
    point_to_polygon(DVec3::ZERO, DVec3::Y, &corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn number_is_checked_to_its_last_decimal() {
        let squares = [1.0, 1.0, 1.0];
        assert!(check_number("0.1998", "parallel_rectangles", &squares).is_ok());
        let error = check_number("0.1999", "parallel_rectangles", &squares).unwrap_err();
        assert!(
            error.starts_with("0.1999 is not parallel_rectangles of [1.0, 1.0, 1.0], which is 0.1998"),
            "{error}"
        );
        assert!(check_number("2", "furnace_radiosity", &[1.0, 0.5]).is_ok());
        assert!(check_number("0.2395", "point_below_square", &[1.0, 1.0]).is_ok());
        let error = check_number("1", "parallel_rectangles", &[1.0]).unwrap_err();
        assert_eq!(error, "there is no function parallel_rectangles of 1 numbers");
    }
}
