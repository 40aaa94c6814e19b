//! How it is decided whether a texel sees a shooter. What an option would not change is not there:
//! rays have no pixels, and only two projections leave a choice of raster.

use serde::{Serialize, Serializer};

/// How it is decided whether a texel sees a shooter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Visibility {
    /// Rays between points of the shooter and points of the texel.
    #[default]
    Rays,
    /// An item buffer drawn from points of the shooter.
    Drawn(Drawing),
}

impl Visibility {
    /// An item buffer of `size`² pixels, all else by default.
    pub const fn drawn(projection: Projection, size: u32) -> Self {
        Self::Drawn(Drawing {
            projection,
            size,
            ..Drawing::DEFAULT
        })
    }

    /// The item buffer, where there is one.
    pub const fn drawing(self) -> Option<Drawing> {
        match self {
            Self::Rays => None,
            Self::Drawn(drawing) => Some(drawing),
        }
    }

    /// `rays`, or what the projection is called.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rays => "rays",
            Self::Drawn(drawing) => drawing.projection.name(),
        }
    }
}

/// How an item buffer is drawn, and how it is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drawing {
    /// The shooter's hemisphere on the square, and how faces get there.
    pub projection: Projection,
    /// Pixels a side.
    pub size: u32,
    /// Pixels that a texel asks.
    pub lookup: Lookup,
}

impl Drawing {
    /// Stereographic by pixels, 1024 of them a side, nine asked.
    pub const DEFAULT: Self = Self {
        projection: Projection::Stereographic(Raster::Pixel),
        size: 1024,
        lookup: Lookup::Neighbours,
    };

    /// Pixels of one item buffer; they are counted again for each plane of its image.
    pub fn pixels(&self) -> u64 {
        u64::from(self.size).pow(2)
    }
}

impl Default for Drawing {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The shooter's hemisphere on the square of the item buffer; the raster where it leaves a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Table 3 as printed (vertices only, planar depth, half a unit deep): tessellated.
    Paper,
    /// Orthographic hemisphere, corrected.
    Hemisphere(Raster),
    /// Stereographic hemisphere.
    Stereographic(Raster),
    /// The five sides of a half cube, by pixels.
    Hemicube,
}

impl Projection {
    /// How faces get into the item buffer.
    pub const fn raster(self) -> Raster {
        match self {
            Self::Paper => Raster::Tessellated,
            Self::Hemisphere(raster) | Self::Stereographic(raster) => raster,
            Self::Hemicube => Raster::Pixel,
        }
    }

    /// The same by `raster`; none where it leaves no choice and that is another.
    pub fn by(self, raster: Raster) -> Option<Self> {
        let drawn = match self {
            Self::Hemisphere(_) => Self::Hemisphere(raster),
            Self::Stereographic(_) => Self::Stereographic(raster),
            Self::Paper | Self::Hemicube => self,
        };
        (drawn.raster() == raster).then_some(drawn)
    }

    /// Planes of the image: the hemicube's sides, or the one of a disc.
    pub const fn sides(self) -> u32 {
        match self {
            Self::Hemicube => 5,
            Self::Paper | Self::Hemisphere(_) | Self::Stereographic(_) => 1,
        }
    }

    /// Its number in the shaders, whatever the raster.
    pub const fn code(self) -> u32 {
        match self {
            Self::Paper => 0,
            Self::Hemisphere(_) => 1,
            Self::Stereographic(_) => 2,
            Self::Hemicube => 3,
        }
    }

    /// In files and in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Hemisphere(_) => "hemisphere",
            Self::Stereographic(_) => "stereographic",
            Self::Hemicube => "hemicube",
        }
    }
}

/// How faces get into the item buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Raster {
    /// Every pixel's own ray is intersected with the faces whose image may lie there.
    Pixel,
    /// Faces are cut into triangles, whose projected corners are drawn.
    Tessellated,
}

/// Which item buffer pixels a texel asks for its ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Lookup {
    /// The pixel that holds its projection.
    Exact,
    /// That pixel or any of its eight neighbours, unless a face seen there hides the texel.
    #[serde(rename = "3x3")]
    Neighbours,
}

impl Lookup {
    /// How many pixels to each side of its own.
    pub fn reach(self) -> i32 {
        match self {
            Self::Exact => 0,
            Self::Neighbours => 1,
        }
    }
}

/// The options in force, side by side: rays have one.
#[derive(Serialize)]
#[serde(rename_all = "kebab-case")]
struct Options {
    visibility: &'static str,
    #[serde(flatten)]
    drawn: Option<DrawnOptions>,
}

#[derive(Serialize)]
#[serde(rename_all = "kebab-case")]
struct DrawnOptions {
    item_buffer: u32,
    raster: Raster,
    lookup: Lookup,
}

impl Serialize for Visibility {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let drawn = self.drawing().map(|drawing| DrawnOptions {
            item_buffer: drawing.size,
            raster: drawing.projection.raster(),
            lookup: drawing.lookup,
        });
        let visibility = self.name();
        Options { visibility, drawn }.serialize(serializer)
    }
}
