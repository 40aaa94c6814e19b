//! Reads the triangles of a mesh's primitive: lists, strips and fans, with or without indices.

use super::document::{GltfDocument, GltfResult};
use crate::precision::UNIT_ROUNDOFF;
use glam::{DMat4, DVec2, DVec3, Vec2, Vec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

/// A triangle of a primitive in world space, with its attributes.
#[derive(Clone, Copy)]
pub struct PrimitiveTriangle {
    /// Corners.
    pub corners: [DVec3; 3],
    /// Shading normals at the corners, untransformed: they are only compared for equality.
    pub normals: Option<[Vec3; 3]>,
    /// Texture coordinates of the corners, for the reflectance and the radiance texture.
    pub texture_coordinates: [Option<[DVec2; 3]>; 2],
    /// Vertex colours.
    pub colours: Option<[DVec3; 3]>,
    /// Lightmap coordinates of the corners.
    pub chart: Option<[Vec2; 3]>,
    /// Largest rounding error of a coordinate, from the file's f32 or integers. The rounding of the node's
    /// transform moves all corners alike and does not count.
    pub rounding: f64,
}

/// Attributes to read of a primitive beside its positions, and its transform.
pub struct PrimitiveRequest {
    /// Sets of texture coordinates for the reflectance and the radiance texture.
    pub sets: [Option<u32>; 2],
    /// Vertex colours.
    pub colours: bool,
    /// Lightmap coordinates.
    pub charts: bool,
    /// Transform to world space. If it mirrors, the winding is reversed, so that fronts stay fronts.
    pub world: DMat4,
}

/// Set of texture coordinates that holds lightmap coordinates.
const LIGHTMAP_SET: u32 = 1;

impl PrimitiveTriangle {
    /// True if texture coordinates and colours of two triangles agree at their common corners.
    pub fn is_continuous_with(&self, other: &Self) -> bool {
        let look = |t: &Self, k: usize| {
            let places = t.texture_coordinates.map(|places| places.map(|p| p[k]));
            (places, t.colours.map(|colours| colours[k]))
        };
        (0..3).all(|k| {
            let there = other.corners.iter().position(|c| *c == self.corners[k]);
            there.is_none_or(|n| look(self, k) == look(other, n))
        })
    }
}

/// Reads a primitive's triangles with the requested attributes; none if it consists of points or lines. Normals
/// that cannot be read count as missing.
///
/// Errors: an accessor is invalid, or requested lightmap coordinates are missing.
pub fn read_triangles(
    document: &GltfDocument,
    primitive: &Primitive,
    request: &PrimitiveRequest,
) -> GltfResult<Option<Vec<PrimitiveTriangle>>> {
    use Mode::{LineLoop, LineStrip, Lines, Points};
    let Checked::Valid(mode) = primitive.mode else {
        return Err("has an unknown mode".into());
    };
    if matches!(mode, Points | Lines | LineLoop | LineStrip) {
        return Ok(None);
    }
    let attribute = |of| primitive.attributes.get(&Checked::Valid(of)).copied();
    let coordinates = |set: Option<u32>| {
        let accessor = set.and_then(|set| attribute(Semantic::TexCoords(set)));
        let places = accessor.map(|accessor| document.read_texture_coordinates(accessor));
        places.transpose()
    };
    let accessor = attribute(Semantic::Positions).ok_or("has no POSITION")?;
    let positions = document.read_vectors(accessor)?;
    let step = document.rounding_step(accessor);
    let normals = attribute(Semantic::Normals);
    let normals = normals.and_then(|accessor| document.read_vectors(accessor).ok());
    let [first, second] = request.sets;
    let places = [coordinates(first)?, coordinates(second)?];
    let charts = coordinates(request.charts.then_some(LIGHTMAP_SET))?;
    if request.charts && charts.is_none() {
        return Err(format!(
            "has no TEXCOORD_{LIGHTMAP_SET}: export with a second UV map, in which no two faces overlap"
        ));
    }
    let colours = attribute(Semantic::Colors(0)).filter(|_| request.colours);
    let colours = colours.map(|accessor| document.read_colours(accessor));
    let colours = colours.transpose()?;
    let indices = match primitive.indices {
        Some(accessor) => document.read_indices(accessor)?,
        None => (0..positions.len() as u32).collect(),
    };
    let mirrored = request.world.determinant() < 0.0;
    let triangle = |[a, b, c]: [u32; 3]| {
        let at = if mirrored { [a, c, b] } else { [a, b, c] };
        let count = positions.len();
        if let Some(index) = [a, b, c].into_iter().find(|k| *k as usize >= count) {
            return Err(format!("has index {index} but only {count} vertices"));
        }
        let corners = at.map(|k| positions[k as usize].as_dvec3());
        Ok(PrimitiveTriangle {
            corners: corners.map(|corner| request.world.transform_point3(corner)),
            normals: values_at(normals.as_ref(), at),
            texture_coordinates: places.each_ref().map(|places| values_at(places.as_ref(), at)),
            colours: values_at(colours.as_ref(), at),
            chart: values_at(charts.as_ref(), at).map(|chart| chart.map(|p: DVec2| p.as_vec2())),
            rounding: coordinate_rounding(&corners, step, request.world),
        })
    };
    let triangles = assemble_triangles(mode, &indices)?;
    let triangles = triangles.into_iter().map(triangle).collect::<GltfResult<_>>();
    triangles.map(Some)
}

/// Looks up an attribute at a triangle's corners; none if a corner lacks it.
fn values_at<T: Copy>(values: Option<&Vec<T>>, corners: [u32; 3]) -> Option<[T; 3]> {
    let values = values?;
    let [a, b, c] = corners.map(|k| values.get(k as usize).copied());
    Some([a?, b?, c?])
}

/// Returns the largest rounding error of a coordinate in world space; `step` is that of integers, 0 for floats.
fn coordinate_rounding(corners: &[DVec3; 3], step: f64, world: DMat4) -> f64 {
    let [x, y, z] = [world.x_axis, world.y_axis, world.z_axis].map(|axis| axis.truncate().abs());
    let in_world = |p: DVec3| (x * p.x + y * p.y + z * p.z).max_element();
    let off = |p: &DVec3| match step {
        0.0 => UNIT_ROUNDOFF * in_world(p.abs()),
        step => in_world(DVec3::splat(step)),
    };
    corners.iter().map(off).fold(0.0, f64::max)
}

/// Returns the vertex indices of each triangle (glTF 2.0 §3.7.2.1). In strips and fans, triangles with a repeated
/// index only connect parts and are dropped.
fn assemble_triangles(mode: Mode, indices: &[u32]) -> GltfResult<Vec<[u32; 3]>> {
    let proper = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    let triples = indices.windows(3).map(|w| [w[0], w[1], w[2]]);
    match mode {
        Mode::TriangleStrip => {
            let turned = |(k, [a, b, c]): (usize, [u32; 3])| if k % 2 == 0 { [a, b, c] } else { [a, c, b] };
            Ok(triples.enumerate().map(turned).filter(proper).collect())
        }
        Mode::TriangleFan => {
            let about_first = |[_, b, c]: [u32; 3]| [indices[0], b, c];
            Ok(triples.map(about_first).filter(proper).collect())
        }
        _ => match indices.as_chunks() {
            (triples, []) => Ok(triples.to_vec()),
            _ => Err(format!(
                "has {} corners, which is no multiple of 3: is the file cut off?",
                indices.len()
            )),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        let check = |mode, indices: &[u32], expected: &[[u32; 3]]| {
            assert_eq!(assemble_triangles(mode, indices).unwrap(), expected);
        };
        let (strip, fan) = (Mode::TriangleStrip, Mode::TriangleFan);
        check(strip, &[0, 1, 2, 3, 4], &[[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        check(strip, &[0, 1, 2, 2, 3, 3, 4, 5], &[[0, 1, 2], [3, 5, 4]]);
        check(fan, &[5, 1, 2, 3], &[[5, 1, 2], [5, 2, 3]]);
        check(fan, &[5, 1], &[]);
        check(Mode::Triangles, &[0, 1, 2, 3, 4, 5], &[[0, 1, 2], [3, 4, 5]]);
        assert!(assemble_triangles(Mode::Triangles, &[0, 1, 2, 3]).is_err());
    }
}
