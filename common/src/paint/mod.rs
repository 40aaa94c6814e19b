//! What of a face is not the same all over it: textures and the colours of its corners.
//!
//! A face is one triangle or two, and on each of them places on a texture, as well as colours, are linear. So
//! the part of a triangle within a texel is a polygon on the picture, and the mean over it is exact.

mod level;
mod picture;
mod polygon;

pub use level::Wrap;
pub use picture::{Picture, from_srgb};

use glam::{DMat2, DVec2, DVec3};
use polygon::Polygon;
use std::sync::Arc;

/// What reflects all light is taken as this: exporters write 1 where nobody chose a colour, and no light
/// would ever be spent there. What is a little less was meant.
pub const WHITEST: f32 = 0.95;

/// Less than this of a texture's light is what rounding leaves of a pixel beside the texel.
const NOTHING: f64 = 1e-6;

/// A triangle on a picture is a line if its area is less than this, per square of its size.
const LINE: f64 = 1e-9;

/// The triangles of a quad cut from corner 0 to corner 2, and from 1 to 3; the first corner of each lies off
/// the cut.
const HALVES: [[[usize; 3]; 2]; 2] = [[[1, 2, 0], [3, 0, 2]], [[0, 1, 3], [2, 3, 1]]];

/// A texture.
#[derive(Clone)]
pub struct Texture {
    /// Its picture.
    pub picture: Arc<Picture>,
    /// How it goes on, right and downwards.
    pub wrap: [Wrap; 2],
}

/// A factor, times a texture, times the corners' colours, as far as there are any.
#[derive(Clone)]
pub struct Coat {
    /// Linear Rec. 709.
    pub factor: DVec3,
    /// None: 1.
    pub texture: Option<Texture>,
    /// Whether the corners' colours count.
    pub coloured: bool,
}

/// What a corner of a face has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Its places on the textures of reflectance and of radiance; (0, 0) is a picture's upper left corner,
    /// (1, 1) its lower right one.
    pub places: [DVec2; 2],
    /// Its colour, linear Rec. 709.
    pub colour: DVec3,
}

impl Corner {
    /// White, and nowhere in particular.
    pub const PLAIN: Self = Self {
        places: [DVec2::ZERO; 2],
        colour: DVec3::ONE,
    };
}

/// How reflectance and radiance vary over a face.
#[derive(Clone)]
pub struct Paint {
    /// The face's corners; of a triangle the fourth says nothing.
    pub corners: [Corner; 4],
    /// Whether a quad is cut from corner 1 to corner 3.
    pub odd: bool,
    /// Of reflectance and of radiance; none: it does not vary.
    pub coats: [Option<Coat>; 2],
}

impl std::fmt::Debug for Paint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let names = ["reflectance", "radiance"].into_iter().zip(&self.coats);
        let painted = names.filter_map(|(name, coat)| coat.as_ref().map(|_| name));
        f.debug_list().entries(painted).finish()
    }
}

impl Paint {
    /// Means of reflectance and radiance over a convex part of a face; none of what does not vary, nor of a
    /// face without area.
    pub fn over(&self, face: &[DVec3], part: &[DVec3]) -> [Option<DVec3>; 2] {
        let (mut sums, mut all) = ([DVec3::ZERO; 2], 0.0);
        for half in self.halves(face) {
            let mut polygon = Polygon::new(part.iter().map(|p| half.place(*p)));
            if face.len() > 3 {
                polygon = polygon.cut(|p| 1.0 - p.x - p.y);
            }
            let area = polygon.middle().0 * half.area;
            if area > 0.0 {
                for (k, sum) in sums.iter_mut().enumerate() {
                    *sum += area * self.mean(k, half.corners, &polygon);
                }
                all += area;
            }
        }
        let mean = |k: usize| {
            let coat = self.coats[k].as_ref()?;
            let mean = sums[k] / all;
            (all > 0.0).then(|| coat.factor * whole_or_nothing(mean))
        };
        [mean(0), mean(1)]
    }

