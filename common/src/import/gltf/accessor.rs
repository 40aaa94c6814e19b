//! Reads accessors: positions, texture coordinates, colours and indices of vertices. [`super::primitive`] reads
//! vertices by it, [`super::material`] the bytes of pictures.
//!
//! The crate `gltf` decodes the numbers. Its readers of whole accessors do not serve: they know no positions in
//! integers (KHR_mesh_quantization), and they overflow where an accessor leaves its buffer view.

use super::document::{GltfDocument, GltfResult};
use crate::import::builder::MAX_FACES;
use gltf::accessor::Item;
use gltf::json::Index;
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::buffer::View;
use gltf::json::validation::Checked;

impl GltfDocument {
    /// Returns the rounding error of an accessor of integers, and 0 for floats.
    pub fn integer_rounding(&self, index: Index<Accessor>) -> f64 {
        match self.root.get(index) {
            Some(Accessor {
                component_type: Checked::Valid(component),
                normalized,
                ..
            }) => {
                let one = largest_integer(component.0);
                one.map_or(0.0, |one| if *normalized { 0.5 / one } else { 0.5 })
            }
            _ => 0.0,
        }
    }

    /// Reads a vector of `N` numbers per element.
    ///
    /// Errors: the accessor is missing, of another type than `wanted` or out of range; the message says `what` it holds.
    pub fn read_values<T, const N: usize>(
        &self,
        index: Index<Accessor>,
        what: &str,
        wanted: Type,
        convert: impl Fn([f64; N]) -> T,
    ) -> GltfResult<Vec<T>> {
        let accessor = self.root.get(index).ok_or_else(|| "does not exist".into());
        let values = accessor.and_then(|accessor| self.decode_accessor(accessor, wanted));
        let values = values.map_err(|message| format!("accessor {index} ({what}) {message}"))?;
        Ok(values.into_iter().map(convert).collect())
    }

    fn decode_accessor<const N: usize>(&self, accessor: &Accessor, wanted: Type) -> GltfResult<Vec<[f64; N]>> {
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_) else {
            return Err("is of no known type".into());
        };
        let component = component.0;
        if kind != wanted {
            return Err(format!("is of type {kind:?} instead of {wanted:?}"));
        }
        let unsigned = matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
        let is_index = wanted == Type::Scalar;
        if is_index && !unsigned {
            return Err("holds no unsigned integers".into());
        } else if !is_index && component == ComponentType::U32 {
            return Err("holds neither floats nor short integers".into());
        }
        let one = largest_integer(component).filter(|_| accessor.normalized && !is_index);
        let number = |bytes: &[u8]| match (decode_number(component, bytes), one) {
            (x, None) => x,
            // −128 also means −1 (glTF 2.0 §3.6.2.2).
            (x, Some(one)) => f64::from((x as f32 / one as f32).max(-1.0)),
        };
        let size = component.size();
        let element = |bytes: &[u8]| std::array::from_fn(|k| number(&bytes[k * size..]));
        let count = accessor.count.0;
        let mut values: Vec<[f64; N]> = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                let elements = self.view_elements(view, offset, count, N * size)?;
                elements.map(element).collect()
            }
            None if accessor.sparse.is_none() => return Err("has no buffer view".into()),
            // The size of the file does not limit this count.
            None if count > 3 * MAX_FACES as u64 => {
                return Err(format!("has {count} elements: too many"));
            }
            None => vec![[0.0; N]; count as usize],
        };
        let Some(sparse) = &accessor.sparse else {
            return Ok(values);
        };
        let (at, new) = (&sparse.indices, &sparse.values);
        let Checked::Valid(component) = at.component_type else {
            return Err("has sparse indices of no known type".into());
        };
        let (component, count) = (component.0, sparse.count.0);
        let places = self.view_elements(at.buffer_view, at.byte_offset.0, count, component.size())?;
        let new = self.view_elements(new.buffer_view, new.byte_offset.0, count, N * size)?;
        for (place, bytes) in places.zip(new) {
            let value = values.get_mut(decode_number(component, place) as usize);
            *value.ok_or("has a sparse index out of range")? = element(bytes);
        }
        Ok(values)
    }

    /// Returns the bytes of a buffer view.
    ///
    /// Errors: it does not exist, or reaches beyond its buffer.
    pub fn view_bytes(&self, view: Index<View>) -> GltfResult<&[u8]> {
        let missing = || format!("uses buffer view {view}, which does not exist");
        let range = self.root.get(view).ok_or_else(missing)?;
        let buffer = self.buffers.get(range.buffer.value());
        let offset = range.byte_offset.map_or(0, |offset| offset.0);
        let bytes = buffer.and_then(|b| checked_slice(b, offset, range.byte_length.0));
        bytes.ok_or_else(|| format!("uses buffer view {view}, which reaches beyond its buffer: is the file cut off?"))
    }

    /// Iterates over `count` elements of `size` bytes from `offset` in a buffer view.
    fn view_elements(
        &self,
        view: Index<View>,
        offset: u64,
        count: u64,
        size: usize,
    ) -> GltfResult<impl Iterator<Item = &[u8]>> {
        let bytes = self.view_bytes(view)?;
        let stride = self.root.get(view).and_then(|view| view.byte_stride);
        let stride = stride.map_or(size, |s| if s.0 == 0 { size } else { s.0 });
        if stride < size {
            return Err(format!("overlaps itself: buffer view {view} has stride {stride}"));
        }
        let before_last = count.saturating_sub(1).saturating_mul(stride as u64);
        let length = before_last.saturating_add(count.min(1) * size as u64);
        let bytes = checked_slice(bytes, offset, length)
            .ok_or_else(|| format!("reaches beyond buffer view {view}: is the file cut off?"))?;
        Ok(bytes.chunks(stride).map(move |chunk| &chunk[..size]))
    }
}

/// Decodes the number at the beginning of `bytes`.
fn decode_number(component: ComponentType, bytes: &[u8]) -> f64 {
    match component {
        ComponentType::I8 => i8::from_slice(bytes).into(),
        ComponentType::U8 => u8::from_slice(bytes).into(),
        ComponentType::I16 => i16::from_slice(bytes).into(),
        ComponentType::U16 => u16::from_slice(bytes).into(),
        ComponentType::U32 => u32::from_slice(bytes).into(),
        ComponentType::F32 => f32::from_slice(bytes).into(),
    }
}

/// Returns the integer that a normalized component maps to 1.
fn largest_integer(component: ComponentType) -> Option<f64> {
    match component {
        ComponentType::I8 => Some(127.0),
        ComponentType::U8 => Some(255.0),
        ComponentType::I16 => Some(32767.0),
        ComponentType::U16 => Some(65535.0),
        ComponentType::U32 | ComponentType::F32 => None,
    }
}

fn checked_slice(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let start = usize::try_from(offset).ok()?;
    bytes.get(start..start.checked_add(usize::try_from(length).ok()?)?)
}
