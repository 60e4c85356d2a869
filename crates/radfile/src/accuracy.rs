//! What a bake that was asked for an error came to, under lights that had no part in its choices.

use serde::{Deserialize, Serialize};

use crate::{Builder, Container, Error, Record, Result};

/// Errors of indirect irradiance at points of the scene's surfaces, held to path-traced light. Shares, 0.01 is 1 %.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// What was asked for: RMS of the error relative to the mean irradiance; `None` where only memory or time was limited.
    pub error_wanted: Option<f64>,
    /// Points of the surfaces, chosen by area.
    pub points: u32,
    /// RMS of the error relative to the mean irradiance, mean over lights.
    pub rms: f64,
    /// The bias of the mean that is furthest from 0.
    pub bias: f64,
    /// 99th percentile of the error relative to what is seen at the place, mean over lights.
    pub vis99: f64,
    /// Each light.
    pub lights: Vec<LightAccuracy>,
    /// Where the error comes from.
    pub parts: ErrorParts,
}

/// One rig of lights and the error under it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightAccuracy {
    /// What it is, for people.
    pub name: String,
    /// The rig, as a lights file (docs/design.md §4).
    pub rig: String,
    /// RMS of the error over the mean of the truth, the noise of the truth taken off.
    pub rms: f64,
    /// Mean of the answer over that of the truth, minus 1.
    pub bias: f64,
    /// As [`Accuracy::vis99`].
    pub vis99: f64,
    /// RMS of the truth's standard errors over its mean.
    pub noise: f64,
}

/// Parts of an error; independent ones add by their squares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorParts {
    /// What the others leave of the whole: patches of finite size.
    pub discretisation: f64,
    /// Noise of the form factors, as their rays tell.
    pub form_factors: f64,
    /// Residual of the sum of bounces.
    pub solver: f64,
    /// Packing of the operator, under probe lights.
    pub packing: f64,
    /// What vertices differ from a last gather of many rays: by rays and packing of their rows, on top of the rms, or by
    /// interpolation, a part of it.
    pub receivers: f64,
}

impl Accuracy {
    fn check(&self) -> Result<()> {
        if let Some(wanted) = self.error_wanted.filter(|e| !(*e > 0.0 && *e <= 1.0)) {
            let what = format!("an error of {wanted} was asked for, expected a share above 0, up to 1");
            return Err(Error::invariant("accuracy", what));
        }
        check_error("all lights", self.rms, self.bias, self.vis99)?;
        for (number, light) in self.lights.iter().enumerate() {
            let of = format!("light {number}");
            check_error(&of, light.rms, light.bias, light.vis99)?;
            check_share(&of, "the noise", light.noise)?;
        }
        let p = &self.parts;
        check_share("discretisation", "the error", p.discretisation)?;
        check_share("form factors", "the error", p.form_factors)?;
        check_share("solver", "the error", p.solver)?;
        check_share("packing", "the error", p.packing)?;
        check_share("receivers", "the error", p.receivers)
    }
}

fn check_error(of: &str, rms: f64, bias: f64, vis99: f64) -> Result<()> {
    check_share(of, "the rms", rms)?;
    check_share(of, "the 99th percentile", vis99)?;
    if bias.is_finite() {
        return Ok(());
    }
    Err(Error::invariant("accuracy", format!("the bias of {of} is {bias}, expected a finite number")))
}

fn check_share(of: &str, what: &str, value: f64) -> Result<()> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(Error::invariant("accuracy", format!("{what} of {of} is {value}, expected a finite number, 0 or more")))
}

impl<'a> Record<'a> for Accuracy {
    const PREFIX: &'static str = "accuracy.";

    fn read(c: &'a Container) -> Result<Accuracy> {
        let accuracy: Accuracy = c.meta("accuracy.meta")?;
        accuracy.check()?;
        Ok(accuracy)
    }

    fn write<'b>(&'b self, builder: &mut Builder<'b>) {
        builder.meta("accuracy.meta", 0, self);
    }
}
