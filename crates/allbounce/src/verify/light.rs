//! Light that is known beforehand, sent through an operator.

use radfile::{Container, FormFactors, Mesh, Patches, Record, read_sky};

use super::{
    form_factors::row_sum,
    patches::{largest, mean, same_size},
};

/// A room is closed where no row lacks more than this.
const CLOSED: f64 = 1e-5;
/// Every so many patches one is lit by the lamp of the energy balance.
const LIT: usize = 7;

/// What each patch sees that is no patch: e of theory.md (2.3).
///
/// In the furnace it shines like the sky. That is exact for any scene where F is there to say how much it is;
/// where F has been dropped, only the sky is known, and a one-sided scene stays below 1 by what its backs absorb.
pub struct Surroundings {
    share: Vec<f64>,
    /// Whether only an excess can be held against the operator.
    from_above: bool,
}

impl Surroundings {
    /// From form factors, or the sky alone.
    pub fn read(c: &Container, p: &Patches) -> anyhow::Result<Surroundings> {
        let sky = read_sky(c)?;
        same_size("sky shares", sky.len(), p)?;
        if c.has("formfactor.values") {
            let f = FormFactors::read(c)?;
            return Ok(Surroundings { share: (0..f.len()).map(|i| 1.0 - row_sum(&f, i)).collect(), from_above: false });
        }
        let share = sky.iter().map(|&s| f64::from(s)).collect();
        Ok(Surroundings { share, from_above: Mesh::read(c)?.one_sided })
    }

    /// Name of an identity `of` something, with a note where it cannot be held in full.
    pub fn named(&self, identity: &str, of: &str) -> String {
        let note = if self.from_above { " (checked from above only: back sides absorb)" } else { "" };
        format!("{identity} of the {of}{note}")
    }
}

/// An operator K with its patches; `product(colour, x)` is K x.
pub struct Bounced<'a, Product> {
    pub patches: &'a Patches,
    pub channels: usize,
    pub product: Product,
}

impl<Product: Fn(usize, &[f64]) -> Vec<f64>> Bounced<'_, Product> {
    /// A^{-1/2} K A^{1/2} b for the radiosity b of one colour.
    fn received(&self, colour: usize, radiosity: impl Fn(usize) -> f64) -> Vec<f64> {
        let root = |i: usize| f64::from(self.patches.area[i]).sqrt();
        let sent: Vec<f64> = (0..self.patches.len()).map(|j| root(j) * radiosity(j)).collect();
        (self.product)(colour, &sent).into_iter().enumerate().map(|(i, y)| y / root(i)).collect()
    }

    fn rho(&self, colour: usize, patch: usize) -> f64 {
        self.patches.reflectance[patch][colour].into()
    }

    /// Deviation of A^{-1} X (1 − ρ + ρ e) + e = 1 for every channel and patch, theory.md (7.2).
    ///
    /// It is what a patch receives where every patch emits 1 − ρ and all that is no patch shines with 1.
    pub fn furnace(&self, around: &Surroundings) -> Vec<Vec<f64>> {
        let deviations = |colour: usize| {
            let glow = |j: usize| 1.0 - self.rho(colour, j) + self.rho(colour, j) * around.share[j];
            let received = self.received(colour, glow).into_iter().zip(&around.share);
            let excess = received.map(|(h, e)| h + e - 1.0);
            excess.map(|x| if around.from_above && x < 0.0 { 0.0 } else { x.abs() }).collect()
        };
        (0..self.channels).map(deviations).collect()
    }

    /// Relative deviation of the mean of indirect light from ρ / (1 − ρ) times the mean of direct light,
    /// theory.md (8.2), which falls on every seventh patch; or why the scene has no such balance.
    pub fn balance(&self, around: &Surroundings) -> Result<f64, &'static str> {
        if around.from_above || around.share.iter().any(|e| e.abs() > CLOSED) {
            return Err("the scene is not known to be closed");
        }
        let same = |colour: &usize| (1..self.patches.len()).all(|i| self.rho(*colour, i) == self.rho(*colour, 0));
        let colours: Vec<usize> = (0..self.channels).filter(|c| same(c) && self.rho(*c, 0) > 0.0).collect();
        if colours.is_empty() {
            return Err("the reflectance is not the same everywhere");
        }
        let direct = |i: usize| f64::from(u8::from(i.is_multiple_of(LIT)));
        let deviation = |colour: usize| {
            let rho = self.rho(colour, 0);
            let received = self.received(colour, |j| rho * direct(j));
            let expected = rho / (1.0 - rho) * mean(self.patches, direct);
            (mean(self.patches, |i| received[i]) / expected - 1.0).abs()
        };
        Ok(largest(colours.into_iter().map(deviation)))
    }
}
