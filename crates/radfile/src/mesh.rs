//! Triangles as the scene file gave them, about a local origin.

use serde::{Deserialize, Serialize};

use crate::{Builder, Container, Error, FLAG_REQUIRED, Record, Result, materials};

/// Static geometry: `v` vertices, `t` triangles.
///
/// A vertex of the scene file is `origin + position`: positions are small numbers even where the
/// file uses map coordinates. Every triangle has two *faces*, see [`face_id`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Point of the scene file's axes that is the local origin, metres, f64.
    pub origin: [f64; 3],
    /// Only front sides reflect and receive; otherwise both sides do.
    pub one_sided: bool,
    /// `v` × 3, metres, relative to `origin`.
    pub positions: Vec<[f32; 3]>,
    /// `t` × 3 indices into `positions`; counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// `t` indices into [`crate::Materials::materials`].
    pub triangle_material: Vec<u32>,
    /// `v` × 2 coordinates of the reflectance texture, or empty. (0, 0) is the first texel of the first row.
    pub uv: Vec<[f32; 2]>,
    /// `v` × 2 coordinates of the emission texture; empty means the same as `uv`.
    pub emission_uv: Vec<[f32; 2]>,
    /// `v` × 2 coordinates of a lightmap that the scene file brings, or empty; same origin as `uv`. A part of the scene
    /// without them has (0, 0).
    pub lightmap_uv: Vec<[f32; 2]>,
}

/// Which side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Side {
    /// The side its vertices turn counter-clockwise on; its normal is (b − a) × (c − a).
    Front = 0,
    /// The other side.
    Back = 1,
}

/// Number of one side of one triangle: `2 · triangle + side`.
pub fn face_id(triangle: u32, side: Side) -> u32 {
    2 * triangle + side as u32
}

#[derive(Serialize, Deserialize)]
struct Meta {
    origin: [f64; 3],
    one_sided: bool,
}

impl Mesh {
    /// The three corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [[f32; 3]; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }

    /// Number of faces, two a triangle.
    pub fn face_count(&self) -> usize {
        2 * self.triangles.len()
    }

    fn check(&self) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("mesh", what));
        if self.triangles.is_empty() {
            return broken("no triangles".into());
        }
        if self.triangles.len() > (u32::MAX / 2) as usize {
            return broken(format!("{} triangles; face numbers hold 2^31", self.triangles.len()));
        }
        if let Some(v) = self.positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return broken(format!("vertex {v} is {:?}, expected finite numbers", self.positions[v]));
        }
        if !self.origin.iter().all(|x| x.is_finite()) {
            return broken(format!("origin is {:?}, expected finite numbers", self.origin));
        }
        for (name, uv) in [("uv", &self.uv), ("emission_uv", &self.emission_uv), ("lightmap_uv", &self.lightmap_uv)] {
            if let Some(v) = uv.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
                return broken(format!("vertex {v} has {name} {:?}, expected finite numbers", uv[v]));
            }
        }
        let v = self.positions.len();
        match self.triangles.iter().position(|t| t.iter().any(|&i| i as usize >= v)) {
            Some(t) => broken(format!("triangle {t} names vertices {:?}, there are {v}", self.triangles[t])),
            None => Ok(()),
        }
    }
}

impl<'a> Record<'a> for Mesh {
    const PREFIX: &'static str = "mesh.";

    fn read(c: &'a Container) -> Result<Mesh> {
        let meta: Meta = c.meta("mesh.meta")?;
        let positions = c.array_of::<f32>("mesh.positions", &[None, Some(3)])?.as_chunks().0.to_vec();
        let v = positions.len();
        let triangles = c.array_of::<u32>("mesh.triangles", &[None, Some(3)])?.as_chunks().0.to_vec();
        let uv = |name| -> Result<Vec<[f32; 2]>> {
            Ok(if c.has(name) { c.array_of::<f32>(name, &[Some(v), Some(2)])?.as_chunks().0.to_vec() } else { vec![] })
        };
        let mesh = Mesh {
            origin: meta.origin,
            one_sided: meta.one_sided,
            triangle_material: c.array_of::<u32>("mesh.material", &[Some(triangles.len())])?.to_vec(),
            uv: uv("mesh.uv")?,
            emission_uv: uv("mesh.emission_uv")?,
            lightmap_uv: uv("mesh.lightmap_uv")?,
            positions,
            triangles,
        };
        mesh.check()?;
        let Some(count) = materials::count(c)? else { return Ok(mesh) };
        match mesh.triangle_material.iter().position(|&m| m as usize >= count) {
            Some(t) => {
                let what = format!("triangle {t} has material {}, there are {count}", mesh.triangle_material[t]);
                Err(Error::invariant("mesh", what))
            }
            None => Ok(mesh),
        }
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        b.meta("mesh.meta", FLAG_REQUIRED, &Meta { origin: self.origin, one_sided: self.one_sided });
        b.array("mesh.positions", FLAG_REQUIRED, &[self.positions.len(), 3], self.positions.as_flattened());
        b.array("mesh.triangles", FLAG_REQUIRED, &[self.triangles.len(), 3], self.triangles.as_flattened());
        b.array("mesh.material", FLAG_REQUIRED, &[self.triangle_material.len()], &self.triangle_material[..]);
        let sets =
            [("mesh.uv", &self.uv), ("mesh.emission_uv", &self.emission_uv), ("mesh.lightmap_uv", &self.lightmap_uv)];
        for (name, uv) in sets {
            if !uv.is_empty() {
                b.array(name, 0, &[uv.len(), 2], uv.as_flattened());
            }
        }
    }
}
