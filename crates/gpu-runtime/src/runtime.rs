//! A bake on the GPU, and its frames.

use std::{
    borrow::Cow,
    f32::consts::PI,
    sync::{Mutex, MutexGuard, PoisonError},
};

use glam::DVec3;
use hmatrix::Rectangle;
use radfile::{Elements, Patches, PointRows, Rows, Transfer, Weights};
use scene::{Camera, LightRig, Scene};
use serde::Serialize;

use crate::{
    Error, Gpu, LastGather, Packed, Parts, Result, Timing,
    buffers::vec4,
    emitters,
    frame::FrameBuffers,
    gather::{Gather, Mixture, RowTables},
    lamp::{Lamps, Studio},
    operator::Decode,
    packed::Product,
    patch_tables::PatchTables,
    picture::{Canvas, FineTables, bounds},
    probe,
    shadows::{Points, Shadows},
};

/// How frames are made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Params {
    /// Points on each patch that direct light is averaged over, where its elements have none of their own.
    pub patch_samples: u32,
    /// Edge of a shadow map, texels. A map of a point on an area light has half of it.
    pub shadow_resolution: u32,
    /// Points on a quad, each with shadow maps of its own.
    pub light_samples: u32,
    /// Points on all emissive surfaces of the scene together.
    pub emitter_samples: u32,
    /// Samples along the edge of a pixel.
    pub pixel_detail: u32,
    /// Who decodes an operator of textures.
    pub decode: Decode,
    /// Scrambling of sample points; the default is the CPU run time's.
    pub seed: u32,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            patch_samples: 32,
            shadow_resolution: 1024,
            light_samples: 16,
            emitter_samples: 64,
            pixel_detail: 2,
            decode: Decode::Auto,
            seed: 0x9a7c,
        }
    }
}

/// What was found and decided when the bake was uploaded.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name, interface and driver of the adapter.
    pub adapter: String,
    /// Who decodes the operator: never [`Decode::Auto`]; hierarchical blocks are [`Decode::Stored`].
    pub decode: Decode,
    /// Relative error of the product for uniform light that the hardware's decoding would cause; none if it was not
    /// probed.
    pub sampler_bias: Option<f64>,
    /// Patches.
    pub patches: usize,
    /// Points on them.
    pub sample_points: usize,
    /// Receivers of the fine mesh.
    pub receivers: usize,
    /// Samples of the scene's emissive surfaces.
    pub emitters: usize,
    /// Bytes of the operator on the device.
    pub operator_bytes: usize,
}

/// The light of a frame, W/m².
#[derive(Clone, Debug, PartialEq)]
pub struct Relit {
    /// Direct irradiance H⁰ of the patches.
    pub direct: Vec<[f32; 3]>,
    /// Irradiance of the patches after one and more bounces.
    pub indirect: Vec<[f32; 3]>,
    /// The same at the receivers of the fine mesh.
    pub receivers: Vec<[f32; 3]>,
}

/// Irradiance at points, W/m².
#[derive(Clone, Debug, PartialEq)]
pub struct PointLight {
    /// Without any bounce.
    pub direct: Vec<[f32; 3]>,
    /// After one and more bounces.
    pub indirect: Vec<[f32; 3]>,
}

/// The parts of a bake but for the operator; they must fit together.
#[derive(Clone, Copy)]
pub struct Bake<'a> {
    /// Mesh and materials.
    pub scene: &'a Scene,
    /// Its patches.
    pub patches: &'a Patches,
    /// What they are parted into.
    pub elements: &'a Elements,
    /// What each patch sees of the sky, [`radfile::read_sky`].
    pub sky: &'a [f32],
    /// The receivers.
    pub transfer: &'a Transfer,
}

/// A bake on the GPU.
pub struct GpuRuntime {
    gpu: Gpu,
    report: Report,
    studio: Studio,
    shadows: Shadows,
    patches: PatchTables,
    gather: Gather,
    /// Receivers of the fine mesh, then the patches themselves.
    rows: RowTables,
    fine: FineTables,
    pixel_detail: u32,
    /// One frame at a time.
    frame: Mutex<FrameBuffers>,
    /// That of the last picture; a frame is locked before.
    canvas: Mutex<Option<Canvas>>,
}

