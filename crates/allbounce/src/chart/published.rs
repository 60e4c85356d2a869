//! The method of A. Shcherbakov and V. Frolov, Matrix transformations for efficient implementation of the radiosity
//! algorithm on GPUs, Light & Engineering 27(2), 2019, composed of our stages.
//!
//! As published: patches are the sides of occupied voxels; the matrix is the sum of the first three bounces; rows and columns
//! are reordered together, each row next to the most similar one that is left; the large values stand apart in
//! a list, the others become codes by a logarithm and go into a BC1 texture, three colours in one; a receiver takes the
//! light of the nearest patch that faces its way.
//!
//! Ours instead: form factors are counted with our rays and closed, which is more exact; the matrix is K, which their sum
//! becomes when areas and the first reflectance are taken out, so that one format holds it; shadows of patches are traced instead of looked up in a
//! shadow map; the texture is decoded and multiplied on the CPU.

use dxt_pack::Params;
use radfile::{Elements, Patches, Rows};
use rayon::prelude::*;
use relight::{Operator, Receivers};
use scene::SurfacePoint;

use glam::Vec3;

use super::{
    baked::{self, Recipe, step},
    ground::Ground,
    judge::Judge,
    ours::{Bake, Parts, bytes_of_rows},
};
use crate::stage::kept;

/// Patches of each entry.
const PATCHES: [u32; 5] = [100, 300, 1000, 2500, 5000];
/// Bounces in the matrix.
const BOUNCES: u32 = 3;
/// The format; nobody asks what the packing alone costs.
const FORMAT: Params = Params { probes: 0, ..Params::PAPER };

/// Enters all settings.
pub fn compete(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    for &patches in judge.choice.of(&PATCHES) {
        let dense = match baked::bake(&Recipe::published(patches, BOUNCES), None, &ground.setting, ground.session) {
            // Coarse voxels can fill a room, so that no side of one faces another.
            Err(error) if matches!(error.downcast_ref(), Some(voxel_simplify::Error::NothingSeen { .. })) => {
                judge.leave_out(format!("{patches} patches"), error.to_string());
                continue;
            }
            dense => dense?,
        };
        let (start, patches) = (ground.session.seconds(), &dense.patches);
        let need = dxt_pack::memory_needed(patches.len(), 3, &FORMAT);
        ground.session.ask_memory("packing", need, "leave the method out (--methods)")?;
        let progress = ground.session.progress();
        let packed =
            kept(|sink| Ok(dxt_pack::run(&dense.container, &FORMAT, step("dxt-pack"), &progress, sink).map(drop)?))?;
        drop(progress);
        let rows = nearest(patches, ground.setting.receivers);
        let seconds = dense.seconds + ground.session.seconds() - start;
        let elements = Elements::whole(patches);
        let (operator, sky) = (Operator::read(&packed)?, radfile::read_sky(&packed)?);
        let (receivers, bytes_of_rows) = (Receivers::Interpolated(&rows), bytes_of_rows(&rows));
        let parts = Parts { patches, elements: &elements, sky, operator: &operator, receivers, bytes_of_rows };
        let name = format!("{} patches, {BOUNCES} bounces", patches.len());
        judge.enter(seconds, &mut Bake::new(name, ground, parts)?)?;
    }
    Ok(())
}

/// One patch a receiver: the nearest that faces its way, or none where none does.
fn nearest(patches: &Patches, receivers: &[SurfacePoint]) -> Rows {
    let of = |receiver: &SurfacePoint| {
        let faces = |&p: &usize| Vec3::from(patches.normal[p]).dot(receiver.normal) > 0.0;
        let distance = |p: usize| Vec3::from(patches.position[p]).distance_squared(receiver.position);
        (0..patches.len()).filter(faces).min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    };
    let chosen: Vec<Option<usize>> = receivers.par_iter().map(of).collect();
    let mut rows = Rows { row_start: vec![0], ..Rows::default() };
    for patch in chosen {
        if let Some(patch) = patch {
            rows.sender.push(patch as u32);
            rows.weight.push(1.0);
        }
        rows.row_start.push(rows.sender.len() as u32);
    }
    rows
}
