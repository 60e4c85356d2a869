//! A lightmap: where its texels lie on the mesh, and which of them receive.

use serde::{Deserialize, Serialize};

use crate::{Builder, Container, Error, NO_RECEIVER, Record, Result};

/// Largest width and height: what graphics hardware takes as one texture.
pub const LARGEST_LIGHTMAP: u32 = 16384;

/// Layout of a lightmap of `width` × `height` texels with `r` receivers, over a mesh of `t` triangles.
///
/// Texel (x, y) has the number y · `width` + x and covers x/`width` to (x + 1)/`width` and y/`height` to
/// (y + 1)/`height`: (0, 0) is the outer corner of the first texel of the first row, as in glTF.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lightmap {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `t` × 3 coordinates of the corners of each triangle, 0 to 1.
    pub corner_uv: Vec<[[f32; 2]; 3]>,
    /// `r` numbers of the texels that receive, increasing.
    pub texel: Vec<u32>,
    /// Where each receiver lies on its triangle, metres, local axes.
    pub position: Vec<[f32; 3]>,
    /// The direction it faces, unit length.
    pub normal: Vec<[f32; 3]>,
    /// Triangle of the mesh that it lies on.
    pub triangle: Vec<u32>,
    /// For every texel the receiver whose light it shows, its own or one nearby; [`NO_RECEIVER`] where none is needed.
    pub receiver: Vec<u32>,
}

#[derive(Serialize, Deserialize)]
struct Meta {
    width: u32,
    height: u32,
}

impl Lightmap {
    /// Number of receivers.
    pub fn receivers(&self) -> usize {
        self.texel.len()
    }

    /// The picture, row by row: every texel has the value of its receiver, and 0 where it has none.
    ///
    /// # Panics
    ///
    /// If there is not one value a receiver: a bug in the caller.
    pub fn fill(&self, values: &[[f32; 3]]) -> Vec<[f32; 3]> {
        assert_eq!(values.len(), self.receivers(), "one value a receiver");
        self.receiver.iter().map(|&r| values.get(r as usize).copied().unwrap_or_default()).collect()
    }

    /// Checks sizes, numbers and indices, those of triangles against `triangle_count` triangles of the mesh.
    ///
    /// # Errors
    ///
    /// [`Error::Invariant`] with the first offender.
    pub fn check(&self, triangle_count: usize) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("lightmap", what));
        let legal = 1..=LARGEST_LIGHTMAP;
        if !(legal.contains(&self.width) && legal.contains(&self.height)) {
            return broken(format!("it is {} × {} texels, expected 1 to 16384 each", self.width, self.height));
        }
        if self.corner_uv.len() != triangle_count {
            return broken(format!("made for {} triangles, the mesh has {triangle_count}", self.corner_uv.len()));
        }
        let inside = |c: &[[f32; 2]; 3]| c.as_flattened().iter().all(|x| (0.0..=1.0).contains(x));
        if let Some(t) = self.corner_uv.iter().position(|c| !inside(c)) {
            return broken(format!("triangle {t} has corners at {:?}, expected 0 to 1", self.corner_uv[t]));
        }
        self.check_receivers(triangle_count)?;
        self.check_texels()
    }

    fn check_receivers(&self, triangle_count: usize) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("lightmap", what));
        let counts = [self.position.len(), self.normal.len(), self.triangle.len()];
        if counts != [self.receivers(); 3] {
            let what = format!("{counts:?} positions, normals and triangles");
            return broken(format!("{} receivers have {what}, expected one each", self.receivers()));
        }
        if let Some(r) = self.position.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return broken(format!("receiver {r} lies at {:?}, expected finite numbers", self.position[r]));
        }
        let unit = |v: &[f32; 3]| (v.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-3;
        if let Some(r) = self.normal.iter().position(|v| !unit(v)) {
            return broken(format!("receiver {r} has normal {:?}, expected a unit vector", self.normal[r]));
        }
        match self.triangle.iter().position(|&t| t as usize >= triangle_count) {
            Some(r) => {
                broken(format!("receiver {r} lies on triangle {}, there are {triangle_count}", self.triangle[r]))
            }
            None => Ok(()),
        }
    }

    fn check_texels(&self) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("lightmap", what));
        let texels = self.width as usize * self.height as usize;
        if self.receiver.len() != texels {
            return broken(format!("{} texels name receivers, there are {texels}", self.receiver.len()));
        }
        if let Some(r) = self.texel.windows(2).position(|pair| pair[0] >= pair[1]) {
            return broken(format!("the texels of receivers {r} and {} do not increase", r + 1));
        }
        let receivers = self.texel.len();
        let legal = |r: u32| (r as usize) < receivers || r == NO_RECEIVER;
        if let Some(x) = self.receiver.iter().position(|&r| !legal(r)) {
            return broken(format!("texel {x} names receiver {}, there are {receivers}", self.receiver[x]));
        }
        let own = |(r, &x): (usize, &u32)| self.receiver.get(x as usize) != Some(&(r as u32));
        match self.texel.iter().enumerate().position(own) {
            Some(r) => broken(format!("texel {} does not show its own receiver {r}", self.texel[r])),
            None => Ok(()),
        }
    }
}

impl<'a> Record<'a> for Lightmap {
    const PREFIX: &'static str = "lightmap.";

    /// Reads the record and checks it against the mesh, which must be in the same container.
    fn read(c: &'a Container) -> Result<Lightmap> {
        let Meta { width, height } = c.meta("lightmap.meta")?;
        let texel = c.array_of::<u32>("lightmap.texel", &[None])?;
        let receivers = Some(texel.len());
        let vectors = |name| -> Result<Vec<[f32; 3]>> {
            Ok(c.array_of::<f32>(name, &[receivers, Some(3)])?.as_chunks().0.to_vec())
        };
        let corners = c.array_of::<f32>("lightmap.corner_uv", &[None, Some(3), Some(2)])?;
        let size = [height, width].map(|extent| Some(extent as usize));
        let lightmap = Lightmap {
            width,
            height,
            corner_uv: corners.as_chunks::<2>().0.as_chunks::<3>().0.to_vec(),
            position: vectors("lightmap.position")?,
            normal: vectors("lightmap.normal")?,
            triangle: c.array_of::<u32>("lightmap.triangle", &[receivers])?.to_vec(),
            receiver: c.array_of::<u32>("lightmap.receiver", &size)?.to_vec(),
            texel: texel.to_vec(),
        };
        lightmap.check(c.array_of::<u32>("mesh.triangles", &[None, Some(3)])?.len() / 3)?;
        Ok(lightmap)
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        b.meta("lightmap.meta", 0, &Meta { width: self.width, height: self.height });
        b.array("lightmap.corner_uv", 0, &[self.corner_uv.len(), 3, 2], self.corner_uv.as_flattened().as_flattened());
        b.array("lightmap.texel", 0, &[self.texel.len()], &self.texel[..]);
        b.array("lightmap.position", 0, &[self.position.len(), 3], self.position.as_flattened());
        b.array("lightmap.normal", 0, &[self.normal.len(), 3], self.normal.as_flattened());
        b.array("lightmap.triangle", 0, &[self.triangle.len()], &self.triangle[..]);
        let size = [self.height as usize, self.width as usize];
        b.array("lightmap.receiver", 0, &size, &self.receiver[..]);
    }
}
