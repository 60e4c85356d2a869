//! What uniform and adaptive patches are worth, as a record.
//!
//!     cargo run --release -p allbounce-tests --example bench_adaptive -- \
//!         RECORD.csv DATE COMMIT MACHINE SCENE TRUTH.rad LIGHTS.json[,LIGHTS.json…] KIND=FILE.rad …
//!
//! Files are what `allbounce series` wrote, KIND is `uniform` or `adaptive`. Rows of the same scene are replaced.

use std::env;

use allbounce_tests::bench::{
    adaptive::{Judge, Row, open},
    case::Error,
    contest::Stamp,
    record,
};
use scene::{Rays, Scene};

const USAGE: &str =
    "usage: bench_adaptive RECORD.csv DATE COMMIT MACHINE SCENE TRUTH.rad LIGHTS.json,… KIND=FILE.rad …";

fn main() -> Result<(), Error> {
    let args: Vec<String> = env::args().skip(1).collect();
    let [path, date, commit, machine, name, truth, lights, bakes @ ..] = &args[..] else { return Err(USAGE.into()) };
    let stamp = Stamp { date: date.clone(), commit: commit.clone(), machine: machine.clone() };
    let files = lights.split(',').map(std::fs::read_to_string).collect::<Result<Vec<_>, _>>()?;
    let mut opened = Vec::new();
    for bake in bakes {
        let (kind, file) = bake.split_once('=').ok_or(USAGE)?;
        opened.push((kind.to_owned(), open(file)?));
    }
    let truth = open(truth)?;
    let scene = Scene::read(&truth)?;
    let rays = Rays::new(&scene.mesh);
    let found = Judge::new(&truth, &scene, &rays, files)?.rows(name, &opened, &stamp)?;
    for row in &found {
        let [constant, gathered] = [row.constant, row.gathered].map(|e| 100.0 * e);
        eprintln!("{name} {} {} {}: {constant:.2} % constant, {gathered:.2} % gathered", row.kind, row.n, row.lights);
    }
    let mut rows: Vec<Row> = record::read(path.as_ref())?;
    rows.retain(|row| &row.scene != name);
    rows.extend(found);
    Ok(record::write(path.as_ref(), &rows)?)
}
