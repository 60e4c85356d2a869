//! `allbounce verify`: the identities of light transport, held against any container of the chain.

use std::{fmt::Write, path::PathBuf};

use anyhow::{Context, bail};
use radfile::{Container, FormFactors, Mesh, Operator, PackedOperator, Patches, Record, Transfer, read_sky};
use serde::Serialize;

use crate::{files, numbers, session::Session};

/// Check the identities that hold for any scene: reciprocity, row sums, furnace, transfer.
///
/// Exit: 0 all hold, 1 some do not or the input is refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// Container of any stage, or a bake
    file: PathBuf,
    /// Largest mean deviation of the furnace identity through the packed operator
    #[arg(long, value_name = "X", default_value_t = 0.02, value_parser = numbers::tolerance)]
    packed_tolerance: f64,
}

/// One identity: what was found, or why it was not asked.
#[derive(Serialize)]
struct Check {
    identity: String,
    #[serde(flatten)]
    outcome: Outcome,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Outcome {
    Held { deviation: f64, tolerance: f64, holds: bool },
    Skipped { skipped: String },
}

/// A deviation that is no number does not hold.
fn check(identity: impl Into<String>, deviation: f64, tolerance: f64) -> Check {
    let holds = deviation.is_finite() && deviation <= tolerance;
    Check { identity: identity.into(), outcome: Outcome::Held { deviation, tolerance, holds } }
}

/// The furnace identity is about all bounces.
fn no_furnace(bounces: u32) -> Check {
    let skipped = format!("the operator holds {bounces} bounces only");
    Check { identity: "furnace identity".into(), outcome: Outcome::Skipped { skipped } }
}

impl Check {
    fn fails(&self) -> bool {
        matches!(self.outcome, Outcome::Held { holds: false, .. })
    }

    fn line(&self) -> String {
        match &self.outcome {
            Outcome::Held { deviation, tolerance, holds } => {
                let verdict = if *holds { "holds" } else { "FAILS" };
                format!("{verdict}  {:<64} {deviation:.2e} (tolerance {tolerance:.0e})", self.identity)
            }
            Outcome::Skipped { skipped } => format!("skipped  {}: {skipped}", self.identity),
        }
    }
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let c = files::open(&args.file)?;
    let name = || args.file.display().to_string();
    if c.has("pack.meta") {
        let packing = PackedOperator::read(&c).with_context(name)?.packing;
        let need = 4 * u64::from(packing.channels) * u64::from(packing.n).pow(2);
        session.ask_memory("verify", need, "it decodes the whole operator; verify a bake of fewer patches")?;
    }
    let checks = identities(&c, args.packed_tolerance).with_context(name)?;
    let mut text = String::new();
    for check in &checks {
        writeln!(text, "{}", check.line())?;
    }
    files::print(&text)?;
    session.finish(&checks)?;
    let held = checks.iter().filter(|c| matches!(c.outcome, Outcome::Held { .. })).count();
    match checks.iter().filter(|c| c.fails()).count() {
        0 => Ok(()),
        failed => bail!("{}: {failed} of {held} identities do not hold", name()),
    }
}

/// Every identity that the container has the numbers for.
fn identities(c: &Container, packed_tolerance: f64) -> anyhow::Result<Vec<Check>> {
    let patches = Patches::read(c)?;
    let mut checks = vec![pieces(&patches)];
    if c.has("formfactor.values") {
        checks.extend(form_factors(&FormFactors::read(c)?, &patches, Mesh::read(c)?.one_sided)?);
    }
    if c.has("series.values") {
        checks.extend(operator(c, &patches)?);
    }
    if c.has("pack.blocks") {
        checks.push(packed(c, &patches, packed_tolerance)?);
    }
    if c.has("transfer.weight") {
        checks.push(transfer(&Transfer::read(c)?));
    }
    Ok(checks)
}

/// The largest value, at least 0; one that is no number wins, where `f64::max` would drop it.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| if most.is_nan() || value <= most { most } else { value })
}

