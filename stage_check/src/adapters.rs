//! Adapters that can run compute shaders, and devices on them.

/// Awaits all adapters that can run compute shaders, hardware first. A browser has one at most.
pub async fn usable_adapters() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    // wgpu's check of indirect arguments is one more pass before every indirect draw. The program's shaders write them
    // from checked counts; checks of stages dispatch directly.
    descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    let instance = wgpu::Instance::new(descriptor);
    let mut found = instance.enumerate_adapters(wgpu::Backends::all()).await;
    found.retain(is_usable);
    // Discrete before integrated before virtual before software; equal kinds keep their order.
    found.sort_by_key(|adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu | wgpu::DeviceType::Other => 2,
        wgpu::DeviceType::Cpu => 3,
    });
    found
}

fn is_usable(adapter: &wgpu::Adapter) -> bool {
    let flags = adapter.get_downlevel_capabilities().flags;
    flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS | wgpu::DownlevelFlags::INDIRECT_EXECUTION)
}

/// Awaits the best adapter, or the first whose name contains `name` (any case).
pub async fn find_adapter(name: Option<&str>) -> Option<wgpu::Adapter> {
    let wanted = name.unwrap_or_default().to_lowercase();
    let mut adapters = usable_adapters().await.into_iter();
    adapters.find(|adapter| adapter.get_info().name.to_lowercase().contains(&wanted))
}

/// Opens a device of wgpu's default limits, but with the adapter's limits of memory, and where it can with a binding more,
/// for a log of races.
///
/// Errors: the adapter refuses, in words that begin with its name.
pub async fn open_device(adapter: &wgpu::Adapter) -> Result<(wgpu::Device, wgpu::Queue), String> {
    let (has, defaults) = (adapter.limits(), wgpu::Limits::default());
    let descriptor = wgpu::DeviceDescriptor {
        required_limits: wgpu::Limits {
            max_storage_buffer_binding_size: has.max_storage_buffer_binding_size,
            max_buffer_size: has.max_buffer_size,
            max_texture_dimension_2d: has.max_texture_dimension_2d,
            max_storage_buffers_per_shader_stage: (has.max_storage_buffers_per_shader_stage)
                .min(defaults.max_storage_buffers_per_shader_stage + 1),
            ..defaults
        },
        ..Default::default()
    };
    let opened = adapter.request_device(&descriptor).await;
    opened.map_err(|error| format!("{}: {error}", adapter.get_info().name))
}
