//! The voxel size that gives a wanted number of patches.
//!
//! The count falls roughly with the square of the size, but in steps: a wall gains a whole row of
//! patches at once, and parts smaller than a voxel are patches at any size. So: steps along the
//! local slope of log count over log size until the size is bracketed, interpolation between the
//! brackets, and if the count jumps over the wanted one there, grids with another layer of cells.

use crate::{Attempt, Error};

/// Good enough to stop at once.
const CLOSE: f64 = 0.02;
/// Good enough to stop after a few attempts, within the promised 10 %.
const FAIR: f64 = 0.07;
const FEW: usize = 5;
const MOST: usize = 16;
/// Brackets closer than this leave only a jump between them.
const NARROW: f64 = 0.004;
const EXTRA: [[u32; 3]; 7] = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 0, 1], [0, 1, 1], [1, 1, 1]];

/// What came of one size.
pub struct Outcome<T> {
    pub patches: usize,
    pub value: T,
    /// Patches are made in another way from now on.
    pub changed: bool,
}

/// Searches between voxels as small as it takes and `largest` metres, beginning at `start`.
///
/// `attempt` gives the number of patches for a size and extra layers, and whatever came of it; the
/// one nearest to `wanted` is returned with all attempts. It may change its mind about how patches
/// are made once, and says so; then what was learnt before no longer counts.
///
/// # Errors
///
/// The first error of `attempt`.
pub fn search<T>(
    wanted: u32,
    start: f32,
    largest: f32,
    mut attempt: impl FnMut(f32, [u32; 3]) -> Result<Outcome<T>, Error>,
) -> Result<(T, Vec<Attempt>), Error> {
    let mut attempts: Vec<Attempt> = Vec::new();
    let mut best: Option<(f64, T)> = None;
    let mut go = |voxel: f32, extra_layers, attempts: &mut Vec<Attempt>| -> Result<(f64, bool), Error> {
        let Outcome { patches, value, changed } = attempt(voxel, extra_layers)?;
        attempts.push(Attempt { voxel, extra_layers, patches });
        let excess = (patches.max(1) as f64 / f64::from(wanted)).ln();
        if changed || best.as_ref().is_none_or(|(least, _)| excess.abs() < *least) {
            best = Some((excess.abs(), value));
        }
        Ok((excess, changed))
    };

    let largest = f64::from(largest).ln();
    let mut size = f64::from(start).ln().min(largest);
    // Points of (ln size, ln count / wanted) on both sides of the goal.
    let mut fine: Option<(f64, f64)> = None;
    let mut coarse: Option<(f64, f64)> = None;
    while attempts.len() < MOST {
        let (excess, changed) = go(size.exp() as f32, [0; 3], &mut attempts)?;
        if changed {
            (fine, coarse) = (None, None);
        }
        let enough = if attempts.len() < FEW { CLOSE } else { FAIR };
        if excess.abs() <= enough || (excess > 0.0 && size >= largest) {
            break;
        }
        let last = if excess > 0.0 { fine.replace((size, excess)) } else { coarse.replace((size, excess)) };
        size = match (fine, coarse) {
            (Some(f), Some(c)) if (c.0 - f.0).abs() < NARROW => break,
            (Some(f), Some(c)) => {
                let share = (f.1 / (f.1 - c.1)).clamp(0.1, 0.9);
                f.0 + if attempts.len() % 4 == 3 { 0.5 } else { share } * (c.0 - f.0)
            }
            _ => {
                let slope = last.map_or(2.0, |(s, e)| ((e - excess) / (size - s)).clamp(0.5, 2.2));
                (size + (excess / slope).clamp(-1.5, 1.5)).min(largest)
            }
        };
    }
    let missed = |attempts: &[Attempt]| {
        attempts.iter().map(|a| (a.patches as f64 / f64::from(wanted) - 1.0).abs()).fold(f64::INFINITY, f64::min)
    };
    if let (Some(fine), Some(coarse)) = (fine, coarse) {
        for extra in EXTRA {
            if missed(&attempts) > FAIR {
                go(fine.0.max(coarse.0).exp() as f32, extra, &mut attempts)?;
            }
        }
    }
    let (_, value) = best.expect("at least one attempt was made");
    Ok((value, attempts))
}
