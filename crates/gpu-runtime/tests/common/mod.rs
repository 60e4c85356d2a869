//! What the device tests share: the adapter, rooms made of rectangles, and operators made by hand.

#![allow(dead_code, reason = "every test binary uses its own part")]

use std::io::Write;

use glam::Vec3;
use gpu_runtime::{Bake, Gpu};
use radfile::{
    BlockFormat, Elements, FineMesh, Material, NO_RECEIVER, PackedOperator, Packing, Patches, Piece, Rows, Transfer,
    ValueMap, Weights,
};
use scene::Scene;

/// The adapter under test; its absence is a failure unless ALLBOUNCE_GPU=skip.
pub fn gpu() -> Option<Gpu> {
    if std::env::var("ALLBOUNCE_GPU").as_deref() == Ok("skip") {
        // Not println!, whose lines are swallowed when a test passes.
        writeln!(std::io::stderr(), "skipped: ALLBOUNCE_GPU=skip leaves the device tests out").expect("standard error");
        return None;
    }
    let gpu = Gpu::new().expect("a GPU or a software Vulkan driver; ALLBOUNCE_GPU=skip leaves these tests out");
    println!("gpu: {}", gpu.adapter());
    Some(gpu)
}

/// A rectangle that reflects on the side of `u` × `v`.
#[derive(Clone, Copy)]
pub struct Wall {
    pub corner: [f32; 3],
    pub u: [f32; 3],
    pub v: [f32; 3],
    pub reflectance: [f32; 3],
    pub emission: [f32; 3],
    /// Patches along u and along v.
    pub cells: [u32; 2],
}

/// A scene with patches and a fine mesh whose corners take the light of the patch they lie on.
pub struct Room {
    pub scene: Scene,
    pub patches: Patches,
    pub elements: Elements,
    pub transfer: Transfer,
    /// The weights of the transfer.
    pub rows: Rows,
    pub sky: Vec<f32>,
}

/// A grey wall of one patch.
pub fn wall(corner: [f32; 3], u: [f32; 3], v: [f32; 3], cells: [u32; 2]) -> Wall {
    Wall { corner, u, v, reflectance: [0.5; 3], emission: [0.0; 3], cells }
}

/// Every cell of every wall becomes two triangles and one patch.
pub fn room(walls: &[Wall]) -> Room {
    let mut room = Room {
        scene: Scene::default(),
        patches: Patches { piece_start: vec![0], ..Patches::default() },
        elements: Elements::default(),
        transfer: Transfer::default(),
        rows: Rows { row_start: vec![0], ..Rows::default() },
        sky: vec![],
    };
    let locator = &mut room.patches.locator;
    (locator.cell_size, locator.face_start) = (1.0, vec![0]);
    for (material, w) in walls.iter().enumerate() {
        room.scene.materials.materials.push(Material {
            name: format!("wall {material}"),
            reflectance: w.reflectance,
            reflectance_texture: None,
            emission: w.emission,
            emission_texture: None,
        });
        for cell in 0..w.cells[0] * w.cells[1] {
            room.add_cell(w, material as u32, [cell % w.cells[0], cell / w.cells[0]]);
        }
    }
    room.sky = vec![0.0; room.patches.len()];
    room.elements = Elements::whole(&room.patches);
    room.transfer.weights = Weights::Interpolated(room.rows.clone());
    room.patches.check().expect("hand-made patches are whole");
    room
}

impl Room {
    fn add_cell(&mut self, w: &Wall, material: u32, [i, j]: [u32; 2]) {
        let at = |a: u32, b: u32| {
            let (s, t) = (a as f32 / w.cells[0] as f32, b as f32 / w.cells[1] as f32);
            Vec3::from(w.corner) + s * Vec3::from(w.u) + t * Vec3::from(w.v)
        };
        let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        let cross = (corners[1] - corners[0]).cross(corners[3] - corners[0]);
        let (patch, p) = (self.patches.len() as u32, &mut self.patches);
        p.position.push((0.25 * corners.iter().sum::<Vec3>()).to_array());
        p.normal.push(cross.normalize().to_array());
        p.area.push(cross.length());
        p.reflectance.push(w.reflectance);
        p.emission.push(w.emission.map(|e| std::f32::consts::PI * e));
        for triangle in [[0, 1, 2], [0, 2, 3]] {
            let (mesh, fine) = (&mut self.scene.mesh, &mut self.transfer.fine);
            let number = mesh.triangles.len() as u32;
            let piece = triangle.map(|k: usize| corners[k].to_array());
            p.pieces.push(Piece { corners: piece, face: 2 * number });
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(piece);
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.triangle_material.push(material);
            // The front face has one cell, the back none.
            p.locator.cell_key.push(0);
            p.locator.cell_patch.push(patch);
            let cells = p.locator.cell_key.len() as u32;
            p.locator.face_start.extend([cells, cells]);
            fine.vertex.extend(piece);
            fine.triangle.push([first, first + 1, first + 2]);
            fine.source.push(number);
            fine.receiver.push([[first, first + 1, first + 2], [NO_RECEIVER; 3]]);
            for corner in piece {
                self.transfer.position.push(corner);
                self.transfer.normal.push(p.normal[patch as usize]);
                self.rows.sender.push(patch);
                self.rows.weight.push(1.0);
                self.rows.row_start.push(self.rows.sender.len() as u32);
            }
        }
        p.piece_start.push(p.pieces.len() as u32);
    }

