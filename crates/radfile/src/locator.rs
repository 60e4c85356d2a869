//! From a point on a face to the patch that it belongs to.
//!
//! The mesh was clipped to the cells of a voxel grid, and within one cell one face belongs to
//! one patch. So a face and a cell name a patch, exactly, without any search in space. Only where
//! something stands on a face, or passes through it, it belongs to several patches within a cell;
//! then a few planes tell them apart, as in a tree for binary space partitioning (H. Fuchs,
//! Z. Kedem, B. Naylor, On visible surface generation by a priori tree structures, SIGGRAPH 1980).

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

    /// The cell of a grid that a point lies in; `origin` is the lower corner of cell (0, 0, 0).
    pub fn of(origin: [f32; 3], edge: f32, point: [f32; 3]) -> CellKey {
        CellKey::new(std::array::from_fn(|a| ((point[a] - origin[a]) / edge).floor() as i64))
    }

    /// Squared distance from a point to the box of the cell, in cells.
    pub fn distance_squared(self, origin: [f32; 3], edge: f32, point: [f32; 3]) -> f32 {
        let cell = self.cell();
        (0..3)
            .map(|a| {
                let x = (point[a] - origin[a]) / edge - cell[a] as f32;
                (x - x.clamp(0.0, 1.0)).powi(2)
            })
            .sum()
    }

    /// The three cell numbers.
    pub fn cell(self) -> [i64; 3] {
        let part = |shift: u32| (self.0 >> shift & (EXTENT as u64 - 1)) as i64;
        [part(0), part(BITS), part(2 * BITS)]
    }
}

/// Bit of an entry that names no patch but, by its other bits, a cut.
pub const CUT: u32 = 1 << 31;

/// Longest way from an entry of the table to a patch, in cuts.
pub const DEEPEST_CUT: usize = 64;

/// A plane that parts a face within a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Normal x, y, z and offset d, metres, local axes: a point p lies above the plane if normal · p ≥ d.
    pub plane: [f32; 4],
    /// What lies below and above: a patch, or [`CUT`] with the number of a later cut.
    pub child: [u32; 2],
}

impl Cut {
    /// How far a point lies above the plane, metres.
    fn height(&self, point: [f32; 3]) -> f64 {
        let [x, y, z, offset] = self.plane.map(f64::from);
        let [px, py, pz] = point.map(f64::from);
        x * px + y * py + z * pz - offset
    }
}

/// The patch that a point belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// Its number.
    pub patch: u32,
    /// Whether another patch of the face may be as near as was asked.
    pub at_border: bool,
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
    /// The patch of that face in that cell, or [`CUT`] with the number of a cut where there are several.
    pub cell_patch: Vec<u32>,
    /// Trees of planes, one for each entry of `cell_patch` that names a cut.
    pub cuts: Vec<Cut>,
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
        self.find(face, point, 0.0).map(|found| found.patch)
    }

    /// The same, and whether the point lies within `tolerance` metres of a cut or of a cell of another patch: what
    /// the error of the point may have moved it across.
    pub fn find(&self, face: u32, point: [f32; 3], tolerance: f32) -> Option<Found> {
        let range = self.face_start[face as usize] as usize..self.face_start[face as usize + 1] as usize;
        let (keys, entries) = (&self.cell_key[range.clone()], &self.cell_patch[range]);
        if let [entry] = *entries {
            return Some(self.follow(entry, point, tolerance));
        }
        let at = match keys.binary_search(&CellKey::of(self.grid_origin, self.cell_size, point).0) {
            Ok(at) => at,
            Err(_) => self.nearest(keys, point)?,
        };
        let found = self.follow(entries[at], point, tolerance);
        let at_border = found.at_border || self.is_near_another(keys, entries, at, point, tolerance);
        Some(Found { at_border, ..found })
    }

    /// The cell nearest to a point.
    #[cold]
    fn nearest(&self, keys: &[u64], point: [f32; 3]) -> Option<usize> {
        let distance = |i: usize| CellKey(keys[i]).distance_squared(self.grid_origin, self.cell_size, point);
        (0..keys.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    }

    /// Whether a neighbour of the cell of entry `at` has another entry and lies within `tolerance` of the point.
    fn is_near_another(&self, keys: &[u64], entries: &[u32], at: usize, point: [f32; 3], tolerance: f32) -> bool {
        let cell = CellKey(keys[at]).cell();
        (0..3).any(|axis| {
            let above = point[axis] - self.grid_origin[axis] - cell[axis] as f32 * self.cell_size;
            let step = i64::from(self.cell_size - above < tolerance) - i64::from(above < tolerance);
            let mut beyond = cell;
            beyond[axis] += step;
            step != 0 && keys.binary_search(&CellKey::new(beyond).0).is_ok_and(|other| entries[other] != entries[at])
        })
    }

    /// The patch below an entry of the table.
    fn follow(&self, mut entry: u32, point: [f32; 3], tolerance: f32) -> Found {
        let mut at_border = false;
        while entry & CUT != 0 {
            let cut = &self.cuts[(entry & !CUT) as usize];
            let height = cut.height(point);
            at_border |= height.abs() < f64::from(tolerance);
            entry = cut.child[usize::from(height >= 0.0)];
        }
        Found { patch: entry, at_border }
    }

    /// The same table with other patch numbers. Where a patch has none, the other side of the nearest cut takes its
    /// place; entries without any disappear, and so do cuts between a patch and itself.
    #[must_use]
    pub fn renumbered(&self, number: impl Fn(u32) -> Option<u32>) -> PatchLocator {
        // Children come after their parents, so from behind they are known first.
        let mut new_cuts: Vec<Option<u32>> = vec![None; self.cuts.len()];
        let mut kept: Vec<Cut> = Vec::new();
        let renumber = |entry: u32, new_cuts: &[Option<u32>]| match entry & CUT {
            0 => number(entry),
            _ => new_cuts[(entry & !CUT) as usize],
        };
        for (at, cut) in self.cuts.iter().enumerate().rev() {
            new_cuts[at] = match cut.child.map(|child| renumber(child, &new_cuts)) {
                [Some(below), Some(above)] if below != above => {
                    kept.push(Cut { plane: cut.plane, child: [below, above] });
                    Some(CUT | (kept.len() - 1) as u32)
                }
                [below, above] => below.or(above),
            };
        }
        // They were collected from behind; the last becomes the first.
        let count = kept.len() as u32;
        let turn = |entry: u32| if entry & CUT != 0 { CUT | (count - 1 - (entry & !CUT)) } else { entry };
        let turned = kept.into_iter().rev().map(|cut| Cut { child: cut.child.map(turn), ..cut });
        let mut to = PatchLocator {
            grid_origin: self.grid_origin,
            cell_size: self.cell_size,
            face_start: vec![0],
            cuts: turned.collect(),
            ..PatchLocator::default()
        };
        for face in self.face_start.windows(2) {
            for at in face[0] as usize..face[1] as usize {
                if let Some(entry) = renumber(self.cell_patch[at], &new_cuts) {
                    to.cell_key.push(self.cell_key[at]);
                    to.cell_patch.push(turn(entry));
                }
            }
            to.face_start.push(to.cell_key.len() as u32);
        }
        to
    }
}
