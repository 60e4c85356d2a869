//! Packed rows of receivers on the device, against the CPU's product and the decoded rows.

mod common;

use common::{cornell, gpu, off};
use gpu_runtime::{Error, LastGather};
use hmatrix::{LANES, Params, Receivers, Rectangle, Row, compress_rows};
use radfile::Quiet;

/// The rows of the patches of a room of `fine` cells a wall as receivers, from those of one of `coarse`: differential form
/// factors, made to sum to 0.9. Every `blind`th receiver sees nothing but the sky.
fn packed(fine: u32, coarse: u32, blind: usize, params: &Params) -> Rectangle {
    let (receivers, senders) = (cornell(fine).patches, cornell(coarse).patches);
    let row = |receiver: usize, out: &mut Row| {
        if receiver % blind == blind - 1 {
            return;
        }
        let (p, m) = (receivers.position[receiver], receivers.normal[receiver]);
        for sender in 0..senders.len() {
            let d: [f32; 3] = std::array::from_fn(|a| senders.position[sender][a] - p[a]);
            let dot = |m: [f32; 3]| (0..3).map(|a| d[a] * m[a]).sum::<f32>();
            let cosines = dot(m).max(0.0) * (-dot(senders.normal[sender])).max(0.0);
            let area = senders.area[sender];
            out.push((sender as u32, area * cosines / (dot(d) + 0.3 * area).powi(2)));
        }
        let sum: f32 = out.iter().map(|entry| entry.1).sum();
        out.iter_mut().for_each(|entry| entry.1 *= 0.9 / sum);
    };
    let places = Receivers { position: &receivers.position, normal: &receivers.normal };
    compress_rows(&places, &(&senders).into(), &row, params, &Quiet).expect("rows of a room").0
}

