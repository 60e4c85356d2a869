//! The rows that are packed to a rectangle, seen once before they are: whether they are rows at all, the light that comes
//! of them, and which receivers and patches have to do with each other.

use radfile::{Groups, Patches, Progress, Rows, luma};
use rayon::prelude::*;

use crate::{Error, Result, compress::numbers_of_groups};

/// What a row may sum to, rounding included.
const MOST: f64 = 1.001;
/// Rows that are looked at before their patches are joined.
const BATCH: usize = 1024;

/// Writes the row of a receiver, a weight a patch, into zeros. Called from any thread, several times for each receiver.
pub type RowSource<'a> = dyn Fn(usize, &mut [f32]) + Sync + 'a;

/// Where receivers are and where they face.
#[derive(Clone, Copy)]
pub struct Receivers<'a> {
    /// Metres.
    pub position: &'a [[f32; 3]],
    /// Unit vectors.
    pub normal: &'a [[f32; 3]],
}

impl Receivers<'_> {
    pub(crate) fn check(&self) -> Result<()> {
        let (positions, normals) = (self.position.len(), self.normal.len());
        match positions {
            _ if positions != normals => Err(Error::ReceiverCount { positions, normals, rows: positions }),
            0 => Err(Error::NoReceivers),
            _ => Ok(()),
        }
    }
}

/// Sparse rows as a source of rows.
///
/// # Errors
///
/// [`Error::ReceiverCount`] if there is not a row a receiver, [`Error::Patch`].
pub fn sparse<'a>(
    rows: &'a Rows,
    receivers: &Receivers,
    patches: &Patches,
) -> Result<impl Fn(usize, &mut [f32]) + Sync + use<'a>> {
    let (positions, normals) = (receivers.position.len(), receivers.normal.len());
    let entries = rows.patch.len().min(rows.weight.len());
    let increasing = rows.row_start.is_sorted() && rows.row_start.last().is_none_or(|&end| end as usize <= entries);
    if rows.len() != positions || !increasing {
        return Err(Error::ReceiverCount { positions, normals, rows: rows.len() });
    }
    let patches = patches.len();
    if let Some(entry) = rows.patch.iter().position(|&patch| patch as usize >= patches) {
        return Err(Error::Patch { entry, patch: rows.patch[entry] as usize, patches });
    }
    Ok(|receiver: usize, out: &mut [f32]| rows.row(receiver).for_each(|(patch, weight)| out[patch] += weight))
}

/// Light that patches send: luma of ρ H⁰, patches × lights.
pub struct Sent {
    pub count: usize,
    pub values: Vec<f32>,
}

impl Sent {
    pub fn new(patches: &Patches, lights: u32, seed: u64) -> Sent {
        let lights = probes::probe_lights(patches, lights, seed);
        let values = patches.reflectance.iter().enumerate();
        let values = values.flat_map(|(i, rho)| lights.iter().map(move |light| luma(*rho) * light[i])).collect();
        Sent { count: lights.len(), values }
    }
}

/// What is known of all rows.
pub struct Scan {
    /// Receivers with a weight, then those without.
    pub order: Vec<u32>,
    /// Number of receivers with a weight.
    pub lit: usize,
    /// The group of each patch; groups exchange nothing.
    pub patch_group: Vec<u32>,
    /// The group of each receiver.
    pub receiver_group: Vec<u32>,
    /// The largest weight times the factor of its patch.
    pub largest: f32,
    /// Sum of each row.
    pub sums: Vec<f64>,
    /// What each receiver gets of the lights: receivers × lights, for every set of lights.
    pub received: [Vec<f64>; 2],
}

/// One row.
struct Seen {
    patches: Vec<u32>,
    largest: f32,
    sum: f64,
    received: [Vec<f64>; 2],
}

impl Scan {
    /// Looks at every row once.
    ///
    /// # Errors
    ///
    /// [`Error::Weight`], [`Error::RowSum`].
    pub fn new(
        row: &RowSource,
        receivers: usize,
        factor: &[f32],
        sent: [&Sent; 2],
        progress: &dyn Progress,
    ) -> Result<Scan> {
        progress.begin("looking at rows", receivers as u64);
        let n = factor.len();
        let (mut groups, mut first) = (Groups::new(n), vec![None; receivers]);
        let mut is_seen = vec![false; n];
        let (mut largest, mut sums, mut received) = (0.0f32, Vec::new(), [Vec::new(), Vec::new()]);
        for start in (0..receivers).step_by(BATCH) {
            let batch = start..receivers.min(start + BATCH);
            let look = |buffer: &mut Vec<f32>, receiver: usize| {
                buffer.fill(0.0);
                row(receiver, buffer);
                progress.advance(1);
                look(receiver, buffer, factor, sent)
            };
            let seen: Vec<Result<Seen>> = batch.clone().into_par_iter().map_init(|| vec![0.0; n], look).collect();
            for (receiver, seen) in batch.zip(seen) {
                let seen = seen?;
                first[receiver] = seen.patches.first().copied();
                seen.patches.windows(2).for_each(|pair| groups.join(pair[0], pair[1]));
                seen.patches.iter().for_each(|&patch| is_seen[patch as usize] = true);
                largest = largest.max(seen.largest);
                sums.push(seen.sum);
                received.iter_mut().zip(seen.received).for_each(|(all, own)| all.extend(own));
            }
        }
        // What nobody sees is one group, too.
        let unseen: Vec<u32> = (0..n as u32).filter(|&patch| !is_seen[patch as usize]).collect();
        unseen.windows(2).for_each(|pair| groups.join(pair[0], pair[1]));
        let patch_group = numbers_of_groups(groups.lists(), n);
        let (lit, dark): (Vec<u32>, Vec<u32>) = (0..receivers as u32).partition(|&r| first[r as usize].is_some());
        let receiver_group = first.iter().map(|patch| patch.map_or(0, |patch| patch_group[patch as usize])).collect();
        Ok(Scan { lit: lit.len(), order: [lit, dark].concat(), patch_group, receiver_group, largest, sums, received })
    }
}

fn look(receiver: usize, row: &[f32], factor: &[f32], sent: [&Sent; 2]) -> Result<Seen> {
    if let Some(patch) = row.iter().position(|w| !(w.is_finite() && *w >= 0.0)) {
        return Err(Error::Weight { receiver, patch, value: row[patch] });
    }
    let sum = row.iter().map(|&w| f64::from(w)).sum();
    if sum > MOST {
        return Err(Error::RowSum { receiver, sum });
    }
    let patches: Vec<u32> = (0..row.len() as u32).filter(|&patch| row[patch as usize] > 0.0).collect();
    let largest = row.iter().zip(factor).map(|(w, f)| w * f).fold(0.0, f32::max);
    let received = sent.map(|sent| {
        let mut sums = vec![0.0; sent.count];
        for &patch in &patches {
            let weight = f64::from(row[patch as usize]);
            let light = &sent.values[patch as usize * sent.count..][..sent.count];
            sums.iter_mut().zip(light).for_each(|(sum, light)| *sum += weight * f64::from(*light));
        }
        sums
    });
    Ok(Seen { patches, largest, sum, received })
}
