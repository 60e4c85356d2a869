//! Bytes, times and errors of every way to keep the operator, as a record. `make bench` runs it on all its scenes.
//!
//!     cargo run --release -p allbounce-tests --example bench_operators -- RECORD.csv DATE COMMIT MACHINE [--only FORMAT[/SETTING],…] \
//!         SCENE=FILE.rad …
//!
//! With ALLBOUNCE_GPU=skip, or without an adapter, the columns of the GPU stay empty. FILE.rad is what `allbounce series` wrote. Rows of the same operator of the same bake are replaced, others stay.
//! `bench/record/README.md` says what the columns mean.

use std::{env, path::Path};

use allbounce_tests::bench::{
    case::{Case, Error},
    contest::{self, Stamp},
    record::{self, Row},
};
use gpu_runtime::Gpu;

const USAGE: &str =
    "usage: bench_operators RECORD.csv DATE COMMIT MACHINE [--only FORMAT[/SETTING],…] SCENE=FILE.rad …";

fn main() -> Result<(), Error> {
    let args: Vec<String> = env::args().skip(1).collect();
    let [path, date, commit, machine, cases @ ..] = &args[..] else { return Err(USAGE.into()) };
    let (only, cases) = match cases {
        [option, formats, cases @ ..] if option == "--only" => (Some(formats.split(',').collect::<Vec<_>>()), cases),
        _ => (None, cases),
    };
    let wanted = |format: &str, setting: &str| {
        let named = |only: &&str| *only == format || only.strip_prefix(format) == Some(&format!("/{setting}"));
        only.as_ref().is_none_or(|only| only.iter().any(named))
    };
    let stamp = Stamp { date: date.clone(), commit: commit.clone(), machine: machine.clone() };
    let gpu = match env::var("ALLBOUNCE_GPU").as_deref() {
        Ok("skip") => None,
        _ => Gpu::new().inspect_err(|error| eprintln!("the GPU columns stay empty: {error}")).ok(),
    };
    for case in cases {
        let (scene, file) = case.split_once('=').ok_or(USAGE)?;
        let case = Case::read(scene, file.as_ref())?;
        let n = case.len();
        let mut say = |what: &str| eprintln!("{scene} {n}: {what}");
        let found = contest::run(&case, &stamp, gpu.as_ref(), &wanted, &mut say)?;
        add(path.as_ref(), found)?;
    }
    Ok(())
}

/// Puts rows in the place of older ones.
fn add(path: &Path, found: Vec<Row>) -> Result<(), Error> {
    let mut rows: Vec<Row> = record::read(path)?;
    let place = |row: &Row, rows: &[Row]| {
        rows.iter().position(|old| {
            (&old.scene, old.n, &old.format, &old.setting) == (&row.scene, row.n, &row.format, &row.setting)
        })
    };
    for row in found {
        match place(&row, &rows) {
            Some(at) => rows[at] = row,
            None => rows.push(row),
        }
    }
    rows.sort_by(|a, b| (&a.scene, a.n).cmp(&(&b.scene, b.n)));
    Ok(record::write(path, &rows)?)
}
