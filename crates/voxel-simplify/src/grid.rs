//! The voxel grid: where its planes lie, and whether it is too fine.
//!
//! Outer walls usually lie on the mesh's bounding box and inner ones at round numbers. A wall on a
//! plane between two layers of cells would belong to either by rounding, so the planes keep away
//! from the box: what the layers are thicker than the scene goes to both ends, almost evenly. Then
//! the outermost layers are at least half filled and no strip of slivers arises along the walls.

use glam::DVec3;

use crate::{Error, surface::Surface};

/// Most layers of cells along one axis, what [`radfile::CellKey`] can hold.
pub const MAX_LAYERS: u32 = 1 << 21;
/// Share of the slack that lies below the mesh: nearly half, and no number that walls like.
const SLACK_BELOW: f64 = 0.47;
/// Least slack, in cells.
const LEAST_SLACK: f64 = 0.02;
/// Memory that a run may plan for, bytes.
pub const MEMORY_LIMIT: u64 = 8 << 30;
/// Bytes of a clipped piece on its way to two patches, measured generously.
const BYTES_PER_PIECE: f64 = 700.0;

/// Cubic cells around a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Lower corner of cell (0, 0, 0), metres, exact in f32.
    pub origin: DVec3,
    /// Edge of a cell, metres, exact in f32.
    pub size: f64,
    /// Layers along x, y and z.
    pub layers: [i64; 3],
}

impl Grid {
    /// The grid of cells of `size` metres with `extra` more layers along each axis than needed.
    ///
    /// # Errors
    ///
    /// A size that is no length, or more cells or memory than there can be.
    pub fn new(surface: &Surface, size: f32, extra: [u32; 3]) -> Result<Grid, Error> {
        if !(size > 0.0 && size.is_finite()) {
            return Err(Error::VoxelSize { found: size });
        }
        let cell = f64::from(size);
        let extent = surface.upper - surface.lower;
        let longest = extent.max_element();
        let cells = longest / cell;
        if cells > f64::from(MAX_LAYERS - 4) {
            let least = (longest / f64::from(MAX_LAYERS - 8)) as f32;
            return Err(Error::TooManyCells { voxel: size, extent: longest, cells, least });
        }
        check_memory(surface, size)?;
        let layers = std::array::from_fn(|a| (extent[a] / cell + LEAST_SLACK).floor() as i64 + 1 + i64::from(extra[a]));
        let slack = DVec3::from_array(layers.map(|l| l as f64)) * cell - extent;
        let origin = (surface.lower - SLACK_BELOW * slack).as_vec3().as_dvec3();
        Ok(Grid { origin, size: cell, layers })
    }

    /// Places that are nearer to each other than this are the same but for rounding, metres.
    pub fn tolerance(&self, surface: &Surface) -> f64 {
        (1e-5 * (surface.upper - surface.lower).length()).min(1e-3 * self.size)
    }

    /// The layer that a coordinate lies in.
    pub fn layer(&self, axis: usize, x: f64) -> i64 {
        (((x - self.origin[axis]) / self.size).floor() as i64).clamp(0, self.layers[axis] - 1)
    }

    /// The plane below a layer.
    pub fn plane(&self, axis: usize, layer: i64) -> f64 {
        self.origin[axis] + layer as f64 * self.size
    }
}

/// Bytes that clipping to voxels of `size` metres takes, estimated.
fn memory_needed(pieces: f64) -> u64 {
    (pieces * BYTES_PER_PIECE) as u64
}

/// Refuses voxels that would cut the scene into more pieces than fit.
fn check_memory(surface: &Surface, size: f32) -> Result<(), Error> {
    let pieces = |size: f64| surface.triangles.len() as f64 + surface.edges / size + surface.faces / (size * size);
    let expected = pieces(f64::from(size));
    let need = memory_needed(expected);
    if need <= MEMORY_LIMIT {
        return Ok(());
    }
    let mut least = f64::from(size);
    while memory_needed(pieces(least)) > MEMORY_LIMIT && least < 1e30 {
        least *= 1.1;
    }
    Err(Error::Memory {
        voxel: size,
        pieces: expected,
        need: need >> 20,
        limit: MEMORY_LIMIT >> 20,
        least: least as f32,
    })
}
