//! Outlines of polygons and their clipping in space. Means of textures, exact form factors and the search for adjacent
//! faces use it.

use glam::DVec3;

/// Returns the 4 or 3 corners, without a triangle's repeated one.
pub fn distinct_corners<T: PartialEq>(corners: &[T; 4]) -> &[T] {
    &corners[..if corners[2] == corners[3] { 3 } else { 4 }]
}

/// Returns the part of a convex polygon above the plane through `point` (Sutherland & Hodgman 1974).
pub fn clip_by_plane(polygon: &[DVec3], point: DVec3, normal: DVec3) -> Vec<DVec3> {
    let mut clipped = Vec::new();
    for (k, &a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()];
        let (above, beyond) = (normal.dot(a - point), normal.dot(b - point));
        if above >= 0.0 {
            clipped.push(a);
        }
        if above * beyond < 0.0 {
            clipped.push(a + (b - a) * (above / (above - beyond)));
        }
    }
    clipped
}
