//! A bake on the GPU, and its frames.

use std::f32::consts::PI;

use glam::DVec3;
use radfile::{PackedOperator, Patches, PointRows, Rows, Transfer};
use scene::{Camera, LightRig, Scene};
use serde::Serialize;

use crate::{
    Error, Gpu, Parts, Result,
    buffers::vec4,
    emitters,
    gather::{Gather, Mixture, RowTables},
    lamp::{Lamps, Studio},
    operator::{Decode, Operator},
    patch_tables::PatchTables,
    picture::{FineTables, bounds},
    probe,
    shadows::{Points, Shadows},
};

/// How frames are made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Params {
    /// Points on each patch that direct light is averaged over.
    pub patch_samples: u32,
    /// Edge of a shadow map, texels. A map of a point on an area light has half of it.
    pub shadow_resolution: u32,
    /// Points on a quad, each with shadow maps of its own.
    pub light_samples: u32,
    /// Points on all emissive surfaces of the scene together.
    pub emitter_samples: u32,
    /// Samples along the edge of a pixel.
    pub pixel_detail: u32,
    /// Who decodes the operator.
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
    /// Who decodes the operator: never [`Decode::Auto`].
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
    /// Bytes of the packed operator.
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

/// A bake on the GPU.
pub struct GpuRuntime {
    gpu: Gpu,
    report: Report,
    studio: Studio,
    shadows: Shadows,
    patches: PatchTables,
    operator: Operator,
    gather: Gather,
    /// Receivers of the fine mesh, then the patches themselves.
    rows: RowTables,
    fine: FineTables,
    pixel_detail: u32,
}

impl GpuRuntime {
    /// Uploads a bake. `sky` is [`radfile::read_sky`].
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the parts are of different numbers of patches, [`Error::TooLarge`] and
    /// [`Error::Unsupported`] if the adapter cannot hold them, [`Error::Scene`] for a texture that cannot be decoded.
    pub fn new(
        gpu: &Gpu,
        scene: &Scene,
        patches: &Patches,
        packed: &PackedOperator,
        sky: &[f32],
        transfer: &Transfer,
        params: &Params,
    ) -> Result<GpuRuntime> {
        let n = patches.len();
        same_count("the packed operator", packed.packing.n as usize, n)?;
        same_count("the sky visibility", sky.len(), n)?;
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
        let runtime = GpuRuntime {
            report: Report {
                adapter: gpu.adapter().to_string(),
                decode: if sampled { Decode::Sampled } else { Decode::Stored },
                sampler_bias,
                patches: n,
                sample_points: n * params.patch_samples as usize,
                receivers: transfer.rows.len(),
                emitters: studio.emitters.len(),
                operator_bytes: packed.size_in_bytes(),
            },
            studio,
            shadows: Shadows::new(gpu, &scene.mesh, params.shadow_resolution)?,
            patches: PatchTables::new(gpu, patches, sky, params.patch_samples, params.seed)?,
            operator: Operator::new(gpu, packed, sampled)?,
            gather: Gather::new(gpu),
            rows: RowTables::new(gpu, &with_patches(&transfer.rows, n), n)?,
            fine: FineTables::new(gpu, scene, patches, transfer)?,
            pixel_detail: params.pixel_detail,
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
        let lamps = self.studio.lamps(rig)?;
        let mut encoder = self.gpu.encoder();
        let h0 = self.light_patches(&mut encoder, &lamps, &[])?;
        let download = self.gpu.download(&mut encoder, &h0, self.patches.count);
        let [direct] = self.gpu.finish(encoder, [download])?;
        Ok(direct)
    }

    /// Irradiance of the patches after one and more bounces of the direct irradiance `h0`.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for another number of values than patches, [`Error::Device`].
    pub fn patch_indirect(&self, h0: &[[f32; 3]]) -> Result<Vec<[f32; 3]>> {
        same_count("the direct light", h0.len(), self.patches.count)?;
        let mut encoder = self.gpu.encoder();
        let h0 = self.upload("direct light of patches", h0)?;
        let h = self.bounce(&mut encoder, &h0)?;
        let download = self.gpu.download(&mut encoder, &h, self.patches.count);
        let [indirect] = self.gpu.finish(encoder, [download])?;
        Ok(indirect)
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
        self.gather_into(&mut encoder, &rows, Mixture { share: 1.0, sky: [0.0; 3] }, &light, &out);
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
        let lamps = self.studio.lamps(rig)?;
        let mut encoder = self.gpu.encoder();
        let h0 = self.light_patches(&mut encoder, &lamps, &[])?;
        let h = self.bounce(&mut encoder, &h0)?;
        let received = self.rows.vectors(&self.gpu, "light of receivers")?;
        self.gather_into(&mut encoder, &self.rows, Mixture { share: 1.0, sky: [0.0; 3] }, &h, &received);
        let n = self.patches.count;
        let downloads = [(&h0, n), (&h, n), (&received, self.report.receivers)];
        let downloads = downloads.map(|(buffer, count)| self.gpu.download(&mut encoder, buffer, count));
        let [direct, indirect, receivers] = self.gpu.finish(encoder, downloads)?;
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
        let tables = RowTables::new(gpu, rows.rows(), self.patches.count)?;
        let wide = |values: &[[f32; 3]], w| values.iter().map(|&v| vec4(v, w)).collect::<Vec<_>>();
        let points = Points {
            position: gpu.storage("points", &wide(position, 1.0), "take the points in parts")?,
            normal: gpu.storage("normals of points", &wide(normal, 0.0), "take the points in parts")?,
            irradiance: tables.vectors(gpu, "direct light of points")?,
            count,
        };
        let mut encoder = gpu.encoder();
        let sky = lamps.sky.map(|l| PI * l);
        if let PointRows::Interpolated(_) = rows {
            let nothing = self.patches.vectors(gpu, "no light")?;
            self.gather_into(&mut encoder, &tables, Mixture { share: 0.0, sky }, &nothing, &points.irradiance);
        }
        let h0 = self.light_patches(&mut encoder, &lamps, &[&points])?;
        let h = self.bounce(&mut encoder, &h0)?;
        let indirect = tables.vectors(gpu, "indirect light of points")?;
        let light = match rows {
            PointRows::Interpolated(_) => h,
            PointRows::Gathered { .. } => {
                let b = self.patches.vectors(gpu, "radiosity of patches")?;
                self.patches.radiosity(gpu, &mut encoder, [&h0, &h], &b);
                b
            }
        };
        self.gather_into(&mut encoder, &tables, Mixture { share: 1.0, sky: [0.0; 3] }, &light, &indirect);
        let downloads = [&points.irradiance, &indirect].map(|b| gpu.download(&mut encoder, b, count));
        let [mut direct, indirect] = gpu.finish(encoder, downloads)?;
        if let PointRows::Gathered { sky: seen, .. } = rows {
            for (e, seen) in direct.iter_mut().zip(seen) {
                *e = std::array::from_fn(|c| e[c] + sky[c] * seen);
            }
        }
        Ok(PointLight { direct, indirect })
    }

    /// The picture that a camera takes: linear RGB radiance, W/(m² sr), row by row from the top.
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
        let mut encoder = gpu.encoder();
        let seen = fine.look(gpu, &mut encoder, &camera, [width, height], self.pixel_detail)?;
        let pixels: &[&Points] = if parts.direct { &[&seen.points] } else { &[] };
        let h = if parts.indirect {
            let h0 = self.light_patches(&mut encoder, &lamps, pixels)?;
            self.bounce(&mut encoder, &h0)?
        } else {
            self.shadows.light(gpu, &mut encoder, &lamps.lamps, pixels);
            self.patches.vectors(gpu, "no light")?
        };
        if !parts.direct {
            lamps.sky = [0.0; 3];
        }
        let mixture = Mixture { share: 1.0, sky: lamps.sky.map(|l| PI * l) };
        let received = self.rows.vectors(gpu, "light of receivers")?;
        self.gather_into(&mut encoder, &self.rows, mixture, &h, &received);
        let glow = parts.direct && rig.use_scene_emission;
        let radiance = fine.shade(gpu, &mut encoder, &seen, &received, glow, lamps.sky)?;
        let download = gpu.download(&mut encoder, &radiance, width as usize * height as usize);
        let [picture] = gpu.finish(encoder, [download])?;
        Ok(picture)
    }

