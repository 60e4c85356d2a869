//! What every order of patches is worth, as a record. `make bench` runs it.
//!
//!     cargo run --release -p allbounce-tests --example bench_orders -- RECORD.csv DATE COMMIT MACHINE SCENE=FILE.rad …
//!
//! FILE.rad is what `allbounce series` wrote, in the order of `voxel-simplify`. The record is written anew.

use std::env;

use allbounce_tests::bench::{
    case::{Case, Error},
    contest::Stamp,
    orders, record,
};

const USAGE: &str = "usage: bench_orders RECORD.csv DATE COMMIT MACHINE SCENE=FILE.rad …";

fn main() -> Result<(), Error> {
    let args: Vec<String> = env::args().skip(1).collect();
    let [path, date, commit, machine, cases @ ..] = &args[..] else { return Err(USAGE.into()) };
    let stamp = Stamp { date: date.clone(), commit: commit.clone(), machine: machine.clone() };
    let mut rows = Vec::new();
    for case in cases {
        let (scene, file) = case.split_once('=').ok_or(USAGE)?;
        let case = Case::as_it_came(scene, file.as_ref())?;
        eprintln!("{scene} {}: orders", case.len());
        rows.append(&mut orders::run(&case, &stamp)?);
    }
    Ok(record::write(path.as_ref(), &rows)?)
}
