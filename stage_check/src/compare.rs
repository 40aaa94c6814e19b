//! Compares what a stage left in a buffer with the reference.

use crate::case::{Bound, Bytes, Case, Output};
use crate::entry_point::{Binding, Component, Region};
use crate::failure::{Difference, Fault};
use crate::tally::{Compared, Tally, Value, ulp_distance};
use wgpu::naga::ScalarKind;

/// Content of outputs before the run, as a u32: a NaN whose bits no stage makes by chance.
pub const UNWRITTEN_BITS: u32 = 0xffc0_dead;

/// Largest number of elements of an input that are shown, and of components of one.
const MAX_SHOWN: usize = 8;

/// Checks that values given for a buffer have the layout of its type in WGSL.
///
/// Errors: what does not fit.
pub fn check_layout(binding: &Binding, values: &Bytes) -> Result<(), String> {
    let (name, length, size) = (&binding.name, values.bytes.len(), values.type_size);
    if length < binding.required_bytes {
        return Err(format!(
            "`{name}` has {length} bytes; its type in WGSL has {}",
            binding.required_bytes
        ));
    }
    if let [
        Region {
            stride: Some(stride),
            components,
            ..
        },
    ] = &binding.regions[..]
    {
        let dense = 4 * components.len() == *stride;
        let divides = size > 0 && (stride.is_multiple_of(size) || size.is_multiple_of(*stride));
        if !(size == *stride || dense && divides) || !length.is_multiple_of(*stride) {
            return Err(format!(
                "`{name}` has {length} bytes in values of {size}; its elements in WGSL have {stride} bytes"
            ));
        }
    }
    let mut kinds = binding.regions.iter().flat_map(|region| &region.components);
    if let Some(kind) = values.kind
        && !kinds.any(|component| component.kind == kind)
    {
        return Err(format!("`{name}` is given as {kind:?}, which its type in WGSL has not"));
    }
    Ok(())
}

/// Compares a buffer; returns the number of compared values, and the largest error over its bound.
///
/// Errors: values differ, or the reference cannot be compared with.
pub fn compare_output(
    case: &Case,
    bindings: &[Binding],
    (binding, output): (&Binding, &Output),
    found: &[u8],
    lanes: usize,
) -> Result<(u64, f64), Fault> {
    let refuse = |text: &str| Fault::Case(format!("`{}`: {text}", output.name));
    let expected = &output.expected.bytes;
    let is_filled = case.inputs.iter().any(|(name, _)| *name == output.name);
    let beyond_end = found.get(expected.len()..).unwrap_or_default();
    if !is_filled && (0..beyond_end.len() / 4).any(|k| word(beyond_end, 4 * k) != UNWRITTEN_BITS) {
        return Err(refuse("is written, but the reference has no value there"));
    }
    let (bound, unit) = match &output.bound {
        Bound::Exact => (0.0, " ulp"),
        Bound::Ulps(ulps) => (*ulps, " ulp"),
        Bound::UlpsOf(ulps, _) => (*ulps, " ulp of the given size"),
        Bound::Absolute(difference) => (*difference, ""),
    };
    if !(0.0..f64::INFINITY).contains(&bound) {
        return Err(refuse(&format!("a bound of {bound} is no bound")));
    }
    let (mut values, mut largest) = (0, 0.0f64);
    for region in &binding.regions {
        let count = region.count(expected.len());
        let mut tally = Tally::new(bound);
        for place in 0..count * region.components.len() {
            let (element, component) = (place / region.components.len(), place % region.components.len());
            let words = [found, expected].map(|bytes| word(bytes, region.place(element, component)));
            let is_unwritten = !is_filled && words[0] == UNWRITTEN_BITS && words[0] != words[1];
            let kind = region.components[component].kind;
            if kind == ScalarKind::Float && f32::from_bits(words[1]).is_nan() && !case.allows_nan {
                let place = region.describe_place(&output.name, element, Some(component));
                return Err(refuse(&format!(
                    "the reference is NaN at {place}; `allow_nan` allows it"
                )));
            }
            let size = match &output.bound {
                Bound::UlpsOf(_, sizes) => sizes.get(element).copied().filter(|size| size.is_finite()),
                _ => Some(0.0),
            };
            let size =
                size.ok_or_else(|| refuse(&format!("element {element} has no size, or one that is not finite")))?;
            let [found, expected] = words.map(|bits| kind_value(kind, bits));
            tally.add(Compared {
                element,
                component,
                label: (),
                found: if is_unwritten { Value::Unwritten } else { found },
                expected,
                error: if is_unwritten {
                    f64::NAN
                } else {
                    error_of(found, expected, &output.bound, size)
                },
            });
        }
        if let (Some(first), Some(worst)) = (tally.first, tally.worst) {
            let name = |k: usize| region.components[k].path.clone();
            let [first, worst] = [first, worst].map(|of| Compared {
                label: region.describe_place(&output.name, of.element, Some(of.component)),
                element: of.element,
                component: of.component,
                found: of.found,
                expected: of.expected,
                error: of.error,
            });
            return Err(Fault::Difference(Box::new(Difference {
                buffer: format!("{}{}", output.name, region.path),
                count: tally.beyond,
                values: tally.values,
                pattern: tally.describe_pattern(count, lanes, name),
                inputs: describe_inputs(case, bindings, first.element, count),
                first,
                worst,
                bound,
                unit,
                other_sizes: Vec::new(),
            })));
        }
        values += tally.values;
        largest = largest.max(tally.largest_error);
    }
    Ok((values, if bound > 0.0 { largest / bound } else { 0.0 }))
}

