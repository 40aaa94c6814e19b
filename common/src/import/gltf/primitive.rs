//! The triangles of a mesh's primitive: lists, strips and fans, with indices or without.

use super::accessor::Result;
use super::buffers::Document;
use glam::{DVec2, DVec3, Vec2, Vec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

/// A triangle.
#[derive(Clone, Copy)]
pub struct Triangle {
    /// Its corners.
    pub corners: [DVec3; 3],
    /// The surface's normals there.
    pub normals: Option<[Vec3; 3]>,
    /// The coordinates there of the textures of reflectance and of radiance.
    pub places: [Option<[DVec2; 3]>; 2],
    /// Its corners' colours.
    pub colours: Option<[DVec3; 3]>,
    /// Its corners' places on a lightmap.
    pub chart: Option<[Vec2; 3]>,
    /// What each coordinate is rounded by where they are integers.
    pub step: f64,
}

/// What is wanted of a primitive beside its corners.
pub struct Asked {
    /// The sets of coordinates of the textures of reflectance and of radiance.
    pub sets: [Option<u32>; 2],
    /// The colours of its corners.
    pub colours: bool,
    /// Its places on a lightmap.
    pub charts: bool,
}

/// The set of coordinates that a lightmap has.
const LIGHTMAP: u32 = 1;

impl Triangle {
    /// Whether textures and colours go on from one to the other where they have corners in common.
    pub fn goes_on(&self, other: &Self) -> bool {
        let look = |t: &Self, k: usize| {
            let places = t.places.map(|places| places.map(|places| places[k]));
            (places, t.colours.map(|colours| colours[k]))
        };
        (0..3).all(|k| {
            let there = other.corners.iter().position(|c| *c == self.corners[k]);
            there.is_none_or(|n| look(self, k) == look(other, n))
        })
    }
}

/// A primitive's triangles, with what is asked for; none if it is of points or lines. Normals that cannot be read
/// are none.
pub fn triangles(
    document: &Document,
    primitive: &Primitive,
    asked: &Asked,
) -> Result<Option<Vec<Triangle>>> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err("has an unknown mode".into());
    };
    if matches!(
        mode,
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip
    ) {
        return Ok(None);
    }
    let accessor = primitive
        .attributes
        .get(&Checked::Valid(Semantic::Positions))
        .ok_or("has no POSITION")?;
    let positions = document.positions(*accessor)?;
    let normals = primitive.attributes.get(&Checked::Valid(Semantic::Normals));
    let normals = normals.and_then(|accessor| document.positions(*accessor).ok());
    let [first, second] = asked.sets;
    let places = [
        places(document, primitive, first)?,
        places(document, primitive, second)?,
    ];
    let place = |of: usize, k: u32| places[of].as_ref()?.get(k as usize).copied();
    let charts = places_of_charts(document, primitive, asked.charts)?;
    let chart = |k: u32| Some(charts.as_ref()?.get(k as usize)?.as_vec2());
    let colours = (primitive.attributes)
        .get(&Checked::Valid(Semantic::Colors(0)))
        .filter(|_| asked.colours)
        .map(|accessor| document.colours(*accessor))
        .transpose()?;
    let colour = |k: u32| colours.as_ref()?.get(k as usize).copied();
    let step = document.step(*accessor);
    let normal = |k: u32| normals.as_ref()?.get(k as usize).copied();
    let indices = match primitive.indices {
        Some(accessor) => document.indices(accessor)?,
        None => (0..positions.len() as u32).collect(),
    };
    let corner = |index: u32| {
        let position = positions.get(index as usize).map(|p| p.as_dvec3());
        position.ok_or_else(|| format!("has index {index} but only {} vertices", positions.len()))
    };
    let triangle = |[a, b, c]: [u32; 3]| {
        let normals = [normal(a), normal(b), normal(c)];
        let places = [0, 1].map(|of| match [a, b, c].map(|k| place(of, k)) {
            [Some(a), Some(b), Some(c)] => Some([a, b, c]),
            _ => None,
        });
        Ok(Triangle {
            corners: [corner(a)?, corner(b)?, corner(c)?],
            normals: match normals {
                [Some(a), Some(b), Some(c)] => Some([a, b, c]),
                _ => None,
            },
            places,
            colours: match [a, b, c].map(colour) {
                [Some(a), Some(b), Some(c)] => Some([a, b, c]),
                _ => None,
            },
            chart: match [a, b, c].map(chart) {
                [Some(a), Some(b), Some(c)] => Some([a, b, c]),
                _ => None,
            },
            step,
        })
    };
    assembled(mode, &indices)?
        .into_iter()
        .map(triangle)
        .collect::<Result<_>>()
        .map(Some)
}

/// The texture coordinates of a set; none where there are none.
fn places(
    document: &Document,
    primitive: &Primitive,
    set: Option<u32>,
) -> Result<Option<Vec<DVec2>>> {
    let accessor = set.and_then(|set| {
        let semantic = Checked::Valid(Semantic::TexCoords(set));
        primitive.attributes.get(&semantic)
    });
    accessor
        .map(|accessor| document.places(*accessor))
        .transpose()
}

/// Those of a lightmap, which must be there if they are asked for.
fn places_of_charts(
    document: &Document,
    primitive: &Primitive,
    asked: bool,
) -> Result<Option<Vec<DVec2>>> {
    let places = places(document, primitive, asked.then_some(LIGHTMAP))?;
    if asked && places.is_none() {
        return Err(format!(
            "has no TEXCOORD_{LIGHTMAP}: export with a second UV map, in which no two faces overlap"
        ));
    }
    Ok(places)
}

/// Vertex indices of each triangle (glTF 2.0 §3.7.2.1). In strips and fans a repeated index only
/// leads from one part to the next, and is no face.
fn assembled(mode: Mode, indices: &[u32]) -> Result<Vec<[u32; 3]>> {
    let proper = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    let triples = indices.windows(3).map(|w| [w[0], w[1], w[2]]);
    match mode {
        Mode::TriangleStrip => {
            let turned =
                |(k, [a, b, c]): (usize, [u32; 3])| if k % 2 == 0 { [a, b, c] } else { [a, c, b] };
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
        let of = |mode, indices: &[u32]| assembled(mode, indices).unwrap_or_default();
        assert_eq!(
            of(Mode::TriangleStrip, &[0, 1, 2, 3, 4]),
            [[0, 1, 2], [1, 3, 2], [2, 3, 4]]
        );
        assert_eq!(
            of(Mode::TriangleStrip, &[0, 1, 2, 2, 3, 3, 4, 5]),
            [[0, 1, 2], [3, 5, 4]]
        );
        assert_eq!(of(Mode::TriangleFan, &[5, 1, 2, 3]), [[5, 1, 2], [5, 2, 3]]);
        assert_eq!(of(Mode::TriangleFan, &[5, 1]), [[0; 3]; 0]);
        assert_eq!(
            of(Mode::Triangles, &[0, 1, 2, 3, 4, 5]),
            [[0, 1, 2], [3, 4, 5]]
        );
        assert!(assembled(Mode::Triangles, &[0, 1, 2, 3]).is_err());
    }
}
