//! The last gather on the GPU: from what patches or their elements send to receivers, by packed rows.
//!
//! The same three dispatches as those of a hierarchical operator (`hierarchical.rs`), with receivers for rows. The twin is
//! [`Rectangle::multiply`], and each receiver adds its share of the sky.

use std::f32::consts::PI;

use hmatrix::Rectangle;

use crate::{
    Error, Gpu, Result, Timing,
    buffers::vec4,
    hierarchical::{Hierarchical, ScatterParams},
    kernels,
};

const FEWER: &str = "take fewer receivers or senders, or allow the rows a larger error";

/// Packed rows, ready for products.
pub struct LastGather {
    gpu: Gpu,
    rows: Hierarchical,
    irradiance: wgpu::Buffer,
    receivers: usize,
    senders: usize,
}

impl LastGather {
    /// Uploads packed rows. `sky` is the share of the sky that each receiver sees, cosine weighted: 1 is all of it.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if there is not a share a receiver, [`Error::TooLarge`].
    pub fn new(gpu: &Gpu, rows: &Rectangle, sky: &[f32]) -> Result<LastGather> {
        let (receivers, senders) = (rows.receivers(), rows.senders());
        if sky.len() != receivers {
            let what = format!("{receivers} receivers have {} shares of the sky; take both from one bake", sky.len());
            return Err(Error::Shape { what });
        }
        let factors: Vec<[f32; 4]> = sky.iter().map(|&share| [share, 0.0, 0.0, 1.0]).collect();
        let factors = gpu.storage("shares of the sky", &factors, FEWER)?;
        let irradiance = gpu.vectors("light of receivers", receivers, FEWER)?;
        let rows = Hierarchical::new(gpu, &rows.layout(), &factors, &irradiance)?;
        gpu.check()?;
        Ok(LastGather { gpu: gpu.clone(), rows, irradiance, receivers, senders })
    }

    /// Where to write what is sent, W/m², a vector a sender in their order, before [`LastGather::run`]. What stands behind
    /// them is not to be written.
    pub(crate) fn sent(&self) -> &wgpu::Buffer {
        &self.rows.x
    }

    /// Irradiance of the receivers, W/m², a vector each, after [`LastGather::run`].
    pub(crate) fn irradiance(&self) -> &wgpu::Buffer {
        &self.irradiance
    }

    /// The sky of all products from the next submission on: its radiance, W/(m² sr).
    pub(crate) fn set_sky(&self, radiance: [f32; 3]) {
        let sky = vec4(radiance.map(|l| PI * l), 0.0);
        let offset = std::mem::offset_of!(ScatterParams, sky) as u64;
        self.gpu.queue.write_buffer(&self.rows.params, offset, bytemuck::bytes_of(&sky));
    }

    /// One product.
    pub(crate) fn run(&self, encoder: &mut wgpu::CommandEncoder) {
        kernels::run(encoder, "last gather", &self.rows.product);
    }

    /// Number of receivers.
    pub fn receivers(&self) -> usize {
        self.receivers
    }

    /// Bytes of the rows on the device.
    pub fn bytes(&self) -> usize {
        self.rows.bytes
    }

    /// Irradiance of the receivers, W/m², from what senders send, W/m², and a sky of `radiance`, W/(m² sr).
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for another number of values than senders, [`Error::Device`].
    pub fn receive(&self, sent: &[[f32; 3]], radiance: [f32; 3]) -> Result<Vec<[f32; 3]>> {
        self.upload(sent)?;
        self.set_sky(radiance);
        let mut encoder = self.gpu.encoder();
        self.run(&mut encoder);
        let download = self.gpu.download(&mut encoder, self.irradiance(), self.receivers);
        let [irradiance] = self.gpu.finish(encoder, [download])?;
        Ok(irradiance)
    }

    /// How long a product takes: the median of `repeats` times, as [`crate::GpuRuntime::time_product`] counts.
    ///
    /// # Errors
    ///
    /// [`Error::Input`] for no repetitions or more than 4095, [`Error::Device`].
    pub fn time(&self, repeats: u32) -> Result<Timing> {
        let (milliseconds, by) = self.gpu.time(repeats, |encoder| self.run(encoder))?;
        Ok(Timing { milliseconds, bytes_read: self.rows.bytes_read, by })
    }

    fn upload(&self, sent: &[[f32; 3]]) -> Result<()> {
        if sent.len() != self.senders {
            let what =
                format!("{} values were given for {} senders; take both from one bake", sent.len(), self.senders);
            return Err(Error::Shape { what });
        }
        let sent: Vec<[f32; 4]> = sent.iter().map(|&light| vec4(light, 0.0)).collect();
        self.gpu.queue.write_buffer(self.sent(), 0, bytemuck::cast_slice(&sent));
        Ok(())
    }
}
