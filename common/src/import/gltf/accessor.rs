//! What accessors hold: vertex positions and indices, every range checked before it is read.

use super::buffers::Document;
use crate::import::builder::MAX_FACES;
use glam::Vec3;
use gltf::json::Index;
use gltf::json::accessor::sparse::Sparse;
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::buffer::View;
use gltf::json::validation::Checked;

/// What is wrong with an accessor.
pub type Result<T> = std::result::Result<T, String>;

impl Document {
    /// Positions of vertices: three f32 each.
    pub fn positions(&self, index: Index<Accessor>) -> Result<Vec<Vec3>> {
        self.values(
            index,
            "positions",
            Type::Vec3,
            |component| match component {
                ComponentType::F32 => Ok((12, Vec3::ZERO, |b| {
                    let word = |k: usize| f32::from_le_bytes([b[k], b[k + 1], b[k + 2], b[k + 3]]);
                    Vec3::new(word(0), word(4), word(8))
                })),
                _ => Err("positions are not floats: export without quantisation".into()),
            },
        )
    }

    /// Indices of vertices.
    pub fn indices(&self, index: Index<Accessor>) -> Result<Vec<u32>> {
        self.values(index, "indices", Type::Scalar, unsigned)
    }

    fn values<T: Copy>(
        &self,
        index: Index<Accessor>,
        what: &str,
        wanted: Type,
        decoder: impl Fn(ComponentType) -> Result<Decoder<T>>,
    ) -> Result<Vec<T>> {
        let wrong = |message: String| format!("accessor {index} ({what}) {message}");
        let accessor = self
            .root
            .get(index)
            .ok_or_else(|| wrong("does not exist".into()))?;
        let (Checked::Valid(component), Checked::Valid(kind)) =
            (accessor.component_type, accessor.type_)
        else {
            return Err(wrong("is of no known type".into()));
        };
        if kind != wanted {
            return Err(wrong(format!("is of type {kind:?} instead of {wanted:?}")));
        }
        let (size, zero, decode) = decoder(component.0)?;
        let count = accessor.count.0;
        let mut values: Vec<T> = match accessor.buffer_view {
            Some(view) => self
                .elements(view, accessor.byte_offset.map_or(0, |o| o.0), count, size)
                .map_err(wrong)?
                .map(decode)
                .collect(),
            // Nothing in the file bounds this one.
            None if count > 3 * MAX_FACES as u64 => {
                return Err(wrong(format!("has {count} elements: too many")));
            }
            None => vec![zero; count as usize],
        };
        match &accessor.sparse {
            Some(sparse) => self
                .replace(&mut values, sparse, (size, zero, decode))
                .map_err(wrong)?,
            None if accessor.buffer_view.is_none() => {
                return Err(wrong("has no buffer view".into()));
            }
            None => {}
        }
        Ok(values)
    }

    /// Puts a sparse accessor's values in their places.
    fn replace<T: Copy>(
        &self,
        values: &mut [T],
        sparse: &Sparse,
        (size, _, decode): Decoder<T>,
    ) -> Result<()> {
        let Checked::Valid(component) = sparse.indices.component_type else {
            return Err("has sparse indices of no known type".into());
        };
        let (index_size, _, index) = unsigned(component.0)?;
        let (indices, new) = (&sparse.indices, &sparse.values);
        let places = self.elements(
            indices.buffer_view,
            indices.byte_offset.0,
            sparse.count.0,
            index_size,
        )?;
        let new = self.elements(new.buffer_view, new.byte_offset.0, sparse.count.0, size)?;
        for (place, value) in places.map(index).zip(new.map(decode)) {
            *values
                .get_mut(place as usize)
                .ok_or("has a sparse index out of range")? = value;
        }
        Ok(())
    }

    /// `count` elements of `size` bytes, from `offset` in a buffer view on.
    fn elements(
        &self,
        view: Index<View>,
        offset: u64,
        count: u64,
        size: usize,
    ) -> Result<impl Iterator<Item = &[u8]>> {
        let outside = || format!("reaches beyond buffer view {view}: is the file cut off?");
        let view_data = self
            .root
            .get(view)
            .ok_or_else(|| format!("uses buffer view {view}, which does not exist"))?;
        let buffer = self
            .buffers
            .get(view_data.buffer.value())
            .ok_or_else(outside)?;
        let stride = view_data
            .byte_stride
            .map(|s| s.0)
            .filter(|s| *s != 0)
            .unwrap_or(size);
        if stride < size {
            return Err(format!(
                "overlaps itself: buffer view {view} has stride {stride}"
            ));
        }
        let bytes = slice(
            buffer,
            view_data.byte_offset.map_or(0, |o| o.0),
            view_data.byte_length.0,
        )
        .ok_or_else(|| {
            format!(
                "uses buffer view {view}, which reaches beyond its buffer: is the file cut off?"
            )
        })?;
        let length = match count {
            0 => 0,
            _ => (count - 1)
                .checked_mul(stride as u64)
                .and_then(|l| l.checked_add(size as u64))
                .ok_or_else(outside)?,
        };
        let bytes = slice(bytes, offset, length).ok_or_else(outside)?;
        Ok(bytes.chunks(stride).map(move |chunk| &chunk[..size]))
    }
}

/// Size in bytes, the value zero, and how to read one.
type Decoder<T> = (usize, T, fn(&[u8]) -> T);

fn unsigned(component: ComponentType) -> Result<Decoder<u32>> {
    match component {
        ComponentType::U8 => Ok((1, 0, |b| u32::from(b[0]))),
        ComponentType::U16 => Ok((2, 0, |b| u32::from(u16::from_le_bytes([b[0], b[1]])))),
        ComponentType::U32 => Ok((4, 0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))),
        _ => Err("indices are not unsigned integers".into()),
    }
}

fn slice(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let start = usize::try_from(offset).ok()?;
    bytes.get(start..start.checked_add(usize::try_from(length).ok()?)?)
}
