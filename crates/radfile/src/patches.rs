//! Patches: pieces of the simplified surface with one radiosity each.

use serde::{Deserialize, Serialize};

use crate::{
    Builder, CUT, Container, Cut, DEEPEST_CUT, Error, FLAG_PATCH_ORDER, FLAG_REQUIRED, PatchLocator, Permutation,
    Record, Result,
};

/// A clipped triangle that belongs to a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Corners, metres, local axes, in the winding of the source triangle.
    pub corners: [[f32; 3]; 3],
    /// Face of the mesh it was cut from, see [`crate::face_id`].
    pub face: u32,
}

/// `n` patches made of `p` pieces. Every array is indexed by patch unless said otherwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patches {
    /// Centroid of the pieces moved to the nearest of them, so a point on the surface, metres, local axes.
    pub position: Vec<[f32; 3]>,
    /// Unit mean normal of the side that the patch stands for.
    pub normal: Vec<[f32; 3]>,
    /// One-sided area A, m².
    pub area: Vec<f32>,
    /// Diffuse reflectance ρ, linear RGB, 0 ≤ ρ < 1.
    pub reflectance: Vec<[f32; 3]>,
    /// Self-emitted exitance M = π · radiance, W/m², linear RGB.
    pub emission: Vec<[f32; 3]>,
    /// `n` + 1 offsets into `pieces`.
    pub piece_start: Vec<u32>,
    /// `p` pieces, those of one patch together.
    pub pieces: Vec<Piece>,
    /// Which patch a point of the mesh belongs to.
    pub locator: PatchLocator,
}

#[derive(Serialize, Deserialize)]
struct Meta {
    grid_origin: [f32; 3],
    cell_size: f32,
}

const FLAGS: u32 = FLAG_REQUIRED | FLAG_PATCH_ORDER;

impl Patches {
    /// Number of patches.
    pub fn len(&self) -> usize {
        self.area.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.area.is_empty()
    }

    /// The pieces of one patch.
    pub fn pieces_of(&self, patch: usize) -> &[Piece] {
        &self.pieces[self.piece_start[patch] as usize..self.piece_start[patch + 1] as usize]
    }

    /// Whether every reflectance is grey, so that one channel of the operator serves all three.
    pub fn is_grey(&self) -> bool {
        self.reflectance.iter().all(|[r, g, b]| r == g && g == b)
    }

    /// The same patches in another order.
    pub fn permuted(&self, order: &Permutation) -> Patches {
        let mut piece_start = vec![0];
        let mut pieces = Vec::with_capacity(self.pieces.len());
        for &old in order.new_to_old() {
            pieces.extend_from_slice(self.pieces_of(old as usize));
            piece_start.push(pieces.len() as u32);
        }
        let old_to_new = order.old_to_new();
        Patches {
            position: order.apply(&self.position),
            normal: order.apply(&self.normal),
            area: order.apply(&self.area),
            reflectance: order.apply(&self.reflectance),
            emission: order.apply(&self.emission),
            piece_start,
            pieces,
            locator: self.locator.renumbered(|patch| Some(old_to_new[patch as usize])),
        }
    }

    /// Checks that offsets, counts, areas and reflectances obey the format's rules.
    ///
    /// # Errors
    ///
    /// [`Error::Invariant`] with the first offender.
    pub fn check(&self) -> Result<()> {
        let n = self.len();
        let broken = |what: String| Err(Error::invariant("patches", what));
        if let Some(i) = self.area.iter().position(|&a| !(a > 0.0 && a.is_finite())) {
            return broken(format!("patch {i} has area {}, expected a positive number", self.area[i]));
        }
        if let Some(i) = self.reflectance.iter().position(|r| !r.iter().all(|v| (0.0..1.0).contains(v))) {
            return broken(format!("patch {i} has reflectance {:?}, expected 0 ≤ ρ < 1", self.reflectance[i]));
        }
        if let Some(i) = self.emission.iter().position(|e| !e.iter().all(|v| *v >= 0.0 && v.is_finite())) {
            return broken(format!("patch {i} has emission {:?}, expected numbers ≥ 0", self.emission[i]));
        }
        let unit = |v: &[f32; 3]| (v.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-3;
        if let Some(i) = self.normal.iter().position(|v| !unit(v)) {
            return broken(format!("patch {i} has normal {:?}, expected a unit vector", self.normal[i]));
        }
        if let Some(i) = self.position.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return broken(format!("patch {i} lies at {:?}, expected finite numbers", self.position[i]));
        }
        check_offsets("patches", "piece_start", &self.piece_start, n, self.pieces.len())?;
        if let Some(i) = (0..n).find(|&i| self.pieces_of(i).is_empty()) {
            return broken(format!("patch {i} has no pieces"));
        }
        let finite = |p: &Piece| p.corners.as_flattened().iter().all(|x| x.is_finite());
        let faces = self.locator.face_start.len().saturating_sub(1);
        if let Some(i) = self.pieces.iter().position(|p| !finite(p) || p.face as usize >= faces) {
            let what = format!("piece {i} is {:?}, expected finite corners and a face below {faces}", self.pieces[i]);
            return broken(what);
        }
        self.check_locator(faces)
    }

