//! What a bake may be asked for instead of patches, rays and errors of packing: an error, a size, a time.

use crate::{memory, numbers};

/// Options that choose the others.
#[derive(Clone, clap::Args)]
#[command(next_help_heading = "Ask for a result instead of settings")]
pub struct Goal {
    /// Error of indirect irradiance, such as 5%: RMS over the scene's surfaces relative to its mean. Patches, rays, packing
    /// and transfer are chosen by trial bakes that are held to path-traced light of lamps hung in the scene's air; the file
    /// says what came out under other lamps
    #[arg(id = "goal", long = "error", value_name = "E", value_parser = numbers::goal_error, conflicts_with_all = CHOSEN)]
    pub error: Option<f64>,
    /// Memory that frames may take beside the scene, such as 2MiB; without --error the smallest error within it
    #[arg(id = "goal_memory", long = "memory", value_name = "SIZE", value_parser = memory::parse, conflicts_with_all = CHOSEN)]
    pub memory: Option<u64>,
    /// Time that the indirect light of all vertices may take a frame, on the processor of this machine, such as 5ms; without
    /// --error the smallest error within it. It is measured, so that the file may differ from run to run
    #[arg(id = "goal_time", long = "time-per-frame", value_name = "TIME", value_parser = numbers::seconds, conflicts_with_all = CHOSEN)]
    pub time: Option<f64>,
}

/// What a goal chooses, so that nobody else can.
const CHOSEN: [&str; 20] = [
    "patches",
    "voxel",
    "mode",
    "adaptive",
    "rays",
    "ff_error",
    "bounces",
    "method",
    "precision",
    "tolerance",
    "operator",
    "kernel",
    "error",
    "keep_dense",
    "transfer",
    "gather_rays",
    "gather_error",
    "format",
    "outliers",
    "shift",
];

impl Goal {
    /// Whether anything is asked for.
    pub fn is_set(&self) -> bool {
        self.error.is_some() || self.memory.is_some() || self.time.is_some()
    }
}
