//! What came out, in numbers for people.

use half::f16;
use radfile::Kernel;
use serde::Serialize;

use crate::block::Block;

/// What bytes are spent on, and numbers of blocks.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Sizes {
    /// Header, order of patches.
    pub structure: usize,
    /// Blocks of low rank.
    pub low_rank: usize,
    /// Tiles.
    pub tiles: usize,
    /// Blocks that are a mean, or nothing, or split.
    pub mean_or_split: usize,
    /// Colour: what planes other than luma take of the bytes of blocks.
    pub colour: usize,
    /// Blocks of low rank.
    pub low_rank_blocks: usize,
    /// Triples in them.
    pub triples: usize,
    /// Tiles.
    pub tile_blocks: usize,
    /// Blocks that are a mean and no more.
    pub mean_blocks: usize,
}

impl Sizes {
    pub(crate) fn count(&mut self, block: &Block, bytes: usize) {
        match block {
            Block::LowRank { triples, .. } if !triples.is_empty() => {
                self.low_rank += bytes;
                self.low_rank_blocks += 1;
                self.triples += triples.len();
            }
            Block::Tile(_) => {
                self.tiles += bytes;
                self.tile_blocks += 1;
            }
            Block::LowRank { mean, .. } => {
                self.mean_or_split += bytes;
                self.mean_blocks += usize::from(*mean != f16::ZERO);
            }
            Block::Split => self.mean_or_split += bytes,
        }
    }
}

/// Numbers about a packed operator.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Number of patches.
    pub patches: usize,
    /// Channels of the operator.
    pub channels: usize,
    /// What the matrix is.
    pub kernel: Kernel,
    /// Error that was wanted.
    pub error_wanted: f64,
    /// The same error under the probe lights that steered.
    pub error_steered: f64,
    /// Number of other probe lights, that certify. Errors under them are of indirect irradiance, as `probes::Errors`
    /// defines them.
    pub probes: usize,
    /// L2 norm of the error relative to that of the irradiance, mean over probes.
    pub l2_mean: f64,
    /// The same, worst probe.
    pub l2_max: f64,
    /// 99th percentile of |error| relative to the mean indirect irradiance, mean over probes.
    pub p99: f64,
    /// 99th percentile of |error| relative to what is seen there, mean over probes.
    pub vis99: f64,
    /// Flux gained or, if negative, lost relative to the indirect flux, mean over probes.
    pub energy_bias: f64,
    /// Bytes of the packed operator.
    pub bytes: usize,
    /// Bytes per entry of the n × n matrix, all channels together.
    pub bytes_per_entry: f64,
    /// How many times smaller than one dense f32 form-factor matrix, which classical radiosity keeps.
    pub smaller_than_form_factors: f64,
    /// What the bytes are spent on.
    pub sizes: Sizes,
    /// Products of a frame: 1, or what solving for all bounces took at most.
    pub products: usize,
    /// Multiplications of a product relative to those of a dense matrix.
    pub multiplications: f64,
    /// How often the price of a byte was corrected.
    pub rounds: usize,
}
