//! All bounces: what the dense operator and the packed one are held to.

use radfile::{Container, FormFactors, Operator, Patches, Record};

use super::{
    check::{Check, check, skip},
    light::{Bounced, Surroundings},
    patches::{largest, mean, mismatch, pairs, same_size},
};

const FURNACE: &str = "furnace identity";
const BALANCE: &str = "energy balance of one reflectance";
/// Largest deviation of light through the dense operator: f32, over thousands of small numbers.
const DENSE: f64 = 1e-4;

/// Symmetry, X ≥ A F, furnace identity and energy balance of the dense operator.
pub fn dense(c: &Container, p: &Patches) -> anyhow::Result<Vec<Check>> {
    let k = Operator::read(c)?;
    same_size("operator rows", k.n, p)?;
    let asymmetry = (0..k.channels).map(|colour| {
        let at = |i: usize, j: usize| f64::from(k.channel(colour)[i * k.n + j]);
        largest(pairs(k.n).map(|(i, j)| mismatch(at(i, j), at(j, i))))
    });
    let mut checks = vec![check("4.2", "the operator is symmetric, X_ij = X_ji", largest(asymmetry), 1e-5)];
    if c.has("formfactor.values") {
        let f = FormFactors::read(c)?;
        same_size("form factors", f.len(), p)?;
        let short = largest((0..k.channels).map(|colour| shortfall(k.channel(colour), &f, p)));
        checks.push(check("8.4", "all bounces are at least one bounce, X ≥ A F", short, 1e-6));
    }
    if let Some(bounces) = k.bounces {
        checks.extend(of_some_bounces(bounces));
        return Ok(checks);
    }
    let around = Surroundings::read(c, p)?;
    let product = |colour: usize, x: &[f64]| -> Vec<f64> {
        let row = |row: &[f32]| row.iter().zip(x).map(|(&k, x)| f64::from(k) * x).sum();
        k.channel(colour).chunks(k.n.max(1)).map(row).collect()
    };
    let all = Bounced { patches: p, channels: k.channels, product };
    let worst = largest(all.furnace(&around).into_iter().flatten());
    checks.push(check("7.2", around.named(FURNACE, "dense operator, worst patch"), worst, DENSE));
    let balance = format!("{BALANCE}, dense operator");
    checks.push(match all.balance(&around) {
        Ok(deviation) => check("8.2", balance, deviation, DENSE),
        Err(reason) => skip("8.2", balance, reason),
    });
    Ok(checks)
}

/// How far K falls short of W = A^{1/2} F A^{-1/2}, at most.
fn shortfall(k: &[f32], f: &FormFactors, p: &Patches) -> f64 {
    let n = f.len();
    largest((0..n * n).map(|at| {
        let (i, j) = (at / n, at % n);
        let one_bounce = f64::from(f.values[at]) * (f64::from(p.area[i]) / f64::from(p.area[j])).sqrt();
        one_bounce - f64::from(k[at]) - 1e-6 * one_bounce
    }))
}

/// Furnace identity and energy balance through the packed operator, by the product that frames use.
pub fn packed(c: &Container, p: &Patches, tolerance: f64) -> anyhow::Result<Vec<Check>> {
    let packed = relight::Operator::read(c)?;
    same_size("packed rows", packed.patches(), p)?;
    if let Some(bounces) = packed.bounces() {
        return Ok(of_some_bounces(bounces).into());
    }
    let product = |colour: usize, x: &[f64]| -> Vec<f64> {
        let x: Vec<[f32; 3]> = x.iter().map(|&v| [v as f32; 3]).collect();
        let mut y = vec![[0.0; 3]; x.len()];
        packed.multiply(&p.reflectance, &x, &mut y, &mut packed.workspace());
        y.iter().map(|y| f64::from(y[colour])).collect()
    };
    let channels = 3;
    let around = Surroundings::read(c, p)?;
    let all = Bounced { patches: p, channels, product };
    let means = all.furnace(&around).into_iter().map(|of_patch| mean(p, |i| of_patch[i]));
    let furnace = means.sum::<f64>() / channels as f64;
    let balance = format!("{BALANCE}, packed operator");
    Ok(vec![
        check("7.2", around.named(FURNACE, "packed operator, mean over patches"), furnace, tolerance),
        match all.balance(&around) {
            Ok(deviation) => check("8.2", balance, deviation, tolerance),
            Err(reason) => skip("8.2", balance, reason),
        },
    ])
}

/// Both are about all bounces.
fn of_some_bounces(bounces: u32) -> [Check; 2] {
    let reason = format!("the operator holds {bounces} bounces only");
    [skip("7.2", FURNACE, reason.clone()), skip("8.2", BALANCE, reason)]
}
