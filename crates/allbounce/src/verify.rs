//! `allbounce verify`: the identities of light transport, held against any container of the chain.

use std::path::PathBuf;

use anyhow::bail;
use radfile::{Container, FormFactors, Mesh, Operator, PackedOperator, Patches, Record, Transfer, read_sky};
use serde::Serialize;

use crate::{files, session::Session};

/// Check the identities that hold for any scene: reciprocity, row sums, furnace, transfer.
///
/// Exit: 0 all hold, 1 some do not or the input is refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// Container of any stage, or a bake
    file: PathBuf,
    /// Largest mean deviation of the furnace identity through the packed operator
    #[arg(long, value_name = "X", default_value_t = 0.02)]
    packed_tolerance: f64,
}

/// One identity.
#[derive(Serialize)]
struct Check {
    identity: &'static str,
    deviation: f64,
    tolerance: f64,
    holds: bool,
}

fn check(identity: &'static str, deviation: f64, tolerance: f64) -> Check {
    Check { identity, deviation, tolerance, holds: deviation <= tolerance }
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let c = files::open(&args.file)?;
    let patches = Patches::read(&c)?;
    let mut checks = vec![pieces(&patches)];
    if c.has("formfactor.values") {
        checks.extend(form_factors(&FormFactors::read(&c)?, &patches)?);
    }
    if c.has("series.values") {
        checks.extend(operator(&c, &patches)?);
    }
    if c.has("pack.blocks") {
        checks.extend(packed(&c, &patches, args.packed_tolerance)?);
    }
    if c.has("transfer.weight") {
        checks.push(transfer(&Transfer::read(&c)?));
    }
    for check in &checks {
        let verdict = if check.holds { "holds" } else { "FAILS" };
        println!("{verdict}  {:<64} {:.2e} (tolerance {:.0e})", check.identity, check.deviation, check.tolerance);
    }
    session.finish(&checks)?;
    match checks.iter().filter(|c| !c.holds).count() {
        0 => Ok(()),
        failed => bail!("{}: {failed} of {} identities do not hold", args.file.display(), checks.len()),
    }
}

/// Area of a patch = sum of its pieces.
fn pieces(p: &Patches) -> Check {
    let worst = (0..p.len()).map(|i| {
        let sum: f64 = p.pieces_of(i).iter().map(|piece| area(&piece.corners)).sum();
        (sum / f64::from(p.area[i]) - 1.0).abs()
    });
    check("a patch is as large as its pieces", worst.fold(0.0, f64::max), 1e-3)
}

