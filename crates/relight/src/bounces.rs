//! The first k bounces, one after the other: H_k = Σ_{b=1..k} (F ρ)^b H⁰, docs/theory.md (3.2).

use radfile::{FormFactors, Patches};
use rayon::prelude::*;

/// Irradiance of the patches after exactly 1 to `count` bounces, W/m²; needs the form factors.
///
/// # Panics
///
/// If patches, form factors and `direct` differ in length: a bug in the caller.
pub fn bounces(patches: &Patches, factors: &FormFactors, direct: &[[f32; 3]], count: u32) -> Vec<[f32; 3]> {
    assert!(factors.len() == patches.len() && direct.len() == patches.len(), "one value a patch");
    let mut arriving: Vec<[f64; 3]> = direct.iter().map(|h| h.map(f64::from)).collect();
    let mut sum = vec![[0.0; 3]; patches.len()];
    for _ in 0..count {
        let leaving: Vec<[f64; 3]> = arriving
            .iter()
            .zip(&patches.reflectance)
            .map(|(h, rho)| std::array::from_fn(|c| f64::from(rho[c]) * h[c]))
            .collect();
        arriving = (0..patches.len()).into_par_iter().map(|i| gather(factors.row(i), &leaving)).collect();
        for (sum, h) in sum.iter_mut().zip(&arriving) {
            *sum = std::array::from_fn(|c| sum[c] + h[c]);
        }
    }
    sum.iter().map(|h| h.map(|v: f64| v as f32)).collect()
}

fn gather(row: &[f32], leaving: &[[f64; 3]]) -> [f64; 3] {
    row.iter().zip(leaving).fold([0.0; 3], |sum, (f, b)| std::array::from_fn(|c| sum[c] + f64::from(*f) * b[c]))
}