    /// Reflectance and radiance at a point of a face; none of what does not vary.
    pub fn at(&self, face: &[DVec3], point: DVec3) -> [Option<DVec3>; 2] {
        let halves = self.halves(face).map(|half| (half.place(point), half));
        let nearest = |a: &(DVec2, _), b: &(DVec2, _)| {
            let outside = |p: DVec2| p.element_sum();
            outside(a.0).total_cmp(&outside(b.0))
        };
        let Some((place, half)) = halves.min_by(nearest) else {
            return [None, None];
        };
        [0, 1].map(|k| {
            let coat = self.coats[k].as_ref()?;
            let [places, _] = self.mapped(k, half.corners);
            let colour = self.colour(coat, half.corners, place);
            let texture = coat.texture.as_ref();
            let light = texture.map(|t| t.picture.at(places.at(place), t.wrap));
            Some(coat.factor * colour * light.unwrap_or(DVec3::ONE))
        })
    }

    /// The same of a face without area: what there is of each in the mean.
    pub fn whole(&self, corners: usize) -> [Option<DVec3>; 2] {
        let colours = self.corners[..corners.min(4)].iter().map(|c| c.colour);
        let colour = colours.sum::<DVec3>() / corners.clamp(1, 4) as f64;
        self.coats.each_ref().map(|coat| {
            let coat = coat.as_ref()?;
            let light = coat.texture.as_ref().map(|t| t.picture.whole());
            let colour = if coat.coloured { colour } else { DVec3::ONE };
            Some(coat.factor * colour * light.unwrap_or(DVec3::ONE))
        })
    }

    /// Of the same face seen from behind: corner k is now what `turned[k]` was.
    pub fn turned(&self, turned: [usize; 4]) -> Self {
        Self {
            corners: turned.map(|k| self.corners[k]),
            ..self.clone()
        }
    }

    /// The triangles of a face that have an area.
    fn halves<'f>(&self, face: &'f [DVec3]) -> impl Iterator<Item = Half> + use<'f> {
        let all: &[[usize; 3]] = if face.len() > 3 {
            &HALVES[usize::from(self.odd)]
        } else {
            &[[0, 1, 2]]
        };
        all.iter().filter_map(|corners| Half::new(face, *corners))
    }

    /// The mean of coat `k` over a polygon in the plane of a half, but for its factor.
    fn mean(&self, k: usize, corners: [usize; 3], polygon: &Polygon) -> DVec3 {
        let Some(coat) = &self.coats[k] else {
            return DVec3::ZERO;
        };
        let colour = self.colour(coat, corners, polygon.middle().1);
        let Some(Texture { picture, wrap }) = &coat.texture else {
            return colour;
        };
        let [places, back] = self.mapped(k, corners);
        let on_picture = polygon.map(|p| places.at(p));
        let [a, b, c] = corners.map(|k| self.corners[k].colour);
        if !coat.coloured || (a == b && b == c) || !places.is_sound() {
            return colour * picture.mean(&on_picture, *wrap, None);
        }
        let shade = |p: DVec2| self.colour(coat, corners, back.at(p));
        picture.mean(&on_picture, *wrap, Some(&shade))
    }

    /// The colour at a place in the plane of a half.
    fn colour(&self, coat: &Coat, corners: [usize; 3], place: DVec2) -> DVec3 {
        if !coat.coloured {
            return DVec3::ONE;
        }
        let [a, b, c] = corners.map(|k| self.corners[k].colour);
        a + (b - a) * place.x + (c - a) * place.y
    }

    /// From the plane of a half to the picture of coat `k`, and back.
    fn mapped(&self, k: usize, corners: [usize; 3]) -> [Map; 2] {
        let [a, b, c] = corners.map(|corner| self.corners[corner].places[k]);
        let there = DMat2::from_cols(b - a, c - a);
        let back = there.inverse();
        [
            Map {
                matrix: there,
                from: DVec2::ZERO,
                to: a,
            },
            Map {
                matrix: back,
                from: a,
                to: DVec2::ZERO,
            },
        ]
    }
}

/// Rounding leaves a little of what is not there.
fn whole_or_nothing(light: DVec3) -> DVec3 {
    if light.max_element() < NOTHING {
        DVec3::ZERO
    } else {
        light
    }
}

/// A linear map of the plane.
struct Map {
    matrix: DMat2,
    from: DVec2,
    to: DVec2,
}

impl Map {
    fn at(&self, p: DVec2) -> DVec2 {
        self.matrix * (p - self.from) + self.to
    }

