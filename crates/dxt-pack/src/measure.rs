//! What packing costs in light.
//!
//! H_ind = A^{-1/2} K A^{1/2} ρ H⁰ is computed with the dense and with the packed operator, summed in
//! f64. Relative RMS of the matrix is reported too, but it is a poor guide: random errors of its
//! entries cancel in the product and coherent ones do not.

use probes::{Errors, Row, sent_light, summarise};
use radfile::{Decoder, Operator, PackedOperator, Patches, Progress};
use rayon::prelude::*;

/// Compares a packed operator with the dense one it was made from, under direct irradiances `lights`.
///
/// # Panics
///
/// If the operators, patches and lights are of different sizes: a bug in the caller.
pub fn measure(
    operator: &Operator,
    packed: &PackedOperator,
    patches: &Patches,
    lights: &[Vec<f32>],
    progress: &dyn Progress,
) -> Errors {
    let n = operator.n;
    assert_eq!((packed.packing.n as usize, patches.len()), (n, n), "operators and patches of the same bake");
    assert_eq!(packed.packing.channels as usize, operator.channels, "channels of the operators");
    assert!(lights.iter().all(|light| light.len() == n), "one irradiance a patch");
    progress.begin("measuring the error", (operator.channels * n.div_ceil(4)) as u64);
    let decoder = packed.decoder();
    let channels: Vec<Vec<Row>> = (0..operator.channels)
        .map(|c| {
            let sent = sent_light(patches, lights, c);
            let blocks = (0..n.div_ceil(4)).into_par_iter();
            let rows: Vec<Vec<Row>> = blocks
                .map(|block| {
                    progress.advance(1);
                    four_rows(operator, &decoder, c, block, &sent, lights.len())
                })
                .collect();
            rows.into_iter().flatten().collect()
        })
        .collect();
    summarise(&channels, patches, lights)
}

fn four_rows(
    operator: &Operator,
    decoder: &Decoder,
    channel: usize,
    block: usize,
    sent: &[f64],
    lights: usize,
) -> Vec<Row> {
    let n = operator.n;
    let mut decoded = vec![0.0; 4 * n];
    decoder.rows(channel, block, &mut decoded);
    (4 * block..n.min(4 * block + 4))
        .map(|row| {
            let decoded = &decoded[row % 4 * n..][..n];
            multiply(&operator.channel(channel)[row * n..][..n], decoded, sent, lights)
        })
        .collect()
}

fn multiply(dense: &[f32], decoded: &[f32], sent: &[f64], lights: usize) -> Row {
    let mut row = Row { light: vec![0.0; lights], error: vec![0.0; lights], matrix: [0.0; 2] };
    for (j, (&dense, &decoded)) in dense.iter().zip(decoded).enumerate() {
        let (value, error) = (f64::from(dense), f64::from(decoded) - f64::from(dense));
        row.matrix[0] += value * value;
        row.matrix[1] += error * error;
        let sums = row.light.iter_mut().zip(&mut row.error);
        for ((light, wrong), sent) in sums.zip(&sent[j * lights..][..lights]) {
            *light += value * sent;
            *wrong += error * sent;
        }
    }
    row
}
