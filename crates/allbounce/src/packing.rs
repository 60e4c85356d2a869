//! What both ways to pack the operator are asked for.

use crate::numbers;

#[derive(Clone, clap::Args)]
pub struct Wanted {
    /// Error of indirect light that packing may cause, 0.05% to 50%: L2 over the scene, mean over probe lights; not for
    /// the format `paper` [default: 0.5% in hierarchical blocks, 1% in textures]
    #[arg(long = "operator-error", value_name = "E", value_parser = numbers::operator_error)]
    pub error: Option<f64>,
    /// Keep form factors and the dense operator in the file
    #[arg(long)]
    pub keep_dense: bool,
}

impl Wanted {
    /// As typed, with the error that is kept within.
    pub fn text(&self, error: f64) -> String {
        format!("--operator-error {error}{}", self.keep_dense_text())
    }

    /// As typed, behind other options.
    pub fn keep_dense_text(&self) -> &'static str {
        if self.keep_dense { " --keep-dense" } else { "" }
    }
}