    /// H⁰ of the patches; the lamps light `others` as well.
    fn light_patches(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        lamps: &Lamps,
        others: &[&Points],
    ) -> Result<wgpu::Buffer> {
        let points = &self.patches.points;
        encoder.clear_buffer(&points.irradiance, 0, None);
        let targets = [&[points][..], others].concat();
        self.shadows.light(&self.gpu, encoder, &lamps.lamps, &targets);
        let h0 = self.patches.vectors(&self.gpu, "direct light of patches")?;
        self.patches.mean(&self.gpu, encoder, lamps.sky.map(|l| PI * l), &h0);
        Ok(h0)
    }

    /// H of the patches after one and more bounces.
    fn bounce(&self, encoder: &mut wgpu::CommandEncoder, h0: &wgpu::Buffer) -> Result<wgpu::Buffer> {
        let x = self.operator.senders(&self.gpu)?;
        let h = self.patches.vectors(&self.gpu, "indirect light of patches")?;
        self.patches.send(&self.gpu, encoder, h0, &x);
        self.operator.multiply(&self.gpu, encoder, &self.patches.factors, &x, &h);
        Ok(h)
    }

    fn gather_into(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        rows: &RowTables,
        mixture: Mixture,
        light: &wgpu::Buffer,
        out: &wgpu::Buffer,
    ) {
        self.gather.run(&self.gpu, encoder, rows, mixture, light, &self.patches.sky, out);
    }

    fn upload(&self, what: &'static str, values: &[[f32; 3]]) -> Result<wgpu::Buffer> {
        let wide: Vec<[f32; 4]> = values.iter().map(|&v| vec4(v, 0.0)).collect();
        self.gpu.storage(what, &wide, "bake fewer patches")
    }
}

/// Whether the hardware decodes the operator, and what the probe of it said.
fn decide(gpu: &Gpu, packed: &PackedOperator, decode: Decode) -> Result<(bool, Option<f64>)> {
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

/// Rows, followed by one for each patch that names it alone.
fn with_patches(rows: &Rows, patches: usize) -> Rows {
    let mut all = rows.clone();
    if all.row_start.is_empty() {
        all.row_start.push(0);
    }
    for patch in 0..patches as u32 {
        all.patch.push(patch);
        all.weight.push(1.0);
        all.row_start.push(all.patch.len() as u32);
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
    use radfile::{BlockFormat, Packing, ValueMap};

    use super::*;

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
        assert_eq!(decide(&gpu, &packed, Decode::Auto).unwrap(), (false, None));
        let text = Operator::new(&gpu, &packed, true).err().expect("no feature").to_string();
        assert!(text.contains("lacks block-compressed textures"), "{text}");
        assert!(text.ends_with("or use --backend cpu"), "{text}");
    }
}
