//! From patches to receivers.

use radfile::{Elements, Patches, Rows, Transfer, Weights};
use relight::Receivers;

use super::{
    check::{Check, check},
    patches::largest,
};

/// Weights of a receiver make a mean; what it sees of the scene and of the sky is not more than all.
pub fn transfer(t: &Transfer, elements: &Elements) -> anyhow::Result<Check> {
    match &t.weights {
        Weights::Interpolated(rows) => Ok(interpolated(rows)),
        Weights::Gathered(gathered) => {
            let Receivers::Gathered { rows, sky } = Receivers::gathered(gathered, elements.senders())? else {
                unreachable!("gathered receivers are gathered")
            };
            let mut sums = vec![[0.0; 3]; sky.len()];
            rows.multiply(&vec![[1.0; 3]; elements.senders()], &mut sums, &mut rows.workspace());
            let excess = |(sum, sky): (&[f32; 3], &f32)| f64::from((sum[0] + sky - 1.0).max(0.0));
            let mean = sums.iter().zip(sky).map(excess).sum::<f64>() / sky.len().max(1) as f64;
            let identity = "form factors of a receiver and its sky sum to at most 1, mean excess";
            Ok(check("11.3", identity, mean, gathered.certificate.error_wanted.max(1e-4)))
        }
    }
}

fn interpolated(rows: &Rows) -> Check {
    let deviation = |r: usize| {
        let (count, sum) = rows.row(r).fold((0, 0.0), |(n, s), (_, w)| (n + 1, s + f64::from(w)));
        if count == 0 { 0.0 } else { (sum - 1.0f64).abs() }
    };
    let worst = largest((0..rows.len()).map(deviation));
    check("11.1", "transfer weights of a receiver sum to 1", worst, 1e-4)
}

/// Elements are parts of their patch.
pub fn elements(elements: &Elements, patches: &Patches) -> Check {
    let area_of = |p: usize| elements.of(p).map(|e| f64::from(elements.area[e])).sum::<f64>();
    let area = largest((0..patches.len()).map(|p| (area_of(p) / f64::from(patches.area[p]) - 1.0).abs()));
    check("11.4", "areas of elements sum to that of their patch", area, 1e-4)
}
