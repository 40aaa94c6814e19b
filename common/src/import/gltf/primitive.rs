//! Reads the triangles of a mesh's primitive: lists, strips and fans, with or without indices. Each vertex carries the
//! largest rounding error of its coordinates in the file, by which [`crate::precision`] finds misshapen faces.

use super::document::{GltfDocument, GltfResult};
use crate::import::material::{InputVertex, clamp_vertex_colour};
use crate::precision::UNIT_ROUNDOFF;
use glam::{DMat4, DVec2, DVec3, Vec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

/// Set of texture coordinates that holds lightmap coordinates.
const LIGHTMAP_SET: u32 = 1;

/// Reads a primitive's triangles, moved by `world`; none if it consists of points or lines. Beside the positions it
/// reads the texture coordinates of both `sets`, and on request colours and lightmap coordinates (`with_lightmap`). Normals that cannot be
/// read count as missing. If `world` mirrors, the winding is reversed, so that fronts stay fronts.
///
/// Errors: an accessor is invalid, or requested lightmap coordinates are missing.
pub fn read_triangles(
    document: &GltfDocument,
    primitive: &Primitive,
    world: DMat4,
    sets: [Option<u32>; 2],
    coloured: bool,
    with_lightmap: bool,
) -> GltfResult<Option<Vec<[InputVertex; 3]>>> {
    use Mode::{LineLoop, LineStrip, Lines, Points};
    let mode = match primitive.mode {
        Checked::Valid(Points | Lines | LineLoop | LineStrip) => return Ok(None),
        Checked::Valid(mode) => mode,
        Checked::Invalid => return Err("has an unknown mode".into()),
    };
    let attribute = |of| primitive.attributes.get(&Checked::Valid(of)).copied();
    let coordinates = |set: Option<u32>| {
        let accessor = set.and_then(|set| attribute(Semantic::TexCoords(set)));
        let values = accessor.map(|k| document.read_values(k, "texture coordinates", Type::Vec2, DVec2::from_array));
        values.transpose()
    };
    let vector = |p: [f64; 3]| Vec3::from(p.map(|x| x as f32));
    let accessor = attribute(Semantic::Positions).ok_or("has no POSITION")?;
    let positions = document.read_values(accessor, "positions", Type::Vec3, vector)?;
    let integer_rounding = document.integer_rounding(accessor);
    let normals = attribute(Semantic::Normals);
    let normals = normals.and_then(|k| document.read_values(k, "normals", Type::Vec3, vector).ok());
    let texture_coordinates = [coordinates(sets[0])?, coordinates(sets[1])?];
    let lightmap_coordinates = coordinates(with_lightmap.then_some(LIGHTMAP_SET))?;
    if with_lightmap && lightmap_coordinates.is_none() {
        return Err(format!(
            "has no TEXCOORD_{LIGHTMAP_SET}: export with a second UV map, in which no two faces overlap"
        ));
    }
    let colour = |c: [f64; 3]| DVec3::from(c.map(|x| clamp_vertex_colour(x as f32).into()));
    let opaque = |[r, g, b, _]: [f64; 4]| colour([r, g, b]);
    let colours = attribute(Semantic::Colors(0)).filter(|_| coloured);
    let colours = colours.map(|k| match document.root.get(k).map(|accessor| accessor.type_) {
        Some(Checked::Valid(Type::Vec4)) => document.read_values(k, "colours", Type::Vec4, opaque),
        _ => document.read_values(k, "colours", Type::Vec3, colour),
    });
    let colours = colours.transpose()?;
    let indices = match primitive.indices {
        Some(accessor) => document.read_values(accessor, "indices", Type::Scalar, |[k]| k as u32)?,
        None => (0..positions.len() as u32).collect(),
    };
    let vertex = |index: u32| -> GltfResult<InputVertex> {
        let k = index as usize;
        let position = positions.get(k);
        let position = position.ok_or_else(|| format!("has index {index} but only {} vertices", positions.len()))?;
        let position = position.as_dvec3();
        Ok(InputVertex {
            position: world.transform_point3(position),
            normal: values_at(&normals, k),
            texture_coordinates: texture_coordinates.each_ref().map(|set| values_at(set, k)),
            colour: values_at(&colours, k),
            index,
            lightmap_coordinates: values_at(&lightmap_coordinates, k).map(|p| p.as_vec2()),
            rounding: coordinate_rounding(position, integer_rounding, world),
        })
    };
    let mirrored = world.determinant() < 0.0;
    let triangle = |[a, b, c]: [u32; 3]| -> GltfResult<[InputVertex; 3]> {
        let [a, b, c] = [vertex(a)?, vertex(b)?, vertex(c)?];
        Ok(if mirrored { [a, c, b] } else { [a, b, c] })
    };
    let triangles = assemble_triangles(mode, &indices)?.into_iter().map(triangle);
    triangles.collect::<GltfResult<_>>().map(Some)
}

fn values_at<T: Copy>(values: &Option<Vec<T>>, k: usize) -> Option<T> {
    values.as_ref()?.get(k).copied()
}

/// Returns the largest rounding error of a coordinate in world space; `integer_rounding` is that in the file of
/// coordinates which are integers, 0 for floats. The rounding of the node's transform moves all vertices alike and does
/// not count.
fn coordinate_rounding(p: DVec3, integer_rounding: f64, world: DMat4) -> f64 {
    let [x, y, z] = [world.x_axis, world.y_axis, world.z_axis].map(|axis| axis.truncate().abs());
    let in_world = |p: DVec3| (x * p.x + y * p.y + z * p.z).max_element();
    match integer_rounding {
        0.0 => UNIT_ROUNDOFF * in_world(p.abs()),
        rounding => in_world(DVec3::splat(rounding)),
    }
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