    /// Whether it leaves triangles triangles.
    fn is_sound(&self) -> bool {
        let [a, b] = [self.matrix.x_axis, self.matrix.y_axis];
        let size = a.length_squared().max(b.length_squared());
        self.matrix.determinant().abs() > LINE * size
    }
}

/// A triangle of a face. In its plane corner 0 is the origin, the others are (1, 0) and (0, 1).
struct Half {
    corners: [usize; 3],
    area: f64,
    origin: DVec3,
    axes: [DVec3; 2],
}

impl Half {
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

    fn place(&self, point: DVec3) -> DVec2 {
        let [x, y] = self.axes;
        DVec2::new(x.dot(point - self.origin), y.dot(point - self.origin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(colour: [f64; 3]) -> Corner {
        Corner {
            places: [DVec2::ZERO; 2],
            colour: DVec3::from(colour),
        }
    }

    fn coloured(corners: [Corner; 4], odd: bool) -> Paint {
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
    fn colours_are_linear_in_a_triangle() {
        let face = [[1., 1., 0.], [3., 1., 0.], [1., 4., 0.]].map(DVec3::from);
        let [r, g, b] = [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(corner);
        let paint = coloured([r, g, b, b], false);
        close(paint.over(&face, &face)[0], [1. / 6.; 3]);
        assert_eq!(paint.over(&face, &face)[1], None);
        // The quarter at corner 0: its centroid has (2/3, 1/6, 1/6) of the corners.
        let quarter = [[1., 1., 0.], [2., 1., 0.], [1., 2.5, 0.]].map(DVec3::from);
        close(
            paint.over(&face, &quarter)[0],
            [1. / 3., 1. / 12., 1. / 12.],
        );
        close(
            paint.at(&face, DVec3::new(2., 1., 0.))[0],
            [0.25, 0.25, 0.0],
        );
        close(paint.whole(3)[0], [1. / 6.; 3]);
    }

    #[test]
    fn a_quad_is_cut_as_it_was_joined() {
        // One corner of four is white: along the cut from 0 to 2 it has a half to itself.
        let face = [[0., 0., 0.], [2., 0., 0.], [2., 1., 0.], [0., 1., 0.]].map(DVec3::from);
        let mut corners = [corner([0.; 3]); 4];
        corners[1] = corner([1.; 3]);
        let [even, odd] = [false, true].map(|odd| coloured(corners, odd));
        close(even.over(&face, &face)[0], [0.5 / 6.; 3]);
        close(odd.over(&face, &face)[0], [0.5 / 3.; 3]);
        let [low, high] = [[0.2, 0.], [0.3, 0.1]];
        let texel = [
            [low[0], low[1], 0.],
            [high[0], low[1], 0.],
            [high[0], high[1], 0.],
            [low[0], high[1], 0.],
        ]
        .map(DVec3::from);
        // White is x/2 − y there, in both; the texel lies below the cut.
        close(even.over(&face, &texel)[0], [0.5 * (0.125 - 0.05); 3]);
        // Of the other cut it is x/2 − 0, as far as the triangle 0 1 3 goes.
        close(odd.over(&face, &texel)[0], [0.5 * 0.125; 3]);
        let behind = even.turned([0, 3, 2, 1]);
        let turned = [0, 3, 2, 1].map(|k| face[k]);
        close(behind.over(&turned, &texel)[0], [0.5 * (0.125 - 0.05); 3]);
    }

    #[test]
    fn a_texture_and_colours_are_multiplied_pixel_by_pixel() {
        // Two pixels, 0 and 1; red grows from 0 to 1 along them: ∫ from ½ to 1 of x.
        let picture = Picture::new([2, 1], vec![[0.0; 3], [1.0; 3]]);
        let place = |x: f64, y: f64| Corner {
            places: [DVec2::new(x, y); 2],
            colour: DVec3::new(x, 1.0, 1.0),
        };
        let texture = Texture {
            picture: Arc::new(picture),
            wrap: [Wrap::Clamp; 2],
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
        let [both, texture] = paint.over(&face, &face);
        close(both, [0.375, 0.5, 0.5]);
        close(texture, [0.5; 3]);
        let [both, texture] = paint.at(&face, DVec3::new(2.25, 1., 5.));
        close(both, [0.75, 1.0, 1.0]);
        close(texture, [1.0; 3]);
    }
}
