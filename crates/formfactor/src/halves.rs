//! Counts of all patches, in two halves whose difference tells how good they are.
//!
//! The rays of a patch are one Sobol sequence. Its samples 0..N/2 and N/2..N are counted apart; both are
//! sequences of their own. What is wanted is their sum, which errs less than two sequences of different
//! scrambling would: the halves are stratified against each other. So half their difference overrates
//! the error of the sum, by as much as `probes.rs` says. A patch gets more rays by going on in its sequence.

use radfile::Progress;
use rayon::prelude::*;

use crate::{
    Error, Result,
    gather::{Surroundings, Tally},
};

/// Counts of n patches; row i holds where the rays of patch i went.
pub struct Halves {
    pub first: Vec<f32>,
    pub second: Vec<f32>,
    pub tallies: Vec<[Tally; 2]>,
}

impl Halves {
    /// No rays yet.
    ///
    /// # Errors
    ///
    /// [`Error::Memory`], with `needed` bytes, if the counts do not fit.
    pub fn new(patches: usize, needed: u64) -> Result<Halves> {
        let (first, second) = (matrix(patches, needed)?, matrix(patches, needed)?);
        Ok(Halves { first, second, tallies: vec![Default::default(); patches] })
    }

    /// Sends rays until patch i has `wanted[i]` samples, at least twice what it had unless it has them already.
    pub fn trace(&mut self, surroundings: &Surroundings, seed: u32, wanted: &[u32], progress: &dyn Progress) {
        let n = wanted.len();
        progress.begin("form factor rays", n as u64);
        let rows = self.first.par_chunks_exact_mut(n).zip(self.second.par_chunks_exact_mut(n));
        rows.zip(&mut self.tallies).zip(wanted).enumerate().for_each(
            |(patch, (((first, second), tallies), &wanted))| {
                let had = tallies[0].samples() + tallies[1].samples();
                if wanted > had {
                    first.iter_mut().zip(second.iter_mut()).for_each(|(a, b)| *a += std::mem::take(b));
                    let [before, after] = std::mem::take(tallies);
                    let grown = surroundings.gather(patch, had..wanted / 2, seed, first);
                    *tallies = [before + after + grown, surroundings.gather(patch, wanted / 2..wanted, seed, second)];
                }
                progress.advance(1);
            },
        );
    }

    /// Standard error of each row as its own rays measured it, relative to the length of the row:
    /// ‖F¹ − F²‖ / ‖F¹ + F²‖ with the rows F¹ and F² of both halves, 0 for a row that met nothing.
    pub fn row_errors(&self) -> Vec<f64> {
        let n = self.tallies.len();
        let rows = self.first.par_chunks_exact(n).zip(self.second.par_chunks_exact(n)).zip(&self.tallies);
        let error = |((first, second), tallies): ((&[f32], &[f32]), &[Tally; 2])| {
            let share = tallies.map(|t| 1.0 / f64::from(t.rays.max(1)));
            let (mut difference, mut sum) = (0.0, 0.0);
            for (&a, &b) in first.iter().zip(second) {
                let (a, b) = (f64::from(a) * share[0], f64::from(b) * share[1]);
                difference += (a - b).powi(2);
                sum += (a + b).powi(2);
            }
            if sum > 0.0 { (difference / sum).sqrt() } else { 0.0 }
        };
        rows.map(error).collect()
    }

    /// What became of all samples of each patch.
    pub fn total_tallies(&self) -> Vec<Tally> {
        self.tallies.iter().map(|[a, b]| *a + *b).collect()
    }

    /// What became of the samples in the second half.
    pub fn second_tallies(&self) -> Vec<Tally> {
        self.tallies.iter().map(|t| t[1]).collect()
    }
}

/// `to` += `more`.
pub fn add(to: &mut [f32], more: &[f32]) {
    to.par_iter_mut().zip(more).for_each(|(a, b)| *a += b);
}

/// A matrix of zeros, or the error that says how much was asked for.
pub fn matrix(patches: usize, needed: u64) -> Result<Vec<f32>> {
    let refused = Error::Memory { patches, bytes: needed };
    let Some(elements) = patches.checked_mul(patches) else { return Err(refused) };
    let mut matrix = Vec::new();
    match matrix.try_reserve_exact(elements) {
        Ok(()) => {
            matrix.resize(elements, 0.0);
            Ok(matrix)
        }
        Err(_) => Err(refused),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_that_no_machine_holds_is_refused_with_its_size() {
        for patches in [1 << 40, 1 << 30] {
            let error = matrix(patches, 77).expect_err("more bytes than an address has");
            let text = format!(
                "form factors of {patches} patches need 77 bytes of memory, which are not there; use fewer patches"
            );
            assert_eq!(error.to_string(), text);
        }
    }
}
