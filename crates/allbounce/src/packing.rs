//! What both ways to pack the operator are asked for.

use crate::numbers;

#[derive(Clone, clap::Args)]
pub struct Wanted {
    /// Error of indirect light that packing may cause: L2 over the scene, mean over probe lights [0.05% to 50%]; not for
    /// the format `paper`
    #[arg(long = "operator-error", value_name = "E", default_value = "1%", value_parser = numbers::operator_error)]
    pub error: f64,
    /// Keep form factors and the dense operator in the file
    #[arg(long)]
    pub keep_dense: bool,
}

impl Wanted {
    /// As typed.
    pub fn text(&self) -> String {
        format!("--operator-error {}{}", self.error, if self.keep_dense { " --keep-dense" } else { "" })
    }
}