    /// What the run time is made of.
    pub fn bake(&self) -> Bake<'_> {
        let Room { scene, patches, elements, sky, transfer, .. } = self;
        Bake { scene, patches, elements, sky, transfer }
    }

    /// A fine mesh without triangles.
    pub fn without_fine_mesh(mut self) -> Room {
        self.transfer.fine = FineMesh::default();
        self
    }
}

/// The inside of a box from `low` to `high`: floor, ceiling, back, front, red left, green right; z is up.
pub fn inside([x0, y0, z0]: [f32; 3], [x1, y1, z1]: [f32; 3], cells: u32) -> Vec<Wall> {
    let (dx, dy, dz) = ([x1 - x0, 0.0, 0.0], [0.0, y1 - y0, 0.0], [0.0, 0.0, z1 - z0]);
    let c = [cells; 2];
    let mut walls = vec![
        wall([x0, y0, z0], dx, dy, c),
        wall([x0, y0, z1], dy, dx, c),
        wall([x0, y1, z0], dx, dz, c),
        wall([x0, y0, z0], dz, dx, c),
        wall([x0, y0, z0], dy, dz, c),
        wall([x1, y0, z0], dz, dy, c),
    ];
    for w in &mut walls {
        w.reflectance = [0.74, 0.74, 0.72];
    }
    walls[4].reflectance = [0.62, 0.06, 0.06];
    walls[5].reflectance = [0.14, 0.44, 0.09];
    walls
}

/// The outside of a box that is turned about the z axis, without its bottom.
pub fn block(centre: [f32; 2], half: [f32; 2], height: f32, degrees: f32, cells: u32) -> Vec<Wall> {
    let turn = glam::Vec2::from_angle(degrees.to_radians());
    let across = turn * (2.0 * half[0]);
    let along = turn.perp() * (2.0 * half[1]);
    let corner = glam::Vec2::from(centre) - 0.5 * (across + along);
    let flat = |v: glam::Vec2, z: f32| [v.x, v.y, z];
    let (a, b, up) = (flat(across, 0.0), flat(along, 0.0), [0.0, 0.0, height]);
    let c = [cells; 2];
    vec![
        wall(flat(corner, height), a, b, c),
        wall(flat(corner, 0.0), a, up, c),
        wall(flat(corner + along, 0.0), up, a, c),
        wall(flat(corner, 0.0), up, b, c),
        wall(flat(corner + across, 0.0), b, up, c),
    ]
}

/// A box of the Cornell kind: a room of 5.5 m with two turned blocks.
pub fn cornell(cells: u32) -> Room {
    let mut walls = inside([0.0; 3], [5.5, 5.6, 5.5], cells);
    walls.extend(block([3.6, 1.7], [0.83, 0.83], 1.65, -17.0, cells.div_ceil(3)));
    walls.extend(block([1.8, 3.6], [0.83, 0.83], 3.3, 19.0, cells.div_ceil(3)));
    room(&walls)
}

/// Reproducible numbers in 0..1.
pub struct Numbers(pub u64);

impl Numbers {
    pub fn bits(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }
}

/// An operator that holds nothing.
pub fn empty_operator(n: u32, channels: u32, format: BlockFormat, map: ValueMap) -> PackedOperator<'static> {
    let (tile, tiles) = Packing::tiling(n);
    let packing = Packing { n, channels, bounces: None, format, map, scale: [0.9, 0.7, 0.5], tile, tiles };
    PackedOperator {
        half: None,
        blocks: vec![0; packing.tile_count() * packing.tile_bytes()].into(),
        outlier_start: vec![0; n as usize + 1].into(),
        outlier_column: vec![].into(),
        outlier_value: vec![].into(),
        packing,
    }
}

/// An operator whose product is `factor` times what each patch sends.
pub fn diagonal_operator(n: u32, factor: f32) -> PackedOperator<'static> {
    let mut packed = empty_operator(n, 1, BlockFormat::Bc4, ValueMap::Sqrt);
    packed.outlier_start = (0..=n).collect();
    packed.outlier_column = (0..n).collect();
    packed.outlier_value = vec![factor; n as usize].into();
    packed
}

/// Mean and root mean square difference of the three channels together, relative to the mean of `truth`.
pub fn difference(found: &[[f32; 3]], truth: &[[f32; 3]]) -> (f64, f64) {
    assert_eq!(found.len(), truth.len());
    let (found, truth) = (found.as_flattened(), truth.as_flattened());
    let count = truth.len() as f64;
    let mean = truth.iter().map(|&t| f64::from(t)).sum::<f64>() / count;
    let off = || found.iter().zip(truth).map(|(&f, &t)| f64::from(f) - f64::from(t));
    (off().sum::<f64>() / count / mean, (off().map(|d| d * d).sum::<f64>() / count).sqrt() / mean)
}

/// The largest difference, relative to the mean of `truth`.
pub fn off(found: &[[f32; 3]], truth: &[[f32; 3]]) -> f32 {
    assert_eq!(found.len(), truth.len());
    let pairs = found.as_flattened().iter().zip(truth.as_flattened());
    let mean = truth.as_flattened().iter().sum::<f32>() / (3 * truth.len()) as f32;
    pairs.map(|(f, t)| (f - t).abs()).fold(0.0, f32::max) / mean
}
