//! Scenes made by hand: sheets cut into rectangles, each rectangle a patch on the sides that are asked for.

use glam::Vec3;
use radfile::{Mesh, PatchLocator, Patches, Piece, Side, face_id};

/// Mesh and patches that grow sheet by sheet.
pub struct Maker {
    pub mesh: Mesh,
    pub patches: Patches,
    /// Patches of each face, put into the locator at the end.
    face_patch: Vec<Option<u32>>,
    cell: f32,
}

impl Maker {
    pub fn new(cell: f32) -> Maker {
        let mut patches = Patches::default();
        patches.piece_start.push(0);
        Maker { mesh: Mesh::default(), patches, face_patch: vec![], cell }
    }

    /// A rectangle from `corner` along `u` and `v` whose front faces u × v, cut into `count[0]` × `count[1]` patches.
    pub fn sheet(&mut self, corner: Vec3, u: Vec3, v: Vec3, count: [usize; 2], sides: &[Side]) {
        let (du, dv) = (u / count[0] as f32, v / count[1] as f32);
        for j in 0..count[1] {
            for i in 0..count[0] {
                let at = |i: usize, j: usize| {
                    let p = corner + i as f32 / count[0] as f32 * u + j as f32 / count[1] as f32 * v;
                    p.to_array()
                };
                let first = self.mesh.triangles.len() as u32;
                for triangle in [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
                {
                    self.triangle(triangle);
                }
                for &side in sides {
                    self.patch(first, side, du.cross(dv));
                }
            }
        }
    }

    /// A box of outer walls that are seen from inside.
    pub fn room(&mut self, low: Vec3, size: Vec3, count: [usize; 3]) {
        let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
        let [i, j, k] = count;
        let inside = &[Side::Front];
        self.sheet(low, z, x, [k, i], inside);
        self.sheet(low + y, x, z, [i, k], inside);
        self.sheet(low, x, y, [i, j], inside);
        self.sheet(low + z, y, x, [j, i], inside);
        self.sheet(low, y, z, [j, k], inside);
        self.sheet(low + x, z, y, [k, j], inside);
    }

    pub fn triangle(&mut self, corners: [[f32; 3]; 3]) {
        let first = self.mesh.positions.len() as u32;
        self.mesh.positions.extend(corners);
        self.mesh.triangles.push([first, first + 1, first + 2]);
        self.mesh.triangle_material.push(0);
        self.face_patch.extend([None, None]);
    }

    /// One patch on a side of the triangles `first` and `first + 1`; `cross` is their front normal times their area.
    fn patch(&mut self, first: u32, side: Side, cross: Vec3) {
        let number = self.patches.len() as u32;
        let normal = if side == Side::Front { cross } else { -cross };
        let corners = [self.mesh.corners(first as usize), self.mesh.corners(first as usize + 1)];
        self.patches.position.push((0.5 * (Vec3::from(corners[0][0]) + Vec3::from(corners[0][2]))).to_array());
        self.patches.normal.push(normal.normalize().to_array());
        self.patches.area.push(cross.length());
        self.patches.reflectance.push([0.5; 3]);
        self.patches.emission.push([0.0; 3]);
        for (triangle, corners) in (first..).zip(corners) {
            let face = face_id(triangle, side);
            self.patches.pieces.push(Piece { corners, face });
            self.face_patch[face as usize] = Some(number);
        }
        self.patches.piece_start.push(self.patches.pieces.len() as u32);
    }

    pub fn finish(mut self) -> (Mesh, Patches) {
        let mut locator = PatchLocator { cell_size: self.cell, face_start: vec![0], ..PatchLocator::default() };
        for &patch in &self.face_patch {
            locator.cell_patch.extend(patch);
            locator.cell_key.extend(patch.map(|_| 0));
            locator.face_start.push(locator.cell_patch.len() as u32);
        }
        self.patches.locator = locator;
        self.patches.check().expect("the maker keeps the rules");
        (self.mesh, self.patches)
    }
}