impl GpuRuntime {
    /// Uploads a bake.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the parts are of different numbers of patches, [`Error::TooLarge`] and
    /// [`Error::Unsupported`] if the adapter cannot hold them, [`Error::Scene`] for a texture that cannot be decoded.
    pub fn new<'a>(gpu: &Gpu, bake: &Bake, packed: impl Into<Packed<'a>>, params: &Params) -> Result<GpuRuntime> {
        let &Bake { scene, patches, elements, sky, transfer } = bake;
        let (n, packed) = (patches.len(), packed.into());
        same_count("the packed operator", packed.patches(), n)?;
        same_count("the sky visibility", sky.len(), n)?;
        same_count("the elements", elements.patches(), n)?;
        let shape = |e: radfile::Error| Error::Shape { what: e.to_string() };
        transfer.check(n, scene.mesh.triangles.len()).map_err(shape)?;
        for (name, value) in [("patch_samples", params.patch_samples), ("pixel_detail", params.pixel_detail)] {
            if value == 0 {
                return Err(Error::Input { what: format!("{name} is 0, expected at least 1") });
            }
        }
        let (sampled, sampler_bias) = decide(gpu, packed, params.decode)?;
        let (low, high) = bounds(&scene.mesh.positions);
        let studio = Studio {
            origin: DVec3::from(scene.mesh.origin),
            bounds: [low, high],
            emitters: emitters::sample(scene, params.emitter_samples, params.seed)?,
            light_samples: params.light_samples,
            resolution: params.shadow_resolution,
        };
        let tables = PatchTables::new(gpu, patches, elements, sky, &scene.mesh, params.patch_samples)?;
        let h = tables.vectors(gpu, "indirect light of patches")?;
        let product = Product::new(gpu, packed, sampled, &tables.factors, h)?;
        let (gather, operator_bytes) = (Gather::new(gpu), product.bytes);
        let (weights, last) = weights(gpu, transfer, elements)?;
        let rows = RowTables::new(gpu, &with_patches(&weights, n), n)?;
        let frame = FrameBuffers::new(gpu, &tables, product, &gather, &rows, transfer.receivers(), last)?;
        let runtime = GpuRuntime {
            report: Report {
                adapter: gpu.adapter().to_string(),
                decode: if sampled { Decode::Sampled } else { Decode::Stored },
                sampler_bias,
                patches: n,
                sample_points: tables.points.count,
                receivers: transfer.receivers(),
                emitters: studio.emitters.len(),
                operator_bytes,
            },
            studio,
            shadows: Shadows::new(gpu, &scene.mesh, params.shadow_resolution)?,
            patches: tables,
            gather,
            rows,
            fine: FineTables::new(gpu, scene, patches, transfer)?,
            pixel_detail: params.pixel_detail,
            frame: Mutex::new(frame),
            canvas: Mutex::default(),
            gpu: gpu.clone(),
        };
        gpu.check()?;
        Ok(runtime)
    }

    /// What was found and decided at the start.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Direct irradiance H⁰ of the patches.
    ///
    /// # Errors
    ///
    /// [`Error::Input`] for a light that cannot be used, [`Error::Device`].
    pub fn patch_direct(&self, rig: &LightRig) -> Result<Vec<[f32; 3]>> {
        let (mut frame, lamps) = (self.frame(), self.studio.lamps(rig)?);
        let mut encoder = self.gpu.encoder();
        self.light_patches(&mut encoder, &mut frame, &lamps, &[]);
        let [way_back, ..] = &frame.back;
        way_back.copy(&mut encoder, &frame.h0);
        let [direct] = self.gpu.finish(encoder, [way_back])?;
        Ok(direct)
    }

    /// Irradiance of the patches after one and more bounces of the direct irradiance `h0`.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for another number of values than patches, [`Error::Device`].
    pub fn patch_indirect(&self, h0: &[[f32; 3]]) -> Result<Vec<[f32; 3]>> {
        same_count("the direct light", h0.len(), self.patches.count)?;
        let (frame, mut encoder) = (self.frame(), self.gpu.encoder());
        frame.set_direct(&self.gpu, h0);
        frame.bounce(&mut encoder);
        let [_, way_back, _] = &frame.back;
        way_back.copy(&mut encoder, &frame.product.h);
        let [indirect] = self.gpu.finish(encoder, [way_back])?;
        Ok(indirect)
    }

    /// How long the product alone takes, all its dispatches, for the direct irradiance `h0`: the median of `repeats`
    /// times, each of one product or, if that is short, the mean of several. They follow each other in one submission,
    /// so an operator that fits the device's caches is read from there.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for another number of values than patches, [`Error::Input`] for no repetitions or more than
    /// 4095, [`Error::Device`].
    pub fn time_product(&self, h0: &[[f32; 3]], repeats: u32) -> Result<Timing> {
        same_count("the direct light", h0.len(), self.patches.count)?;
        let (gpu, frame, mut encoder) = (&self.gpu, self.frame(), self.gpu.encoder());
        frame.set_direct(gpu, h0);
        frame.send(&mut encoder);
        gpu.submit(encoder, std::iter::empty())?;
        let (milliseconds, by) = gpu.time(repeats, |encoder| frame.product.run(encoder))?;
        Ok(Timing { milliseconds, bytes_read: frame.product.bytes_read, by })
    }

    /// Irradiance at the receivers of `rows` from irradiance of the patches.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for rows or values that do not fit the patches, [`Error::TooLarge`], [`Error::Device`].
    pub fn gather(&self, rows: &Rows, patch_light: &[[f32; 3]]) -> Result<Vec<[f32; 3]>> {
        same_count("the light of the patches", patch_light.len(), self.patches.count)?;
        let rows = RowTables::new(&self.gpu, rows, self.patches.count)?;
        let out = rows.vectors(&self.gpu, "light of receivers")?;
        let light = self.upload("light of patches", patch_light)?;
        let mut encoder = self.gpu.encoder();
        self.gather_into(&mut encoder, &rows, Mixture::LIGHT, &light, &out);
        let download = self.gpu.download(&mut encoder, &out, rows.count);
        let [received] = self.gpu.finish(encoder, [download])?;
        Ok(received)
    }

    /// A whole frame in one submission: direct light, all bounces, transfer.
    ///
    /// # Errors
    ///
    /// As [`GpuRuntime::patch_direct`].
    pub fn relight(&self, rig: &LightRig) -> Result<Relit> {
        let (gpu, mut frame, lamps) = (&self.gpu, self.frame(), self.studio.lamps(rig)?);
        let mut encoder = gpu.encoder();
        self.light_patches(&mut encoder, &mut frame, &lamps, &[]);
        frame.bounce(&mut encoder);
        frame.gather(gpu, &mut encoder, &self.rows, Mixture::LIGHT);
        for (way_back, from) in frame.back.iter().zip([&frame.h0, &frame.product.h, &frame.received]) {
            way_back.copy(&mut encoder, from);
        }
        let [direct, indirect, receivers] = gpu.finish(encoder, frame.back.each_ref())?;
        Ok(Relit { direct, indirect, receivers })
    }

    /// Light at points on surfaces, local axes: direct by shadow maps, the sky and all bounces by `rows`; a last
    /// gather adds a bounce to those of the operator.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if there are not as many normals and rows as positions, otherwise as [`GpuRuntime::relight`].
    pub fn relight_points(
        &self,
        rig: &LightRig,
        position: &[[f32; 3]],
        normal: &[[f32; 3]],
        rows: &PointRows,
    ) -> Result<PointLight> {
        let count = position.len();
        if normal.len() != count || rows.rows().len() != count {
            let (n, r) = (normal.len(), rows.rows().len());
            return Err(Error::Shape { what: format!("{count} points have {n} normals and {r} rows of weights") });
        }
        if let PointRows::Gathered { sky, .. } = rows
            && sky.len() != count
        {
            return Err(Error::Shape { what: format!("{count} points have {} shares of the sky", sky.len()) });
        }
        let (gpu, lamps) = (&self.gpu, self.studio.lamps(rig)?);
        let senders = match rows {
            PointRows::Interpolated(_) => self.patches.count,
            PointRows::Gathered { .. } => self.patches.count + self.patches.elements,
        };
        let tables = RowTables::new(gpu, rows.rows(), senders)?;
        let points = Points::new(gpu, position, normal)?;
        let (mut frame, mut encoder) = (self.frame(), gpu.encoder());
        let sky = lamps.sky.map(|l| PI * l);
        if let PointRows::Interpolated(_) = rows {
            let nothing = self.patches.vectors(gpu, "no light")?;
            self.gather_into(&mut encoder, &tables, Mixture { share: 0.0, sky }, &nothing, &points.irradiance);
        }
        self.light_patches(&mut encoder, &mut frame, &lamps, &[&points]);
        frame.bounce(&mut encoder);
        let indirect = tables.vectors(gpu, "indirect light of points")?;
        let light = match rows {
            PointRows::Interpolated(_) => &frame.product.h,
            PointRows::Gathered { .. } => {
                frame.radiosity(&mut encoder);
                &frame.b
            }
        };
        self.gather_into(&mut encoder, &tables, Mixture::LIGHT, light, &indirect);
        let downloads = [&points.irradiance, &indirect].map(|b| gpu.download(&mut encoder, b, count));
        let [mut direct, indirect] = gpu.finish(encoder, downloads)?;
        if let PointRows::Gathered { sky, .. } = rows {
            add_sky(&mut direct, sky, lamps.sky);
        }
        Ok(PointLight { direct, indirect })
    }

    /// Light at the bake's own receivers, of which `transfer` is: direct by shadow maps, all else as [`GpuRuntime::relight`].
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for the receivers of another bake, otherwise as [`GpuRuntime::relight`].
    pub fn relight_receivers(&self, rig: &LightRig, transfer: &Transfer) -> Result<PointLight> {
        let (count, expected) = (transfer.receivers(), self.report.receivers);
        if count != expected {
            return Err(Error::Shape { what: format!("there are {count} receivers, the bake has {expected}") });
        }
        let sky = match &transfer.weights {
            Weights::Gathered(gathered) => &gathered.sky,
            Weights::Interpolated(rows) => {
                let rows = PointRows::Interpolated(rows.clone());
                return self.relight_points(rig, &transfer.position, &transfer.normal, &rows);
            }
        };
        let (gpu, lamps) = (&self.gpu, self.studio.lamps(rig)?);
        let points = Points::new(gpu, &transfer.position, &transfer.normal)?;
        let (mut frame, mut encoder) = (self.frame(), gpu.encoder());
        self.light_patches(&mut encoder, &mut frame, &lamps, &[&points]);
        frame.bounce(&mut encoder);
        frame.gather(gpu, &mut encoder, &self.rows, Mixture::LIGHT);
        let downloads = [&points.irradiance, &frame.received].map(|b| gpu.download(&mut encoder, b, count));
        let [mut direct, indirect] = gpu.finish(encoder, downloads)?;
        add_sky(&mut direct, sky, lamps.sky);
        Ok(PointLight { direct, indirect })
    }

    /// The picture that a camera takes: linear RGB radiance, W/(m² sr), row by row from the top. What it is made on
    /// stays on the device for the next one of this size, about 150 bytes a sample.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the bake has no fine mesh, [`Error::Input`] for a camera or light that cannot be used,
    /// [`Error::TooLarge`], [`Error::Device`].
    pub fn render(
        &self,
        rig: &LightRig,
        camera: &Camera,
        width: u32,
        height: u32,
        parts: Parts,
    ) -> Result<Vec<[f32; 3]>> {
        let (gpu, fine, mut lamps) = (&self.gpu, &self.fine, self.studio.lamps(rig)?);
        let camera = fine.camera(camera, self.studio.origin, [width, height])?;
        let (mut frame, mut encoder) = (self.frame(), gpu.encoder());
        let (mut kept, size) = (self.canvas.lock().unwrap_or_else(PoisonError::into_inner), [width, height]);
        let canvas = match kept.take().filter(|canvas| canvas.is_for(size)) {
            Some(canvas) => canvas,
            None => fine.canvas(gpu, size, self.pixel_detail, &frame.received)?,
        };
        let canvas = kept.insert(canvas);
        fine.look(gpu, &mut encoder, &camera, canvas);
        let pixels: &[&Points] = if parts.direct { &[&canvas.points] } else { &[] };
        if parts.indirect {
            self.light_patches(&mut encoder, &mut frame, &lamps, pixels);
            frame.bounce(&mut encoder);
        } else {
            self.shadows.light(gpu, &mut encoder, &lamps.lamps, pixels, &mut frame.lamps);
            encoder.clear_buffer(&frame.product.h, 0, None);
        }
        if !parts.direct {
            lamps.sky = [0.0; 3];
        }
        let mixture = Mixture { share: 1.0, sky: lamps.sky.map(|l| PI * l) };
        frame.gather(gpu, &mut encoder, &self.rows, mixture);
        let glow = parts.direct && rig.use_scene_emission;
        canvas.shade(gpu, &mut encoder, glow, lamps.sky);
        canvas.back.copy(&mut encoder, &canvas.radiance);
        let [picture] = gpu.finish(encoder, [&canvas.back])?;
        Ok(picture)
    }

    /// The buffers of a frame, once nobody else uses them. A frame sets all that it reads.
    fn frame(&self) -> MutexGuard<'_, FrameBuffers> {
        self.frame.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// H⁰ of the patches; the lamps light `others` as well.
    fn light_patches(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &mut FrameBuffers,
        lamps: &Lamps,
        others: &[&Points],
    ) {
        let points = &self.patches.points;
        encoder.clear_buffer(&points.irradiance, 0, None);
        let targets = [&[points][..], others].concat();
        self.shadows.light(&self.gpu, encoder, &lamps.lamps, &targets, &mut frame.lamps);
        frame.mean(&self.gpu, encoder, &self.patches, lamps.sky.map(|l| PI * l));
    }

    fn gather_into(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        rows: &RowTables,
        mixture: Mixture,
        light: &wgpu::Buffer,
        out: &wgpu::Buffer,
    ) {
        let gather = self.gather.prepare(&self.gpu, rows, light, &self.patches.sky, out);
        gather.run(&self.gpu, encoder, &mixture.params(rows));
    }

    fn upload(&self, what: &'static str, values: &[[f32; 3]]) -> Result<wgpu::Buffer> {
        let wide: Vec<[f32; 4]> = values.iter().map(|&v| vec4(v, 0.0)).collect();
        self.gpu.storage(what, &wide, "bake fewer patches")
    }
}

