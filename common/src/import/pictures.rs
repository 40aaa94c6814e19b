//! The pictures of a file, each read once, and not too many of them.

use crate::paint::{Picture, WHITEST};
use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// So many pixels are kept of all pictures together, of which each takes 17 bytes with its copies.
const MOST: usize = 1 << 25;

/// Those that were read so far, by what the file calls them.
pub struct Pictures<K> {
    read: BTreeMap<(K, [bool; 3]), Arc<Picture>>,
    left: usize,
    shrunk: usize,
}

impl<K: Ord> Pictures<K> {
    /// None yet.
    pub fn new() -> Self {
        Self {
            read: BTreeMap::new(),
            left: MOST,
            shrunk: 0,
        }
    }

    /// The picture called `key` for colours of a `factor`, which `read` finds if it is not known; what it
    /// would then have reflect all light reflects a little less.
    pub fn get(
        &mut self,
        key: K,
        factor: DVec3,
        read: impl FnOnce([f32; 3]) -> Result<Picture, String>,
    ) -> Result<Arc<Picture>, String> {
        let key = (key, factor.to_array().map(|f| f >= 1.0));
        if let Some(picture) = self.read.get(&key) {
            return Ok(picture.clone());
        }
        let mut picture = read(key.1.map(|all| if all { WHITEST } else { 1.0 }))?;
        self.shrunk += usize::from(picture.shrink(self.left));
        self.left -= picture.count().min(self.left);
        let picture = Arc::new(picture);
        self.read.insert(key, picture.clone());
        Ok(picture)
    }

    /// What is to be said of them.
    pub fn note(&self) -> Option<String> {
        (self.shrunk > 0).then(|| {
            format!(
                "textures have more than {MOST} pixels together: {} of {} pictures are taken at a lower resolution",
                self.shrunk,
                self.read.len()
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
    fn many_pictures_share_the_room() {
        let mut bytes = Cursor::new(Vec::new());
        let image = RgbImage::new(64, 64);
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let mut pictures = Pictures::new();
        pictures.left = 5000;
        let mut get = |key: u32| {
            let read = |most| Picture::decode(bytes.get_ref(), most);
            let picture = pictures.get(key, DVec3::ONE, read).unwrap();
            picture.count()
        };
        assert_eq!([1, 1, 2, 3, 1].map(&mut get), [4096, 4096, 256, 256, 4096]);
        assert!(pictures.note().unwrap().contains("2 of 3 pictures"));
        assert_eq!(pictures.left, 5000 - 4096 - 512);
    }
}
