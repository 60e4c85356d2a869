//! The rows that are packed to a rectangle, seen once before they are: whether they are rows at all, the light that comes
//! of them, and which receivers and senders have to do with each other.

use probes::Surfaces;
use radfile::{Groups, Patches, Progress, Rows, luma};
use rayon::prelude::*;

use crate::{Error, Result, compress::numbers_of_groups};

/// What a row may sum to, rounding included.
const MOST: f64 = 1.001;
/// Rows that are looked at before their senders are joined.
const BATCH: usize = 1024;

/// Senders of a receiver and their weights, in any order; those of a sender that is named again add up.
pub type Row = Vec<(u32, f32)>;

/// Appends the row of a receiver to an empty one. Called from any thread, several times for each receiver.
pub type RowSource<'a> = dyn Fn(usize, &mut Row) + Sync + 'a;

/// Where receivers are and where they face.
#[derive(Clone, Copy)]
pub struct Receivers<'a> {
    /// Metres.
    pub position: &'a [[f32; 3]],
    /// Unit vectors.
    pub normal: &'a [[f32; 3]],
}

/// What light comes from, patches or pieces of them; the columns of the matrix, in this order. Every array has a number a
/// sender.
#[derive(Clone, Copy)]
pub struct Senders<'a> {
    /// A point on each, metres.
    pub position: &'a [[f32; 3]],
    /// Unit vectors.
    pub normal: &'a [[f32; 3]],
    /// m².
    pub area: &'a [f32],
    /// Diffuse reflectance, linear RGB: how much of a probe light they send.
    pub reflectance: &'a [[f32; 3]],
}

impl<'a> From<&'a Patches> for Senders<'a> {
    fn from(patches: &'a Patches) -> Senders<'a> {
        let Patches { position, normal, area, reflectance, .. } = patches;
        Senders { position, normal, area, reflectance }
    }
}

impl Senders<'_> {
    pub(crate) fn check(&self) -> Result<()> {
        let counts = [self.position.len(), self.normal.len(), self.area.len(), self.reflectance.len()];
        match counts[0] {
            _ if counts != [counts[0]; 4] => Err(Error::SenderCount { counts }),
            0 => Err(Error::NoSenders),
            _ => Ok(()),
        }
    }
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
/// [`Error::ReceiverCount`] if there is not a row a receiver.
pub fn sparse<'a>(rows: &'a Rows, receivers: &Receivers) -> Result<impl Fn(usize, &mut Row) + Sync + use<'a>> {
    let (positions, normals) = (receivers.position.len(), receivers.normal.len());
    let entries = rows.sender.len().min(rows.weight.len());
    let increasing = rows.row_start.is_sorted() && rows.row_start.last().is_none_or(|&end| end as usize <= entries);
    if rows.len() != positions || !increasing {
        return Err(Error::ReceiverCount { positions, normals, rows: rows.len() });
    }
    Ok(|receiver: usize, out: &mut Row| {
        out.extend(rows.row(receiver).map(|(sender, weight)| (sender as u32, weight)));
    })
}

/// The row of a receiver by increasing sender, each once, into `out`.
pub fn read_row(row: &RowSource, receiver: usize, out: &mut Row) {
    out.clear();
    row(receiver, out);
    if !out.is_sorted_by(|a, b| a.0 < b.0) {
        out.sort_by_key(|entry| entry.0);
        out.dedup_by(|again, first| {
            let same = again.0 == first.0;
            if same {
                first.1 += again.1;
            }
            same
        });
    }
}

/// Light that senders send: luma of ρ H⁰, senders × lights.
pub struct Sent {
    pub count: usize,
    pub values: Vec<f32>,
}

