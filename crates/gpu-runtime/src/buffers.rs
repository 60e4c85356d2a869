//! Buffers: upload with the adapter's limits checked, and the way back.

use bytemuck::Pod;
use wgpu::util::DeviceExt;

use crate::{Error, Gpu, Result};

/// A buffer on its way back to the CPU: filled when the encoder's work is submitted.
pub struct Download {
    staging: Option<wgpu::Buffer>,
}

/// Bindings may not be empty; empty arrays become this many zero bytes.
const LEAST: u64 = 16;

impl Gpu {
    /// A storage buffer that holds `data`.
    pub(crate) fn storage<T: Pod>(&self, what: &'static str, data: &[T], remedy: &'static str) -> Result<wgpu::Buffer> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        self.check_storage(what, bytes.len() as u64, remedy)?;
        let contents = if bytes.is_empty() { &[0; LEAST as usize] } else { bytes };
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        Ok(self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(what), contents, usage }))
    }

    /// A storage buffer of `count` zero `vec4<f32>`.
    pub(crate) fn vectors(&self, what: &'static str, count: usize, remedy: &'static str) -> Result<wgpu::Buffer> {
        let size = (16 * count as u64).max(LEAST);
        self.check_storage(what, size, remedy)?;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let descriptor = wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false };
        Ok(self.device.create_buffer(&descriptor))
    }

    /// A uniform buffer.
    pub(crate) fn uniform<T: Pod>(&self, what: &'static str, value: &T) -> wgpu::Buffer {
        let (contents, usage) = (bytemuck::bytes_of(value), wgpu::BufferUsages::UNIFORM);
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(what), contents, usage })
    }

    /// A buffer of vertices or indices.
    pub(crate) fn geometry<T: Pod>(
        &self,
        what: &'static str,
        data: &[T],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer> {
        let contents: &[u8] = bytemuck::cast_slice(data);
        let limit = self.device.limits().max_buffer_size;
        if contents.len() as u64 > limit {
            let remedy = "use a coarser mesh";
            return Err(self.too_large(what, contents.len() as u64, limit, "maxBufferSize", remedy));
        }
        Ok(self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(what), contents, usage }))
    }

    /// Whether a storage buffer of `bytes` can be bound.
    pub(crate) fn check_storage(&self, what: &'static str, bytes: u64, remedy: &'static str) -> Result<()> {
        let limits = self.device.limits();
        let (limit, rule) = if limits.max_storage_buffer_binding_size < limits.max_buffer_size {
            (limits.max_storage_buffer_binding_size, "maxStorageBufferBindingSize")
        } else {
            (limits.max_buffer_size, "maxBufferSize")
        };
        if bytes > limit { Err(self.too_large(what, bytes, limit, rule, remedy)) } else { Ok(()) }
    }

    fn too_large(&self, what: &'static str, bytes: u64, limit: u64, rule: &'static str, remedy: &'static str) -> Error {
        let mebibytes = |b: u64| format!("{:.1} MiB", b as f64 / (1 << 20) as f64);
        let (need, limit) = (mebibytes(bytes), mebibytes(limit));
        Error::TooLarge { what, need, adapter: self.adapter().to_string(), limit, rule, remedy }
    }

    /// Copies the first `count` vectors of a buffer to where the CPU can read them.
    pub(crate) fn download(&self, encoder: &mut wgpu::CommandEncoder, from: &wgpu::Buffer, count: usize) -> Download {
        let size = 16 * count as u64;
        let staging = (size > 0).then(|| {
            let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
            let descriptor =
                wgpu::BufferDescriptor { label: Some("read back"), size, usage, mapped_at_creation: false };
            let staging = self.device.create_buffer(&descriptor);
            encoder.copy_buffer_to_buffer(from, 0, &staging, 0, size);
            staging
        });
        Download { staging }
    }

    /// An encoder for one frame.
    pub(crate) fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") })
    }

    /// Submits the work, waits for it, and reads what was downloaded, as RGB.
    pub(crate) fn finish<const K: usize>(
        &self,
        encoder: wgpu::CommandEncoder,
        downloads: [Download; K],
    ) -> Result<[Vec<[f32; 3]>; K]> {
        let commands = encoder.finish();
        self.check()?;
        self.queue.submit([commands]);
        self.check()?;
        for staging in downloads.iter().filter_map(|d| d.staging.as_ref()) {
            // A failure to map comes back from get_mapped_range below.
            staging.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        }
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| self.broken(e))?;
        self.check()?;
        let mut all = std::array::from_fn(|_| Vec::new());
        for (download, values) in downloads.iter().zip(&mut all) {
            let Some(staging) = &download.staging else { continue };
            let mapped = staging.slice(..).get_mapped_range().map_err(|e| self.broken(e))?;
            *values = mapped.as_chunks::<16>().0.iter().map(rgb).collect();
        }
        Ok(all)
    }
}

/// The first three floats of a vector.
fn rgb(bytes: &[u8; 16]) -> [f32; 3] {
    let [r, g, b, _]: [f32; 4] = bytemuck::pod_read_unaligned(bytes);
    [r, g, b]
}

/// Three numbers and a fourth, as WGSL wants them.
pub fn vec4([x, y, z]: [f32; 3], w: f32) -> [f32; 4] {
    [x, y, z, w]
}
