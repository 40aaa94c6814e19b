//! Reflectance and radiance that vary over a face: textures and vertex colours. The importers make paint, and the mesh
//! takes each texel's means from it.
//!
//! A face is one triangle or two. Texture coordinates and colours are linear on each triangle. So the part
//! of a triangle within a texel is a polygon on the picture, and the mean over it is exact.

mod picture;

pub use picture::{TexturePicture, WrapMode, from_srgb};

use crate::polygon::clip_by_plane;
use glam::{DAffine2, DMat2, DVec2, DVec3};
use picture::{signed_area, triangle_fan};
use std::sync::Arc;

/// Reflectance that replaces 1 on import. Exporters write 1 for an unset colour, and a surface with it would
/// absorb no light. A value slightly below 1 is kept as intended.
pub const MAX_WHITE_REFLECTANCE: f32 = 0.95;

/// A texture's mean below this value is rounding from a pixel beside the texel, and becomes 0.
const MIN_TEXTURE_MEAN: f64 = 1e-6;

/// Pieces per side of a triangle on which the product of texture and vertex colours is that of their means.
const PIECES_PER_SIDE: usize = 16;

/// Triangles of a quad with the diagonal from corner 0 to corner 2, and from 1 to 3. The first corner of
/// each triangle lies off the diagonal.
const QUAD_TRIANGLES: [[[usize; 3]; 2]; 2] = [[[1, 2, 0], [3, 0, 2]], [[0, 1, 3], [2, 3, 1]]];

/// A picture with its continuation beyond the edges.
#[derive(Clone)]
pub struct WrappedTexture {
    /// The picture.
    pub picture: Arc<TexturePicture>,
    /// Continuation to the right and downwards.
    pub wrap: [WrapMode; 2],
}

/// A varying quantity: a factor, times a texture and the corners' colours if present.
#[derive(Clone)]
pub struct Coat {
    /// Factor, linear Rec. 709.
    pub factor: DVec3,
    /// Texture; `None` stands for 1.
    pub texture: Option<WrappedTexture>,
    /// True if the corners' colours are factors too.
    pub coloured: bool,
}

/// Texture coordinates and colour of a face's corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaintCorner {
    /// Coordinates on the textures of reflectance and of radiance; (0, 0) is a picture's upper left corner,
    /// (1, 1) its lower right one.
    pub texture_coordinates: [DVec2; 2],
    /// Colour, linear Rec. 709.
    pub colour: DVec3,
}

/// Variation of reflectance and radiance over a face.
#[derive(Clone)]
pub struct Paint {
    /// The face's corners; the fourth of a triangle is ignored.
    pub corners: [PaintCorner; 4],
    /// True if a quad's diagonal runs from corner 1 to corner 3, false from 0 to 2.
    pub odd: bool,
    /// Coats of reflectance and of radiance; `None`: constant over the face.
    pub coats: [Option<Coat>; 2],
}

impl std::fmt::Debug for Paint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [reflectance, radiance] = self.coats.each_ref().map(Option::is_some);
        write!(f, "Paint {{ reflectance: {reflectance}, radiance: {radiance} }}")
    }
}

impl Paint {
    /// Returns the means of reflectance and radiance over a convex part of a face; `None` for a constant one,
    /// and for a face without area.
    pub fn mean_over(&self, face: &[DVec3], part: &[DVec3]) -> [Option<DVec3>; 2] {
        let (mut sums, mut all) = ([DVec3::ZERO; 2], 0.0);
        for half in self.face_triangles(face) {
            let within = if face.len() > 3 {
                clip_by_plane(part, face[half.corners[1]], -(half.axes[0] + half.axes[1]))
            } else {
                part.to_vec()
            };
            let polygon: Vec<DVec2> = within.into_iter().map(|p| half.local_coordinates(p)).collect();
            let area = signed_area(&polygon).abs() * half.area;
            if area > 0.0 {
                for (k, sum) in sums.iter_mut().enumerate() {
                    *sum += area * self.coat_mean(k, half.corners, &polygon);
                }
                all += area;
            }
        }
        [0, 1].map(|k| {
            let coat = self.coats[k].as_ref().filter(|_| all > 0.0)?;
            let mean = (sums[k] / all).max(DVec3::ZERO);
            let is_rounding = mean.max_element() < MIN_TEXTURE_MEAN;
            Some(if is_rounding { DVec3::ZERO } else { coat.factor * mean })
        })
    }

