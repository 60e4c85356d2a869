//! Buffers: upload with the adapter's limits checked, and the way back.

use std::{borrow::Borrow, sync::atomic::Ordering};

use bytemuck::Pod;
use wgpu::util::DeviceExt;

use crate::{Error, Gpu, Result};

/// The way back of vectors to the CPU.
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
        Ok(self.filled(what, contents, usage))
    }

    /// A storage buffer of `count` zero `vec4<f32>`.
    pub(crate) fn vectors(&self, what: &'static str, count: usize, remedy: &'static str) -> Result<wgpu::Buffer> {
        let size = (16 * count as u64).max(LEAST);
        self.check_storage(what, size, remedy)?;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        Ok(self.empty(what, size, usage))
    }

    /// A uniform buffer.
    pub(crate) fn uniform<T: Pod>(&self, what: &'static str, value: &T) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        self.filled(what, bytemuck::bytes_of(value), usage)
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
        Ok(self.filled(what, contents, usage))
    }

    /// Number of buffers that were made on the device so far, by all clones of this.
    pub fn buffers_made(&self) -> usize {
        self.made.load(Ordering::Relaxed)
    }

    fn filled(&self, what: &'static str, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.made.fetch_add(1, Ordering::Relaxed);
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(what), contents, usage })
    }

    /// A buffer of `size` zero bytes.
    pub(crate) fn empty(&self, what: &'static str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.made.fetch_add(1, Ordering::Relaxed);
        let descriptor = wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false };
        self.device.create_buffer(&descriptor)
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
        let download = self.way_back(count);
        download.copy(encoder, from);
        download
    }

    /// A way back for `count` vectors.
    pub(crate) fn way_back(&self, count: usize) -> Download {
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        Download { staging: (count > 0).then(|| self.empty("read back", 16 * count as u64, usage)) }
    }

    /// An encoder for one frame.
    pub(crate) fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") })
    }

    /// Submits the work, waits for it, and reads what was downloaded, as RGB.
    pub(crate) fn finish<const K: usize, D: Borrow<Download>>(
        &self,
        encoder: wgpu::CommandEncoder,
        downloads: [D; K],
    ) -> Result<[Vec<[f32; 3]>; K]> {
        let stagings: [Option<&wgpu::Buffer>; K] = downloads.each_ref().map(|d| d.borrow().staging.as_ref());
        let mut all = std::array::from_fn(|_| Vec::new());
        self.submit(encoder, stagings.into_iter().flatten())?;
        for (staging, values) in stagings.into_iter().zip(&mut all) {
            let Some(staging) = staging else { continue };
            *values = self.read(staging, |bytes| bytes.as_chunks::<16>().0.iter().map(rgb).collect())?;
        }
        Ok(all)
    }

    /// Submits the work and waits until it is done and `stagings` can be read.
    pub(crate) fn submit<'a>(
        &self,
        encoder: wgpu::CommandEncoder,
        stagings: impl Iterator<Item = &'a wgpu::Buffer>,
    ) -> Result<()> {
        let commands = encoder.finish();
        self.check()?;
        self.queue.submit([commands]);
        self.check()?;
        for staging in stagings {
            // A failure to map comes back from get_mapped_range in `read`.
            staging.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        }
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| self.broken(e))?;
        self.check()
    }

    /// What a buffer holds that [`Gpu::submit`] made readable.
    pub(crate) fn read<T>(&self, staging: &wgpu::Buffer, decode: impl Fn(&[u8]) -> T) -> Result<T> {
        let value = decode(&staging.slice(..).get_mapped_range().map_err(|e| self.broken(e))?);
        staging.unmap();
        Ok(value)
    }
}

impl Download {
    /// Fills the way back once the encoder's work is submitted.
    pub fn copy(&self, encoder: &mut wgpu::CommandEncoder, from: &wgpu::Buffer) {
        if let Some(staging) = &self.staging {
            encoder.copy_buffer_to_buffer(from, 0, staging, 0, staging.size());
        }
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