impl Sent {
    pub fn new(senders: &Senders, lights: u32, seed: u64) -> Sent {
        let Senders { position, normal, area, reflectance } = *senders;
        let lights = probes::probe_lights(Surfaces { position, normal, area }, lights, seed);
        let values = reflectance.iter().enumerate();
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
    /// The group of each sender; groups exchange nothing.
    pub sender_group: Vec<u32>,
    /// The group of each receiver.
    pub receiver_group: Vec<u32>,
    /// The largest weight times the factor of its sender.
    pub largest: f32,
    /// Sum of squares of weights times the factors of their senders.
    pub energy: f64,
    /// Sum of each row.
    pub sums: Vec<f64>,
    /// What each receiver gets of the lights: receivers × lights, for every set of lights.
    pub received: [Vec<f64>; 2],
}

/// One row.
struct Seen {
    senders: Vec<u32>,
    largest: f32,
    energy: f64,
    sum: f64,
    received: [Vec<f64>; 2],
}

impl Scan {
    /// Looks at every row once.
    ///
    /// # Errors
    ///
    /// [`Error::Sender`], [`Error::Weight`], [`Error::RowSum`].
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
        let (mut largest, mut energy, mut sums, mut received) = (0.0f32, 0.0, Vec::new(), [Vec::new(), Vec::new()]);
        for start in (0..receivers).step_by(BATCH) {
            let batch = start..receivers.min(start + BATCH);
            let look = |buffer: &mut Row, receiver: usize| {
                read_row(row, receiver, buffer);
                progress.advance(1);
                look(receiver, buffer, factor, sent)
            };
            let seen: Vec<Result<Seen>> = batch.clone().into_par_iter().map_init(Row::new, look).collect();
            for (receiver, seen) in batch.zip(seen) {
                let seen = seen?;
                first[receiver] = seen.senders.first().copied();
                seen.senders.windows(2).for_each(|pair| groups.join(pair[0], pair[1]));
                seen.senders.iter().for_each(|&sender| is_seen[sender as usize] = true);
                largest = largest.max(seen.largest);
                energy += seen.energy;
                sums.push(seen.sum);
                received.iter_mut().zip(seen.received).for_each(|(all, own)| all.extend(own));
            }
        }
        // What nobody sees is one group, too.
        let unseen: Vec<u32> = (0..n as u32).filter(|&sender| !is_seen[sender as usize]).collect();
        unseen.windows(2).for_each(|pair| groups.join(pair[0], pair[1]));
        let sender_group = numbers_of_groups(groups.lists(), n);
        let (lit, dark): (Vec<u32>, Vec<u32>) = (0..receivers as u32).partition(|&r| first[r as usize].is_some());
        let receiver_group =
            first.iter().map(|sender| sender.map_or(0, |sender| sender_group[sender as usize])).collect();
        Ok(Scan {
            lit: lit.len(),
            order: [lit, dark].concat(),
            sender_group,
            receiver_group,
            largest,
            energy,
            sums,
            received,
        })
    }
}

fn look(receiver: usize, row: &[(u32, f32)], factor: &[f32], sent: [&Sent; 2]) -> Result<Seen> {
    let senders = factor.len();
    for &(sender, value) in row {
        let sender = sender as usize;
        if sender >= senders {
            return Err(Error::Sender { receiver, sender, senders });
        }
        if !(value.is_finite() && value >= 0.0) {
            return Err(Error::Weight { receiver, sender, value });
        }
    }
    let sum = row.iter().map(|entry| f64::from(entry.1)).sum();
    if sum > MOST {
        return Err(Error::RowSum { receiver, sum });
    }
    let values = row.iter().map(|&(sender, weight)| weight * factor[sender as usize]);
    let energy = values.clone().map(|v| f64::from(v).powi(2)).sum();
    let largest = values.fold(0.0, f32::max);
    let received = sent.map(|sent| {
        let mut sums = vec![0.0; sent.count];
        for &(sender, weight) in row {
            let light = &sent.values[sender as usize * sent.count..][..sent.count];
            sums.iter_mut().zip(light).for_each(|(sum, light)| *sum += f64::from(weight) * f64::from(*light));
        }
        sums
    });
    let senders = row.iter().filter(|entry| entry.1 > 0.0).map(|entry| entry.0).collect();
    Ok(Seen { senders, largest, energy, sum, received })
}
