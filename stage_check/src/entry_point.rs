//! Describes what an entry point binds: its buffers by name, and the scalars of their elements.

use wgpu::naga::valid::ModuleInfo;
use wgpu::naga::{
    AddressSpace, ArraySize, Handle, Module, Scalar, ScalarKind, ShaderStage, StorageAccess, Type, TypeInner,
};

/// Largest number of scalars of an element, so that a shader's types cost no more memory than its buffers.
const MAX_COMPONENTS: usize = 4096;

/// A scalar of an element.
pub struct Component {
    /// What follows the element in WGSL: `.position.x`.
    pub path: String,
    /// First byte in the element.
    pub offset: usize,
    pub kind: ScalarKind,
}

/// Elements of one type in a buffer.
pub struct Region {
    /// What follows the buffer's name in WGSL: `.values`, mostly nothing.
    pub path: String,
    /// First byte.
    pub start: usize,
    /// Bytes from one element to the next; none for a single element.
    pub stride: Option<usize>,
    /// True for an array of any length.
    pub is_open: bool,
    pub components: Vec<Component>,
}

impl Region {
    /// Returns the number of elements in a buffer of so many bytes.
    pub fn count(&self, bytes: usize) -> usize {
        self.stride
            .map_or(1, |stride| bytes.saturating_sub(self.start) / stride)
    }

    /// Returns the first byte of a component.
    pub fn place(&self, element: usize, component: usize) -> usize {
        self.start + element * self.stride.unwrap_or(0) + self.components[component].offset
    }

    /// Returns what an element, or a component of it, is called.
    pub fn describe_place(&self, name: &str, element: usize, component: Option<usize>) -> String {
        let element = self.stride.map_or(String::new(), |_| format!("[{element}]"));
        let component = component.map_or("", |component| &self.components[component].path);
        format!("{name}{}{element}{component}", self.path)
    }
}

/// A buffer that an entry point uses.
pub struct Binding {
    pub group: u32,
    pub binding: u32,
    pub name: String,
    pub uniform: bool,
    pub written: bool,
    /// Bytes of the type, with one element of an array of any length.
    pub min_bytes: usize,
    /// Bytes of the type without that element.
    pub required_bytes: usize,
    pub regions: Vec<Region>,
}

/// An entry point and what it binds.
pub struct EntryPoint {
    pub workgroup_size: [u32; 3],
    pub bindings: Vec<Binding>,
}

impl EntryPoint {
    /// Describes the compute entry point `name`.
    ///
    /// Errors: there is none, or it uses something other than buffers of 32-bit scalars.
    pub fn new(module: &Module, info: &ModuleInfo, name: &str) -> Result<Self, String> {
        let points = &module.entry_points;
        let found = points
            .iter()
            .position(|point| point.name == name && point.stage == ShaderStage::Compute);
        let Some(index) = found else {
            let names: Vec<&str> = points.iter().map(|point| point.name.as_str()).collect();
            return Err(format!(
                "has no compute entry point `{name}`; there are: {}",
                names.join(", ")
            ));
        };
        if points[index].workgroup_size_overrides.is_some() {
            return Err(format!("`{name}` has a workgroup size that is set from outside"));
        }
        let variables = module.global_variables.iter();
        let used = variables.filter(|(handle, _)| !info.get_entry_point(index)[*handle].is_empty());
        let mut bindings = Vec::new();
        for (_, variable) in used {
            let Some(place) = variable.binding else {
                continue;
            };
            let name = variable.name.clone().unwrap_or_default();
            let (uniform, written) = match variable.space {
                AddressSpace::Uniform => (true, false),
                AddressSpace::Storage { access } => (false, access.contains(StorageAccess::STORE)),
                _ => return Err(format!("`{name}` is no buffer: only buffers can be given")),
            };
            let regions = find_regions(module, variable.ty).map_err(|reason| format!("`{name}`: {reason}"))?;
            let min_bytes = module.types[variable.ty].inner.size(module.to_ctx()) as usize;
            let open = regions.iter().find(|region| region.is_open);
            bindings.push(Binding {
                group: place.group,
                binding: place.binding,
                name,
                uniform,
                written,
                min_bytes,
                required_bytes: open.map_or(min_bytes, |region| region.start),
                regions,
            });
        }
        Ok(Self {
            workgroup_size: points[index].workgroup_size,
            bindings,
        })
    }
}

