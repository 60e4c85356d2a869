//! The `.rad` container and the typed records that live in it.
//!
//! Every stage of the bake reads one container and writes another, so this is the
//! only crate that all of them share. It knows bytes, shapes and invariants
//! ("areas are positive", "a permutation names every patch once"); it knows no
//! physics beyond that and no geometry.
//!
//! Start at [`Container`] to read, at [`Builder`] to write, and at the records
//! ([`Mesh`], [`Materials`], [`Patches`], [`FormFactors`], [`Operator`],
//! [`Permutation`], [`PackedOperator`], [`Transfer`]) for what the sections mean.
//! The byte layout is specified in `formats/rad.md`.

#[cfg(target_endian = "big")]
compile_error!("a .rad file is little-endian and is mapped without conversion; big-endian hosts are not supported");

mod builder;
mod bytes;
mod container;
mod diff;
mod element;
mod error;
mod foreign;
mod form_factors;
mod layout;
mod locator;
mod materials;
mod mesh;
mod meta;
mod operator;
mod packed;
mod patches;
mod permutation;
mod progress;
mod provenance;
mod record;
mod table;
mod transfer;

pub use builder::{Builder, Sink};
pub use container::{Container, Section};
pub use diff::{Report, SectionDiff, Tolerance, Verdict, diff};
pub use element::{Element, ElementType};
pub use error::{Error, Result};
pub use form_factors::{FormFactors, read_sky};
pub use layout::{FLAG_PATCH_ORDER, FLAG_REQUIRED, IDENTIFIER, VERSION};
pub use locator::{CellKey, PatchLocator};
pub use materials::{Material, Materials, Texture, Wrap};
pub use mesh::{Mesh, Side, face_id};
pub use meta::{decode as decode_meta, encode as encode_meta};
pub use operator::Operator;
pub use packed::{BlockFormat, PackedOperator, Packing, ValueMap};
pub use patches::{Patches, Piece};
pub use permutation::Permutation;
pub use progress::{Progress, Quiet};
pub use provenance::{Provenance, Step, digest};
pub use record::{Record, SECTIONS};
pub use transfer::{FineMesh, NO_RECEIVER, Rows, Transfer};
