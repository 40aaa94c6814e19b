//! Visibility between a texel and a shooter. Each method has only the options that it reads: rays have no pixels. Both
//! engines read it, and the comparison of their visibilities.

use serde::ser::SerializeMap;
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
    /// Projection of the shooter's hemisphere onto the square.
    pub projection: ItemBufferProjection,
    /// Pixels per side.
    pub size: u32,
    /// Pixels that a texel reads.
    pub lookup: Lookup,
}

impl ItemBufferSettings {
    /// Stereographic projection, 1024 pixels per side, 3×3 lookup.
    pub const DEFAULT: Self = Self {
        projection: ItemBufferProjection::Stereographic,
        size: 1024,
        lookup: Lookup::Neighbours,
    };

    /// Returns the pixels of one plane of the item buffer.
    pub fn pixel_count(&self) -> u64 {
        u64::from(self.size).pow(2)
    }
}

/// Projection of the shooter's hemisphere onto the square of the item buffer. Each pixel's ray is intersected with
/// the faces whose image may lie there, but for `Paper`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemBufferProjection {
    /// Table 3 as printed: only corners are projected, and depth is planar and half a unit deep.
    Paper,
    /// Orthographic hemisphere, corrected.
    Hemisphere,
    /// Stereographic hemisphere.
    Stereographic,
    /// The five sides of a half cube (Cohen & Greenberg 1985).
    Hemicube,
}

impl ItemBufferProjection {
    /// Every projection.
    pub const ALL_PROJECTIONS: [Self; 4] = [Self::Paper, Self::Hemisphere, Self::Stereographic, Self::Hemicube];

    /// Returns the number of image planes: the hemicube's five sides, or one disc.
    pub const fn plane_count(self) -> u32 {
        match self {
            Self::Hemicube => 5,
            Self::Paper | Self::Hemisphere | Self::Stereographic => 1,
        }
    }

    /// Returns the projection's number in the shaders.
    pub const fn shader_code(self) -> u32 {
        match self {
            Self::Paper => 0,
            Self::Hemisphere => 1,
            Self::Stereographic => 2,
            Self::Hemicube => 3,
        }
    }

    /// Returns the projection's name in files and messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Hemisphere => "hemisphere",
            Self::Stereographic => "stereographic",
            Self::Hemicube => "hemicube",
        }
    }
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

impl Serialize for Visibility {
    /// Writes the options in force; rays have one.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut options = serializer.serialize_map(None)?;
        options.serialize_entry("visibility", self.name())?;
        if let Some(drawing) = self.item_buffer() {
            options.serialize_entry("item-buffer", &drawing.size)?;
            options.serialize_entry("lookup", &drawing.lookup)?;
        }
        options.end()
    }
}
