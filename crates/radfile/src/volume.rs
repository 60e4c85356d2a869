//! An irradiance volume: a regular grid of probes, each the irradiance of six planes, for what moves through a scene.
//!
//! Source: J. Mitchell, G. McTaggart, C. Green, Shading in Valve's Source Engine, SIGGRAPH 2006 course, slides 27 and
//! 28 (the ambient cube); G. Greger et al., The Irradiance Volume, 1998 (the grid).

use serde::{Deserialize, Serialize};

use crate::{Builder, Container, Error, Record, Result};

/// Most cells along an axis: six directions as three slabs one behind the other fit a texture of 2048.
pub const LARGEST_VOLUME: u32 = 682;

/// How far a probe may lie outside of its cell, edges of it: rounding.
const OUTSIDE: f32 = 1e-3;

/// A box of `count` cells with a probe in the middle of each that is not inside of something.
///
/// Cell (x, y, z) has the number x + count_x (y + count_y z).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Volume {
    /// Lower corner of cell (0, 0, 0), metres, local axes.
    pub origin: [f32; 3],
    /// Edges of a cell, metres.
    pub spacing: [f32; 3],
    /// Cells along x, y and z.
    pub count: [u32; 3],
    /// Number of the cell of each probe, increasing.
    pub cell: Vec<u32>,
    /// Where each probe is: in its cell, close to the middle. Metres, local axes.
    pub position: Vec<[f32; 3]>,
    /// For every cell the probe whose light it shows, its own or one nearby.
    pub probe: Vec<u32>,
}

#[derive(Serialize, Deserialize)]
struct Meta {
    origin: [f32; 3],
    spacing: [f32; 3],
    count: [u32; 3],
}

impl Volume {
    /// Where the receivers of a probe face. Receiver 6 · probe + direction.
    pub const NORMALS: [[f32; 3]; 6] =
        [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.count.iter().fold(1, |product, &n| product.saturating_mul(n as usize))
    }

    /// Number of probes.
    pub fn probes(&self) -> usize {
        self.cell.len()
    }

    /// Number of receivers: six a probe.
    pub fn receivers(&self) -> usize {
        self.cell.len() * Volume::NORMALS.len()
    }

    /// The middle of a cell, metres, local axes.
    pub fn middle(&self, cell: usize) -> [f32; 3] {
        let at = place(self.count, cell);
        std::array::from_fn(|a| self.origin[a] + (at[a] as f32 + 0.5) * self.spacing[a])
    }

    /// The six values of every cell: those of the probe that it shows.
    ///
    /// # Panics
    ///
    /// If there is not one value a receiver: a bug in the caller.
    pub fn fill(&self, values: &[[f32; 3]]) -> Vec<[[f32; 3]; 6]> {
        assert_eq!(values.len(), self.receivers(), "one value a receiver");
        let (cubes, _) = values.as_chunks::<6>();
        self.probe.iter().map(|&probe| cubes[probe as usize]).collect()
    }

    /// Checks sizes, numbers and indices.
    ///
    /// # Errors
    ///
    /// [`Error::Invariant`] with the first offender.
    pub fn check(&self) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("volume", what));
        if !self.count.iter().all(|n| (1..=LARGEST_VOLUME).contains(n)) {
            return broken(format!("{:?} cells, expected 1 to {LARGEST_VOLUME} along each axis", self.count));
        }
        let box_is_one = self.origin.iter().all(|x| x.is_finite())
            && self.spacing.iter().all(|x| *x > 0.0)
            && (0..3).all(|a| (self.origin[a] + self.count[a] as f32 * self.spacing[a]).is_finite());
        if !box_is_one {
            let found = format!("cells of {:?} from {:?} on", self.spacing, self.origin);
            return broken(format!("{found}, expected finite numbers and positive edges"));
        }
        self.check_probes()?;
        self.check_cells()
    }

    fn check_probes(&self) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("volume", what));
        if self.position.len() != self.probes() {
            return broken(format!(
                "{} probes have {} positions, expected one each",
                self.probes(),
                self.position.len()
            ));
        }
        if let Some(p) = self.cell.windows(2).position(|pair| pair[0] >= pair[1]) {
            return broken(format!("the cells of probes {p} and {} do not increase", p + 1));
        }
        if let Some(p) = self.cell.iter().position(|&cell| cell as usize >= self.cells()) {
            return broken(format!("probe {p} lies in cell {}, there are {}", self.cell[p], self.cells()));
        }
        match (0..self.probes()).find(|&p| !self.is_in_its_cell(p)) {
            Some(p) => broken(format!("probe {p} lies at {:?}, outside of cell {}", self.position[p], self.cell[p])),
            None => Ok(()),
        }
    }

    fn is_in_its_cell(&self, probe: usize) -> bool {
        let middle = self.middle(self.cell[probe] as usize);
        (0..3).all(|a| (self.position[probe][a] - middle[a]).abs() <= (0.5 + OUTSIDE) * self.spacing[a])
    }

    fn check_cells(&self) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("volume", what));
        if self.probe.len() != self.cells() {
            return broken(format!("{} cells name probes, there are {}", self.probe.len(), self.cells()));
        }
        if let Some(c) = self.probe.iter().position(|&p| p as usize >= self.probes()) {
            return broken(format!("cell {c} names probe {}, there are {}", self.probe[c], self.probes()));
        }
        let other = |(p, &cell): (usize, &u32)| self.probe[cell as usize] as usize != p;
        match self.cell.iter().enumerate().position(other) {
            Some(p) => broken(format!("cell {} does not show its own probe {p}", self.cell[p])),
            None => Ok(()),
        }
    }
}

/// Place of a cell along x, y and z.
fn place(count: [u32; 3], cell: usize) -> [usize; 3] {
    let [x, y, _] = count.map(|n| n as usize);
    [cell % x, cell / x % y, cell / x / y]
}

impl Record<'_> for Volume {
    const PREFIX: &'static str = "volume.";

    fn read(c: &Container) -> Result<Volume> {
        let Meta { origin, spacing, count } = c.meta("volume.meta")?;
        let cell = c.array_of::<u32>("volume.cell", &[None])?;
        let size = [count[2], count[1], count[0]].map(|n| Some(n as usize));
        let volume = Volume {
            origin,
            spacing,
            count,
            position: c.array_of::<f32>("volume.position", &[Some(cell.len()), Some(3)])?.as_chunks().0.to_vec(),
            probe: c.array_of::<u32>("volume.probe", &size)?.to_vec(),
            cell: cell.to_vec(),
        };
        volume.check()?;
        Ok(volume)
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        b.meta("volume.meta", 0, &Meta { origin: self.origin, spacing: self.spacing, count: self.count });
        b.array("volume.cell", 0, &[self.cell.len()], &self.cell[..]);
        b.array("volume.position", 0, &[self.position.len(), 3], self.position.as_flattened());
        let size = [self.count[2], self.count[1], self.count[0]].map(|n| n as usize);
        b.array("volume.probe", 0, &size, &self.probe[..]);
    }
}
