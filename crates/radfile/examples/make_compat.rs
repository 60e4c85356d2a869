//! Writes the file of `tests/compat/1.4`, once. Those of 1.0 to 1.3 were made in the same way by their versions.
//!
//! `cargo run --release -p radfile --example make_compat -- FOLDER`
//!
//! It never overwrites: what version 1.4 wrote stays as it is, whatever this program writes today.

use std::path::PathBuf;

#[path = "../tests/fixture/mod.rs"]
mod fixture;

use radfile::{Builder, VERSION};

fn main() -> Result<(), String> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: make_compat FOLDER")?);
    if VERSION != (1, 4) {
        return Err(format!("this crate writes version {}.{}, the fixture is of 1.4", VERSION.0, VERSION.1));
    }
    let path = folder.join("certified.rad");
    if path.exists() {
        return Err(format!("{} is there already and is not made again", path.display()));
    }
    Builder::from_input(&fixture::certified(), |_| true).write_file(&path).map_err(|e| e.to_string())?;
    println!("{}", path.display());
    Ok(())
}
