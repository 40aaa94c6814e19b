//! Cache of a file's pictures: reads each once and limits their total size.

use crate::paint::{MAX_WHITE_REFLECTANCE, TexturePicture};
use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Largest number of pixels of all pictures together; each takes 17 bytes with its mip levels.
const MAX_TOTAL_PIXELS: usize = 1 << 25;

/// Pictures read so far, by their key in the file.
pub struct PictureCache<K> {
    pictures: BTreeMap<(K, [bool; 3]), Arc<TexturePicture>>,
    pixels_left: usize,
    reduced_count: usize,
}

impl<K: Ord> PictureCache<K> {
    /// Creates an empty cache.
    pub fn new() -> Self {
        Self {
            pictures: BTreeMap::new(),
            pixels_left: MAX_TOTAL_PIXELS,
            reduced_count: 0,
        }
    }

    /// Returns the picture `key` for a colour of this `factor`, and calls `read` if the cache lacks it. `read`
    /// receives the largest value per channel: [`MAX_WHITE_REFLECTANCE`] for channels whose factor is 1 or more.
    pub fn get(
        &mut self,
        key: K,
        factor: DVec3,
        read: impl FnOnce([f32; 3]) -> Result<TexturePicture, String>,
    ) -> Result<Arc<TexturePicture>, String> {
        let key = (key, factor.to_array().map(|f| f >= 1.0));
        if let Some(picture) = self.pictures.get(&key) {
            return Ok(picture.clone());
        }
        let mut picture = read(key.1.map(|all| if all { MAX_WHITE_REFLECTANCE } else { 1.0 }))?;
        self.reduced_count += usize::from(picture.shrink_to(self.pixels_left));
        self.pixels_left -= picture.pixel_count().min(self.pixels_left);
        let picture = Arc::new(picture);
        self.pictures.insert(key, picture.clone());
        Ok(picture)
    }

    /// Returns a note if pictures were reduced.
    pub fn resolution_note(&self) -> Option<String> {
        let (reduced, all) = (self.reduced_count, self.pictures.len());
        (reduced > 0).then(|| {
            format!(
                "textures have more than {MAX_TOTAL_PIXELS} pixels together: {reduced} of {all} pictures are taken at a lower resolution"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageFormat, RgbImage};
    use std::io::Cursor;

    #[test]
    fn pictures_beyond_the_limit_are_reduced() {
        let mut bytes = Cursor::new(Vec::new());
        let image = RgbImage::new(64, 64);
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let mut pictures = PictureCache::new();
        pictures.pixels_left = 5000;
        let mut get = |key: u32| {
            let read = |most| TexturePicture::decode_image(bytes.get_ref(), most);
            let picture = pictures.get(key, DVec3::ONE, read).unwrap();
            picture.pixel_count()
        };
        assert_eq!([1, 1, 2, 3, 1].map(&mut get), [4096, 4096, 256, 256, 4096]);
        assert!(pictures.resolution_note().unwrap().contains("2 of 3 pictures"));
        assert_eq!(pictures.pixels_left, 5000 - 4096 - 512);
    }
}
