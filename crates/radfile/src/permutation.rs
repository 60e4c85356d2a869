//! One order for rows, columns and everything else that patches index.

use crate::{Builder, Container, Error, FLAG_REQUIRED, Record, Result, record::check_patch_count};

/// Patch order: entry `k` is the old index of the patch that is now number `k`.
#[derive(Clone, Debug, PartialEq)]
pub struct Permutation {
    new_to_old: Vec<u32>,
}

impl Permutation {
    /// A permutation from its table.
    ///
    /// # Errors
    ///
    /// [`Error::Invariant`] if some patch is named twice or not at all.
    pub fn new(new_to_old: Vec<u32>) -> Result<Permutation> {
        let mut seen = vec![false; new_to_old.len()];
        for (new, &old) in new_to_old.iter().enumerate() {
            match seen.get_mut(old as usize) {
                Some(s) if !*s => *s = true,
                Some(_) => return Err(Error::invariant("permutation", format!("patch {old} is named twice"))),
                None => {
                    return Err(Error::invariant(
                        "permutation",
                        format!("entry {new} names patch {old} of {}", seen.len()),
                    ));
                }
            }
        }
        Ok(Permutation { new_to_old })
    }

    /// The order in which nothing moves.
    pub fn identity(n: usize) -> Permutation {
        Permutation { new_to_old: (0..n as u32).collect() }
    }

    /// Old index of each new one.
    pub fn new_to_old(&self) -> &[u32] {
        &self.new_to_old
    }

    /// New index of each old one.
    pub fn old_to_new(&self) -> Vec<u32> {
        let mut inverse = vec![0; self.new_to_old.len()];
        for (new, &old) in self.new_to_old.iter().enumerate() {
            inverse[old as usize] = new as u32;
        }
        inverse
    }

    /// `values` in the new order.
    ///
    /// # Panics
    ///
    /// If the lengths differ: a bug in the caller.
    #[track_caller]
    pub fn apply<T: Clone>(&self, values: &[T]) -> Vec<T> {
        assert_eq!(values.len(), self.new_to_old.len(), "one value a patch");
        self.new_to_old.iter().map(|&old| values[old as usize].clone()).collect()
    }

    /// A square matrix with rows and columns in the new order.
    ///
    /// # Panics
    ///
    /// If `matrix` is not n × n: a bug in the caller.
    #[track_caller]
    pub fn apply_to_matrix(&self, matrix: &[f32]) -> Vec<f32> {
        let n = self.new_to_old.len();
        assert_eq!(matrix.len(), n * n, "a square matrix over the patches");
        let mut out = Vec::with_capacity(n * n);
        for &row in &self.new_to_old {
            let row = &matrix[row as usize * n..][..n];
            out.extend(self.new_to_old.iter().map(|&column| row[column as usize]));
        }
        out
    }
}

impl<'a> Record<'a> for Permutation {
    const PREFIX: &'static str = "permute.";

    fn read(c: &'a Container) -> Result<Permutation> {
        let new_to_old = c.array_of::<u32>("permute.new_to_old", &[None])?;
        check_patch_count(c, "permutation", new_to_old.len())?;
        Permutation::new(new_to_old.to_vec())
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        b.array("permute.new_to_old", FLAG_REQUIRED, &[self.new_to_old.len()], &self.new_to_old[..]);
    }
}
