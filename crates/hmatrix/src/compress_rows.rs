//! Packs the rows of receivers until the error is what was asked for, and certifies it.

use probes::{Errors, summarise};
use radfile::{Patches, Progress};
use serde::Serialize;

use crate::{
    HMatrix, Params, Rectangle, Result,
    compress::weights,
    packer::{ENTRIES, Packer, Trees},
    pairs::Pairs,
    report::Sizes,
    rows::{Receivers, RowSource, Scan, Senders, Sent},
    stream::HEAVIEST,
};

/// Numbers about packed rows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RowsReport {
    /// Number of receivers.
    pub receivers: usize,
    /// Receivers without any weight.
    pub dark: usize,
    /// Number of senders.
    pub senders: usize,
    /// Trees of receivers.
    pub chunks: usize,
    /// Error that was wanted.
    pub error_wanted: f64,
    /// The same error under the probe lights that steered.
    pub error_steered: f64,
    /// Number of other probe lights, that certify. Errors under them are of what receivers with any weight receive; each
    /// counts the same.
    pub probes: usize,
    /// L2 norm of the error relative to that of what is received, mean over probes.
    pub l2_mean: f64,
    /// The same, worst probe.
    pub l2_max: f64,
    /// 99th percentile of |error| relative to the mean of what is received, mean over probes.
    pub p99: f64,
    /// 99th percentile of |error| relative to what is received there plus a tenth of the mean, mean over probes.
    pub vis99: f64,
    /// Light gained or, if negative, lost relative to all that is received, mean over probes.
    pub energy_bias: f64,
    /// Mean of what packing changes the sum of a row by, relative to the mean sum.
    pub furnace: f64,
    /// Bytes of the packed rows.
    pub bytes: usize,
    /// Bytes per receiver.
    pub bytes_per_receiver: f64,
    /// Bytes per entry of the receivers × senders matrix.
    pub bytes_per_entry: f64,
    /// What the bytes are spent on.
    pub sizes: Sizes,
    /// Multiplications of a product with one channel relative to those of a dense matrix.
    pub multiplications: f64,
    /// How often rows were packed until the error was as wanted, on average.
    pub passes: f64,
}

/// Packs the weights of all senders at all receivers, which need not be symmetric; a row sums to at most 1.
///
/// Of `params` everything counts that is not said of operators: `kernel` and `keep_dense` do not. The error is that of
/// what receivers get of senders that are lit by probe lights. Receivers without a weight get nothing, and receivers and
/// senders that no row connects, even over others, exchange exactly nothing. `row` is called two or three times for most
/// receivers.
///
/// # Errors
///
/// [`crate::Error::Option`], [`crate::Error::NoSenders`], [`crate::Error::SenderCount`], [`crate::Error::NoReceivers`],
/// [`crate::Error::ReceiverCount`], [`crate::Error::Sender`], [`crate::Error::Weight`], [`crate::Error::RowSum`].
pub fn compress_rows(
    receivers: &Receivers,
    senders: &Senders,
    row: &RowSource,
    params: &Params,
    progress: &dyn Progress,
) -> Result<(Rectangle, RowsReport)> {
    params.check()?;
    receivers.check()?;
    senders.check()?;
    let (m, n) = (receivers.position.len(), senders.area.len());
    let [steering, certifying] = [0, 1].map(|k| Sent::new(senders, params.probes, params.seed.wrapping_add(k)));
    let numbers: Vec<u32> = (0..n as u32).collect();
    let factor: Vec<f32> = weights(senders.area, &numbers).iter().map(|&w| HEAVIEST / f32::from(w)).collect();
    let scan = Scan::new(row, m, &factor, [&steering, &certifying], progress)?;
    let packer = Packer::new(receivers, senders, row, factor, &scan, &steering, params, progress);
    let (parts, error_steered, passes) = packer.run(params.error);
    let (bytes, sizes) = parts.write();
    let packed = Rectangle(HMatrix::new(&parts, bytes));
    let errors = certify(&packed, &scan, &certifying);
    let (bytes, entries) = (packed.to_bytes().len(), m as f64 * n as f64);
    let report = RowsReport {
        receivers: m,
        dark: m - scan.lit,
        senders: n,
        chunks: parts.rows().tree.roots,
        error_wanted: params.error,
        error_steered,
        probes: certifying.count,
        l2_mean: errors.l2_mean,
        l2_max: errors.l2_max,
        p99: errors.p99,
        vis99: errors.vis99,
        energy_bias: errors.energy_bias,
        furnace: furnace(&packed, &scan),
        bytes,
        bytes_per_receiver: bytes as f64 / m as f64,
        bytes_per_entry: bytes as f64 / entries,
        sizes,
        multiplications: packed.0.multiplications() as f64 / entries,
        passes,
    };
    Ok((packed, report))
}

