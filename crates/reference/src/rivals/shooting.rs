//! Progressive refinement: the patch with most unshot light shoots first.
//!
//! Source: M. F. Cohen, S. E. Chen, J. R. Wallace, D. P. Greenberg, A progressive refinement approach to fast radiosity
//! image generation, SIGGRAPH 1988. Light that was not shot yet may be spread evenly over the scene (their ambient term).
//! A shot from patch i needs row i of F alone: patch j receives F_ij A_i / A_j times the exitance of i. The first shots,
//! of the lights, are direct light as for all methods; shots follow each other, so one thread does them.

use std::array::from_fn;

use pulp::Arch;
use radfile::{FormFactors, Patches, Progress};
use scene::LightRig;

use super::{
    Rival, Setting,
    on_patches::{OnPatches, PatchLight},
};

/// When shooting ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShootingParams {
    /// Most shots.
    pub shots: u32,
    /// It ends earlier if no more than this share of the flux that the patches sent first is unshot.
    pub unshot: f64,
    /// Whether the rest is spread evenly: too bright where light leaves the scene.
    pub ambient: bool,
}

/// Progressive refinement over a setting.
pub struct Shooting<'a> {
    on: OnPatches<'a>,
    patches: &'a Patches,
    form_factors: &'a FormFactors<'a>,
    params: ShootingParams,
    /// Reflectance, a channel after the other.
    reflectance: [Vec<f32>; 3],
    /// 1 / A, 1/m².
    per_area: Vec<f32>,
}

impl<'a> Shooting<'a> {
    /// Shoots by `form_factors`, which are reciprocal: A_i F_ij = A_j F_ji.
    ///
    /// # Panics
    ///
    /// If there are not as many form factors as patches: a bug in the caller.
    pub fn new(
        setting: Setting<'a>,
        patches: &'a Patches,
        form_factors: &'a FormFactors<'a>,
        params: ShootingParams,
        light: PatchLight,
    ) -> Shooting<'a> {
        assert_eq!(patches.len(), form_factors.len(), "form factors of these patches");
        Shooting {
            on: OnPatches::new(setting, patches, light),
            patches,
            form_factors,
            params,
            reflectance: from_fn(|c| patches.reflectance.iter().map(|r| r[c]).collect()),
            per_area: patches.area.iter().map(|a| 1.0 / a).collect(),
        }
    }

    /// The patch with most unshot flux, and the flux of all, W, sum of the channels.
    fn brightest(&self, [red, green, blue]: &[Vec<f32>; 3]) -> (usize, f64) {
        let (mut brightest, mut most, mut sum) = (0, 0.0, 0.0);
        for (i, area) in self.patches.area.iter().enumerate() {
            let flux = area * (red[i] + green[i] + blue[i]);
            sum += f64::from(flux);
            if flux > most {
                (brightest, most) = (i, flux);
            }
        }
        (brightest, sum)
    }

    /// Patch `from` shoots what it has.
    #[inline(always)]
    fn shoot(&self, from: usize, unshot: &mut [Vec<f32>; 3], received: &mut [Vec<f32>; 3]) {
        let (row, area) = (self.form_factors.row(from), self.patches.area[from]);
        for ((unshot, received), reflectance) in unshot.iter_mut().zip(received).zip(&self.reflectance) {
            let flux = area * std::mem::take(&mut unshot[from]);
            let to = unshot.iter_mut().zip(received).zip(row.iter().zip(&self.per_area).zip(reflectance));
            for ((unshot, received), ((form_factor, per_area), reflectance)) in to {
                let light = flux * form_factor * per_area;
                *received += light;
                *unshot += reflectance * light;
            }
        }
    }

    /// Irradiance that the unshot light would give if it met all patches alike, with all bounces.
    fn ambient(&self, unshot: &[Vec<f32>; 3]) -> [f32; 3] {
        let mean = |of: &[f32]| {
            let areas = || self.patches.area.iter().map(|&a| f64::from(a));
            areas().zip(of).map(|(a, &x)| a * f64::from(x)).sum::<f64>() / areas().sum::<f64>()
        };
        from_fn(|c| (mean(&unshot[c]) / (1.0 - mean(&self.reflectance[c]))) as f32)
    }
}

impl Rival for Shooting<'_> {
    fn name(&self) -> String {
        let ShootingParams { shots, unshot, ambient } = self.params;
        let ambient = if ambient { ", ambient" } else { "" };
        format!("progressive refinement, {} patches, {shots} shots or {unshot} unshot{ambient}", self.patches.len())
    }

    fn indirect(&mut self, rig: &LightRig, progress: &dyn Progress) -> Vec<[f32; 3]> {
        let direct = self.on.direct(rig);
        let mut unshot: [Vec<f32>; 3] =
            from_fn(|c| direct.iter().zip(&self.reflectance[c]).map(|(e, rho)| e[c] * rho).collect());
        let mut received: [Vec<f32>; 3] = from_fn(|_| vec![0.0; direct.len()]);
        let (_, first) = self.brightest(&unshot);
        progress.begin("shots", u64::from(self.params.shots));
        let arch = Arch::new();
        for _ in 0..self.params.shots {
            let (brightest, flux) = self.brightest(&unshot);
            if flux <= self.params.unshot * first {
                break;
            }
            arch.dispatch(|| self.shoot(brightest, &mut unshot, &mut received));
            progress.advance(1);
        }
        let ambient = if self.params.ambient { self.ambient(&unshot) } else { [0.0; 3] };
        self.on.at_receivers(|patch| from_fn(|c| received[c][patch] + ambient[c]))
    }

    fn bytes(&self) -> u64 {
        let own = size_of_val(&self.form_factors.values[..]) + 4 * size_of_val(&self.per_area[..]);
        own as u64 + self.on.bytes()
    }
}
