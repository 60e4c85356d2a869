//! Probe lights, and what an approximate operator does to their light.
//!
//! A packed operator is judged by the irradiance that comes out of it, not by its entries: [`probe_lights`]
//! go in through the exact and through the packed operator, and [`Errors`] compare what comes out. Every
//! crate that packs reports the same figures.

mod errors;
mod lights;

pub use errors::{Errors, Row, sent_light, summarise, vis99};
pub use lights::{Surfaces, probe_lights};
