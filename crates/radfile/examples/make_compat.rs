//! Writes the files of `tests/compat/1.0`, once.
//!
//! `cargo run --release -p radfile --example make_compat -- FOLDER`
//!
//! It never overwrites: what version 1.0 wrote stays as it is, whatever this program writes today.

use std::path::PathBuf;

#[path = "../tests/fixture/mod.rs"]
mod fixture;

use radfile::{Builder, Record, VERSION};

fn main() -> Result<(), String> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: make_compat FOLDER")?);
    if VERSION != (1, 0) {
        return Err(format!("this crate writes version {}.{}, the fixture is of 1.0", VERSION.0, VERSION.1));
    }
    let (cube, mut paper) = (fixture::cube(), Builder::new());
    let packed = cube.packed_as_the_paper();
    packed.write(&mut paper);
    paper.provenance(None, fixture::step("dxt-pack")).map_err(|e| e.to_string())?;
    let files = [
        ("minimal.rad", fixture::minimal()),
        ("cube.rad", cube.builder()),
        ("cube-bc1.rad", paper),
        ("every-feature.rad", fixture::every_feature()),
    ];
    for (name, builder) in &files {
        let path = folder.join(name);
        if path.exists() {
            return Err(format!("{} is there already and is not made again", path.display()));
        }
        builder.write_file(&path).map_err(|e| e.to_string())?;
        println!("{}", path.display());
    }
    Ok(())
}
