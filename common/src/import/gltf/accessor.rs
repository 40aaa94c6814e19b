//! What accessors hold: positions, texture coordinates and indices of vertices, every range checked before it is read.

use super::buffers::Document;
use crate::import::builder::MAX_FACES;
use crate::import::material::of_vertex;
use glam::{DVec2, DVec3, Vec3};
use gltf::json::Index;
use gltf::json::accessor::sparse::Sparse;
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::buffer::View;
use gltf::json::validation::Checked;

/// What is wrong with an accessor.
pub type Result<T> = std::result::Result<T, String>;

impl Document {
    /// Positions or normals of vertices.
    pub fn positions(&self, index: Index<Accessor>) -> Result<Vec<Vec3>> {
        let values = self.values(index, "positions", Type::Vec3, floats::<3>)?;
        Ok(values.into_iter().map(Vec3::from).collect())
    }

    /// Texture coordinates of vertices.
    pub fn places(&self, index: Index<Accessor>) -> Result<Vec<DVec2>> {
        let values = self.values(index, "texture coordinates", Type::Vec2, floats::<2>)?;
        let place = |p: [f32; 2]| DVec2::from(p.map(f64::from));
        Ok(values.into_iter().map(place).collect())
    }

    /// Colours of vertices, without their opacity.
    pub fn colours(&self, index: Index<Accessor>) -> Result<Vec<DVec3>> {
        let kind = self.root.get(index).map(|accessor| accessor.type_);
        let values: Vec<[f32; 3]> = if matches!(kind, Some(Checked::Valid(Type::Vec4))) {
            let values = self.values(index, "colours", Type::Vec4, floats::<4>)?;
            values.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
        } else {
            self.values(index, "colours", Type::Vec3, floats::<3>)?
        };
        let colour = |p: [f32; 3]| DVec3::from(p.map(|x| f64::from(of_vertex(x))));
        Ok(values.into_iter().map(colour).collect())
    }

    /// What an accessor of integers rounds each value by; 0 of floats.
    pub fn step(&self, index: Index<Accessor>) -> f64 {
        let of = |accessor: &Accessor| match accessor.component_type {
            Checked::Valid(component) => {
                let one = largest(component.0)?;
                Some(if accessor.normalized { 0.5 / one } else { 0.5 })
            }
            Checked::Invalid => None,
        };
        self.root.get(index).and_then(of).unwrap_or(0.0)
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
        decoder: impl Fn(ComponentType, bool) -> Result<Decoder<T>>,
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
        let (size, zero, decode) = decoder(component.0, accessor.normalized).map_err(wrong)?;
        let count = accessor.count.0;
        let mut values: Vec<T> = match accessor.buffer_view {
            Some(view) => self
                .elements(view, accessor.byte_offset.map_or(0, |o| o.0), count, size)
                .map_err(wrong)?
                .map(&decode)
                .collect(),
            // Nothing in the file bounds this one.
            None if count > 3 * MAX_FACES as u64 => {
                return Err(wrong(format!("has {count} elements: too many")));
            }
            None => vec![zero; count as usize],
        };
        match &accessor.sparse {
            Some(sparse) => self
                .replace(&mut values, sparse, &(size, zero, decode))
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
        (size, _, decode): &Decoder<T>,
    ) -> Result<()> {
        let Checked::Valid(component) = sparse.indices.component_type else {
            return Err("has sparse indices of no known type".into());
        };
        let (index_size, _, index) = unsigned(component.0, false)?;
        let (indices, new) = (&sparse.indices, &sparse.values);
        let places = self.elements(
            indices.buffer_view,
            indices.byte_offset.0,
            sparse.count.0,
            index_size,
        )?;
        let new = self.elements(new.buffer_view, new.byte_offset.0, sparse.count.0, *size)?;
        for (place, value) in places.map(index).zip(new.map(decode)) {
            *values
                .get_mut(place as usize)
                .ok_or("has a sparse index out of range")? = value;
        }
        Ok(())
    }

    /// A buffer view.
    pub fn bytes(&self, view: Index<View>) -> Result<&[u8]> {
        let beyond = || {
            format!(
                "uses buffer view {view}, which reaches beyond its buffer: is the file cut off?"
            )
        };
        let data = self
            .root
            .get(view)
            .ok_or_else(|| format!("uses buffer view {view}, which does not exist"))?;
        let buffer = self.buffers.get(data.buffer.value());
        let offset = data.byte_offset.map_or(0, |o| o.0);
        buffer
            .and_then(|buffer| slice(buffer, offset, data.byte_length.0))
            .ok_or_else(beyond)
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
        let bytes = self.bytes(view)?;
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
type Decoder<T> = (usize, T, Box<dyn Fn(&[u8]) -> T>);

fn unsigned(component: ComponentType, _: bool) -> Result<Decoder<u32>> {
    let (size, read): (_, fn(&[u8]) -> u32) = match component {
        ComponentType::U8 => (1, |b| u32::from(b[0])),
        ComponentType::U16 => (2, |b| u32::from(u16::from_le_bytes([b[0], b[1]]))),
        ComponentType::U32 => (4, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        _ => return Err("holds no unsigned integers".into()),
    };
    Ok((size, 0, Box::new(read)))
}

/// Vectors of floats, or of integers as KHR_mesh_quantization has them.
fn floats<const N: usize>(component: ComponentType, normalized: bool) -> Result<Decoder<[f32; N]>> {
    let (size, read): (usize, fn(&[u8]) -> f32) = match component {
        ComponentType::F32 => (4, |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        ComponentType::I8 => (1, |b| f32::from(b[0] as i8)),
        ComponentType::U8 => (1, |b| f32::from(b[0])),
        ComponentType::I16 => (2, |b| f32::from(i16::from_le_bytes([b[0], b[1]]))),
        ComponentType::U16 => (2, |b| f32::from(u16::from_le_bytes([b[0], b[1]]))),
        ComponentType::U32 => return Err("holds neither floats nor short integers".into()),
    };
    // −128 is −1 as well (glTF 2.0 §3.6.2.2).
    let one = largest(component).filter(|_| normalized);
    let value = move |b: &[u8]| one.map_or(read(b), |one| (read(b) / one as f32).max(-1.0));
    let vector = move |b: &[u8]| std::array::from_fn(|k| value(&b[k * size..]));
    Ok((N * size, [0.0; N], Box::new(vector)))
}

/// The integer that stands for 1.
fn largest(component: ComponentType) -> Option<f64> {
    match component {
        ComponentType::I8 => Some(127.0),
        ComponentType::U8 => Some(255.0),
        ComponentType::I16 => Some(32767.0),
        ComponentType::U16 => Some(65535.0),
        ComponentType::U32 | ComponentType::F32 => None,
    }
}

fn slice(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let start = usize::try_from(offset).ok()?;
    bytes.get(start..start.checked_add(usize::try_from(length).ok()?)?)
}
