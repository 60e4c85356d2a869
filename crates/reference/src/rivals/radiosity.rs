//! Classical radiosity: bounce after bounce by the dense matrix of form factors.
//!
//! Source: C. M. Goral, K. E. Torrance, D. P. Greenberg, B. Battaile, Modeling the interaction of light between diffuse
//! surfaces, SIGGRAPH 1984, solved as M. F. Cohen, D. P. Greenberg, The hemi-cube, SIGGRAPH 1985, by iteration: Jacobi's,
//! so that after k products exactly k bounces are there. With direct irradiance E, H ← F ρ (E + H).
//!
//! A product reads F once for all three channels, four rows at a time, and is as fast as memory for large F.

use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};
use radfile::{FormFactors, Patches, Progress};
use rayon::prelude::*;
use scene::LightRig;

use super::{
    Rival, Setting,
    on_patches::{OnPatches, PatchLight},
};

/// Rows that share what is loaded of the senders.
const ROWS: usize = 4;

/// Classical radiosity over a setting.
pub struct Radiosity<'a> {
    on: OnPatches<'a>,
    patches: &'a Patches,
    form_factors: &'a FormFactors<'a>,
    bounces: u32,
}

impl<'a> Radiosity<'a> {
    /// `bounces` products with `form_factors` a change of the lights.
    ///
    /// # Panics
    ///
    /// If there are not as many form factors as patches: a bug in the caller.
    pub fn new(
        setting: Setting<'a>,
        patches: &'a Patches,
        form_factors: &'a FormFactors<'a>,
        bounces: u32,
        light: PatchLight,
    ) -> Radiosity<'a> {
        assert_eq!(patches.len(), form_factors.len(), "form factors of these patches");
        Radiosity { on: OnPatches::new(setting, patches, light), patches, form_factors, bounces }
    }
}

impl Rival for Radiosity<'_> {
    fn name(&self) -> String {
        format!("classical radiosity, {} patches, {} bounces", self.patches.len(), self.bounces)
    }

    fn indirect(&mut self, rig: &LightRig, progress: &dyn Progress) -> Vec<[f32; 3]> {
        let n = self.patches.len();
        let direct = self.on.direct(rig);
        let mut indirect = vec![[0.0; 3]; n];
        progress.begin("bounces", u64::from(self.bounces));
        for _ in 0..self.bounces {
            let sent = |i: usize| Vec3::from(self.patches.reflectance[i]) * (direct[i] + Vec3::from(indirect[i]));
            let sent: [Vec<f32>; 3] = std::array::from_fn(|c| (0..n).map(|i| sent(i)[c]).collect());
            product(&self.form_factors.values, [&sent[0], &sent[1], &sent[2]], &mut indirect);
            progress.advance(1);
        }
        self.on.at_receivers(|patch| indirect[patch])
    }

    fn bytes(&self) -> u64 {
        let own = size_of_val(&self.form_factors.values[..]) + size_of_val(&self.patches.reflectance[..]);
        own as u64 + self.on.bytes()
    }
}

/// `to` = F times three vectors; rows of F, one after the other, receive, columns send.
///
/// # Panics
///
/// If F is not square, or `from` or `to` not of its size: a bug in the caller.
pub fn product(values: &[f32], from: [&[f32]; 3], to: &mut [[f32; 3]]) {
    assert_eq!(values.len(), to.len() * to.len(), "a square matrix");
    assert!(from.iter().all(|from| from.len() == to.len()), "one value a patch");
    let (n, arch) = (to.len(), Arch::new());
    to.par_chunks_mut(ROWS).zip(values.par_chunks(ROWS * n.max(1))).for_each(|(to, rows)| {
        match <&mut [[f32; 3]; ROWS]>::try_from(&mut *to) {
            Ok(to) => *to = arch.dispatch(Dots { rows: std::array::from_fn(|r| &rows[r * n..][..n]), from }),
            Err(_) => {
                to.iter_mut()
                    .zip(rows.chunks(n))
                    .for_each(|(to, row)| [*to] = arch.dispatch(Dots { rows: [row], from }));
            }
        }
    });
}

/// Each of `R` rows times each of three vectors of the same length.
struct Dots<'a, const R: usize> {
    rows: [&'a [f32]; R],
    from: [&'a [f32]; 3],
}

impl<const R: usize> WithSimd for Dots<'_, R> {
    type Output = [[f32; 3]; R];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [[f32; 3]; R] {
        let (rows, from) = (self.rows.map(S::as_simd_f32s), self.from.map(S::as_simd_f32s));
        let count = from[0].0.len();
        let (row_lanes, from_lanes) = (rows.map(|(lanes, _)| &lanes[..count]), from.map(|(lanes, _)| &lanes[..count]));
        let mut sums = [[simd.splat_f32s(0.0); 3]; R];
        for k in 0..count {
            for r in 0..R {
                for c in 0..3 {
                    sums[r][c] = simd.mul_add_e_f32s(row_lanes[r][k], from_lanes[c][k], sums[r][c]);
                }
            }
        }
        std::array::from_fn(|r| {
            std::array::from_fn(|c| {
                let rest: f32 = rows[r].1.iter().zip(from[c].1).map(|(f, b)| f * b).sum();
                simd.reduce_sum_f32s(sums[r][c]) + rest
            })
        })
    }
}
