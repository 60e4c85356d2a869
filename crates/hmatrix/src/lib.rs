//! Operator to hierarchical blocks, and the product with them.
//!
//! The operator K is smooth where patches are far apart or meet only after many bounces, so most of it has low
//! rank once patches that lie near each other and face alike stand together. Its luma
//! K_Y = Σ w_c K_c (Rec. 709) is cut into blocks of pairs of clusters; each is the cheapest of nothing, a few
//! quantised singular triples, a quantised tile, or four smaller blocks. What the channels differ from luma is
//! stored alike, in two planes of colour. One number steers everything: the error of light under probe lights.
//!
//! Sources: W. Hackbusch, A sparse matrix arithmetic based on H-matrices, Computing 62, 1999 (blocks of clusters);
//! N. Halko, P.-G. Martinsson, J. Tropp, Finding structure with randomness, SIAM Review 53, 2011 (sketches);
//! Y. Shoham, A. Gersho, Efficient bit allocation for an arbitrary set of quantizers, IEEE Trans. ASSP 36, 1988
//! (every choice at one price of a byte).
//!
//! - `cluster.rs`: the tree of patches. `sketch.rs`, `small.rs`: singular triples of a block.
//! - `tile.rs`, `triple.rs`: the two codes; `block.rs`: their bytes, for any rectangle, symmetric or not.
//! - `stretch.rs`: the norm of errors. `plan.rs`: what every block could be, and what it is at a price. `colour.rs`: luma and planes of colour.
//! - `stream.rs`: the packed bytes. `hmatrix.rs`, `kernels.rs`: the form that is multiplied with.
//! - `bounces.rs`: all bounces from the operator of one. `stage.rs`: from container to container.
//! - `map.rs`: where which kind of block is. `pairs.rs`: the blocks of a matrix, symmetric or not.
//! - `compress.rs`: all of it until the error is what was asked for (`search.rs`); `trial.rs`: the light that decides.
//! - `rows.rs`, `compress_rows.rs`, `rectangle.rs`: the same for the rows of receivers that are no patches, which are sparse;
//!   `packer.rs`: their parts and the price of a byte; `choose.rs`: what they are cut into at a price; `residual.rs`: triples
//!   of sparse blocks.
//!
//! Start at [`compress`] and [`HMatrix::multiply`], for receivers at [`compress_rows`] and [`Rectangle::multiply`].

mod bits;
mod block;
mod bounces;
mod choose;
mod cluster;
mod colour;
mod compress;
mod compress_rows;
mod error;
mod hmatrix;
mod kernels;
mod map;
mod packer;
mod pairs;
mod params;
mod plan;
mod rectangle;
mod report;
mod residual;
mod rows;
mod search;
mod sketch;
mod small;
mod stage;
mod stream;
mod stretch;
mod tile;
mod trial;
mod triple;

pub use bounces::Solve;
pub use compress::{compress, memory_needed};
pub use compress_rows::{RowsReport, compress_rows, rows_memory_needed};
pub use error::{Error, Result};
pub use hmatrix::{Cluster, HMatrix, Layout, Leaf, Near, Panel, Workspace};
pub use kernels::{LANES, Lanes, ROWS};
pub use map::{BlockKind, Map, MapBlock};
pub use params::Params;
pub use rectangle::Rectangle;
pub use report::Report;
pub use rows::{Receivers, Row, RowSource, Senders, sparse};
pub use stage::{one_bounce, read, run};
pub use trial::SOLVE_SHARE;
