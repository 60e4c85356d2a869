//! A set of receivers whose light is gathered: packed form factors and the sky.
//!
//! This record knows what the stream is for; the stream itself is read by the crate `hmatrix` and specified in
//! `formats/rad.md` §6.

use serde::{Deserialize, Serialize};

use crate::{Builder, Container, Error, FLAG_PATCH_ORDER, Result};

/// What the packed rows are and what they were measured to be.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GatherCertificate {
    /// Patches and elements that the rows weigh.
    pub senders: u32,
    /// Rays of each row.
    pub rays: u32,
    /// Error of the light of the receivers that packing was allowed; shares, 0.01 is 1 %.
    pub error_wanted: f64,
    /// L2 norm of that error relative to that of the light, mean over probe lights that packing did not see.
    pub l2_mean: f64,
    /// 99th percentile of the error relative to what is seen at the place, mean over the same.
    pub vis99: f64,
}

/// Form factors of receivers, packed: row = receiver, column = sender of a gather ([`crate::Elements`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Gathered {
    /// What they are and what they are worth.
    pub certificate: GatherCertificate,
    /// The stream, see `formats/rad.md` §6.
    pub stream: Vec<u8>,
    /// What each receiver sees of the sky, 0 to 1.
    pub sky: Vec<f32>,
}

impl Gathered {
    /// Whether a container has those of the set `prefix`, such as `transfer.`.
    pub fn is_in(c: &Container, prefix: &str) -> bool {
        c.has(&format!("{prefix}gather"))
    }

    /// Reads those of the set `prefix` for `receivers` receivers.
    ///
    /// # Errors
    ///
    /// [`Error::Invariant`] for an illegal certificate or share of the sky; what the container refuses.
    pub fn read(c: &Container, prefix: &str, receivers: usize) -> Result<Gathered> {
        const NAME: &str = "gathered rows";
        let certificate: GatherCertificate = c.meta(&format!("{prefix}gather_meta"))?;
        let k = &certificate;
        let measured = [k.l2_mean, k.vis99].iter().all(|e| e.is_finite() && *e >= 0.0);
        if k.senders == 0 || k.rays == 0 || !measured || !(1e-6..=1.0).contains(&k.error_wanted) {
            return Err(Error::invariant(NAME, format!("illegal certificate {k:?}")));
        }
        let sky = c.array_of::<f32>(&format!("{prefix}sky"), &[Some(receivers)])?.to_vec();
        if let Some(r) = sky.iter().position(|s| !(0.0..=1.0).contains(s)) {
            return Err(Error::invariant(NAME, format!("receiver {r} sees {} of the sky, expected 0 to 1", sky[r])));
        }
        let stream = c.array_of::<u8>(&format!("{prefix}gather"), &[None])?.to_vec();
        Ok(Gathered { certificate, stream, sky })
    }

    /// Adds those of the set `prefix`; `flags` are [`crate::FLAG_REQUIRED`], or 0 for receivers that a reader may do
    /// without.
    pub fn write<'b>(&'b self, b: &mut Builder<'b>, prefix: &str, flags: u32) {
        b.meta(&format!("{prefix}gather_meta"), flags, &self.certificate);
        b.array(&format!("{prefix}sky"), flags, &[self.sky.len()], &self.sky[..]);
        b.array(&format!("{prefix}gather"), flags | FLAG_PATCH_ORDER, &[self.stream.len()], &self.stream[..]);
    }
}