    /// Returns reflectance and radiance at a point of a face; `None` for a constant one.
    pub fn value_at(&self, face: &[DVec3], point: DVec3) -> [Option<DVec3>; 2] {
        let halves = self.face_triangles(face);
        let placed = halves.map(|half| (half.local_coordinates(point), half.corners));
        let nearest = placed.min_by(|a, b| a.0.element_sum().total_cmp(&b.0.element_sum()));
        let Some((place, corners)) = nearest else {
            return [None, None];
        };
        [0, 1].map(|k| {
            let coat = self.coats[k].as_ref()?;
            let on_picture = self.picture_map(k, corners).transform_point2(place);
            let texture = coat.texture.as_ref();
            let light = texture.map_or(DVec3::ONE, |t| t.picture.colour_at(on_picture, t.wrap));
            Some(coat.factor * self.corner_colour(coat, corners, place) * light)
        })
    }

    /// Returns reflectance and radiance of a face without area: means over the whole texture and all corners.
    pub fn overall_mean(&self, corners: usize) -> [Option<DVec3>; 2] {
        let colours = self.corners[..corners.min(4)].iter().map(|c| c.colour);
        let colour = colours.sum::<DVec3>() / corners.clamp(1, 4) as f64;
        self.coats.each_ref().map(|coat| {
            let coat = coat.as_ref()?;
            let light = coat.texture.as_ref().map_or(DVec3::ONE, |t| t.picture.mean_colour());
            let colour = if coat.coloured { colour } else { DVec3::ONE };
            Some(coat.factor * colour * light)
        })
    }

    /// Returns the paint with reordered corners, for the face's back: corner `k` was corner `turned[k]`.
    pub fn with_corner_order(&self, turned: [usize; 4]) -> Self {
        Self {
            corners: turned.map(|k| self.corners[k]),
            ..self.clone()
        }
    }

    /// Returns the triangles of a face that have an area.
    fn face_triangles<'f>(&self, face: &'f [DVec3]) -> impl Iterator<Item = FaceTriangle> + use<'f> {
        let all: &[[usize; 3]] = match face.len() {
            0..=3 => &[[0, 1, 2]],
            _ => &QUAD_TRIANGLES[usize::from(self.odd)],
        };
        all.iter().filter_map(|corners| FaceTriangle::new(face, *corners))
    }

    /// Returns the mean of coat `k`, without its factor, over a polygon in a triangle's coordinates.
    fn coat_mean(&self, k: usize, corners: [usize; 3], polygon: &[DVec2]) -> DVec3 {
        let Some(coat) = &self.coats[k] else {
            return DVec3::ZERO;
        };
        let to_picture = self.picture_map(k, corners);
        let product = |part: &[DVec2]| {
            let texture = coat.texture.as_ref().map_or(DVec3::ONE, |texture| {
                let on_picture: Vec<DVec2> = part.iter().map(|p| to_picture.transform_point2(*p)).collect();
                texture.picture.mean_over(&on_picture, texture.wrap)
            });
            let centroid = centroid_of_convex(part);
            texture * self.corner_colour(coat, corners, centroid)
        };
        let [a, b, c] = corners.map(|k| self.corners[k].colour);
        if coat.texture.is_none() || !coat.coloured || (a == b && b == c) {
            return product(polygon);
        }
        let (mut sum, mut all) = (DVec3::ZERO, 0.0);
        for triangle in triangle_fan(polygon) {
            let area = signed_area(&triangle);
            let pieces = divide_triangle(triangle).map(|piece| product(&piece));
            sum += area * pieces.sum::<DVec3>() / (PIECES_PER_SIDE * PIECES_PER_SIDE) as f64;
            all += area;
        }
        sum / all
    }

    /// Returns the interpolated corner colour at a point in a triangle's coordinates.
    fn corner_colour(&self, coat: &Coat, corners: [usize; 3], place: DVec2) -> DVec3 {
        if !coat.coloured {
            return DVec3::ONE;
        }
        let [a, b, c] = corners.map(|k| self.corners[k].colour);
        a + (b - a) * place.x + (c - a) * place.y
    }

    /// Returns the map from a triangle's coordinates to the picture of coat `k`.
    fn picture_map(&self, k: usize, corners: [usize; 3]) -> DAffine2 {
        let [a, b, c] = corners.map(|corner| self.corners[corner].texture_coordinates[k]);
        DAffine2::from_mat2_translation(DMat2::from_cols(b - a, c - a), a)
    }
}