/// Whether the hardware decodes the operator, and what the probe of it said.
fn decide(gpu: &Gpu, packed: Packed, decode: Decode) -> Result<(bool, Option<f64>)> {
    let Packed::Textures(packed) = packed else { return Ok((false, None)) };
    match decode {
        Decode::Sampled => Ok((true, None)),
        Decode::Stored => Ok((false, None)),
        Decode::Auto if !gpu.has_block_textures() => Ok((false, None)),
        Decode::Auto => {
            let bias = probe::sampler_bias(gpu, packed)?;
            Ok((bias.abs() <= probe::GOOD, Some(bias)))
        }
    }
}

/// Adds what each receiver sees of a sky of `radiance`.
fn add_sky(direct: &mut [[f32; 3]], seen: &[f32], radiance: [f32; 3]) {
    for (e, seen) in direct.iter_mut().zip(seen) {
        *e = std::array::from_fn(|c| e[c] + PI * radiance[c] * seen);
    }
}

/// Rows of the receivers, empty where they gather by the other.
fn weights<'a>(gpu: &Gpu, transfer: &'a Transfer, elements: &Elements) -> Result<(Cow<'a, Rows>, Option<LastGather>)> {
    let gathered = match &transfer.weights {
        Weights::Interpolated(rows) => return Ok((Cow::Borrowed(rows), None)),
        Weights::Gathered(gathered) => gathered,
    };
    let rows = Rectangle::from_bytes(&gathered.stream).map_err(|e| Error::Shape { what: e.to_string() })?;
    if rows.senders() != elements.senders() {
        let (found, expected) = (rows.senders(), elements.senders());
        let what = format!("the receivers gather from {found} senders, the bake has {expected}; run transfer again");
        return Err(Error::Shape { what });
    }
    let empty = Rows { row_start: vec![0; transfer.receivers() + 1], ..Rows::default() };
    Ok((Cow::Owned(empty), Some(LastGather::new(gpu, &rows, &gathered.sky)?)))
}