fn noise(seed: usize) -> f32 {
    ((seed as u32).wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32
}

fn light(n: usize) -> Vec<[f32; 3]> {
    (0..n).map(|i| std::array::from_fn(|c| noise(3 * i + c))).collect()
}

fn sky(m: usize) -> Vec<f32> {
    (0..m).map(|i| 0.1 * noise(i + 7)).collect()
}

/// What is received by the definition, in double precision, and by the CPU's product; what packing took below 0 is 0.
fn expected(rows: &Rectangle, sent: &[[f32; 3]], sky: &[f32], radiance: [f32; 3]) -> [Vec<[f32; 3]>; 2] {
    let (n, dense) = (sent.len(), rows.decode().expect("own bytes"));
    let mut product = vec![[0.0; 3]; rows.receivers()];
    rows.multiply(sent, &mut product, &mut rows.workspace());
    let from_sky = |i: usize, c: usize| std::f32::consts::PI * radiance[c] * sky[i];
    let dot = |i: usize, c: usize| (0..n).map(|j| dense[i * n + j] * f64::from(sent[j][c])).sum::<f64>() as f32;
    let decoded = (0..sky.len()).map(|i| std::array::from_fn(|c| dot(i, c).max(0.0) + from_sky(i, c))).collect();
    let cpu =
        product.iter().enumerate().map(|(i, y)| std::array::from_fn(|c| y[c].max(0.0) + from_sky(i, c))).collect();
    [decoded, cpu]
}

/// Many more receivers than senders, as many, fewer, and one wall's worth.
#[test]
fn receivers_get_what_the_cpu_and_the_decoded_rows_give_them() {
    let Some(gpu) = gpu() else { return };
    for (fine, coarse, blind, error, leaf) in
        [(17, 6, 5, 0.01, 24), (9, 9, 1000, 0.002, 40), (3, 15, 2, 0.01, 7), (1, 9, 3, 0.01, 24), (12, 1, 4, 0.01, 24)]
    {
        let params = Params { leaf, ..Params::error(error) };
        let rows = packed(fine, coarse, blind, &params);
        let (sent, sky, radiance) = (light(rows.senders()), sky(rows.receivers()), [0.5, 0.2, 3.0]);
        let gather = LastGather::new(&gpu, &rows, &sky).expect("it fits");
        let found = gather.receive(&sent, radiance).unwrap();
        let [decoded, cpu] = expected(&rows, &sent, &sky, radiance).map(|truth| off(&found, &truth));
        println!(
            "{} receivers, {} senders: off by {cpu:.1e} from the CPU, {decoded:.1e} from the decoded rows; {} bytes packed, \
             {} here",
            rows.receivers(),
            rows.senders(),
            rows.to_bytes().len(),
            gather.bytes(),
        );
        assert!(cpu < 1e-5 && decoded < 1e-5, "{cpu:e} from the CPU, {decoded:e} from the decoded rows");
        assert_eq!(found, gather.receive(&sent, radiance).unwrap(), "the same bits again");
        // Another sky and no light: what the product before left behind does not count.
        let dark = gather.receive(&vec![[0.0; 3]; sent.len()], [1.0, 0.0, 2.0]).unwrap();
        for (y, share) in dark.iter().zip(&sky) {
            let pi = std::f32::consts::PI;
            let close = |found: f32, truth: f32| (found - truth).abs() <= 1e-6 * truth;
            assert!(close(y[0], pi * share) && y[1] == 0.0 && close(y[2], 2.0 * pi * share), "{y:?} of {share}");
        }
    }
}

/// One sender is lit, so that most receivers have little; coarse rows take more than there is from some.
#[test]
fn no_receiver_has_light_below_0() {
    let Some(gpu) = gpu() else { return };
    let rows = packed(17, 9, 5, &Params::error(0.3));
    let (n, m) = (rows.senders(), rows.receivers());
    let gather = LastGather::new(&gpu, &rows, &vec![0.0; m]).expect("it fits");
    let below = |lit: usize| {
        let sent: Vec<[f32; 3]> = (0..n).map(|i| [f32::from(u8::from(i == lit)); 3]).collect();
        let mut product = vec![[0.0; 3]; m];
        rows.multiply(&sent, &mut product, &mut rows.workspace());
        product.as_flattened().iter().any(|e| *e < 0.0).then_some(sent)
    };
    let sent = (0..n).find_map(below).expect("the CPU's product is below 0 somewhere, or this shows nothing");
    let found = gather.receive(&sent, [0.0; 3]).unwrap();
    assert!(found.as_flattened().iter().all(|e| *e >= 0.0), "{found:?}");
}

/// All kinds of blocks have been multiplied with above, or the test has seen little.
#[test]
fn the_rows_of_these_tests_have_blocks_of_all_kinds() {
    let rows = packed(17, 6, 5, &Params::error(0.01));
    let layout = rows.layout();
    let in_leaves: usize = layout.leaves.iter().map(|leaf| leaf.rows.len()).sum();
    assert_eq!((layout.receivers.len(), in_leaves), (rows.receivers(), rows.receivers() - rows.receivers() / 5));
    assert!(layout.leaves[0].above.len() >= 3, "levels");
    assert!(layout.panels.len() * LANES > 100 && layout.factor.len() > layout.panels.len(), "triples");
    assert!(!layout.means.is_empty(), "means");
    let fine = packed(9, 9, 1000, &Params::error(0.002));
    assert!(fine.layout().leaves.iter().any(|leaf| leaf.near.senders.len() > 16), "tiles");
    assert!(fine.layout().leaves.iter().any(|leaf| !leaf.near.apart.is_empty()), "entries that stand apart");
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let Some(gpu) = gpu() else { return };
    let rows = packed(3, 2, 5, &Params::error(0.05));
    let text = LastGather::new(&gpu, &rows, &[1.0]).err().expect("refused").to_string();
    assert!(text.contains("1 shares of the sky") && text.contains("one bake"), "{text}");
    let gather = LastGather::new(&gpu, &rows, &sky(rows.receivers())).expect("it fits");
    let refused = gather.receive(&light(rows.senders() + 1), [0.0; 3]);
    assert!(matches!(refused, Err(Error::Shape { .. })), "{refused:?}");
    assert!(gather.time(0).is_err() && gather.time(3).unwrap().milliseconds > 0.0);
}
