//! How light comes from patches to receivers, and the finer mesh whose vertices receive.

use crate::{
    Builder, Container, Error, FLAG_PATCH_ORDER, FLAG_REQUIRED, Gathered, Record, Result, patches::check_offsets,
};

/// Sparse rows: one a receiver, entries are (sender, weight).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// Receivers + 1 offsets into the two tables below.
    pub row_start: Vec<u32>,
    /// Sender of each entry: a patch where irradiance is interpolated, a sender of a gather where
    /// radiosity is.
    pub sender: Vec<u32>,
    /// Its weight.
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
        self.sender[range.clone()].iter().map(|&p| p as usize).zip(self.weight[range].iter().copied())
    }

    /// What arrives at every receiver of the light of the senders.
    pub fn gather(&self, light: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let add =
            |sum: [f32; 3], (sender, weight): (usize, f32)| std::array::from_fn(|c| sum[c] + weight * light[sender][c]);
        (0..self.len()).map(|receiver| self.row(receiver).fold([0.0; 3], add)).collect()
    }
}

/// How light comes from the patches to points.
#[derive(Clone, Debug, PartialEq)]
pub enum PointRows {
    /// From patches around each point: the rows weigh irradiance, and each sums to 1.
    Interpolated(Rows),
    /// From all that each point sees: the rows are its form factors and weigh radiosity; with the sky they sum to at
    /// most 1.
    Gathered {
        /// Form factors of the points, row = point, column = sender of a gather ([`crate::Elements`]).
        rows: Rows,
        /// What each point sees of the sky.
        sky: Vec<f32>,
    },
}

impl PointRows {
    /// Weights or form factors, one row a point.
    pub fn rows(&self) -> &Rows {
        match self {
            PointRows::Interpolated(rows) | PointRows::Gathered { rows, .. } => rows,
        }
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

impl FineMesh {
    /// Takes the given receivers from corners of triangles whose side has others left.
    pub fn drop_receivers(&mut self, dropped: &[u32]) {
        let dropped: std::collections::HashSet<u32> = dropped.iter().copied().collect();
        for corners in self.receiver.as_flattened_mut() {
            let is_left = |corner: &u32| *corner != NO_RECEIVER && !dropped.contains(corner);
            if corners.iter().any(is_left) {
                corners.iter_mut().filter(|c| dropped.contains(c)).for_each(|c| *c = NO_RECEIVER);
            }
        }
    }
}

/// How light comes to the receivers of a bake.
#[derive(Clone, Debug, PartialEq)]
pub enum Weights {
    /// From patches around each receiver: the rows weigh irradiance; each sums to 1, or is empty where the receiver sees
    /// no patch.
    Interpolated(Rows),
    /// From all that each receiver sees: packed form factors that weigh radiosity.
    Gathered(Gathered),
}

impl Default for Weights {
    fn default() -> Weights {
        Weights::Interpolated(Rows::default())
    }
}

/// Receivers of a bake: the sides of the vertices of the fine mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transfer {
    /// Where each receiver is, metres, local axes.
    pub position: Vec<[f32; 3]>,
    /// The direction it faces.
    pub normal: Vec<[f32; 3]>,
    /// How light comes to it.
    pub weights: Weights,
    /// The mesh whose corners they are.
    pub fine: FineMesh,
}

impl Transfer {
    /// Number of receivers.
    pub fn receivers(&self) -> usize {
        self.position.len()
    }

    /// Checks numbers, counts and indices, those of senders against `patch_count` patches and those of sources
    /// against `triangle_count` triangles of the mesh.
    ///
    /// # Errors
    ///
    /// [`Error::Invariant`] with the first offender.
    pub fn check(&self, patch_count: usize, triangle_count: usize) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("transfer", what));
        let finite = |v: &[f32; 3]| v.iter().all(|x| x.is_finite());
        if let Some(r) = self.position.iter().position(|p| !finite(p)) {
            return broken(format!("receiver {r} lies at {:?}, expected finite numbers", self.position[r]));
        }
        let unit = |v: &[f32; 3]| (v.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-3;
        if let Some(r) = self.normal.iter().position(|v| !unit(v)) {
            return broken(format!("receiver {r} has normal {:?}, expected a unit vector", self.normal[r]));
        }
        self.check_rows(patch_count)?;
        self.check_fine_mesh(triangle_count)
    }

