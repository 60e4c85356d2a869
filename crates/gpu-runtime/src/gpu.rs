//! Finding an adapter and opening a device on it.
//!
//! Real devices are preferred, software ones accepted; no environment variable is read. Errors of the
//! device are kept and handed out by [`Gpu::check`]; left alone, wgpu would end the process.

use std::{
    fmt,
    sync::{Arc, Mutex, atomic::AtomicUsize},
};

use crate::{Error, Result};

/// What can be said of an adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adapter {
    /// Name of the device.
    pub name: String,
    /// The interface it is driven through, for instance "vulkan".
    pub backend: String,
    /// Driver and its version.
    pub driver: String,
    /// Whether a CPU does the work.
    pub software: bool,
}

impl fmt::Display for Adapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {})", self.name, self.backend, self.driver)
    }
}

/// An open device. Clones share it.
#[derive(Clone)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    adapter: Adapter,
    /// The first error that the device reported and nobody has fetched yet.
    fault: Arc<Mutex<Option<String>>>,
    /// Number of buffers.
    pub(crate) made: Arc<AtomicUsize>,
}

/// Bytes that a pixel of the shading pass writes.
const TARGET_BYTES: u32 = 64;
/// Storage buffers of the largest kernel.
const STORAGE_BUFFERS: u32 = 8;

impl Gpu {
    /// Opens the best adapter of this machine.
    ///
    /// # Errors
    ///
    /// [`Error::NoAdapter`], or [`Error::Device`] if the device cannot be opened.
    pub fn new() -> Result<Gpu> {
        Gpu::matching(|_| true)
    }

    /// Opens the best of the adapters that `accept` takes.
    ///
    /// # Errors
    ///
    /// As [`Gpu::new`].
    pub fn matching(accept: impl Fn(&Adapter) -> bool) -> Result<Gpu> {
        Gpu::with_features(accept, wgpu::Features::TEXTURE_COMPRESSION_BC | wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Opens a device with those of `features` that its adapter has.
    pub(crate) fn with_features(accept: impl Fn(&Adapter) -> bool, features: wgpu::Features) -> Result<Gpu> {
        let native = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
        let mut refused = Vec::new();
        for backends in [native, wgpu::Backends::GL] {
            let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
            descriptor.backends = backends;
            let instance = wgpu::Instance::new(descriptor);
            let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
            adapters.sort_by_key(|a| rank(a.get_info().device_type));
            for adapter in adapters {
                let about = about(&adapter.get_info());
                if !accept(&about) {
                    refused.push(format!("{about} was not asked for"));
                } else if let Some(lack) = lack(&adapter) {
                    refused.push(format!("{about} lacks {lack}"));
                } else {
                    return open(&adapter, about, features & adapter.features());
                }
            }
        }
        let found = if refused.is_empty() { "none was found".into() } else { refused.join("; ") };
        Err(Error::NoAdapter { found })
    }

    /// The adapter behind the device.
    pub fn adapter(&self) -> &Adapter {
        &self.adapter
    }

    /// Whether textures of compressed blocks can be used.
    pub(crate) fn has_block_textures(&self) -> bool {
        self.device.features().contains(wgpu::Features::TEXTURE_COMPRESSION_BC)
    }

    /// Whether the device notes the time at which it does its work.
    pub(crate) fn has_timestamps(&self) -> bool {
        self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// The first error that the device has reported since the last call.
    pub(crate) fn check(&self) -> Result<()> {
        let fault = self.fault.lock().unwrap_or_else(|broken| broken.into_inner()).take();
        match fault {
            None => Ok(()),
            Some(what) => Err(self.broken(what)),
        }
    }

    /// An error of the device.
    pub(crate) fn broken(&self, what: impl fmt::Display) -> Error {
        Error::Device { adapter: self.adapter.to_string(), what: what.to_string() }
    }
}

/// Smaller is better.
fn rank(kind: wgpu::DeviceType) -> u32 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

fn about(info: &wgpu::AdapterInfo) -> Adapter {
    Adapter {
        name: info.name.clone(),
        backend: info.backend.to_str().into(),
        driver: format!("{} {}", info.driver, info.driver_info).trim().into(),
        software: info.device_type == wgpu::DeviceType::Cpu,
    }
}

/// What an adapter would need to serve.
fn lack(adapter: &wgpu::Adapter) -> Option<&'static str> {
    let limits = adapter.limits();
    let flags = adapter.get_downlevel_capabilities().flags;
    if !flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        return Some("compute shaders");
    }
    if limits.max_storage_buffers_per_shader_stage < STORAGE_BUFFERS {
        return Some("8 storage buffers a shader");
    }
    if limits.max_color_attachment_bytes_per_sample < TARGET_BYTES {
        return Some("64 bytes of render targets a pixel");
    }
    None
}

fn open(adapter: &wgpu::Adapter, about: Adapter, required_features: wgpu::Features) -> Result<Gpu> {
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("allbounce"),
        required_features,
        required_limits: adapter.limits(),
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
        .map_err(|e| Error::Device { adapter: about.to_string(), what: e.to_string() })?;
    let fault = Arc::new(Mutex::new(None));
    let keep = |slot: &Mutex<Option<String>>, what: String| {
        slot.lock().unwrap_or_else(|broken| broken.into_inner()).get_or_insert(what);
    };
    let slot = fault.clone();
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| keep(&slot, error.to_string())));
    let slot = fault.clone();
    device.set_device_lost_callback(move |reason, what| match reason {
        wgpu::DeviceLostReason::Destroyed => {}
        _ => keep(&slot, format!("the device was lost: {what}")),
    });
    Ok(Gpu { device, queue, adapter: about, fault, made: Arc::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_adapter_is_said_with_what_was_found_and_what_to_do() {
        let text = Gpu::matching(|_| false).err().expect("nothing was accepted").to_string();
        assert!(text.starts_with("no usable GPU adapter ("), "{text}");
        assert!(text.contains("lavapipe") && text.ends_with("use --backend cpu"), "{text}");
    }

    #[test]
    fn errors_of_the_device_come_back_instead_of_ending_the_process() {
        if std::env::var("ALLBOUNCE_GPU").as_deref() == Ok("skip") {
            println!("gpu: skipped, ALLBOUNCE_GPU=skip");
            return;
        }
        let gpu = Gpu::new().expect("an adapter");
        // More layers than any adapter has.
        let _ = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("too many layers"),
            size: wgpu::Extent3d { width: 4, height: 4, depth_or_array_layers: 1 << 30 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R8Unorm,
            usage: wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let text = gpu.check().expect_err("the texture cannot exist").to_string();
        assert!(text.contains("reported an error") && text.contains("too many layers"), "{text}");
        gpu.check().expect("an error is told once");
    }
}
