//! Visibility between a texel and a shooter. Each method has only the options that it reads: rays have no
//! pixels, and only two projections have a choice of raster.

use serde::{Serialize, Serializer};

/// Method of the visibility test between a texel and a shooter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Visibility {
    /// Rays between points of the shooter and points of the texel.
    #[default]
    Rays,
    /// An item buffer drawn from points of the shooter.
    ItemBuffer(ItemBufferSettings),
}

impl Visibility {
    /// Returns an item buffer of `size`² pixels, all else by default.
    pub const fn with_item_buffer(projection: ItemBufferProjection, size: u32) -> Self {
        Self::ItemBuffer(ItemBufferSettings {
            projection,
            size,
            ..ItemBufferSettings::DEFAULT
        })
    }

    /// Returns the item buffer's settings, if the method is an item buffer.
    pub const fn item_buffer(self) -> Option<ItemBufferSettings> {
        match self {
            Self::Rays => None,
            Self::ItemBuffer(drawing) => Some(drawing),
        }
    }

    /// Returns `rays`, or the projection's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rays => "rays",
            Self::ItemBuffer(drawing) => drawing.projection.name(),
        }
    }
}

/// Settings by which an item buffer is drawn and read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ItemBufferSettings {
    /// Projection of the shooter's hemisphere onto the square, and rasterisation.
    pub projection: ItemBufferProjection,
    /// Pixels per side.
    pub size: u32,
    /// Pixels that a texel reads.
    pub lookup: Lookup,
}

impl ItemBufferSettings {
    /// Stereographic projection, rasterised per pixel, 1024 pixels per side, 3×3 lookup.
    pub const DEFAULT: Self = Self {
        projection: ItemBufferProjection::Stereographic(Raster::Pixel),
        size: 1024,
        lookup: Lookup::Neighbours,
    };

    /// Returns the pixels of one plane of the item buffer.
    pub fn pixel_count(&self) -> u64 {
        u64::from(self.size).pow(2)
    }
}

impl Default for ItemBufferSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Projection of the shooter's hemisphere onto the square of the item buffer, with the raster where there
/// is a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemBufferProjection {
    /// Table 3 as printed (vertices only, planar depth, half a unit deep): tessellated.
    Paper,
    /// Orthographic hemisphere, corrected.
    Hemisphere(Raster),
    /// Stereographic hemisphere.
    Stereographic(Raster),
    /// The five sides of a half cube, rasterised per pixel (Cohen & Greenberg 1985).
    Hemicube,
}

impl ItemBufferProjection {
    /// Returns the rasterisation of faces into the item buffer.
    pub const fn raster_method(self) -> Raster {
        match self {
            Self::Paper => Raster::Tessellated,
            Self::Hemisphere(raster) | Self::Stereographic(raster) => raster,
            Self::Hemicube => Raster::Pixel,
        }
    }

    /// Returns the projection with `raster`, or `None` if it cannot have this raster.
    pub fn with_raster(self, raster: Raster) -> Option<Self> {
        let drawn = match self {
            Self::Hemisphere(_) => Self::Hemisphere(raster),
            Self::Stereographic(_) => Self::Stereographic(raster),
            Self::Paper | Self::Hemicube => self,
        };
        (drawn.raster_method() == raster).then_some(drawn)
    }

    /// Returns the number of image planes: the hemicube's five sides, or one disc.
    pub const fn plane_count(self) -> u32 {
        match self {
            Self::Hemicube => 5,
            Self::Paper | Self::Hemisphere(_) | Self::Stereographic(_) => 1,
        }
    }

    /// Returns the projection's number in the shaders, whatever the raster.
    pub const fn shader_code(self) -> u32 {
        match self {
            Self::Paper => 0,
            Self::Hemisphere(_) => 1,
            Self::Stereographic(_) => 2,
            Self::Hemicube => 3,
        }
    }

    /// Returns the projection's name in files and messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Hemisphere(_) => "hemisphere",
            Self::Stereographic(_) => "stereographic",
            Self::Hemicube => "hemicube",
        }
    }
}

/// Rasterisation of faces into the item buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Raster {
    /// Each pixel's ray is intersected with the faces whose image may lie there.
    Pixel,
    /// Faces are divided into triangles, whose projected corners are drawn.
    Tessellated,
}

/// Item buffer pixels in which a texel looks for its face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Lookup {
    /// The pixel that holds its projection.
    Exact,
    /// This pixel or any of its eight neighbours, unless a face seen there hides the texel.
    #[serde(rename = "3x3")]
    Neighbours,
}

impl Lookup {
    /// Returns the number of pixels to each side of the texel's own.
    pub fn reach_pixels(self) -> i32 {
        match self {
            Self::Exact => 0,
            Self::Neighbours => 1,
        }
    }
}

/// Options in force, as they are written to files; rays have one.
#[derive(Serialize)]
#[serde(rename_all = "kebab-case")]
struct VisibilityOptions {
    visibility: &'static str,
    #[serde(flatten)]
    drawn: Option<ItemBufferOptions>,
}

#[derive(Serialize)]
#[serde(rename_all = "kebab-case")]
struct ItemBufferOptions {
    item_buffer: u32,
    raster: Raster,
    lookup: Lookup,
}

impl Serialize for Visibility {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let drawn = self.item_buffer().map(|drawing| ItemBufferOptions {
            item_buffer: drawing.size,
            raster: drawing.projection.raster_method(),
            lookup: drawing.lookup,
        });
        let visibility = self.name();
        VisibilityOptions { visibility, drawn }.serialize(serializer)
    }
}
