//! The form-factor matrix F and what each patch sees of the sky.

use std::borrow::Cow;

use crate::{Builder, Container, Error, FLAG_PATCH_ORDER, FLAG_REQUIRED, Record, Result, record::check_patch_count};

/// Dense form factors of `n` patches.
#[derive(Clone, Debug, PartialEq)]
pub struct FormFactors<'a> {
    /// F, `n` × `n`, row-major: `values[i * n + j]` = F_ij, the part of the flux leaving patch i that
    /// reaches patch j; as a gather, the weight of sender j at receiver i. A_i F_ij = A_j F_ji.
    pub values: Cow<'a, [f32]>,
    /// The part of the flux leaving patch i that leaves the scene; Σ_j F_ij + sky_i = 1.
    pub sky: Cow<'a, [f32]>,
}

impl FormFactors<'_> {
    /// Number of patches.
    pub fn len(&self) -> usize {
        self.sky.len()
    }

    /// Whether there are no patches.
    pub fn is_empty(&self) -> bool {
        self.sky.is_empty()
    }

    /// Row i: what receiver i sees of every sender.
    pub fn row(&self, receiver: usize) -> &[f32] {
        &self.values[receiver * self.len()..][..self.len()]
    }
}

/// What each patch sees of the sky; a packed bake keeps it after F itself is gone.
///
/// # Errors
///
/// [`Error::Missing`], or [`Error::Invariant`] for a share outside 0..1 or another number of patches.
pub fn read_sky(c: &Container) -> Result<&[f32]> {
    let sky = c.array_of::<f32>("formfactor.sky", &[None])?;
    check_patch_count(c, "form factors", sky.len())?;
    match sky.iter().position(|v| !(0.0..=1.0).contains(v)) {
        Some(i) => Err(Error::invariant("form factors", format!("sky of patch {i} is {}, expected 0..1", sky[i]))),
        None => Ok(sky),
    }
}

impl<'a> Record<'a> for FormFactors<'a> {
    const PREFIX: &'static str = "formfactor.";

    fn read(c: &'a Container) -> Result<FormFactors<'a>> {
        let sky = read_sky(c)?;
        let n = sky.len();
        let values = c.array_of::<f32>("formfactor.values", &[Some(n), Some(n)])?;
        if let Some(at) = values.iter().position(|v| !(0.0..=1.0).contains(v)) {
            let what = format!("F[{}, {}] is {}, expected 0 ≤ F ≤ 1", at / n, at % n, values[at]);
            return Err(Error::invariant("form factors", what));
        }
        Ok(FormFactors { values: values.into(), sky: sky.into() })
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        const FLAGS: u32 = FLAG_REQUIRED | FLAG_PATCH_ORDER;
        let n = self.len();
        b.array("formfactor.values", FLAGS, &[n, n], &self.values[..]);
        b.array("formfactor.sky", FLAGS, &[n], &self.sky[..]);
    }
}