/// Iterates over n² equal triangles that make up a triangle, n = [`PIECES_PER_SIDE`].
fn divide_triangle([a, b, c]: [DVec2; 3]) -> impl Iterator<Item = [DVec2; 3]> {
    let n = PIECES_PER_SIDE;
    let at = move |[i, j]: [usize; 2]| a + ((b - a) * i as f64 + (c - a) * j as f64) / n as f64;
    let rows = (0..n).flat_map(move |j| (0..n - j).map(move |i| [i, j]));
    rows.flat_map(move |[i, j]| {
        let upright = [[i, j], [i + 1, j], [i, j + 1]];
        let inverted = [[i + 1, j + 1], [i, j + 1], [i + 1, j]];
        let pieces = [Some(upright), (i + j + 1 < n).then_some(inverted)];
        pieces.into_iter().flatten().map(move |piece| piece.map(at))
    })
}

fn centroid_of_convex(polygon: &[DVec2]) -> DVec2 {
    let (mut moment, mut all) = (DVec2::ZERO, 0.0);
    for [a, b, c] in triangle_fan(polygon) {
        let area = signed_area(&[a, b, c]);
        moment += area * ((b - a) + (c - a)) / 3.0;
        all += area;
    }
    if all == 0.0 {
        polygon[0]
    } else {
        polygon[0] + moment / all
    }
}

/// A triangle of a face. Its coordinates are (0, 0) at corner 0, and (1, 0) and (0, 1) at the others.
struct FaceTriangle {
    corners: [usize; 3],
    area: f64,
    origin: DVec3,
    axes: [DVec3; 2],
}

impl FaceTriangle {
    fn new(face: &[DVec3], corners: [usize; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|k| face[k]);
        let normal = (b - a).cross(c - a);
        let square = normal.length_squared();
        let axes = [(c - a).cross(normal) / square, normal.cross(b - a) / square];
        axes.iter().all(|axis| axis.is_finite()).then(|| Self {
            corners,
            area: square.sqrt(),
            origin: a,
            axes,
        })
    }