/// Returns the regions of a buffer: an array's elements, or a struct's members and the elements of an array of any length
/// at its end.
fn find_regions(module: &Module, ty: Handle<Type>) -> Result<Vec<Region>, String> {
    let mut single = Vec::new();
    let mut regions = Vec::new();
    let mut add_elements = |base, stride, path: String, start, is_open| {
        let mut components = Vec::new();
        add_components(module, base, "", 0, &mut components)?;
        regions.push(Region {
            path,
            start,
            stride: Some(stride),
            is_open,
            components,
        });
        Ok::<(), String>(())
    };
    match &module.types[ty].inner {
        TypeInner::Array { base, stride, size } => {
            add_elements(*base, *stride as usize, String::new(), 0, *size == ArraySize::Dynamic)?;
        }
        TypeInner::Struct { members, .. } => {
            for member in members {
                let path = format!(".{}", member.name.as_deref().unwrap_or_default());
                let start = member.offset as usize;
                match module.types[member.ty].inner {
                    TypeInner::Array {
                        base,
                        size: ArraySize::Dynamic,
                        stride,
                    } => add_elements(base, stride as usize, path, start, true)?,
                    _ => add_components(module, member.ty, &path, start, &mut single)?,
                }
            }
        }
        _ => add_components(module, ty, "", 0, &mut single)?,
    }
    if !single.is_empty() {
        regions.push(Region {
            path: String::new(),
            start: 0,
            stride: None,
            is_open: false,
            components: single,
        });
    }
    Ok(regions)
}

/// Adds the scalars of a type.
fn add_components(
    module: &Module,
    ty: Handle<Type>,
    path: &str,
    offset: usize,
    found: &mut Vec<Component>,
) -> Result<(), String> {
    let mut add = |scalar: Scalar, path: String, offset| {
        if scalar.width != 4 || found.len() == MAX_COMPONENTS {
            return Err(format!(
                "an element may have {MAX_COMPONENTS} scalars of 32 bits, no others"
            ));
        }
        found.push(Component {
            path,
            offset,
            kind: scalar.kind,
        });
        Ok(())
    };
    match &module.types[ty].inner {
        TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => add(*scalar, path.to_owned(), offset),
        TypeInner::Vector { size, scalar } => {
            let mut axes = ['x', 'y', 'z', 'w'].into_iter().enumerate().take(*size as usize);
            axes.try_for_each(|(k, axis)| add(*scalar, format!("{path}.{axis}"), offset + 4 * k))
        }
        TypeInner::Matrix { columns, rows, scalar } => {
            let column = if *rows as usize == 2 { 8 } else { 16 };
            let mut places = (0..*columns as usize).flat_map(|c| (0..*rows as usize).map(move |r| (c, r)));
            places.try_for_each(|(c, r)| add(*scalar, format!("{path}[{c}][{r}]"), offset + column * c + 4 * r))
        }
        TypeInner::Array {
            base,
            size: ArraySize::Constant(count),
            stride,
        } => (0..count.get() as usize).try_for_each(|k| {
            let at = offset + *stride as usize * k;
            add_components(module, *base, &format!("{path}[{k}]"), at, found)
        }),
        TypeInner::Struct { members, .. } => members.iter().try_for_each(|member| {
            let path = format!("{path}.{}", member.name.as_deref().unwrap_or_default());
            add_components(module, member.ty, &path, offset + member.offset as usize, found)
        }),
        _ => Err("a type that buffers of this library do not hold".to_owned()),
    }
}
