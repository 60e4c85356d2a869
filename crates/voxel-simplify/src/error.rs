//! Why a scene could not be simplified.

/// What is wrong: found, expected, what next.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No triangle at all.
    #[error("the mesh has no triangles; patches need at least one")]
    EmptyMesh,
    /// A vertex that is no point.
    #[error("vertex {vertex} lies at {position:?}, expected finite numbers; repair the scene file")]
    NotFinite {
        /// Number of the vertex.
        vertex: usize,
        /// What was found.
        position: [f32; 3],
    },
    /// Only triangles without area.
    #[error("none of the {triangles} triangles has an area; patches need at least one that has")]
    NoArea {
        /// Number of triangles.
        triangles: usize,
    },
    /// The voxel size is no length.
    #[error("voxel size {found} m, expected a positive finite length")]
    VoxelSize {
        /// What was found.
        found: f32,
    },
    /// No patches were asked for.
    #[error("0 patches were asked for, expected at least 1")]
    NoPatchesWanted,
    /// Voxels out of all proportion to the scene.
    #[error(
        "voxels of {voxel} m are more than {} times as large as the scene, which is {extent} m long; use voxels well below \
         {extent} m, or give a number of patches",
        crate::simplify::MOST_EXTENTS
    )]
    VoxelTooLarge {
        /// Edge of a voxel, metres.
        voxel: f32,
        /// Longest side of the scene's box, metres.
        extent: f32,
    },
    /// More cells along an axis than a cell number can hold.
    #[error(
        "voxels of {voxel} m cut the scene's {extent} m into {cells} cells along one axis, at most {} are possible; \
         use voxels of at least {least} m, or remove far-away geometry",
        crate::grid::MAX_LAYERS
    )]
    TooManyCells {
        /// Edge of a voxel, metres.
        voxel: f32,
        /// Longest side of the scene's box, metres.
        extent: f64,
        /// Cells along it.
        cells: f64,
        /// Smallest voxel that would do.
        least: f32,
    },
    /// More pieces than memory is meant for.
    #[error(
        "voxels of {voxel} m would cut the scene into about {pieces:.1e} pieces, {need} MiB, the limit is {limit} MiB; \
         use voxels of about {least} m or more, or fewer patches"
    )]
    Memory {
        /// Edge of a voxel, metres.
        voxel: f32,
        /// Estimated number of clipped pieces.
        pieces: f64,
        /// Estimated need, MiB.
        need: u64,
        /// Limit, MiB.
        limit: u64,
        /// A voxel that would do.
        least: f32,
    },
    /// No patch sees another.
    #[error(
        "none of the {patches} patches sees any surface ({rays} rays each escaped): the scene is open on all sides, \
         so there is no bounced light to compute; check that walls are there and face inwards"
    )]
    NothingSeen {
        /// Patches before dropping.
        patches: usize,
        /// Rays a patch.
        rays: u32,
    },
    /// A pilot that was not solved.
    #[error(
        "the pilot has no dense operator, expected one with series.values; run formfactor and series on it and do not pack it"
    )]
    PilotUnsolved,
    /// A pilot of some bounces only.
    #[error(
        "the pilot's operator holds the first {bounces} bounces, expected all of them; run series without --bounces"
    )]
    PilotBounces {
        /// What was found.
        bounces: u32,
    },
    /// A pilot that is too coarse to tell anything.
    #[error("the pilot has {found} patches, expected at least {least}; make one of some hundred patches")]
    PilotTooSmall {
        /// What was found.
        found: usize,
        /// What is needed.
        least: usize,
    },
    /// A pilot of another scene.
    #[error(
        "the pilot was made of another mesh (it has {found} triangles, the scene {expected}), or with other sides; \
         make one of this scene"
    )]
    PilotOfAnother {
        /// Triangles of the pilot.
        found: usize,
        /// Triangles of the scene.
        expected: usize,
    },
    /// Adaptive patches of a kind that has none.
    #[error(
        "adaptive patches are clusters and are asked for by their number; leave out the voxel size and the mode faces"
    )]
    NotAdaptive,
    /// More fine patches than memory is meant for.
    #[error(
        "{wanted} adaptive patches are chosen from {patches} fine ones, whose light takes {need} MiB, the limit is {limit} MiB; \
         ask for fewer"
    )]
    AdaptiveMemory {
        /// Patches that were asked for.
        wanted: usize,
        /// Fine patches.
        patches: usize,
        /// Estimated need, MiB.
        need: u64,
        /// Limit, MiB.
        limit: u64,
    },
    /// A texture could not be used.
    #[error(transparent)]
    Scene(#[from] scene::Error),
    /// The container could not be written.
    #[error(transparent)]
    Container(#[from] radfile::Error),
}