/// Area of a patch = sum of its pieces.
fn pieces(p: &Patches) -> Check {
    let deviation = |i: usize| {
        let sum: f64 = p.pieces_of(i).iter().map(|piece| area(&piece.corners)).sum();
        (sum / f64::from(p.area[i]) - 1.0).abs()
    };
    check("a patch is as large as its pieces", largest((0..p.len()).map(deviation)), 1e-3)
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

fn row_sum(f: &FormFactors, i: usize) -> f64 {
    f.row(i).iter().map(|&v| f64::from(v)).sum()
}

/// Difference of two numbers that should agree, relative to the larger.
fn mismatch(there: f64, back: f64) -> f64 {
    (there - back).abs() / there.max(back).max(1e-30)
}

/// Pairs of patches, each once.
fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(|i| (0..i).map(move |j| (i, j)))
}

/// Reciprocity, A_i F_ij = A_j F_ji, and what becomes of the light of a patch: Σ_j F_ij + sky_i is 1 less
/// what was absorbed.
///
/// The back of a one-sided surface absorbs, and the file does not say how much: there only an excess is held
/// against a row. Where both sides reflect, a row can lack something only where its rays met a sliver too small to
/// be a patch, or where the patch lies so close between others that it could not be sampled at all. Both are rare
/// but whole rows when they happen (at most 0.04 % of the light in eight rooms, single rows down to 0), so the mean
/// over the area is held to 0.1 % and no single row is.
fn form_factors(f: &FormFactors, p: &Patches, one_sided: bool) -> anyhow::Result<Vec<Check>> {
    same_size("form factors", f.len(), p)?;
    let exchange = |i: usize, j: usize| f64::from(p.area[i]) * f64::from(f.values[i * f.len() + j]);
    let reciprocity = largest(pairs(f.len()).map(|(i, j)| mismatch(exchange(i, j), exchange(j, i))));
    let excess: Vec<f64> = (0..f.len()).map(|i| row_sum(f, i) + f64::from(f.sky[i]) - 1.0).collect();
    let mut checks = vec![
        check("reciprocity of form factors, A_i F_ij = A_j F_ji", reciprocity, 1e-5),
        check("rows of F and the sky do not exceed 1", largest(excess.iter().copied()), 1e-5),
    ];
    if !one_sided {
        checks.push(check("rows of F and the sky reach 1, mean over the area", mean(p, |i| excess[i].abs()), 1e-3));
    }
    Ok(checks)
}

/// Mean over the area of the patches.
fn mean(p: &Patches, value: impl Fn(usize) -> f64) -> f64 {
    let area = |i: usize| f64::from(p.area[i]);
    (0..p.len()).map(|i| area(i) * value(i)).sum::<f64>() / (0..p.len()).map(area).sum::<f64>()
}

/// Symmetry, furnace identity and X ≥ A F.
fn operator(c: &Container, p: &Patches) -> anyhow::Result<Vec<Check>> {
    let k = Operator::read(c)?;
    same_size("operator rows", k.n, p)?;
    let asymmetry = (0..k.channels).map(|colour| {
        let at = |i: usize, j: usize| f64::from(k.channel(colour)[i * k.n + j]);
        largest(pairs(k.n).map(|(i, j)| mismatch(at(i, j), at(j, i))))
    });
    let mut checks = vec![check("the operator is symmetric, X_ij = X_ji", largest(asymmetry), 1e-5)];
    if c.has("formfactor.values") {
        let f = FormFactors::read(c)?;
        let below = (0..k.channels).map(|colour| {
            largest((0..k.n * k.n).map(|at| {
                let (i, j) = (at / k.n, at % k.n);
                let one_bounce = f64::from(f.values[at]) * (f64::from(p.area[i]) / f64::from(p.area[j])).sqrt();
                one_bounce - f64::from(k.channel(colour)[at]) - 1e-6 * one_bounce
            }))
        });
        checks.push(check("all bounces are at least one bounce, X ≥ A F", largest(below), 1e-6));
    }
    checks.push(match k.bounces {
        Some(bounces) => no_furnace(bounces),
        None => {
            let surroundings = Surroundings::read(c, p)?;
            let deviations = surroundings.furnace(p, k.channels, |colour, i| &k.channel(colour)[i * k.n..][..k.n]);
            let identity = surroundings.identity("dense operator, worst patch");
            check(identity, largest(deviations.into_iter().flatten()), 1e-4)
        }
    });
    Ok(checks)
}

