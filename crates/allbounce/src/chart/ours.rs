//! Allbounce: all bounces in hierarchical blocks, receivers that gather from elements or interpolate between patches.

use radfile::{Container, Elements, Patches, Progress, Rows};
use reference::rivals::Rival;
use relight::{Bounces, Operator, PatchSamples, Receivers, Relighter};
use scene::LightRig;
use transfer::{GatherParams, Senders};

use super::{
    baked::{Dense, step},
    ground::Ground,
    judge::Judge,
};
use crate::{numbers::percent, stage::kept};

/// A setting that gathers.
struct Gather {
    patches: u32,
    /// Patches of the bake by which they are adaptive.
    pilot: Option<u32>,
    /// Error that packing the operator may cause.
    operator: f64,
    /// Rays of each receiver, and error that packing its row may cause.
    rays: u32,
    rows: f64,
}

const fn coarse(patches: u32, operator: f64) -> Gather {
    Gather { patches, pilot: None, operator, rays: 1024, rows: 0.01 }
}

const fn fine(patches: u32, pilot: Option<u32>) -> Gather {
    Gather { patches, pilot, operator: 0.002, rays: 8192, rows: 0.002 }
}

const GATHERED: [Gather; 12] = [
    coarse(100, 0.005),
    coarse(200, 0.005),
    coarse(500, 0.005),
    coarse(1000, 0.005),
    coarse(2500, 0.005),
    coarse(1000, 0.02),
    coarse(1000, 0.05),
    fine(2500, None),
    fine(5000, None),
    fine(10_000, None),
    fine(2500, Some(2500)),
    fine(5000, Some(2500)),
];
/// Patches and error of packing of each entry that interpolates.
const INTERPOLATED: [(u32, f64); 5] = [(100, 0.005), (200, 0.005), (500, 0.005), (1000, 0.005), (2500, 0.005)];
/// Points of a patch without elements, and rays from each point of a patch to every area light: patches are many, and each
/// has dozens of points.
const SAMPLES: PatchSamples = PatchSamples { points: 16, area: 1 };

/// A bake, ready for frames of given receivers. The paper's method is one, too.
pub struct Bake<'a> {
    name: String,
    relighter: Relighter<'a>,
    bounces: Bounces<'a>,
    receivers: Receivers<'a>,
    bytes: usize,
}

/// The parts of a bake.
pub struct Parts<'a> {
    pub patches: &'a Patches,
    pub elements: &'a Elements,
    /// What each patch sees of the sky.
    pub sky: &'a [f32],
    pub operator: &'a Operator<'a>,
    pub receivers: Receivers<'a>,
    /// Bytes of the receivers' rows.
    pub bytes_of_rows: usize,
}

impl<'a> Bake<'a> {
    pub fn new(name: String, ground: &Ground<'a>, parts: Parts<'a>) -> anyhow::Result<Bake<'a>> {
        let Parts { patches, elements, sky, operator, receivers, bytes_of_rows } = parts;
        let setting = ground.setting;
        let relighter = Relighter::new(setting.scene, setting.rays, patches, elements, operator, sky)?;
        let bytes = operator.size_in_bytes() + bytes_of_rows + tables(elements);
        Ok(Bake { name, relighter, bounces: Bounces::new(patches, operator), receivers, bytes })
    }
}

impl Rival for Bake<'_> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn indirect(&mut self, rig: &LightRig, progress: &dyn Progress) -> Vec<[f32; 3]> {
        let light = self.relighter.direct_light(rig);
        let element_direct = self.relighter.element_light(&light, &SAMPLES, progress);
        let direct = self.relighter.elements().mean(&element_direct);
        let indirect = self.bounces.indirect(&direct).to_vec();
        self.receivers.indirect(&self.relighter, &relight::Frame { element_direct, direct, indirect })
    }

    fn bytes(&self) -> u64 {
        self.bytes as u64
    }
}