/// Rows, followed by one for each patch that names it alone.
fn with_patches(rows: &Rows, patches: usize) -> Rows {
    let mut all = rows.clone();
    if all.row_start.is_empty() {
        all.row_start.push(0);
    }
    for patch in 0..patches as u32 {
        all.sender.push(patch);
        all.weight.push(1.0);
        all.row_start.push(all.sender.len() as u32);
    }
    all
}

fn same_count(part: &str, found: usize, patches: usize) -> Result<()> {
    if found == patches {
        return Ok(());
    }
    let what = format!("{part} is of {found} patches, the bake has {patches}; all parts must come from one bake");
    Err(Error::Shape { what })
}

#[cfg(test)]
mod tests {
    use radfile::{BlockFormat, PackedOperator, Packing, ValueMap};

    use super::*;
    use crate::operator::Operator;

    #[test]
    fn without_block_textures_the_kernel_decodes_and_a_forced_sampler_is_refused() {
        if std::env::var("ALLBOUNCE_GPU").as_deref() == Ok("skip") {
            println!("gpu: skipped, ALLBOUNCE_GPU=skip");
            return;
        }
        let gpu = Gpu::with_features(|_| true, wgpu::Features::empty()).expect("an adapter");
        let (format, map) = (BlockFormat::Bc4, ValueMap::Sqrt);
        let packing = Packing { n: 4, channels: 1, bounces: None, format, map, scale: [1.0; 3], tile: 4, tiles: 1 };
        let packed = PackedOperator {
            half: None,
            packing,
            blocks: vec![0; 8].into(),
            outlier_start: vec![0; 5].into(),
            outlier_column: vec![].into(),
            outlier_value: vec![].into(),
        };
        assert_eq!(decide(&gpu, (&packed).into(), Decode::Auto).unwrap(), (false, None));
        let text = Operator::new(&gpu, &packed, true).err().expect("no feature").to_string();
        assert!(text.contains("lacks block-compressed textures"), "{text}");
        assert!(text.ends_with("or use --backend cpu"), "{text}");
    }
}