    fn check_locator(&self, faces: usize) -> Result<()> {
        let l = &self.locator;
        let broken = |what: String| Err(Error::invariant("patches", what));
        check_offsets("patches", "face_start", &l.face_start, faces, l.cell_key.len())?;
        if !(l.cell_size > 0.0 && l.cell_size.is_finite() && l.grid_origin.iter().all(|x| x.is_finite())) {
            let what = format!("voxel grid of cell size {} at {:?}", l.cell_size, l.grid_origin);
            return broken(format!("{what}, expected a positive size and finite numbers"));
        }
        let increasing = |face: usize| {
            let keys = &l.cell_key[l.face_start[face] as usize..l.face_start[face + 1] as usize];
            keys.windows(2).all(|pair| pair[0] < pair[1])
        };
        if let Some(face) = (0..faces).find(|&f| !increasing(f)) {
            return broken(format!("the cells of face {face} do not increase"));
        }
        if let Some(i) = l.cuts.iter().position(|cut| !cut.plane.iter().all(|x| x.is_finite())) {
            return broken(format!("cut {i} is the plane {:?}, expected finite numbers", l.cuts[i].plane));
        }
        self.check_trees()
    }

    /// Every cut is named once, by a cell or by a cut before it, so that they form trees, and none is too deep.
    fn check_trees(&self) -> Result<()> {
        let cuts = &self.locator.cuts;
        let mut depth = vec![0; cuts.len()];
        for (i, &entry) in self.locator.cell_patch.iter().enumerate() {
            self.check_entry(&mut depth, entry, 0, 1, || format!("cell {i}"))?;
        }
        for (i, cut) in cuts.iter().enumerate() {
            let level = depth[i];
            if !(1..=DEEPEST_CUT).contains(&level) {
                let what = format!("cut {i} is the cut {level} below its cell, expected 1 to {DEEPEST_CUT}");
                return Err(Error::invariant("patches", what));
            }
            for child in cut.child {
                self.check_entry(&mut depth, child, i + 1, level + 1, || format!("cut {i}"))?;
            }
        }
        Ok(())
    }

    /// Checks what a cell or a cut names, and notes how deep that lies; cuts before `first` are none of its children.
    fn check_entry(
        &self,
        depth: &mut [usize],
        entry: u32,
        first: usize,
        level: usize,
        by: impl Fn() -> String,
    ) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("patches", format!("{} {what}", by())));
        let (patch, cut) = (entry as usize, (entry & !CUT) as usize);
        match entry & CUT {
            0 if patch >= self.len() => broken(format!("names patch {patch}, there are {}", self.len())),
            0 => Ok(()),
            _ if !(first..depth.len()).contains(&cut) => {
                broken(format!("names cut {cut}, expected {first} to {}", depth.len()))
            }
            _ if depth[cut] != 0 => broken(format!("names cut {cut}, which is named already")),
            _ => {
                depth[cut] = level;
                Ok(())
            }
        }
    }
}

/// Offsets start at 0, never decrease, and end at `end`.
pub(crate) fn check_offsets(record: &'static str, name: &str, start: &[u32], rows: usize, end: usize) -> Result<()> {
    let fits = start.len() == rows + 1
        && start[0] == 0
        && start.windows(2).all(|w| w[0] <= w[1])
        && start[rows] as usize == end;
    if fits {
        return Ok(());
    }
    Err(Error::invariant(record, format!("{name} does not run from 0 to {end} in {rows} steps")))
}

