//! `allbounce show`: a container of any stage and a camera in, a picture of its patches out.

mod light;
mod patches;
mod row;
mod view;

use crate::session::Session;

/// Pictures of the patches of a container: what a stage of a bake has made.
///
/// Any container that has patches will do, from `voxel-simplify` on. Exit: 0 done, 1 input refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Patches(patches::Args),
    Row(row::Args),
    Light(light::Args),
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    match &args.what {
        What::Patches(args) => patches::run(args, session),
        What::Row(args) => row::run(args, session),
        What::Light(args) => light::run(args, session),
    }
}