/// Bytes that [`compress_rows`] takes besides its inputs, its result included.
pub fn rows_memory_needed(receivers: usize, senders: usize, params: &Params) -> u64 {
    let (m, n) = (receivers as u64, senders as u64);
    let Trees { rows, columns } = Trees::new(receivers, senders, params.leaf);
    let part = rows.largest(Pairs::rectangular(rows, columns).first) as u64 * n;
    // Rows that are read at once, if they are dense; light of both sets of probes, and of each receiver; what is packed, in
    // all forms it has, which is seldom as much as a byte an entry.
    let (read, probes) = ((ENTRIES as u64).min(m * n).max(part), u64::from(params.probes) * 8);
    16 * read + m * (6 * probes + 256) + n * (3 * probes + 512) + m * n + (1 << 20)
}

/// What receivers get of lights: receivers × lights.
fn received(matrix: &HMatrix, receivers: usize, sent: &Sent) -> Vec<f64> {
    let (count, mut workspace) = (sent.count, matrix.workspace());
    let mut all = vec![0.0; receivers * count];
    let mut y = vec![[0.0; 3]; receivers];
    for first in (0..count).step_by(3) {
        // Three lights are the three colours of one.
        let light = |sent: &[f32]| std::array::from_fn(|c| sent.get(first + c).copied().unwrap_or(0.0));
        let x: Vec<[f32; 3]> = sent.values.chunks(count).map(light).collect();
        matrix.multiply(&x, &mut y, &mut workspace);
        for (all, y) in all.chunks_mut(count).zip(&y) {
            all[first..].iter_mut().zip(y).for_each(|(all, y)| *all = f64::from(*y));
        }
    }
    all
}

/// Errors under lights that did not steer.
fn certify(packed: &Rectangle, scan: &Scan, sent: &Sent) -> Errors {
    let lit = &scan.order[..scan.lit];
    if lit.is_empty() {
        return Errors::default();
    }
    let (found, exact) = (received(&packed.0, packed.receivers(), sent), &scan.received[1]);
    let row = |&receiver: &u32| {
        let own = receiver as usize * sent.count..(receiver as usize + 1) * sent.count;
        let error = found[own.clone()].iter().zip(&exact[own.clone()]).map(|(f, e)| f - e).collect();
        probes::Row { light: exact[own].to_vec(), error, matrix: [0.0; 2] }
    };
    let rows: Vec<probes::Row> = lit.iter().map(row).collect();
    // Receivers of one size that no light reaches directly.
    let alike = Patches { area: vec![1.0; lit.len()], ..Patches::default() };
    summarise(&[rows], &alike, &vec![vec![0.0; lit.len()]; sent.count])
}

fn furnace(packed: &Rectangle, scan: &Scan) -> f64 {
    let mut y = vec![[0.0; 3]; packed.receivers()];
    packed.multiply(&vec![[1.0; 3]; packed.senders()], &mut y, &mut packed.workspace());
    let total: f64 = scan.sums.iter().sum();
    let error = y.iter().zip(&scan.sums).map(|(y, sum)| (f64::from(y[0]) - sum).abs()).sum::<f64>();
    if total > 0.0 { error / total } else { 0.0 }
}
