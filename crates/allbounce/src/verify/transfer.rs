//! From patches to receivers.

use radfile::Transfer;

use super::{
    check::{Check, check},
    patches::largest,
};

/// Weights of a receiver make a mean.
pub fn transfer(t: &Transfer) -> Check {
    let deviation = |r: usize| {
        let (count, sum) = t.rows.row(r).fold((0, 0.0), |(n, s), (_, w)| (n + 1, s + f64::from(w)));
        if count == 0 { 0.0 } else { (sum - 1.0f64).abs() }
    };
    let worst = largest((0..t.rows.len()).map(deviation));
    check("11.1", "transfer weights of a receiver sum to 1", worst, 1e-4)
}
