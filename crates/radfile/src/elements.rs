//! Elements: the parts of patches that the last gather tells apart.
//!
//! Light bounces between patches, but what a receiver sees of a patch is finer than one value: the border of a shadow
//! runs across it, its texture has a grain. So a patch is parted by a grid into elements with a direct light and a
//! reflectance of their own, as patches and elements of M. F. Cohen, D. P. Greenberg, D. S. Immel, P. J. Brock, An
//! efficient radiosity approach for realistic image synthesis, IEEE CG&A 6(3), 1986 ("substructuring").
//!
//! The senders of a gather are the patches, for what is far, and then the elements, for what is near: sender i < n is
//! patch i, sender n + e is element e.

use std::ops::Range;

use crate::{
    Builder, CellKey, Container, Error, FLAG_PATCH_ORDER, FLAG_REQUIRED, Patches, Record, Result,
    patches::check_offsets, record::check_patch_count,
};

/// `m` elements of `n` patches; those of a patch follow each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Elements {
    /// `n` + 1 offsets: the elements of each patch, one at least.
    pub start: Vec<u32>,
    /// One-sided area of each element, m²; those of a patch add up to its area, in the proportions that others see.
    pub area: Vec<f32>,
    /// Diffuse reflectance ρ of each element, linear RGB, 0 ≤ ρ < 1.
    pub reflectance: Vec<[f32; 3]>,
    /// `m` + 1 offsets into the two tables below.
    pub point_start: Vec<u32>,
    /// Points of each element at which its direct light is looked up, one at least, metres, local axes; or none of any,
    /// and whoever needs them draws them on the patches.
    pub point: Vec<[f32; 3]>,
    /// The face of the mesh that each lies on.
    pub point_face: Vec<u32>,
    /// Lower corner of cell (0, 0, 0) of the grids that part the patches, metres, local axes.
    pub grid_origin: [f32; 3],
    /// `n` edges of the cells that part each patch, metres.
    pub edge: Vec<f32>,
    /// `n` + 1 offsets into the two tables below; a patch of one element has no cells.
    pub cell_start: Vec<u32>,
    /// Cells that a patch has parts in, increasing within a patch ([`CellKey`]).
    pub cell_key: Vec<u64>,
    /// The element in each of them.
    pub cell_element: Vec<u32>,
}

impl Elements {
    /// One element a patch.
    pub fn whole(patches: &Patches) -> Elements {
        let n = patches.len();
        Elements {
            start: (0..=n as u32).collect(),
            area: patches.area.clone(),
            reflectance: patches.reflectance.clone(),
            point_start: vec![0; n + 1],
            grid_origin: patches.locator.grid_origin,
            edge: vec![patches.locator.cell_size; n],
            cell_start: vec![0; n + 1],
            ..Elements::default()
        }
    }

    /// Those of a container, or whole patches where it has none.
    ///
    /// # Errors
    ///
    /// What [`Elements::read`] refuses.
    pub fn read_or_whole(c: &Container, patches: &Patches) -> Result<Elements> {
        if c.has("elements.start") { Elements::read(c) } else { Ok(Elements::whole(patches)) }
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.area.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.area.is_empty()
    }

    /// Number of patches.
    pub fn patches(&self) -> usize {
        self.edge.len()
    }

    /// Number of senders of a gather: patches, then elements.
    pub fn senders(&self) -> usize {
        self.patches() + self.len()
    }

    /// The elements of a patch.
    pub fn of(&self, patch: usize) -> Range<usize> {
        self.start[patch] as usize..self.start[patch + 1] as usize
    }

    /// The element of `patch` that `point` lies in, or the nearest: the point of a hit carries rounding errors.
    pub fn at(&self, patch: usize, point: [f32; 3]) -> u32 {
        let cells = self.cell_start[patch] as usize..self.cell_start[patch + 1] as usize;
        if cells.is_empty() {
            return self.start[patch];
        }
        let keys = &self.cell_key[cells.clone()];
        let key = CellKey::of(self.grid_origin, self.edge[patch], point);
        let at = keys.binary_search(&key.0).unwrap_or_else(|_| self.nearest(keys, patch, point));
        self.cell_element[cells.start + at]
    }

    /// A value of each patch, from values of its elements: their mean by area.
    pub fn mean(&self, values: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let mean = |patch: usize| {
            let (mut sum, mut area) = ([0.0; 3], 0.0);
            for e in self.of(patch) {
                let a = f64::from(self.area[e]);
                area += a;
                sum = std::array::from_fn(|c| sum[c] + a * f64::from(values[e][c]));
            }
            sum.map(|s| (s / area) as f32)
        };
        (0..self.patches()).map(mean).collect()
    }

    fn nearest(&self, keys: &[u64], patch: usize, point: [f32; 3]) -> usize {
        let distance = |key: u64| CellKey(key).distance_squared(self.grid_origin, self.edge[patch], point);
        (0..keys.len()).min_by(|&a, &b| distance(keys[a]).total_cmp(&distance(keys[b]))).unwrap_or(0)
    }

