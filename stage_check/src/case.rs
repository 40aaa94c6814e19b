//! A case of a check: the contents of a stage's buffers, and what a reference in Rust makes of them.

use bytemuck::{Pod, cast_slice};
use std::any::TypeId;
use wgpu::naga::ScalarKind;

/// Error that a value may have.
#[derive(Clone, Debug, PartialEq)]
pub enum Bound {
    /// Equal bits: −0 is not 0.
    Exact,
    /// Roundings of f32: units in the last place of the larger of the two values. Integers must be equal.
    Ulps(f64),
    /// Roundings of a size for each element, if it is larger than the values: for sums that cancel.
    UlpsOf(f64, Vec<f32>),
    /// Difference of numbers.
    Absolute(f64),
}

/// Bytes of values, and what is known of their type.
pub(crate) struct Bytes {
    pub(crate) bytes: Vec<u8>,
    pub(crate) type_size: usize,
    /// Kind of the scalars, if the values are scalars.
    pub(crate) kind: Option<ScalarKind>,
}

impl Bytes {
    fn new<T: Pod>(values: &[T]) -> Self {
        let kinds = [
            (TypeId::of::<f32>(), ScalarKind::Float),
            (TypeId::of::<u32>(), ScalarKind::Uint),
            (TypeId::of::<i32>(), ScalarKind::Sint),
        ];
        let own = kinds.into_iter().find(|(id, _)| *id == TypeId::of::<T>());
        Self {
            bytes: cast_slice(values).to_vec(),
            type_size: size_of::<T>(),
            kind: own.map(|(_, kind)| kind),
        }
    }
}

/// What a buffer has to hold after the stage.
pub(crate) struct Output {
    pub(crate) name: String,
    pub(crate) expected: Bytes,
    pub(crate) bound: Bound,
}

/// Returns the elements of an input that an element of the outputs is made of.
pub(crate) type ElementsRead = Box<dyn Fn(usize) -> Vec<usize>>;

/// Contents of a stage's buffers by their names in WGSL.
///
/// Values have the layout of WGSL: a `vec3f` in an array takes 16 bytes, a struct what naga says in the message.
#[derive(Default)]
pub struct Case {
    pub(crate) inputs: Vec<(String, Bytes)>,
    pub(crate) outputs: Vec<Output>,
    pub(crate) reads: Vec<(String, ElementsRead)>,
    pub(crate) allows_nan: bool,
}

impl Case {
    /// Starts a case without buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Fills a buffer before the run: a storage buffer or a uniform. One that the stage writes too is compared only if
    /// it is an output as well.
    pub fn input<T: Pod>(mut self, name: &str, values: &[T]) -> Self {
        self.inputs.push((name.to_owned(), Bytes::new(values)));
        self
    }

    /// Compares a buffer with the reference after the run. If it is no input, it is filled with a pattern before, so that
    /// a value that the stage does not write is noticed.
    pub fn output<T: Pod>(mut self, name: &str, reference: &[T], bound: Bound) -> Self {
        self.outputs.push(Output {
            name: name.to_owned(),
            expected: Bytes::new(reference),
            bound,
        });
        self
    }

    /// Shows these elements of an input with a wrong element of an output. Otherwise the input's element of the same
    /// number is shown where the two have as many.
    pub fn reads(mut self, input: &str, elements: impl Fn(usize) -> Vec<usize> + 'static) -> Self {
        self.reads.push((input.to_owned(), Box::new(elements)));
        self
    }

    /// Lets the reference have NaN; a NaN of the stage is right there, and only there.
    pub fn allow_nan(mut self) -> Self {
        self.allows_nan = true;
        self
    }
}
