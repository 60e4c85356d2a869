//! Truth to hold bakes against.
//!
//! [`PathTracer`] follows light through a scene by chance alone: no patches, no form factors, no
//! operator. With the product it shares the scene file's triangles, the reflectance and emission of
//! their texels, the lights file, the ray query and the Sobol sequence, and nothing else; lights are sampled by
//! code of its own.
//!
//! - [`PathTracer::points`]: irradiance at points, direct, after one bounce and after all, with standard errors.
//! - [`PathTracer::picture`]: what a camera sees.
//! - [`Stop`]: when an estimate is good enough.
//! - [`rivals`]: other methods for lights that change.
//!
//! Answers are the same bits for any number of threads.

mod path_tracer;
mod progressive;
pub mod rivals;
mod statistics;

pub use path_tracer::{PathTracer, Picture, PictureReport, PointEstimate, PointReport, Sampling};
pub use progressive::{FLOOR, Stop};
pub use statistics::Measured;