/// Furnace identity through the packed operator.
fn packed(c: &Container, p: &Patches, tolerance: f64) -> anyhow::Result<Check> {
    let packed = PackedOperator::read(c)?;
    let (n, channels) = (packed.packing.n as usize, packed.packing.channels as usize);
    same_size("packed rows", n, p)?;
    if let Some(bounces) = packed.packing.bounces {
        return Ok(no_furnace(bounces));
    }
    let matrices: Vec<Vec<f32>> = (0..channels).map(|colour| packed.decode(colour)).collect();
    let surroundings = Surroundings::read(c, p)?;
    let deviations = surroundings.furnace(p, channels, |colour, i| &matrices[colour][i * n..][..n]);
    let means = deviations.iter().map(|of_patch| mean(p, |i| of_patch[i]));
    let identity = surroundings.identity("packed operator, mean over patches");
    Ok(check(identity, means.sum::<f64>() / channels as f64, tolerance))
}

/// What each patch sees that is no patch.
///
/// In the furnace it shines like the sky. That is exact for any scene where F is there to say how much it is;
/// where F has been dropped, only the sky is known, and a one-sided scene stays below 1 by what its backs absorb.
struct Surroundings {
    share: Vec<f64>,
    /// Whether only an excess can be held against the operator.
    from_above: bool,
}

impl Surroundings {
    fn read(c: &Container, p: &Patches) -> anyhow::Result<Surroundings> {
        let sky = read_sky(c)?;
        same_size("sky shares", sky.len(), p)?;
        if c.has("formfactor.values") {
            let f = FormFactors::read(c)?;
            return Ok(Surroundings { share: (0..f.len()).map(|i| 1.0 - row_sum(&f, i)).collect(), from_above: false });
        }
        let share = sky.iter().map(|&s| f64::from(s)).collect();
        Ok(Surroundings { share, from_above: Mesh::read(c)?.one_sided })
    }

    fn identity(&self, of: &str) -> String {
        let note = if self.from_above { " (checked from above only: back sides absorb)" } else { "" };
        format!("furnace identity of the {of}{note}")
    }

    /// Deviation of A^{-1} X (1 − ρ + ρ s) + s = 1 with s = `share`, for every channel and patch.
    ///
    /// It is what a patch receives where every patch emits 1 − ρ and all that is no patch shines with 1.
    fn furnace<'k>(&self, p: &Patches, channels: usize, row: impl Fn(usize, usize) -> &'k [f32]) -> Vec<Vec<f64>> {
        let sent = |colour: usize, j: usize| {
            let rho = f64::from(p.reflectance[j][colour]);
            f64::from(p.area[j]).sqrt() * (1.0 - rho + rho * self.share[j])
        };
        let deviations = |colour: usize| {
            let sent: Vec<f64> = (0..p.len()).map(|j| sent(colour, j)).collect();
            let deviation = |i: usize| {
                let gathered: f64 = row(colour, i).iter().zip(&sent).map(|(&k, s)| f64::from(k) * s).sum();
                let excess = gathered / f64::from(p.area[i]).sqrt() + self.share[i] - 1.0;
                if self.from_above && excess < 0.0 { 0.0 } else { excess.abs() }
            };
            (0..p.len()).map(deviation).collect()
        };
        (0..channels).map(deviations).collect()
    }
}

/// Weights of a receiver make a mean.
fn transfer(t: &Transfer) -> Check {
    let deviation = |r: usize| {
        let (count, sum) = t.rows.row(r).fold((0, 0.0), |(n, s), (_, w)| (n + 1, s + f64::from(w)));
        if count == 0 { 0.0 } else { (sum - 1.0f64).abs() }
    };
    check("transfer weights of a receiver sum to 1", largest((0..t.rows.len()).map(deviation)), 1e-4)
}
