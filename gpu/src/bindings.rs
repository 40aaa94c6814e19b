//! Buffers and textures by the names that shaders give them: a shader is bound by its own declarations.

use bytemuck::{Pod, cast_slice};
use std::collections::HashMap;
use std::ops::Index;
use wgpu::BufferUsages as Usage;
use wgpu::naga::{AddressSpace, Module, StorageAccess};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Usage of a buffer that shaders read and write, and that the host fills and reads back.
pub const STORAGE: Usage = Usage::STORAGE.union(Usage::COPY_SRC).union(Usage::COPY_DST);
/// Usage of a buffer of parameters.
pub const UNIFORM: Usage = Usage::UNIFORM.union(Usage::COPY_DST);

/// A part of a buffer: its first byte and the number of bytes.
pub type BufferRange<'a> = (&'a wgpu::Buffer, u64, u64);

/// Buffers and textures by name.
#[derive(Clone, Default)]
pub struct BindingTable {
    buffers: HashMap<&'static str, wgpu::Buffer>,
    textures: HashMap<&'static str, wgpu::TextureView>,
}

impl Index<&str> for BindingTable {
    type Output = wgpu::Buffer;

    fn index(&self, name: &str) -> &wgpu::Buffer {
        &self.buffers[name]
    }
}

impl BindingTable {
    /// Creates buffers of zeros from their names, bytes and usages.
    pub fn zeroed<const N: usize>(device: &wgpu::Device, buffers: [(&'static str, u64, Usage); N]) -> Self {
        let create = |(name, size, usage)| {
            let descriptor = wgpu::BufferDescriptor {
                label: Some(name),
                size,
                usage,
                mapped_at_creation: false,
            };
            (name, device.create_buffer(&descriptor))
        };
        Self {
            buffers: buffers.map(create).into(),
            textures: HashMap::new(),
        }
    }

    /// Adds a buffer of `data`.
    pub fn add_filled<T: Pod>(&mut self, device: &wgpu::Device, name: &'static str, data: &[T], usage: Usage) {
        let descriptor = BufferInitDescriptor {
            label: Some(name),
            contents: cast_slice(data),
            usage,
        };
        self.buffers.insert(name, device.create_buffer_init(&descriptor));
    }

    /// Adds a texture.
    pub fn add_texture(&mut self, name: &'static str, view: wgpu::TextureView) {
        self.textures.insert(name, view);
    }

    /// Returns a table in which `name` is `buffer`.
    pub fn with(&self, name: &'static str, buffer: &wgpu::Buffer) -> Self {
        let mut table = self.clone();
        table.buffers.insert(name, buffer.clone());
        table
    }

    /// Returns a message on a name that the table lacks.
    fn describe_unknown(&self, name: &str) -> String {
        let mut known: Vec<&str> = self.buffers.keys().chain(self.textures.keys()).copied().collect();
        known.sort_unstable();
        format!("declares an unknown `{name}`; there are: {}", known.join(", "))
    }

    /// Returns a table of both; names of `other` take precedence.
    pub fn joined_with(&self, other: &Self) -> Self {
        let mut table = self.clone();
        table.buffers.extend(other.buffers.clone());
        table.textures.extend(other.textures.clone());
        table
    }
}

/// Layout of a shader's bind group, with the names of its bindings.
pub struct BindingLayout {
    pub layout: wgpu::BindGroupLayout,
    names: Vec<(u32, String)>,
}

impl BindingLayout {
    /// Reads the declarations of a shader; `stages` see all of them.
    pub fn new(device: &wgpu::Device, stages: wgpu::ShaderStages, module: &Module) -> Self {
        let (mut entries, mut names) = (Vec::new(), Vec::new());
        for (_, variable) in module.global_variables.iter() {
            let (Some(place), Some(name)) = (variable.binding, &variable.name) else {
                continue;
            };
            entries.push(wgpu::BindGroupLayoutEntry {
                binding: place.binding,
                visibility: stages,
                ty: binding_type(variable.space, module.types[variable.ty].inner.size(module.to_ctx())),
                count: None,
            });
            names.push((place.binding, name.clone()));
        }
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &entries,
        });
        Self { layout, names }
    }

    /// Binds what `table` has under the shader's names.
    ///
    /// Errors: it lacks one, in words that follow the name of the shader.
    pub fn bind_table(
        &self,
        device: &wgpu::Device,
        table: &BindingTable,
    ) -> std::result::Result<wgpu::BindGroup, String> {
        let entry = |(binding, name): &(u32, String)| {
            let buffer = table.buffers.get(name.as_str()).map(wgpu::Buffer::as_entire_binding);
            let texture = || {
                table
                    .textures
                    .get(name.as_str())
                    .map(wgpu::BindingResource::TextureView)
            };
            let resource = buffer.or_else(texture);
            Ok(wgpu::BindGroupEntry {
                binding: *binding,
                resource: resource.ok_or_else(|| table.describe_unknown(name))?,
            })
        };
        let entries: Vec<wgpu::BindGroupEntry> = self
            .names
            .iter()
            .map(entry)
            .collect::<std::result::Result<_, String>>()?;
        Ok(device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.layout,
            entries: &entries,
        }))
    }
}

/// Returns the type of a binding of `bytes` at least; an array of any length has one element.
fn binding_type(space: AddressSpace, bytes: u32) -> wgpu::BindingType {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: wgpu::BufferSize::new(bytes.into()),
    };
    match space {
        AddressSpace::Uniform => buffer(wgpu::BufferBindingType::Uniform),
        AddressSpace::Storage { access } => buffer(wgpu::BufferBindingType::Storage {
            read_only: !access.contains(StorageAccess::STORE),
        }),
        _ => wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Uint,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
    }
}
