//! What is to be computed: by which method, in which precision.

use serde::Serialize;

use crate::{Error, methods, tiles::Grid};

/// How the series of bounces is summed. W = A^{1/2} F A^{-1/2} is one bounce, R = ρ^{1/2}, docs/theory.md (5.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// All bounces: L Lᵀ = I − R W R. Refuses light that does not fade.
    #[default]
    Cholesky,
    /// The first k bounces in ⌈log₂ k⌉ steps.
    Doubling,
    /// The first k bounces one by one, K ← W + W ρ K, as classical radiosity gathers.
    Neumann,
    /// All bounces: conjugate gradients on I − R W R, column by column. Refuses light that does not fade.
    Cg,
    /// All bounces: LU of I − F ρ with F as given, as A. Shcherbakov and V. Frolov write it (2019).
    PaperInverse,
}

impl Method {
    /// As the command line spells it.
    pub fn name(self) -> &'static str {
        match self {
            Method::Cholesky => "cholesky",
            Method::Doubling => "doubling",
            Method::Neumann => "neumann",
            Method::Cg => "cg",
            Method::PaperInverse => "paper-inverse",
        }
    }

    /// Whether it sums a number of bounces instead of all.
    pub fn truncates(self) -> bool {
        matches!(self, Method::Doubling | Method::Neumann)
    }
}

/// Floating-point numbers of the matrices. Sums over vectors and all reported figures are in f64 in any case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// 24 bits, half the memory.
    F32,
    /// 53 bits.
    #[default]
    F64,
}

/// What to compute. The default is all bounces, by Cholesky, in f64.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Params {
    /// How.
    pub method: Method,
    /// Highest bounce that is in the sum, 1 or more: needed by [`Method::Doubling`] and [`Method::Neumann`],
    /// `None` for the others.
    pub bounces: Option<u32>,
    /// In which numbers.
    pub precision: Precision,
    /// Residual of a column, relative to its right side, at which [`Method::Cg`] stops;
    /// `None` is 10⁻¹² in f64 and 10⁻⁶ in f32.
    pub tolerance: Option<f64>,
}

impl Params {
    /// The first `bounces` by doubling, in f64.
    pub fn first_bounces(bounces: u32) -> Params {
        Params { method: Method::Doubling, bounces: Some(bounces), ..Params::default() }
    }

    /// Whether method, bounces and tolerance belong together.
    ///
    /// # Errors
    ///
    /// [`Error::NoBounces`], [`Error::BouncesMissing`], [`Error::BouncesUnused`], [`Error::Tolerance`].
    pub fn check(&self) -> Result<(), Error> {
        let method = self.method.name();
        match (self.method.truncates(), self.bounces) {
            (true, None) => return Err(Error::BouncesMissing { method }),
            (false, Some(_)) => return Err(Error::BouncesUnused { method }),
            (true, Some(0)) => return Err(Error::NoBounces),
            _ => {}
        }
        match self.tolerance {
            // What is below the rounding of f64 shrinks steps until they vanish.
            Some(found) if self.method != Method::Cg || !(f64::EPSILON..1.0).contains(&found) => {
                Err(Error::Tolerance { method, found })
            }
            _ => Ok(()),
        }
    }

    /// The tolerance of conjugate gradients.
    pub(crate) fn tolerance(&self) -> f64 {
        self.tolerance.unwrap_or(match self.precision {
            Precision::F32 => 1e-6,
            Precision::F64 => 1e-12,
        })
    }

    /// Bytes that [`crate::all_bounces`] takes besides its inputs, its result included; more threads take a little more.
    pub fn memory_needed(&self, n: usize, channels: usize) -> u64 {
        if n == 0 {
            return 0;
        }
        4 * (channels * n * n) as u64 + methods::bytes_needed(Grid::new(n), self)
    }
}

/// Bytes that [`crate::all_bounces`] takes by default; see [`Params::memory_needed`] for other methods.
pub fn memory_needed(n: usize, channels: usize) -> u64 {
    Params::default().memory_needed(n, channels)
}
