//! Colour conversion from a file's own primaries to linear Rec. 709. Both decoders of maps use it.

use glam::{DMat3, DVec2, DVec3, Vec3};

/// Chromaticities (x, y) of red, green, blue and white.
pub(super) type Primaries = [DVec2; 4];

/// The primaries of the workspace's own colours.
pub(super) const REC709_PRIMARIES: Primaries = [
    DVec2::new(0.64, 0.33),
    DVec2::new(0.30, 0.60),
    DVec2::new(0.15, 0.06),
    DVec2::new(0.3127, 0.3290),
];

/// CIE XYZ, written as primaries.
pub(super) const XYZ_PRIMARIES: Primaries = [
    DVec2::new(1.0, 0.0),
    DVec2::new(0.0, 1.0),
    DVec2::new(0.0, 0.0),
    DVec2::new(1.0 / 3.0, 1.0 / 3.0),
];

/// Returns the matrix to XYZ with Y = 1 for white; `None` if the four points do not span a colour space.
fn matrix_to_xyz([r, g, b, w]: Primaries) -> Option<DMat3> {
    let column = |c: DVec2| DVec3::new(c.x, c.y, 1.0 - c.x - c.y);
    let primaries = DMat3::from_cols(column(r), column(g), column(b));
    let spanned = primaries.determinant().abs() > 1e-9;
    if w.y.is_nan() || w.y <= 0.0 || !spanned {
        return None;
    }
    let scale = primaries.inverse() * (column(w) / w.y);
    Some(primaries * DMat3::from_diagonal(scale))
}

/// Converts `pixels` in place without adapting the white point, so that the light itself does not
/// change. Returns false, and changes nothing, if the primaries do not span a colour space.
pub(super) fn convert_pixels(primaries: Primaries, pixels: &mut [Vec3]) -> bool {
    let (Some(from), Some(to)) = (matrix_to_xyz(primaries), matrix_to_xyz(REC709_PRIMARIES)) else {
        return false;
    };
    let matrix = to.inverse() * from;
    for pixel in pixels {
        *pixel = (matrix * pixel.as_dvec3()).as_vec3();
    }
    true
}