/// Bytes of what a frame reads of patches (area, reflectance, sky) and elements (area, reflectance, points, faces).
fn tables(elements: &Elements) -> usize {
    20 * elements.patches() + 16 * elements.len() + 16 * elements.point.len()
}

/// Bytes of rows.
pub fn bytes_of_rows(rows: &Rows) -> usize {
    4 * rows.row_start.len() + 8 * rows.sender.len()
}

/// Enters all settings that gather.
pub fn gather(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    for &Gather { patches, pilot, operator: error, rays, rows } in judge.choice.of(&GATHERED) {
        let dense = match pilot {
            Some(pilot) => ground.adaptive(patches, pilot)?,
            None => ground.all_bounces(patches)?,
        };
        let (start, progress) = (ground.session.seconds(), ground.session.progress());
        let packed = pack(&dense, error, ground)?;
        let (setting, patches) = (ground.setting, &dense.patches);
        let elements = transfer::subdivide(patches, setting.surfaces, setting.rays, &progress);
        let senders = Senders { patches, elements: &elements, rays: setting.rays };
        let params = GatherParams { rays, ..GatherParams::default() };
        let need = transfer::gather_memory_needed(setting.receivers.len(), elements.senders(), &params)
            + hmatrix::rows_memory_needed(setting.receivers.len(), elements.senders(), &hmatrix::Params::error(rows));
        ground.session.ask_memory("the last gather", need, "take fewer receivers")?;
        let (gathered, _) = transfer::pack(&senders, setting.receivers, &params, rows, &progress)?;
        drop(progress);
        let seconds = dense.seconds + ground.session.seconds() - start;
        let (operator, sky) = (Operator::read(&packed)?, radfile::read_sky(&packed)?);
        let receivers = Receivers::gathered(&gathered, elements.senders())?;
        let bytes_of_rows = gathered.stream.len() + 4 * gathered.sky.len();
        let parts = Parts { patches, elements: &elements, sky, operator: &operator, receivers, bytes_of_rows };
        let kind = if pilot.is_some() { "adaptive, " } else { "" };
        let name = format!("{kind}{}, {rays} rays, rows {}", name(patches, error), percent(rows));
        judge.enter(seconds, &mut Bake::new(name, ground, parts)?)?;
    }
    Ok(())
}

/// Enters all settings that interpolate.
pub fn interpolate(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    for &(patches, error) in judge.choice.of(&INTERPOLATED) {
        let dense = ground.all_bounces(patches)?;
        let (start, progress) = (ground.session.seconds(), ground.session.progress());
        let packed = pack(&dense, error, ground)?;
        let (setting, patches) = (ground.setting, &dense.patches);
        let elements = Elements::whole(patches);
        let params = transfer::Params::default();
        let rows = transfer::interpolate_for_points(patches, setting.rays, setting.receivers, &params, &progress);
        drop(progress);
        let seconds = dense.seconds + ground.session.seconds() - start;
        let (operator, sky) = (Operator::read(&packed)?, radfile::read_sky(&packed)?);
        let (receivers, bytes_of_rows) = (Receivers::Interpolated(&rows), bytes_of_rows(&rows));
        let parts = Parts { patches, elements: &elements, sky, operator: &operator, receivers, bytes_of_rows };
        judge.enter(seconds, &mut Bake::new(name(patches, error), ground, parts)?)?;
    }
    Ok(())
}

fn name(patches: &Patches, error: f64) -> String {
    format!("{} patches, operator {}", patches.len(), percent(error))
}

/// Packs an operator into hierarchical blocks.
fn pack(dense: &Dense, error: f64, ground: &Ground) -> anyhow::Result<Container> {
    let need = hmatrix::memory_needed(dense.patches.len(), 3);
    ground.session.ask_memory("packing", need, "leave the method out (--methods)")?;
    let (params, progress) = (hmatrix::Params::error(error), ground.session.progress());
    kept(|sink| Ok(hmatrix::run(&dense.container, &params, step("hmatrix"), &progress, sink).map(drop)?))
}
