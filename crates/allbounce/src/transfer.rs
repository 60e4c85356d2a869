//! `allbounce transfer`: weights that carry patch light to the vertices of a finer mesh.

use radfile::{Container, Progress, Sink, Step};

use crate::{numbers, stage::Stage};

/// Tessellate the mesh and find, for each vertex and side, the patches whose light it shows.
///
/// Reads mesh and patches. Adds the finer mesh and normalised weights over patches the vertex can see.
#[derive(clap::Args)]
pub struct Options {
    /// Longest edge of the finer mesh, such as 0.1m [default: the voxel size]
    #[arg(long, value_name = "LENGTH", value_parser = numbers::metres)]
    edge: Option<f32>,
}

impl Stage for Options {
    const NAME: &'static str = "transfer";
    type Report = transfer::Report;

    fn text(&self) -> String {
        self.edge.map_or_else(String::new, |edge| format!("--edge {edge}m"))
    }

    fn memory(&self, _input: &Container) -> anyhow::Result<(u64, &'static str)> {
        Ok((0, "")) // the stage itself refuses a tessellation that is out of proportion
    }

    fn apply(&self, input: &Container, step: Step, p: &dyn Progress, sink: &mut Sink) -> anyhow::Result<Self::Report> {
        let params = transfer::Params { edge: self.edge, ..transfer::Params::default() };
        Ok(transfer::run(input, &params, step, p, sink)?)
    }
}
