//! The `.rad` container and the typed records that live in it.
//!
//! Every stage of the bake reads one container and writes another, so this is the
//! only crate that all of them share. It knows bytes, shapes and invariants
//! ("areas are positive", "a permutation names every patch once"); it knows no
//! physics beyond that and no geometry.
//!
//! Start at [`Container`] to read, at [`Builder`] to write, and at the records
//! ([`Mesh`], [`Materials`], [`Patches`], [`FormFactors`], [`Operator`],
//! [`Permutation`], [`PackedOperator`], [`HierarchicalOperator`], [`Elements`], [`Transfer`],
//! [`Lightmap`], [`Volume`], [`Accuracy`]) for what the sections mean.
//! The byte layout is specified in `formats/rad.md`.
//!
//! # Example
//!
//! A stage reads what it needs, hands the rest through and adds its own:
//!
//! ```
//! use radfile::{Builder, Permutation, Record, Step};
//!
//! let mut builder = Builder::new();
//! builder.array("x-lamp", 0, &[3], vec![17.0f32, 12.0, 4.0]);
//! let input = builder.finish()?;
//!
//! let order = Permutation::new(vec![2, 0, 1])?;
//! let mut builder = Builder::from_input(&input, |_| true);
//! order.write(&mut builder);
//! let step = Step { stage: "permute".into(), version: "1".into(), options: String::new(), inputs: vec![] };
//! builder.provenance(Some(&input), step)?;
//!
//! let output = builder.finish()?; // or builder.write_file(path)?
//! assert_eq!(Permutation::read(&output)?, order);
//! assert_eq!(output.array::<f32>("x-lamp", 1)?.0, [17.0, 12.0, 4.0]);
//! # Ok::<(), radfile::Error>(())
//! ```

#[cfg(target_endian = "big")]
compile_error!("a .rad file is little-endian and is mapped without conversion; big-endian hosts are not supported");

mod accuracy;
mod builder;
mod bytes;
mod components;
mod container;
mod diff;
mod element;
mod elements;
mod error;
mod foreign;
mod form_factors;
mod gathered;
mod half;
mod hierarchical;
mod layout;
mod lightmap;
mod locator;
mod luma;
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
mod volume;

pub use accuracy::{Accuracy, ErrorParts, LightAccuracy};
pub use builder::{Builder, Sink};
pub use components::Groups;
pub use container::{Container, Section};
pub use diff::{Report, SectionDiff, Tolerance, Verdict, diff};
pub use element::{Element, ElementType};
pub use elements::Elements;
pub use error::{Error, Result};
pub use form_factors::{FormFactors, read_sky};
pub use gathered::{GatherCertificate, Gathered};
pub use half::{Colour, ColourBlock, MOST_PATCHES, NO_COMPONENT, half_blocks, rounded, unit_of};
pub use hierarchical::{Certificate, HierarchicalOperator, Kernel};
pub use layout::{FLAG_PATCH_ORDER, FLAG_REQUIRED, IDENTIFIER, VERSION};
pub use lightmap::{LARGEST_LIGHTMAP, Lightmap};
pub use locator::{CUT, CellKey, Cut, DEEPEST_CUT, Found, PatchLocator};
pub use luma::{LUMA, luma};
pub use materials::{Material, Materials, Texture, Wrap};
pub use mesh::{Mesh, Side, face_id};
pub use meta::{decode as decode_meta, encode as encode_meta};
pub use operator::Operator;
pub use packed::{BlockFormat, Decoder, Outliers, PackedOperator, Packing, ValueMap};
pub use patches::{Patches, Piece};
pub use permutation::Permutation;
pub use progress::{Progress, Quiet};
pub use provenance::{Provenance, Step, digest};
pub use record::{Record, SECTIONS, bounces_held, outlasts_packing, rests_on_operator};
pub use transfer::{FineMesh, NO_RECEIVER, PointRows, Rows, Transfer, Weights};
pub use volume::{LARGEST_VOLUME, Volume};