fn area(corners: &[[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| glam::Vec3::from(p).as_dvec3());
    0.5 * (b - a).cross(c - a).length()
}

fn same_size(what: &str, found: usize, patches: &Patches) -> anyhow::Result<()> {
    if found != patches.len() {
        bail!("{what} are for {found} patches, the file has {}", patches.len());
    }
    Ok(())
}

/// Reciprocity, and nothing gained: A_i F_ij = A_j F_ji, Σ_j F_ij + sky_i ≤ 1.
fn form_factors(f: &FormFactors, p: &Patches) -> anyhow::Result<Vec<Check>> {
    same_size("form factors", f.len(), p)?;
    let n = f.len();
    let (mut reciprocity, mut rows) = (0.0f64, 0.0f64);
    for i in 0..n {
        let row = f.row(i);
        for j in 0..i {
            let (there, back) = (f64::from(p.area[i] * row[j]), f64::from(p.area[j] * f.values[j * n + i]));
            reciprocity = reciprocity.max((there - back).abs() / there.max(back).max(1e-30));
        }
        let sum: f64 = row.iter().map(|&v| f64::from(v)).sum::<f64>() + f64::from(f.sky[i]);
        rows = rows.max(sum - 1.0);
    }
    Ok(vec![
        check("reciprocity of form factors, A_i F_ij = A_j F_ji", reciprocity, 1e-5),
        check("rows of F and the sky do not exceed 1", rows, 1e-5),
    ])
}

/// Symmetry, furnace identity and X ≥ A F.
fn operator(c: &Container, p: &Patches) -> anyhow::Result<Vec<Check>> {
    let k = Operator::read(c)?;
    same_size("operator rows", k.n, p)?;
    let mut checks = Vec::new();
    let mut asymmetry = 0.0f64;
    for colour in 0..k.channels {
        let m = k.channel(colour);
        for i in 0..k.n {
            for j in 0..i {
                let (there, back) = (m[i * k.n + j], m[j * k.n + i]);
                asymmetry = asymmetry.max(f64::from((there - back).abs()) / f64::from(there.max(back)).max(1e-30));
            }
        }
    }
    checks.push(check("the operator is symmetric, X_ij = X_ji", asymmetry, 1e-5));
    if c.has("formfactor.values") {
        let f = FormFactors::read(c)?;
        let below = (0..k.n * k.n).map(|at| {
            let (i, j) = (at / k.n, at % k.n);
            let one_bounce = f64::from(f.values[at]) * (f64::from(p.area[i]) / f64::from(p.area[j])).sqrt();
            one_bounce - f64::from(k.channel(1)[at]) - 1e-6 * one_bounce
        });
        checks.push(check("all bounces are at least one bounce, X ≥ A F", below.fold(0.0, f64::max), 1e-6));
    }
    if k.bounces.is_none() {
        let row = |colour: usize, i: usize| k.channel(colour)[i * k.n..][..k.n].to_vec();
        let (worst, _) = furnace(c, p, k.channels, row)?;
        checks.push(check("furnace identity of the dense operator, worst patch", worst, 1e-4));
    }
    Ok(checks)
}

/// Furnace identity through the packed operator.
fn packed(c: &Container, p: &Patches, tolerance: f64) -> anyhow::Result<Vec<Check>> {
    let packed = PackedOperator::read(c)?;
    let n = packed.packing.n as usize;
    same_size("packed rows", n, p)?;
    if packed.packing.bounces.is_some() {
        return Ok(vec![]); // the identity is about all bounces
    }
    let matrices: Vec<Vec<f32>> = (0..packed.packing.channels as usize).map(|colour| packed.decode(colour)).collect();
    let row = |colour: usize, i: usize| matrices[colour][i * n..][..n].to_vec();
    let (_, mean) = furnace(c, p, matrices.len(), row)?;
    Ok(vec![check("furnace identity of the packed operator, mean over patches", mean, tolerance)])
}

/// Worst and area-mean deviation of A^{-1} X (1 − ρ) + sky + A^{-1} X ρ sky = 1 over patches and channels.
/// Where back sides are black the left side stays below 1, and only an excess counts.
fn furnace(
    c: &Container,
    p: &Patches,
    channels: usize,
    row: impl Fn(usize, usize) -> Vec<f32>,
) -> anyhow::Result<(f64, f64)> {
    let sky = read_sky(c)?;
    same_size("sky shares", sky.len(), p)?;
    let one_sided = Mesh::read(c)?.one_sided;
    let (mut worst, mut sum, mut area) = (0.0f64, 0.0, 0.0);
    for colour in 0..channels {
        for i in 0..p.len() {
            let gathered: f64 = row(colour, i)
                .iter()
                .enumerate()
                .map(|(j, &k)| {
                    let rho = f64::from(p.reflectance[j][colour]);
                    f64::from(k) * f64::from(p.area[j]).sqrt() * (1.0 - rho + rho * f64::from(sky[j]))
                })
                .sum();
            let total = gathered / f64::from(p.area[i]).sqrt() + f64::from(sky[i]);
            let deviation = if one_sided { (total - 1.0).max(0.0) } else { (total - 1.0).abs() };
            worst = worst.max(deviation);
            sum += deviation * f64::from(p.area[i]);
            area += f64::from(p.area[i]);
        }
    }
    Ok((worst, sum / area))
}

/// Weights of a receiver make a mean.
fn transfer(t: &Transfer) -> Check {
    let worst = (0..t.rows.len()).map(|r| {
        let (count, sum) = t.rows.row(r).fold((0, 0.0), |(n, s), (_, w)| (n + 1, s + f64::from(w)));
        if count == 0 { 0.0 } else { (sum - 1.0f64).abs() }
    });
    check("transfer weights of a receiver sum to 1", worst.fold(0.0, f64::max), 1e-4)
}
