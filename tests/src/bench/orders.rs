//! What the order of patches is worth: the matrix error that the paper measures, and the light that is seen.

use std::time::Instant;

use dxt_pack::Params;
use permute::{Order, order, random_order, zero_tiles};
use radfile::Permutation;
use serde::{Deserialize, Serialize};

use super::{
    case::{Case, Error},
    contest::Stamp,
    judge::Judge,
    packed::Textures,
    record::digits,
};

/// From here on orders are found and timed, but nothing is packed in them.
const LARGE: usize = 4000;

/// One order of one scene. Errors are fractions.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    pub date: String,
    pub commit: String,
    pub machine: String,
    pub scene: String,
    /// Patches.
    pub n: usize,
    /// As `allbounce permute --order` calls it; `scene` is that of voxel-simplify, `random` the paper's yardstick.
    pub order: String,
    /// Seconds to find it, on all cores, without the report.
    pub order_s: f64,
    /// Share of 16 × 16 tiles of the form factors that are zero.
    pub zero_tiles: f64,
    /// Of `paper`: RMS of the error of its codes 0..1, which the paper goes by.
    pub paper_code_rms: Option<f64>,
    /// Frobenius norm of the error of K over that of K, and the light under probes that packing did not see.
    pub paper_rms: Option<f64>,
    pub paper_l2: Option<f64>,
    pub paper_vis99: Option<f64>,
    /// The same of `bc4-sqrt`.
    pub bc4_sqrt_rms: Option<f64>,
    pub bc4_sqrt_l2: Option<f64>,
    pub bc4_sqrt_vis99: Option<f64>,
}

/// The yardstick's name in the record.
pub const RANDOM: &str = "random";

/// A row for every order.
///
/// # Errors
///
/// If something cannot be ordered or packed.
pub fn run(case: &Case, stamp: &Stamp) -> Result<Vec<Row>, Error> {
    let n = case.len();
    let random = || Ok((RANDOM, random_order(n)));
    let known = Order::ALL.map(|kind| {
        move || {
            let name = if kind == Order::None { "scene" } else { kind.name() };
            let operator = (kind == Order::Greedy).then_some(&case.operator);
            Ok::<_, Error>((name, order(&case.patches, operator, &permute::Params { order: kind })?.0))
        }
    });
    let mut rows = vec![row(case, stamp, random)?];
    for find in known {
        rows.push(row(case, stamp, find)?);
    }
    Ok(rows)
}

fn row(
    case: &Case,
    stamp: &Stamp,
    find: impl Fn() -> Result<(&'static str, Permutation), Error>,
) -> Result<Row, Error> {
    let start = Instant::now();
    let (name, found) = find()?;
    let order_s = start.elapsed().as_secs_f64();
    let (mut paper, mut sqrt) = (None, None);
    if case.len() < LARGE {
        let reordered = case.reordered(&found);
        paper = Some(errors(&reordered, &Params::PAPER)?);
        sqrt = Some(errors(&reordered, &Params::BC4_SQRT)?);
    }
    let number = |of: &Option<[f64; 4]>, k: usize| of.map(|errors| digits(errors[k], 4));
    Ok(Row {
        date: stamp.date.clone(),
        commit: stamp.commit.clone(),
        machine: stamp.machine.clone(),
        scene: case.scene.clone(),
        n: case.len(),
        order: name.into(),
        order_s: digits(order_s, 3),
        zero_tiles: digits(zero_tiles(&case.factors, &found).after, 4),
        paper_code_rms: number(&paper, 3),
        paper_rms: number(&paper, 0),
        paper_l2: number(&paper, 1),
        paper_vis99: number(&paper, 2),
        bc4_sqrt_rms: number(&sqrt, 0),
        bc4_sqrt_l2: number(&sqrt, 1),
        bc4_sqrt_vis99: number(&sqrt, 2),
    })
}

/// Error of the matrix, L2 and vis99 of the light, error of the codes.
///
/// # Errors
///
/// If it cannot be packed.
pub fn errors(case: &Case, params: &Params) -> Result<[f64; 4], Error> {
    let mut textures = Textures::pack(case, params)?;
    let score = Judge::new(case).score(&mut textures);
    Ok([textures.matrix_rms, score.l2, score.vis99, textures.code_rms(&case.operator)])
}
