//! The bench of operators: every way to keep the light of all bounces, on one scale.
//!
//! A [`case::Case`] is a scene with its dense operator K. [`contest::run`] packs it in every way, times the
//! product K x of each in three colours ([`clock`]), and measures what light that very product brings
//! ([`judge`]); a [`record::Row`] is what is written down. `rivals` are there to be beaten and should be hard to beat:
//! [`classical`] radiosity with the form factors, [`planes`] of K in three kinds of numbers; `loops` has what they
//! spend their time in. [`packed`] are the operators of this project, [`device`] is their product on a GPU.
//! [`claims`] holds what the paper says of its method against such products; [`orders`] asks what the order of patches is worth, [`adaptive`] what it is worth to make them where light changes.
//!
//! `make bench` runs it; `bench/record/README.md` says what the columns mean.

pub mod adaptive;
pub mod case;
pub mod claims;
pub mod classical;
pub mod clock;
pub mod contest;
pub mod device;
pub mod judge;
mod loops;
pub mod orders;
pub mod packed;
pub mod planes;
pub mod record;

/// A way to compute y = K x in three colours, `x` and `y` one value a patch. Takes no memory.
pub trait Product {
    /// y = K x.
    fn multiply(&mut self, x: &[[f32; 3]], y: &mut [[f32; 3]]);

    /// The operator in a form that a GPU takes, if it has one.
    fn for_gpu(&self) -> Option<gpu_runtime::Packed<'_>> {
        None
    }
}
