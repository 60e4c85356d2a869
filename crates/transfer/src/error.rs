//! Why no weights were made.

/// Result of this stage.
pub type Result<T> = std::result::Result<T, Error>;

/// What was found, what was expected, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The edge is no length.
    #[error(
        "the longest edge of the fine mesh is {found} m, expected a positive length; leave it out for the voxel size"
    )]
    Edge {
        /// The edge that was asked for.
        found: f32,
    },
    /// More fine triangles than the limit.
    #[error(
        "edges of {edge} m cut the mesh into about {triangles} triangles ({mebibytes} MiB with their weights), \
         the limit is {limit}; an edge of {remedy} m fits"
    )]
    TooFine {
        /// The edge that was asked for, metres.
        edge: f32,
        /// About how many triangles it makes.
        triangles: u64,
        /// Memory that they and their weights would take.
        mebibytes: u64,
        /// Largest number that is accepted.
        limit: u64,
        /// An edge that stays below the limit, metres.
        remedy: f32,
    },
    /// The source mesh alone has more triangles than the limit.
    #[error(
        "the mesh has {triangles} triangles before any is cut, the limit of fine triangles is {limit}; raise the limit"
    )]
    LargeMesh {
        /// Triangles of the mesh.
        triangles: u64,
        /// Largest number that is accepted.
        limit: u64,
    },
    /// A last gather is a bounce of its own.
    #[error(
        "the operator holds the first {bounces} bounces, and a last gather would add one; take --mode interpolate, or \
         run series without --bounces"
    )]
    CutOperator {
        /// The highest bounce that it holds.
        bounces: u32,
    },
    /// What is only gathered was asked for without a gather.
    #[error(
        "{what} is only made where light is gathered; leave out --mode interpolate, and run series without --bounces"
    )]
    NotGathered {
        /// What was asked for.
        what: &'static str,
    },
    /// The spacing of probes is no length.
    #[error("probes of an irradiance volume every {found} m, expected a positive length")]
    Spacing {
        /// The spacing that was asked for.
        found: f32,
    },
    /// More cells than the limit.
    #[error(
        "probes every {spacing} m are {found:.0?} along x, y and z, the limit is {limit} in all and {} along an axis; a \
         spacing of {remedy} m fits",
        radfile::LARGEST_VOLUME
    )]
    TooManyCells {
        /// The spacing that was asked for, metres.
        spacing: f32,
        /// Cells along each axis that it makes.
        found: [f64; 3],
        /// Largest number of cells that is accepted.
        limit: u64,
        /// A spacing that stays below the limits, metres.
        remedy: f32,
    },
    /// All probes lie inside of something.
    #[error(
        "the middles of all {cells} cells of the irradiance volume lie inside or behind the scene's surfaces; take a \
         shorter spacing"
    )]
    NoProbe {
        /// Cells that were tried.
        cells: usize,
    },
    /// There is no lightmap.
    #[error(transparent)]
    Lightmap(#[from] lightmap::Error),
    /// The gathered rows cannot be packed.
    #[error(transparent)]
    Packing(#[from] hmatrix::Error),
    /// The scene cannot be read.
    #[error(transparent)]
    Scene(#[from] scene::Error),
    /// The container is broken or cannot be written.
    #[error(transparent)]
    Container(#[from] radfile::Error),
}