    fn local_coordinates(&self, point: DVec3) -> DVec2 {
        let [x, y] = self.axes;
        DVec2::new(x.dot(point - self.origin), y.dot(point - self.origin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(colour: [f64; 3]) -> PaintCorner {
        PaintCorner {
            texture_coordinates: [DVec2::ZERO; 2],
            colour: DVec3::from(colour),
        }
    }

    fn coloured(corners: [PaintCorner; 4], odd: bool) -> Paint {
        let coat = Coat {
            factor: DVec3::splat(0.5),
            texture: None,
            coloured: true,
        };
        Paint {
            corners,
            odd,
            coats: [Some(coat), None],
        }
    }

    fn close(found: Option<DVec3>, expected: [f64; 3]) {
        let off = found.map(|found| (found - DVec3::from(expected)).length());
        assert!(off.is_some_and(|off| off < 1e-12), "{found:?} {expected:?}");
    }

    #[test]
    fn corner_colours_are_interpolated_linearly_in_a_triangle() {
        let face = [[1., 1., 0.], [3., 1., 0.], [1., 4., 0.]].map(DVec3::from);
        let [r, g, b] = [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(corner);
        let paint = coloured([r, g, b, b], false);
        close(paint.mean_over(&face, &face)[0], [1. / 6.; 3]);
        assert_eq!(paint.mean_over(&face, &face)[1], None);
        // The quarter at corner 0: its centroid has (2/3, 1/6, 1/6) of the corners.
        let quarter = [[1., 1., 0.], [2., 1., 0.], [1., 2.5, 0.]].map(DVec3::from);
        close(paint.mean_over(&face, &quarter)[0], [1. / 3., 1. / 12., 1. / 12.]);
        close(paint.value_at(&face, DVec3::new(2., 1., 0.))[0], [0.25, 0.25, 0.0]);
        close(paint.overall_mean(3)[0], [1. / 6.; 3]);
    }

    #[test]
    fn quad_colours_follow_the_chosen_diagonal() {
        // One corner of four is white. With the diagonal from 0 to 2 it belongs to one triangle only.
        let face = [[0., 0., 0.], [2., 0., 0.], [2., 1., 0.], [0., 1., 0.]].map(DVec3::from);
        let mut corners = [corner([0.; 3]); 4];
        corners[1] = corner([1.; 3]);
        let [even, odd] = [false, true].map(|odd| coloured(corners, odd));
        close(even.mean_over(&face, &face)[0], [0.5 / 6.; 3]);
        close(odd.mean_over(&face, &face)[0], [0.5 / 3.; 3]);
        let [low, high] = [[0.2, 0.], [0.3, 0.1]];
        let texel = [
            [low[0], low[1], 0.],
            [high[0], low[1], 0.],
            [high[0], high[1], 0.],
            [low[0], high[1], 0.],
        ]
        .map(DVec3::from);
        // White is x/2 − y there; the texel lies below the diagonal.
        close(even.mean_over(&face, &texel)[0], [0.5 * (0.125 - 0.05); 3]);
        // With the other diagonal it is x/2 within triangle 0 1 3.
        close(odd.mean_over(&face, &texel)[0], [0.5 * 0.125; 3]);
        let behind = even.with_corner_order([0, 3, 2, 1]);
        let turned = [0, 3, 2, 1].map(|k| face[k]);
        close(behind.mean_over(&turned, &texel)[0], [0.5 * (0.125 - 0.05); 3]);
    }

    #[test]
    fn texture_times_corner_colours_is_within_its_bound() {
        // Two pixels, 0 and 1; red grows from 0 to 1 along them: ∫ from ½ to 1 of x.
        let picture = TexturePicture::new([2, 1], vec![[0.0; 3], [1.0; 3]]);
        let place = |x: f64, y: f64| PaintCorner {
            texture_coordinates: [DVec2::new(x, y); 2],
            colour: DVec3::new(x, 1.0, 1.0),
        };
        let texture = WrappedTexture {
            picture: Arc::new(picture),
            wrap: [WrapMode::Clamp; 2],
        };
        let coat = |coloured| Coat {
            factor: DVec3::ONE,
            texture: Some(texture.clone()),
            coloured,
        };
        let paint = Paint {
            corners: [place(0., 1.), place(1., 1.), place(1., 0.), place(0., 0.)],
            odd: false,
            coats: [Some(coat(true)), Some(coat(false))],
        };
        let face = [[0., 0., 5.], [3., 0., 5.], [3., 2., 5.], [0., 2., 5.]].map(DVec3::from);
        let [both, texture] = paint.mean_over(&face, &face);
        close(both, [0.375, 0.5, 0.5]);
        close(texture, [0.5; 3]);
        // A part that is w = 0.9 wide: ∫ from ½ to w of x, over w. Pieces are w/n wide. Those that hold the
        // pixels' common edge lie within w/n of it on either side; there the colour differs from that of the
        // centroid by less than ⅔ w/n, and the texture from its mean by ½ on average.
        let (w, n) = (0.9, PIECES_PER_SIDE as f64);
        let part = [[0., 0.], [3. * w, 0.], [3. * w, 2.], [0., 2.]].map(|[x, y]| DVec3::new(x, y, 5.));
        let exact = (w * w - 0.25) / (2.0 * w);
        let bound = (2.0 / n) * (2.0 / 3.0 * w / n) / 2.0;
        let red = paint.mean_over(&face, &part)[0].map_or(f64::NAN, |mean| mean.x);
        assert!((red - exact).abs() < bound, "{red} instead of {exact}, within {bound}");
        let [both, texture] = paint.value_at(&face, DVec3::new(2.25, 1., 5.));
        close(both, [0.75, 1.0, 1.0]);
        close(texture, [1.0; 3]);
    }
}
