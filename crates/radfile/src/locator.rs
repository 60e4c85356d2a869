//! From a point on a face to the patch that it belongs to.
//!
//! The mesh was clipped to the cells of a voxel grid, and within one cell one face belongs to
//! one patch. So a face and a cell name a patch, exactly, without any search in space.

/// Cell `(i, j, k)` of the voxel grid in one number, 21 bits each, x in the lowest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellKey(pub u64);

const BITS: u32 = 21;
/// Largest number of cells along one axis.
const EXTENT: i64 = 1 << BITS;

impl CellKey {
    /// Packs three cell numbers; each is clamped to what 21 bits hold.
    pub fn new(cell: [i64; 3]) -> CellKey {
        let [i, j, k] = cell.map(|c| c.clamp(0, EXTENT - 1) as u64);
        CellKey(i | j << BITS | k << (2 * BITS))
    }

    /// The three cell numbers.
    pub fn cell(self) -> [i64; 3] {
        let part = |shift: u32| (self.0 >> shift & (EXTENT as u64 - 1)) as i64;
        [part(0), part(BITS), part(2 * BITS)]
    }
}

/// Sorted table of (face, cell) → patch over the voxel grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchLocator {
    /// Lower corner of cell (0, 0, 0), metres, local axes.
    pub grid_origin: [f32; 3],
    /// Edge of a cell, metres.
    pub cell_size: f32,
    /// Faces + 1 offsets into the two tables below.
    pub face_start: Vec<u32>,
    /// Cells that a face has pieces in, increasing within a face ([`CellKey`]).
    pub cell_key: Vec<u64>,
    /// The patch of that face in that cell.
    pub cell_patch: Vec<u32>,
}

impl PatchLocator {
    /// The cell that a point lies in.
    pub fn cell_of(&self, point: [f32; 3]) -> [i64; 3] {
        std::array::from_fn(|a| ((point[a] - self.grid_origin[a]) / self.cell_size).floor() as i64)
    }

    /// The patch that `point` on `face` belongs to, `None` if the face has no patch at all.
    ///
    /// A hit point carries rounding errors and may fall just outside the cells of its face;
    /// then the nearest of them answers.
    pub fn patch_at(&self, face: u32, point: [f32; 3]) -> Option<u32> {
        let range = self.face_start[face as usize] as usize..self.face_start[face as usize + 1] as usize;
        let (keys, patches) = (&self.cell_key[range.clone()], &self.cell_patch[range]);
        match (patches, keys.binary_search(&CellKey::new(self.cell_of(point)).0)) {
            ([], _) => None,
            ([only], _) => Some(*only),
            (_, Ok(at)) => Some(patches[at]),
            (_, Err(_)) => {
                let nearest = (0..keys.len()).min_by(|&a, &b| {
                    let distance = |i: usize| self.distance_to_cell(CellKey(keys[i]), point);
                    distance(a).total_cmp(&distance(b))
                });
                nearest.map(|at| patches[at])
            }
        }
    }

    /// Squared distance from a point to the box of a cell, in cells.
    fn distance_to_cell(&self, key: CellKey, point: [f32; 3]) -> f32 {
        let cell = key.cell();
        (0..3)
            .map(|a| {
                let x = (point[a] - self.grid_origin[a]) / self.cell_size - cell[a] as f32;
                (x - x.clamp(0.0, 1.0)).powi(2)
            })
            .sum()
    }
}
