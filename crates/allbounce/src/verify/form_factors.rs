//! One bounce: reciprocity, row sums and what two patches can exchange at most.

use radfile::{FormFactors, Patches};

use super::{
    check::{Check, check},
    patches::{largest, mean, mismatch, pairs, same_size},
};

/// Σ_j F_ij.
pub fn row_sum(f: &FormFactors, i: usize) -> f64 {
    f.row(i).iter().map(|&v| f64::from(v)).sum()
}

/// Reciprocity, what becomes of the light of a patch (Σ_j F_ij + sky_i is 1 less what was absorbed), and the limit
/// of an exchange area. That F ≥ 0 and F ≤ 1 is the reader's to say.
///
/// The back of a one-sided surface absorbs, and the file does not say how much: there only an excess is held
/// against a row. Where both sides reflect, a row can lack something only where its rays met a sliver too small to
/// be a patch, or where the patch lies so close between others that it could not be sampled at all. Both are rare
/// but whole rows when they happen (at most 0.04 % of the light in eight rooms, single rows down to 0), so the mean
/// over the area is held to 0.1 % and no single row is.
pub fn form_factors(f: &FormFactors, p: &Patches, one_sided: bool) -> anyhow::Result<Vec<Check>> {
    same_size("form factors", f.len(), p)?;
    let area = |i: usize| f64::from(p.area[i]);
    let exchange = |i: usize, j: usize| area(i) * f64::from(f.values[i * f.len() + j]);
    let reciprocity = largest(pairs(f.len()).map(|(i, j)| mismatch(exchange(i, j), exchange(j, i))));
    let above = |(i, j)| exchange(i, j).max(exchange(j, i)) / area(i).min(area(j)) - 1.0;
    let excess: Vec<f64> = (0..f.len()).map(|i| row_sum(f, i) + f64::from(f.sky[i]) - 1.0).collect();
    let mut checks = vec![
        check("2.2", "reciprocity of form factors, A_i F_ij = A_j F_ji", reciprocity, 1e-5),
        check(
            "2.4",
            "an exchange area fits into both patches, A_i F_ij ≤ A_i, A_j",
            largest(pairs(f.len()).map(above)),
            1e-5,
        ),
        check("2.3", "rows of F and the sky do not exceed 1", largest(excess.iter().copied()), 1e-5),
    ];
    if !one_sided {
        let short = mean(p, |i| excess[i].abs());
        checks.push(check("2.3", "rows of F and the sky reach 1, mean over the area", short, 1e-3));
    }
    Ok(checks)
}