/// The cuts of a locator; files in which no face is cut have no sections for them.
fn read_cuts(c: &Container) -> Result<Vec<Cut>> {
    if !c.has("patches.cut_plane") && !c.has("patches.cut_child") {
        return Ok(vec![]);
    }
    let planes = c.array_of::<f32>("patches.cut_plane", &[None, Some(4)])?.as_chunks().0;
    let children = c.array_of::<u32>("patches.cut_child", &[Some(planes.len()), Some(2)])?.as_chunks().0;
    Ok(planes.iter().zip(children).map(|(&plane, &child)| Cut { plane, child }).collect())
}

impl<'a> Record<'a> for Patches {
    const PREFIX: &'static str = "patches.";

    fn read(c: &'a Container) -> Result<Patches> {
        let area = c.array_of::<f32>("patches.area", &[None])?;
        let vectors = |name| -> Result<Vec<[f32; 3]>> {
            Ok(c.array_of::<f32>(name, &[Some(area.len()), Some(3)])?.as_chunks().0.to_vec())
        };
        let corners = c.array_of::<f32>("patches.piece_corners", &[None, Some(3), Some(3)])?;
        let (corners, _) = corners.as_chunks::<3>().0.as_chunks::<3>();
        let face = c.array_of::<u32>("patches.piece_face", &[Some(corners.len())])?;
        let meta: Meta = c.meta("patches.meta")?;
        let cell_key = c.array_of::<u64>("patches.cell_key", &[None])?;
        let patches = Patches {
            position: vectors("patches.position")?,
            normal: vectors("patches.normal")?,
            area: area.to_vec(),
            reflectance: vectors("patches.reflectance")?,
            emission: vectors("patches.emission")?,
            piece_start: c.array_of::<u32>("patches.piece_start", &[Some(area.len() + 1)])?.to_vec(),
            pieces: corners.iter().zip(face).map(|(&corners, &face)| Piece { corners, face }).collect(),
            locator: PatchLocator {
                grid_origin: meta.grid_origin,
                cell_size: meta.cell_size,
                face_start: c.array_of::<u32>("patches.face_start", &[None])?.to_vec(),
                cell_key: cell_key.to_vec(),
                cell_patch: c.array_of::<u32>("patches.cell_patch", &[Some(cell_key.len())])?.to_vec(),
                cuts: read_cuts(c)?,
            },
        };
        patches.check()?;
        if c.has("mesh.triangles") {
            let triangles = c.array_of::<u32>("mesh.triangles", &[None, Some(3)])?.len() / 3;
            let faces = patches.locator.face_start.len() - 1;
            if faces != 2 * triangles {
                let what = format!("made for {faces} faces, the mesh has {triangles} triangles with two each");
                return Err(Error::invariant("patches", what));
            }
        }
        Ok(patches)
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        let l = &self.locator;
        let n = self.len();
        b.meta("patches.meta", FLAG_REQUIRED, &Meta { grid_origin: l.grid_origin, cell_size: l.cell_size });
        b.array("patches.position", FLAGS, &[n, 3], self.position.as_flattened());
        b.array("patches.normal", FLAGS, &[n, 3], self.normal.as_flattened());
        b.array("patches.area", FLAGS, &[n], &self.area[..]);
        b.array("patches.reflectance", FLAGS, &[n, 3], self.reflectance.as_flattened());
        b.array("patches.emission", FLAGS, &[n, 3], self.emission.as_flattened());
        b.array("patches.piece_start", FLAGS, &[n + 1], &self.piece_start[..]);
        let corners: Vec<f32> = self.pieces.iter().flat_map(|p| p.corners.as_flattened()).copied().collect();
        b.array("patches.piece_corners", FLAGS, &[self.pieces.len(), 3, 3], corners);
        let faces: Vec<u32> = self.pieces.iter().map(|p| p.face).collect();
        b.array("patches.piece_face", FLAGS, &[faces.len()], faces);
        b.array("patches.face_start", FLAG_REQUIRED, &[l.face_start.len()], &l.face_start[..]);
        b.array("patches.cell_key", FLAG_REQUIRED, &[l.cell_key.len()], &l.cell_key[..]);
        b.array("patches.cell_patch", FLAGS, &[l.cell_patch.len()], &l.cell_patch[..]);
        if !l.cuts.is_empty() {
            let planes: Vec<f32> = l.cuts.iter().flat_map(|cut| cut.plane).collect();
            let children: Vec<u32> = l.cuts.iter().flat_map(|cut| cut.child).collect();
            b.array("patches.cut_plane", FLAG_REQUIRED, &[l.cuts.len(), 4], planes);
            b.array("patches.cut_child", FLAGS, &[l.cuts.len(), 2], children);
        }
    }
}
