//! What frames work on, made once: a later frame makes no buffers for it.

use std::f32::consts::PI;

use crate::{
    Gpu, LastGather, Result,
    buffers::{Download, vec4},
    gather::{Gather, Mixture, RowTables},
    kernels::{Dispatch, Parametric},
    packed::Product,
    patch_tables::{ElementLightParams, PatchTables},
};

/// Vectors of patches and receivers, and the kernels that are bound to them. One frame at a time.
pub struct FrameBuffers {
    /// Direct irradiance H⁰ of the patches.
    pub h0: wgpu::Buffer,
    /// Radiosity of patches and elements, the senders of the last gather.
    pub b: wgpu::Buffer,
    /// All bounces, and H.
    pub product: Product,
    /// Irradiance of the receivers of the fine mesh.
    pub received: wgpu::Buffer,
    element_light: Parametric,
    mean: Parametric,
    send: Dispatch,
    radiosity: Dispatch,
    gather: Parametric,
    /// Where receivers gather from all that they see.
    last: Option<LastGather>,
    /// One for each lamp of the frame that had most.
    pub lamps: Vec<wgpu::Buffer>,
    /// Ways back of H⁰, of H, and of the light of receivers.
    pub back: [Download; 3],
}

impl FrameBuffers {
    /// `rows` are the receivers and, behind them, the patches; the first `receivers` of them are read back, and those of
    /// `last` take its light instead. `product` has the vectors x and H.
    pub fn new(
        gpu: &Gpu,
        patches: &PatchTables,
        product: Product,
        gather: &Gather,
        rows: &RowTables,
        receivers: usize,
        last: Option<LastGather>,
    ) -> Result<FrameBuffers> {
        let element_h0 = patches.element_vectors(gpu, "direct light of elements")?;
        let h0 = patches.vectors(gpu, "direct light of patches")?;
        let b = match &last {
            Some(last) => last.sent().clone(),
            None => patches.sender_vectors(gpu, "radiosity of patches and elements")?,
        };
        let received = rows.vectors(gpu, "light of receivers")?;
        Ok(FrameBuffers {
            element_light: patches.element_light(gpu, &element_h0),
            mean: gather.prepare(gpu, &patches.means, &element_h0, &patches.element_sky, &h0),
            radiosity: patches.radiosity(gpu, [&element_h0, &product.h], &b),
            send: patches.send(gpu, &h0, &product.x),
            gather: gather.prepare(gpu, rows, &product.h, &patches.sky, &received),
            last,
            lamps: Vec::new(),
            back: [patches.count, patches.count, receivers].map(|count| gpu.way_back(count)),
            h0,
            b,
            received,
            product,
        })
    }

    /// Sets H⁰.
    pub fn set_direct(&self, gpu: &Gpu, h0: &[[f32; 3]]) {
        let wide: Vec<[f32; 4]> = h0.iter().map(|&v| vec4(v, 0.0)).collect();
        gpu.queue.write_buffer(&self.h0, 0, bytemuck::cast_slice(&wide));
    }

    /// H⁰ of elements and patches from the light of the sample points; `sky` is π L.
    pub fn mean(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, patches: &PatchTables, sky: [f32; 3]) {
        self.element_light.run(gpu, encoder, &ElementLightParams { sky: vec4(sky, 0.0) });
        self.mean.run(gpu, encoder, &Mixture::LIGHT.params(&patches.means));
    }

    /// B of patches and elements from H⁰ of the elements and H of the patches.
    pub fn radiosity(&self, encoder: &mut wgpu::CommandEncoder) {
        self.radiosity.run(encoder);
    }

    /// x from H⁰.
    pub fn send(&self, encoder: &mut wgpu::CommandEncoder) {
        self.send.run(encoder);
    }

    /// H from H⁰.
    pub fn bounce(&self, encoder: &mut wgpu::CommandEncoder) {
        self.send(encoder);
        self.product.run(encoder);
    }

    /// Light of the receivers from H and, where they gather, from H⁰ of the elements.
    pub fn gather(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, rows: &RowTables, mixture: Mixture) {
        self.gather.run(gpu, encoder, &mixture.params(rows));
        if let Some(last) = &self.last {
            self.radiosity(encoder);
            last.set_sky(mixture.sky.map(|e| e / PI));
            last.run(encoder);
            let from = last.irradiance();
            encoder.copy_buffer_to_buffer(from, 0, &self.received, 0, last.receivers() as u64 * 16);
        }
    }
}