    fn check(&self, faces: usize) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("elements", what));
        let (n, m) = (self.patches(), self.len());
        check_offsets("elements", "start", &self.start, n, m)?;
        check_offsets("elements", "cell_start", &self.cell_start, n, self.cell_key.len())?;
        if let Some(e) = self.area.iter().position(|&a| !(a > 0.0 && a.is_finite())) {
            return broken(format!("element {e} has area {}, expected a positive number", self.area[e]));
        }
        if let Some(e) = self.reflectance.iter().position(|r| !r.iter().all(|v| (0.0..1.0).contains(v))) {
            return broken(format!("element {e} has reflectance {:?}, expected 0 ≤ ρ < 1", self.reflectance[e]));
        }
        check_offsets("elements", "point_start", &self.point_start, m, self.point.len())?;
        if !self.point.is_empty() && self.point_start.windows(2).any(|w| w[0] == w[1]) {
            return broken("an element has no point, others have".into());
        }
        if let Some(p) = self.point.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return broken(format!("point {p} lies at {:?}, expected finite numbers", self.point[p]));
        }
        if let Some(p) = self.point_face.iter().position(|&f| f as usize >= faces) {
            return broken(format!("point {p} lies on face {}, there are {faces}", self.point_face[p]));
        }
        if let Some(p) = self.edge.iter().position(|&e| !(e > 0.0 && e.is_finite())) {
            return broken(format!(
                "the cells of patch {p} have an edge of {}, expected a positive number",
                self.edge[p]
            ));
        }
        if !self.grid_origin.iter().all(|x| x.is_finite()) {
            return broken(format!("the grid starts at {:?}, expected finite numbers", self.grid_origin));
        }
        match (0..n).find(|&p| self.of(p).is_empty() || !self.is_parted_well(p)) {
            Some(p) => broken(format!("patch {p} has no elements, or cells that do not increase or name others")),
            None => Ok(()),
        }
    }

    fn is_parted_well(&self, patch: usize) -> bool {
        let cells = self.cell_start[patch] as usize..self.cell_start[patch + 1] as usize;
        let own = self.of(patch);
        let named = self.cell_element[cells.clone()].iter().all(|&e| own.contains(&(e as usize)));
        named && self.cell_key[cells].windows(2).all(|pair| pair[0] < pair[1])
    }
}

impl<'a> Record<'a> for Elements {
    const PREFIX: &'static str = "elements.";

    /// Reads the record and checks it against patches and mesh, which must be in the same container.
    fn read(c: &'a Container) -> Result<Elements> {
        let edge = c.array_of::<f32>("elements.edge", &[None])?;
        let (area, key) =
            (c.array_of::<f32>("elements.area", &[None])?, c.array_of::<u64>("elements.cell_key", &[None])?);
        let (n, m) = (Some(edge.len() + 1), Some(area.len()));
        let point = c.array_of::<f32>("elements.point", &[None, Some(3)])?;
        let origin = c.array_of::<f32>("elements.grid_origin", &[Some(3)])?;
        let elements = Elements {
            start: c.array_of::<u32>("elements.start", &[n])?.to_vec(),
            area: area.to_vec(),
            reflectance: c.array_of::<f32>("elements.reflectance", &[m, Some(3)])?.as_chunks().0.to_vec(),
            point_start: c.array_of::<u32>("elements.point_start", &[Some(area.len() + 1)])?.to_vec(),
            point: point.as_chunks().0.to_vec(),
            point_face: c.array_of::<u32>("elements.point_face", &[Some(point.len() / 3)])?.to_vec(),
            grid_origin: [origin[0], origin[1], origin[2]],
            edge: edge.to_vec(),
            cell_start: c.array_of::<u32>("elements.cell_start", &[n])?.to_vec(),
            cell_key: key.to_vec(),
            cell_element: c.array_of::<u32>("elements.cell_element", &[Some(key.len())])?.to_vec(),
        };
        check_patch_count(c, "elements", elements.patches())?;
        let triangles = c.array_of::<u32>("mesh.triangles", &[None, Some(3)])?.len() / 3;
        elements.check(2 * triangles)?;
        Ok(elements)
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        const FLAGS: u32 = FLAG_REQUIRED | FLAG_PATCH_ORDER;
        let (n, m, cells) = (self.patches(), self.len(), self.cell_key.len());
        b.array("elements.start", FLAGS, &[n + 1], &self.start[..]);
        b.array("elements.area", FLAGS, &[m], &self.area[..]);
        b.array("elements.reflectance", FLAGS, &[m, 3], self.reflectance.as_flattened());
        b.array("elements.point_start", FLAGS, &[m + 1], &self.point_start[..]);
        b.array("elements.point", FLAGS, &[self.point.len(), 3], self.point.as_flattened());
        b.array("elements.point_face", FLAGS, &[self.point_face.len()], &self.point_face[..]);
        b.array("elements.grid_origin", FLAGS, &[3], &self.grid_origin[..]);
        b.array("elements.edge", FLAGS, &[n], &self.edge[..]);
        b.array("elements.cell_start", FLAGS, &[n + 1], &self.cell_start[..]);
        b.array("elements.cell_key", FLAGS, &[cells], &self.cell_key[..]);
        b.array("elements.cell_element", FLAGS, &[cells], &self.cell_element[..]);
    }
}
