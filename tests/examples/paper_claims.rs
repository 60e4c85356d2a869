//! Which claims of the paper hold, as a page and a table. `make claims` runs it.
//!
//!     cargo run --release -p allbounce-tests --example paper_claims -- PAGE.md DATE COMMIT MACHINE SCENE=FILE.rad …
//!
//! FILE.rad is what `allbounce formfactor` wrote of sides of voxels (`voxel-simplify --mode faces`). The table stands beside the page.

use std::{env, fs, path::Path};

use allbounce_tests::bench::{
    case::Error,
    claims::{self, page},
    contest::Stamp,
    record,
};

const USAGE: &str = "usage: paper_claims PAGE.md DATE COMMIT MACHINE SCENE=FILE.rad …";

fn main() -> Result<(), Error> {
    let args: Vec<String> = env::args().skip(1).collect();
    let [path, date, commit, machine, cases @ ..] = &args[..] else { return Err(USAGE.into()) };
    let stamp = Stamp { date: date.clone(), commit: commit.clone(), machine: machine.clone() };
    let mut found = Vec::new();
    for case in cases {
        let (scene, file) = case.split_once('=').ok_or(USAGE)?;
        eprintln!("{scene}: {file}");
        found.push(claims::run(scene, file.as_ref())?);
    }
    let all: Vec<_> = found.iter().flat_map(|f| f.claims.clone()).collect();
    record::write(&Path::new(path).with_extension("csv"), &all)?;
    Ok(fs::write(path, page::text(&found, &stamp))?)
}
