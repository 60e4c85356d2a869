//! Rooms of rectangles, cut to patches by hand.

#![allow(dead_code, reason = "each test file uses its own part")]

use glam::Vec3;
use radfile::{CellKey, Mesh, PatchLocator, Patches, Piece};

/// A parallelogram; its front looks along `u` × `v`.
#[derive(Clone, Copy)]
pub struct Wall {
    pub corner: Vec3,
    pub u: Vec3,
    pub v: Vec3,
    /// Sides that become patches: front, back.
    pub sides: [bool; 2],
}

impl Wall {
    pub fn new(corner: [f32; 3], u: [f32; 3], v: [f32; 3]) -> Wall {
        Wall { corner: corner.into(), u: u.into(), v: v.into(), sides: [true, false] }
    }

    /// Both sides reflect.
    pub fn both(self) -> Wall {
        Wall { sides: [true, true], ..self }
    }

    /// No side reflects.
    pub fn black(self) -> Wall {
        Wall { sides: [false, false], ..self }
    }
}

/// Mesh and patches of a test.
#[derive(Default)]
pub struct Room {
    pub mesh: Mesh,
    pub patches: Patches,
    /// Patches of each wall, front then back.
    pub of_wall: Vec<Vec<usize>>,
}

/// The inside of a box: floor, ceiling, and the walls at x = low, x = high, y = low, y = high.
pub fn inside_of_box(low: [f32; 3], high: [f32; 3]) -> Vec<Wall> {
    let (low, size) = (Vec3::from(low), Vec3::from(high) - Vec3::from(low));
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    let wall = |corner, u, v| Wall { corner, u, v, sides: [true, false] };
    vec![
        wall(low, x, y),
        wall(low + z, y, x),
        wall(low, y, z),
        wall(low + x, z, y),
        wall(low, z, x),
        wall(low + y, x, z),
    ]
}

/// One patch a wall side.
pub fn whole(walls: &[Wall]) -> Room {
    build(walls, |_| 1, 1e6)
}

/// Walls cut to squares of edge `cell`, of which their edges must be multiples.
pub fn cut(walls: &[Wall], cell: f32) -> Room {
    build(walls, |edge| (edge.length() / cell).round() as usize, cell)
}

fn build(walls: &[Wall], cells: impl Fn(Vec3) -> usize, cell_size: f32) -> Room {
    let mut room = Room::default();
    room.patches.piece_start.push(0);
    room.patches.locator = PatchLocator { grid_origin: [-10.0; 3], cell_size, ..PatchLocator::default() };
    let mut cell_lists: Vec<Vec<(u64, u32)>> = Vec::new();
    for wall in walls {
        let triangle = room.mesh.triangles.len() as u32;
        let first = room.mesh.positions.len() as u32;
        let corners = [wall.corner, wall.corner + wall.u, wall.corner + wall.u + wall.v, wall.corner + wall.v];
        room.mesh.positions.extend(corners.map(|c| c.to_array()));
        room.mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        room.mesh.triangle_material.extend([0, 0]);
        cell_lists.extend(std::iter::repeat_n(vec![], 4));
        for side in (0..2).filter(|&s| wall.sides[s]) {
            let (m, n) = (cells(wall.u), cells(wall.v));
            let mut members = Vec::new();
            for (a, b) in (0..m * n).map(|c| (c / n, c % n)) {
                members.push(room.patches.len());
                add_patch(&mut room.patches, &mut cell_lists, wall, [a, b], [m, n], 2 * triangle + side as u32);
            }
            room.of_wall.push(members);
        }
    }
    let locator = &mut room.patches.locator;
    locator.face_start = vec![0];
    for mut list in cell_lists {
        list.sort_unstable();
        locator.cell_key.extend(list.iter().map(|e| e.0));
        locator.cell_patch.extend(list.iter().map(|e| e.1));
        locator.face_start.push(locator.cell_key.len() as u32);
    }
    room.patches.check().expect("patches of a test");
    room
}

/// Cell (a, b) of m × n becomes a patch of two pieces. The wall's diagonal must not cross cells
/// other than along their own diagonal, so walls of many cells must be square.
fn add_patch(p: &mut Patches, lists: &mut [Vec<(u64, u32)>], wall: &Wall, at: [usize; 2], of: [usize; 2], face: u32) {
    assert!(of[0] == of[1] || of[0] * of[1] == 1, "cut walls must be square");
    let patch = p.len() as u32;
    let point =
        |i: usize, j: usize| wall.corner + wall.u * (i as f32 / of[0] as f32) + wall.v * (j as f32 / of[1] as f32);
    let [a, b] = at;
    let [p00, p10, p11, p01] = [point(a, b), point(a + 1, b), point(a + 1, b + 1), point(a, b + 1)];
    // The first triangle of the wall lies where u ≥ v, the second where v ≥ u.
    let second = [a < b, a <= b].map(|s| if s { 2 } else { 0 });
    let middle = (p00 + p11) * 0.5;
    for (corners, face) in [([p00, p10, p11], face + second[0]), ([p00, p11, p01], face + second[1])] {
        p.pieces.push(Piece { corners: corners.map(|c| c.to_array()), face });
        let key = CellKey::new(p.locator.cell_of(middle.to_array())).0;
        let list = &mut lists[face as usize];
        if !list.contains(&(key, patch)) {
            list.push((key, patch));
        }
    }
    p.piece_start.push(p.pieces.len() as u32);
    let front = wall.u.cross(wall.v);
    let normal = if face.is_multiple_of(2) { front } else { -front }.normalize();
    p.position.push(middle.to_array());
    p.normal.push(normal.to_array());
    p.area.push(front.length() / (of[0] * of[1]) as f32);
    p.reflectance.push([0.5; 3]);
    p.emission.push([0.0; 3]);
}
