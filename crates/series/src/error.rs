//! Why no operator was made.

/// Errors of this stage.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The container could not be read or written.
    #[error(transparent)]
    Container(#[from] radfile::Error),
    /// There is nothing to exchange light.
    #[error("the scene has no patches, at least one is needed; check the scene, then run `allbounce voxel-simplify`")]
    NoPatches,
    /// Form factors of other patches.
    #[error(
        "form factors of {factors} patches ({values} values), but there are {patches} patches: \
         they were made for another simplification; run `allbounce formfactor` on this one"
    )]
    Count {
        /// Patches.
        patches: usize,
        /// Rows of the form factors.
        factors: usize,
        /// Values of the form factors.
        values: usize,
    },
    /// A number that no surface has.
    #[error("{what} of patch {patch} is {found}, expected {expected}; make the patches and form factors again")]
    Value {
        /// Which number.
        what: &'static str,
        /// Whose.
        patch: usize,
        /// What it is.
        found: f32,
        /// What it may be.
        expected: &'static str,
    },
    /// The empty sum was asked for.
    #[error("0 bounces were asked for, the operator starts with the first; ask for 1 or more, or for all")]
    NoBounces,
    /// A sum of how many bounces?
    #[error("{method} sums a number of bounces and was not told how many; say --bounces K, or use cholesky for all")]
    BouncesMissing {
        /// As the command line spells it.
        method: &'static str,
    },
    /// A solver of all bounces was asked for a few.
    #[error(
        "{method} solves for all bounces and cannot stop after some; leave --bounces out, or use doubling or neumann"
    )]
    BouncesUnused {
        /// As the command line spells it.
        method: &'static str,
    },
    /// A tolerance that means nothing.
    #[error("tolerance {found} for {method}: only cg has one, a number between 2.3e-16 and 1")]
    Tolerance {
        /// As the command line spells it.
        method: &'static str,
        /// What was asked for.
        found: f64,
    },
    /// The numbers are too coarse for the system.
    #[error(
        "{channel}: {method} in f32 cannot tell this scene from one whose light never fades \
         (condition {condition:.0}); use --precision f64"
    )]
    Precision {
        /// Colour channel.
        channel: &'static str,
        /// As the command line spells it.
        method: &'static str,
        /// Condition number of I − R W R.
        condition: f64,
    },
    /// Conjugate gradients did not reach their goal.
    #[error(
        "{channel}: conjugate gradients have not reached a residual of {tolerance:e} after {steps} steps; \
         allow more (--tolerance), or use --method cholesky"
    )]
    Stalled {
        /// Colour channel.
        channel: &'static str,
        /// Steps that were taken.
        steps: u64,
        /// Relative residual that was asked for.
        tolerance: f64,
    },
    /// The series of bounces has no finite sum.
    #[error(
        "{channel}: light grows from bounce to bounce instead of fading (by {radius:.4}, must be below 1); \
         the worst is patch {patch}, which gives back {row_sum:.4} of the light around it: its form factors \
         times the reflectances they meet must not sum to more than 1; make the form factors again \
         with more rays or with normalisation, or lower the reflectance"
    )]
    NotContracting {
        /// Colour channel.
        channel: &'static str,
        /// Patch with the largest row sum of F ρ.
        patch: usize,
        /// That sum.
        row_sum: f64,
        /// Spectral radius of F ρ.
        radius: f64,
    },
}
