//! Receivers: light of the patches in, irradiance of vertices, texels, probes or points out.

use hmatrix::Rectangle;
use radfile::{Gathered, PointRows, Rows, Weights};

use crate::{
    Relighter,
    error::{Error, Result},
    points::radiosity,
    product::not_negative,
    relighter::Frame,
};

/// How light comes to receivers, ready for frames.
#[allow(clippy::large_enum_variant, reason = "there is one of it")]
pub enum Receivers<'a> {
    /// By weights of patches nearby.
    Interpolated(&'a Rows),
    /// By form factors, as they were counted.
    Counted {
        /// Form factors from the senders of a gather to receivers.
        rows: &'a Rows,
        /// What each receiver sees of the sky, 0 to 1.
        sky: &'a [f32],
    },
    /// By packed form factors.
    Gathered {
        /// Form factors from the senders of a gather to receivers.
        rows: Rectangle,
        /// What each receiver sees of the sky, 0 to 1.
        sky: &'a [f32],
    },
}

impl<'a> Receivers<'a> {
    /// Of the weights of a bake with so many `senders` ([`radfile::Elements`]).
    ///
    /// # Errors
    ///
    /// As [`Receivers::gathered`].
    pub fn new(weights: &'a Weights, senders: usize) -> Result<Receivers<'a>> {
        match weights {
            Weights::Interpolated(rows) => Ok(Receivers::Interpolated(rows)),
            Weights::Gathered(gathered) => Receivers::gathered(gathered, senders),
        }
    }

    /// Of packed rows.
    ///
    /// # Errors
    ///
    /// [`Error::Hierarchical`] for a damaged stream, [`Error::Rows`] for one of other receivers or senders.
    pub fn gathered(gathered: &'a Gathered, senders: usize) -> Result<Receivers<'a>> {
        let rows = Rectangle::from_bytes(&gathered.stream)?;
        let (found, expected) = ([rows.receivers(), rows.senders()], [gathered.sky.len(), senders]);
        if found != expected {
            return Err(Error::Rows { found, expected });
        }
        Ok(Receivers::Gathered { rows, sky: &gathered.sky })
    }

    /// Number of receivers.
    pub fn len(&self) -> usize {
        match self {
            Receivers::Interpolated(rows) | Receivers::Counted { rows, .. } => rows.len(),
            Receivers::Gathered { sky, .. } => sky.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bounces that these rows add to those of a frame's patches.
    pub fn bounces(&self) -> u32 {
        u32::from(!matches!(self, Receivers::Interpolated(_)))
    }

    /// What each receiver sees of the sky, 0 to 1, where that is known.
    pub fn sky(&self) -> Option<&'a [f32]> {
        match self {
            Receivers::Interpolated(_) => None,
            Receivers::Counted { sky, .. } | Receivers::Gathered { sky, .. } => Some(sky),
        }
    }

    /// Indirect irradiance of the receivers, W/m², nowhere below 0.
    ///
    /// # Panics
    ///
    /// If the frame is of another bake: a bug in the caller.
    pub fn indirect(&self, bake: &Relighter, frame: &Frame) -> Vec<[f32; 3]> {
        match self {
            Receivers::Interpolated(rows) => rows.gather(&frame.indirect),
            Receivers::Counted { rows, .. } => rows.gather(&radiosity(bake.elements(), frame)),
            Receivers::Gathered { rows, .. } => {
                let mut light = vec![[0.0; 3]; self.len()];
                rows.multiply(&radiosity(bake.elements(), frame), &mut light, &mut rows.workspace());
                light.as_flattened_mut().iter_mut().for_each(|e| *e = not_negative(*e));
                light
            }
        }
    }
}

impl<'a> From<&'a PointRows> for Receivers<'a> {
    fn from(rows: &'a PointRows) -> Receivers<'a> {
        match rows {
            PointRows::Interpolated(rows) => Receivers::Interpolated(rows),
            PointRows::Gathered { rows, sky } => Receivers::Counted { rows, sky },
        }
    }
}