/// Returns the word at a byte; what is not there is a word that no reference has.
fn word(bytes: &[u8], at: usize) -> u32 {
    let found = bytes.get(at..at + 4).and_then(|word| word.try_into().ok());
    found.map_or(UNWRITTEN_BITS, u32::from_le_bytes)
}

fn kind_value(kind: ScalarKind, bits: u32) -> Value {
    match kind {
        ScalarKind::Float => Value::Float(f32::from_bits(bits)),
        ScalarKind::Sint => Value::Integer((bits as i32).into()),
        _ => Value::Integer(bits.into()),
    }
}

/// Returns the error of `a` in the unit of the bound; NaN where a number is NaN, and infinity of integers that must be
/// equal.
fn error_of(a: Value, b: Value, bound: &Bound, size: f32) -> f64 {
    match (a, b, bound) {
        (Value::Float(a), Value::Float(b), _) if a.is_nan() && b.is_nan() => 0.0,
        (Value::Float(a), Value::Float(b), Bound::Exact) if a == b => f64::from(u8::from(a.to_bits() != b.to_bits())),
        (Value::Float(a), Value::Float(b), Bound::Absolute(_)) if a != b => (f64::from(a) - f64::from(b)).abs(),
        (Value::Float(a), Value::Float(b), _) => ulp_distance(a, b, size),
        (Value::Integer(a), Value::Integer(b), Bound::Exact | Bound::Absolute(_)) => a.abs_diff(b) as f64,
        _ if a == b => 0.0,
        _ => f64::INFINITY,
    }
}

/// Describes the inputs of an output's element, one of `count`.
fn describe_inputs(case: &Case, bindings: &[Binding], element: usize, count: usize) -> Vec<String> {
    let mut described = Vec::new();
    for (name, values) in &case.inputs {
        let binding = bindings.iter().find(|binding| binding.name == *name);
        for region in binding.iter().flat_map(|binding| &binding.regions) {
            let own = region.count(values.bytes.len());
            let elements = match case.reads.iter().find(|(input, _)| input == name) {
                Some((_, reads)) => reads(element),
                None if region.stride.is_none() => vec![0],
                None if own == count => vec![element],
                None => continue,
            };
            let shown = elements.iter().filter(|k| **k < own).take(MAX_SHOWN);
            described.extend(shown.map(|k| describe_element(region, name, &values.bytes, *k)));
            if elements.len() > MAX_SHOWN {
                described.push("…".to_owned());
            }
        }
    }
    described
}

fn describe_element(region: &Region, name: &str, bytes: &[u8], element: usize) -> String {
    let of = |(k, component): (usize, &Component)| {
        kind_value(component.kind, word(bytes, region.place(element, k))).to_string()
    };
    let values: Vec<String> = region.components.iter().enumerate().take(MAX_SHOWN).map(of).collect();
    let values = match region.components.len() {
        1 => values.concat(),
        _ => format!("({})", values.join(", ")),
    };
    let only = (region.components.len() == 1).then_some(0);
    format!("{} = {values}", region.describe_place(name, element, only))
}
