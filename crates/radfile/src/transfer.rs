//! Weights that carry irradiance from patches to receivers, and the finer mesh whose vertices receive.

use crate::{Builder, Container, Error, FLAG_PATCH_ORDER, FLAG_REQUIRED, Record, Result, patches::check_offsets};

/// Sparse rows: one a receiver, entries are (patch, weight).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// Receivers + 1 offsets into the two tables below.
    pub row_start: Vec<u32>,
    /// Sender patch of each entry.
    pub patch: Vec<u32>,
    /// Its weight; a row sums to 1, or is empty where the receiver sees no patch.
    pub weight: Vec<f32>,
}

impl Rows {
    /// Number of receivers.
    pub fn len(&self) -> usize {
        self.row_start.len().saturating_sub(1)
    }

    /// Whether there are no receivers.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Entries of one receiver.
    pub fn row(&self, receiver: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        let range = self.row_start[receiver] as usize..self.row_start[receiver + 1] as usize;
        self.patch[range.clone()].iter().map(|&p| p as usize).zip(self.weight[range].iter().copied())
    }

    /// Irradiance at every receiver from irradiance of the patches.
    pub fn gather(&self, patches: &[[f32; 3]]) -> Vec<[f32; 3]> {
        (0..self.len())
            .map(|receiver| {
                self.row(receiver)
                    .fold([0.0; 3], |sum, (patch, weight)| std::array::from_fn(|c| sum[c] + weight * patches[patch][c]))
            })
            .collect()
    }
}

/// Marks a corner of a fine triangle whose side nobody can see.
pub const NO_RECEIVER: u32 = u32::MAX;

/// The mesh tessellated to about the voxel size, without T-junctions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FineMesh {
    /// Vertices, metres, local axes.
    pub vertex: Vec<[f32; 3]>,
    /// Three vertices a triangle, in the winding of its source.
    pub triangle: Vec<[u32; 3]>,
    /// Triangle of [`crate::Mesh`] it was cut from.
    pub source: Vec<u32>,
    /// Receivers of its corners, on the front side and on the back side; [`NO_RECEIVER`] where there is none.
    pub receiver: Vec<[[u32; 3]; 2]>,
}

/// Receivers of a bake: the sides of the vertices of the fine mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transfer {
    /// Where each receiver is, metres, local axes.
    pub position: Vec<[f32; 3]>,
    /// The direction it faces.
    pub normal: Vec<[f32; 3]>,
    /// Weights of the patches.
    pub rows: Rows,
    /// The mesh whose corners they are.
    pub fine: FineMesh,
}

impl Transfer {
    /// Checks counts and indices against `patch_count` patches and `triangle_count` triangles of the mesh.
    pub fn check(&self, patch_count: usize, triangle_count: usize) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("transfer", what));
        check_offsets("transfer", "row_start", &self.rows.row_start, self.position.len(), self.rows.patch.len())?;
        if let Some(e) = self.rows.patch.iter().position(|&p| p as usize >= patch_count) {
            return broken(format!("entry {e} names patch {}, there are {patch_count}", self.rows.patch[e]));
        }
        if let Some(e) = self.rows.weight.iter().position(|w| !(0.0..=1.0001).contains(w)) {
            return broken(format!("entry {e} has weight {}, expected 0..1", self.rows.weight[e]));
        }
        let fine = &self.fine;
        let vertices = fine.vertex.len() as u32;
        if let Some(t) = fine.triangle.iter().position(|t| t.iter().any(|&v| v >= vertices)) {
            return broken(format!("fine triangle {t} names a vertex that is not there"));
        }
        if let Some(t) = fine.source.iter().position(|&s| s as usize >= triangle_count) {
            return broken(format!(
                "fine triangle {t} comes from triangle {}, there are {triangle_count}",
                fine.source[t]
            ));
        }
        let receivers = self.position.len() as u32;
        let legal = |r: &u32| *r < receivers || *r == NO_RECEIVER;
        match fine.receiver.iter().position(|r| !r.as_flattened().iter().all(legal)) {
            Some(t) => broken(format!("fine triangle {t} names a receiver that is not there")),
            None => Ok(()),
        }
    }
}

impl<'a> Record<'a> for Transfer {
    const PREFIX: &'static str = "transfer.";

    /// Reads the record; [`Transfer::check`] against patches and mesh is done where those are in the same container.
    fn read(c: &'a Container) -> Result<Transfer> {
        let (_, shape) = c.array::<f32>("transfer.position", 2)?;
        let receivers = shape[0] as usize;
        let vectors = |name| -> Result<Vec<[f32; 3]>> {
            Ok(c.array_of::<f32>(name, &[Some(receivers), Some(3)])?.as_chunks().0.to_vec())
        };
        let patch = c.array_of::<u32>("transfer.patch", &[None])?;
        let source = c.array_of::<u32>("transfer.fine_source", &[None])?;
        let triangles = Some(source.len());
        let receiver = c.array_of::<u32>("transfer.fine_receiver", &[triangles, Some(2), Some(3)])?;
        let transfer = Transfer {
            position: vectors("transfer.position")?,
            normal: vectors("transfer.normal")?,
            rows: Rows {
                row_start: c.array_of::<u32>("transfer.row_start", &[Some(receivers + 1)])?.to_vec(),
                patch: patch.to_vec(),
                weight: c.array_of::<f32>("transfer.weight", &[Some(patch.len())])?.to_vec(),
            },
            fine: FineMesh {
                vertex: c.array_of::<f32>("transfer.fine_vertex", &[None, Some(3)])?.as_chunks().0.to_vec(),
                triangle: c.array_of::<u32>("transfer.fine_triangle", &[triangles, Some(3)])?.as_chunks().0.to_vec(),
                source: source.to_vec(),
                receiver: receiver.as_chunks::<3>().0.as_chunks::<2>().0.to_vec(),
            },
        };
        let (_, patches) = c.array::<f32>("patches.area", 1)?;
        let (_, triangles) = c.array::<u32>("mesh.triangles", 2)?;
        transfer.check(patches[0] as usize, triangles[0] as usize)?;
        Ok(transfer)
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        const BOUND: u32 = FLAG_REQUIRED | FLAG_PATCH_ORDER;
        let (rows, fine) = (&self.rows, &self.fine);
        b.array("transfer.position", FLAG_REQUIRED, &[self.position.len(), 3], self.position.as_flattened());
        b.array("transfer.normal", FLAG_REQUIRED, &[self.normal.len(), 3], self.normal.as_flattened());
        b.array("transfer.row_start", FLAG_REQUIRED, &[rows.row_start.len()], &rows.row_start[..]);
        b.array("transfer.patch", BOUND, &[rows.patch.len()], &rows.patch[..]);
        b.array("transfer.weight", BOUND, &[rows.weight.len()], &rows.weight[..]);
        b.array("transfer.fine_vertex", FLAG_REQUIRED, &[fine.vertex.len(), 3], fine.vertex.as_flattened());
        b.array("transfer.fine_triangle", FLAG_REQUIRED, &[fine.triangle.len(), 3], fine.triangle.as_flattened());
        b.array("transfer.fine_source", FLAG_REQUIRED, &[fine.source.len()], &fine.source[..]);
        let receiver = fine.receiver.as_flattened().as_flattened();
        b.array("transfer.fine_receiver", FLAG_REQUIRED, &[fine.receiver.len(), 2, 3], receiver);
    }
}
