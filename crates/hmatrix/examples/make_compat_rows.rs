//! Packs the form factors of the receivers of `tests/compat/1.3`, once: crates/radfile/tests/fixture/*.hmr.
//!
//! `cargo run --release -p hmatrix --example make_compat_rows -- FOLDER`
//!
//! It never overwrites a stream: what was packed when version 1.3 was new stays as it is, whatever this program packs today.

use std::path::{Path, PathBuf};

#[path = "../../radfile/tests/fixture/mod.rs"]
mod fixture;

use hmatrix::{Params, Receivers, Senders, compress_rows, sparse};
use radfile::{Quiet, Volume};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: make_compat_rows FOLDER")?);
    let (transfer, lightmap, volume) = (fixture::cube().transfer, fixture::lightmap(), fixture::volume());
    make(&folder.join("vertices.hmr"), &transfer.position, &transfer.normal)?;
    make(&folder.join("texels.hmr"), &lightmap.position, &lightmap.normal)?;
    let position: Vec<[f32; 3]> = volume.position.iter().flat_map(|&p| [p; 6]).collect();
    let normal: Vec<[f32; 3]> = volume.position.iter().flat_map(|_| Volume::NORMALS).collect();
    make(&folder.join("probes.hmr"), &position, &normal)
}

fn make(path: &Path, position: &[[f32; 3]], normal: &[[f32; 3]]) -> Result<(), Failure> {
    if path.exists() && !std::fs::read(path)?.is_empty() {
        return Err(format!("{} is there already and is not made again", path.display()).into());
    }
    let (patches, elements) = (fixture::cube().patches, fixture::elements());
    let of_elements = |values: &[[f32; 3]]| -> Vec<[f32; 3]> {
        (0..patches.len()).flat_map(|p| elements.of(p).map(move |_| values[p])).collect()
    };
    let senders = Senders {
        position: &[&patches.position[..], &elements.point].concat(),
        normal: &[&patches.normal[..], &of_elements(&patches.normal)].concat(),
        area: &[&patches.area[..], &elements.area].concat(),
        reflectance: &[&patches.reflectance[..], &elements.reflectance].concat(),
    };
    let (receivers, rows) = (Receivers { position, normal }, fixture::form_factors(position.len()));
    let source = sparse(&rows, &receivers)?;
    let (packed, report) = compress_rows(&receivers, &senders, &source, &Params::error(0.0005), &Quiet)?;
    std::fs::write(path, packed.to_bytes())?;
    println!("{}: {} bytes, error {:.1e}", path.display(), packed.to_bytes().len(), report.l2_mean);
    Ok(())
}