    fn check_rows(&self, patch_count: usize) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("transfer", what));
        let rows = match &self.weights {
            Weights::Interpolated(rows) => rows,
            Weights::Gathered(gathered) if gathered.sky.len() != self.receivers() => {
                let (found, expected) = (gathered.sky.len(), self.receivers());
                return broken(format!("{found} shares of the sky, expected one for each of {expected} receivers"));
            }
            Weights::Gathered(_) => return Ok(()), // the stream is checked where it is read
        };
        check_offsets("transfer", "row_start", &rows.row_start, self.receivers(), rows.sender.len())?;
        if let Some(e) = rows.sender.iter().position(|&p| p as usize >= patch_count) {
            return broken(format!("entry {e} names patch {}, there are {patch_count}", rows.sender[e]));
        }
        if let Some(e) = rows.weight.iter().position(|w| !(0.0..=1.0001).contains(w)) {
            return broken(format!("entry {e} has weight {}, expected 0..1", rows.weight[e]));
        }
        let sum = |r: usize| rows.row(r).map(|(_, weight)| f64::from(weight)).sum::<f64>();
        let normalised = |r: usize| rows.row_start[r] == rows.row_start[r + 1] || (sum(r) - 1.0).abs() < 1e-3;
        match (0..rows.len()).find(|&r| !normalised(r)) {
            Some(r) => broken(format!("the weights of receiver {r} sum to {}, expected 1", sum(r))),
            None => Ok(()),
        }
    }

    fn check_fine_mesh(&self, triangle_count: usize) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("transfer", what));
        let (fine, receivers) = (&self.fine, self.receivers());
        if let Some(v) = fine.vertex.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return broken(format!("fine vertex {v} is {:?}, expected finite numbers", fine.vertex[v]));
        }
        let vertices = fine.vertex.len();
        if let Some(t) = fine.triangle.iter().position(|t| t.iter().any(|&v| v as usize >= vertices)) {
            return broken(format!("fine triangle {t} names vertices {:?}, there are {vertices}", fine.triangle[t]));
        }
        if let Some(t) = fine.source.iter().position(|&s| s as usize >= triangle_count) {
            let source = fine.source[t];
            return broken(format!("fine triangle {t} comes from triangle {source}, there are {triangle_count}"));
        }
        let legal = |r: &u32| (*r as usize) < receivers || *r == NO_RECEIVER;
        match fine.receiver.iter().position(|r| !r.as_flattened().iter().all(legal)) {
            Some(t) => {
                broken(format!("fine triangle {t} names receivers {:?}, there are {receivers}", fine.receiver[t]))
            }
            None => Ok(()),
        }
    }
}

impl<'a> Record<'a> for Transfer {
    const PREFIX: &'static str = "transfer.";

    /// Reads the record and checks it against the patches and the mesh, which must be in the same container.
    fn read(c: &'a Container) -> Result<Transfer> {
        let receivers = c.array_of::<f32>("transfer.position", &[None, Some(3)])?.len() / 3;
        let vectors = |name| -> Result<Vec<[f32; 3]>> {
            Ok(c.array_of::<f32>(name, &[Some(receivers), Some(3)])?.as_chunks().0.to_vec())
        };
        let weights = match Gathered::is_in(c, Self::PREFIX) {
            true => Weights::Gathered(Gathered::read(c, Self::PREFIX, receivers)?),
            false => Weights::Interpolated(read_rows(c, receivers)?),
        };
        let source = c.array_of::<u32>("transfer.fine_source", &[None])?;
        let triangles = Some(source.len());
        let receiver = c.array_of::<u32>("transfer.fine_receiver", &[triangles, Some(2), Some(3)])?;
        let transfer = Transfer {
            position: vectors("transfer.position")?,
            normal: vectors("transfer.normal")?,
            weights,
            fine: FineMesh {
                vertex: c.array_of::<f32>("transfer.fine_vertex", &[None, Some(3)])?.as_chunks().0.to_vec(),
                triangle: c.array_of::<u32>("transfer.fine_triangle", &[triangles, Some(3)])?.as_chunks().0.to_vec(),
                source: source.to_vec(),
                receiver: receiver.as_chunks::<3>().0.as_chunks::<2>().0.to_vec(),
            },
        };
        let patches = c.array_of::<f32>("patches.area", &[None])?.len();
        let triangles = c.array_of::<u32>("mesh.triangles", &[None, Some(3)])?.len() / 3;
        transfer.check(patches, triangles)?;
        Ok(transfer)
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        let fine = &self.fine;
        b.array("transfer.position", FLAG_REQUIRED, &[self.receivers(), 3], self.position.as_flattened());
        b.array("transfer.normal", FLAG_REQUIRED, &[self.receivers(), 3], self.normal.as_flattened());
        match &self.weights {
            Weights::Interpolated(rows) => write_rows(rows, b),
            Weights::Gathered(gathered) => gathered.write(b, Self::PREFIX, FLAG_REQUIRED),
        }
        b.array("transfer.fine_vertex", FLAG_REQUIRED, &[fine.vertex.len(), 3], fine.vertex.as_flattened());
        b.array("transfer.fine_triangle", FLAG_REQUIRED, &[fine.triangle.len(), 3], fine.triangle.as_flattened());
        b.array("transfer.fine_source", FLAG_REQUIRED, &[fine.source.len()], &fine.source[..]);
        let receiver = fine.receiver.as_flattened().as_flattened();
        b.array("transfer.fine_receiver", FLAG_REQUIRED, &[fine.receiver.len(), 2, 3], receiver);
    }
}

fn read_rows(c: &Container, receivers: usize) -> Result<Rows> {
    let sender = c.array_of::<u32>("transfer.patch", &[None])?;
    Ok(Rows {
        row_start: c.array_of::<u32>("transfer.row_start", &[Some(receivers + 1)])?.to_vec(),
        sender: sender.to_vec(),
        weight: c.array_of::<f32>("transfer.weight", &[Some(sender.len())])?.to_vec(),
    })
}

fn write_rows<'b>(rows: &'b Rows, b: &mut Builder<'b>) {
    const BOUND: u32 = FLAG_REQUIRED | FLAG_PATCH_ORDER;
    b.array("transfer.row_start", FLAG_REQUIRED, &[rows.row_start.len()], &rows.row_start[..]);
    b.array("transfer.patch", BOUND, &[rows.sender.len()], &rows.sender[..]);
    b.array("transfer.weight", BOUND, &[rows.weight.len()], &rows.weight[..]);
}
