//! Two rooms with a block and a round column each, seen without occlusion inside a room.
#![allow(dead_code)] // every test file uses its own part

use radfile::{FormFactors, Operator, PatchLocator, Patches, Piece};

type V = [f64; 3];

fn add(a: V, b: V, s: f64) -> V {
    std::array::from_fn(|i| a[i] + s * b[i])
}

fn dot(a: V, b: V) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Position, normal and area of one patch.
type Plate = (V, V, f64);

/// `m` × `m` plates on a parallelogram; they face along u × v.
fn wall(plates: &mut Vec<Plate>, corner: V, u: V, v: V, m: usize) {
    let normal = cross(u, v);
    let area = dot(normal, normal).sqrt();
    for at in 0..m * m {
        let [s, t] = [at / m, at % m].map(|k| (k as f64 + 0.5) / m as f64);
        plates.push((add(add(corner, u, s), v, t), normal.map(|x| x / area), area / (m * m) as f64));
    }
}

fn box_walls(plates: &mut Vec<Plate>, low: V, u: V, v: V, w: V, m: usize) {
    for (a, b, c) in [(u, v, w), (v, w, u), (w, u, v)] {
        wall(plates, low, b, a, m); // faces along −c, away from the box
        wall(plates, add(low, c, 1.0), a, b, m);
    }
}

/// Plates of one room; the shell faces inwards.
fn room(x: f64, m: usize) -> Vec<Plate> {
    let mut plates = vec![];
    box_walls(&mut plates, [x, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 2.5], m);
    plates.iter_mut().for_each(|p| p.1 = p.1.map(|n| -n));
    box_walls(&mut plates, [x + 1.0, 1.0, 0.0], [0.6, 0.35, 0.0], [-0.35, 0.6, 0.0], [0.0, 0.0, 1.2], m / 2);
    for k in 0..12 {
        let [a, b] = [k, k + 1].map(|k| f64::from(k) / 12.0 * std::f64::consts::TAU);
        let at = |angle: f64| [x + 3.0 + 0.3 * angle.cos(), 2.0 + 0.3 * angle.sin(), 0.0];
        wall(&mut plates, at(a), add(at(b), at(a), -1.0), [0.0, 0.0, 2.5], 2);
    }
    plates
}

/// Patches of two rooms in random sequence, with locator and one-bounce exchange: K = A^{1/2} F A^{-1/2}.
pub fn scene(m: usize) -> (Patches, FormFactors<'static>, Operator<'static>) {
    let mut plates: Vec<(usize, Plate)> =
        [0.0, 10.0].iter().enumerate().flat_map(|(r, &x)| room(x, m).into_iter().map(move |p| (r, p))).collect();
    let n = plates.len();
    let mut random = Random(7);
    for i in (1..n).rev() {
        plates.swap(i, (random.next() * (i + 1) as f64) as usize);
    }
    let exchange = |(room_a, a): &(usize, Plate), (room_b, b): &(usize, Plate)| {
        let between = add(b.0, a.0, -1.0);
        let square = dot(between, between);
        let cosines = [dot(between, a.1).max(0.0), (-dot(between, b.1)).max(0.0)];
        let disc = cosines[0] * cosines[1] / (square * (std::f64::consts::PI * square + b.2.max(a.2)));
        if room_a == room_b && square > 0.0 { disc * a.2 * b.2 } else { 0.0 }
    };
    let (mut values, mut k) = (vec![], vec![]);
    for a in &plates {
        for b in &plates {
            let g = exchange(a, b);
            values.push((g / a.1.2) as f32);
            k.push((g / (a.1.2 * b.1.2).sqrt()) as f32);
        }
    }
    let operator = Operator { n, channels: 1, bounces: None, values: k.into() };
    (
        patches(&plates),
        FormFactors { values: values.into(), sky: (0..n).map(|i| i as f32 / n as f32).collect::<Vec<_>>().into() },
        operator,
    )
}

fn patches(plates: &[(usize, Plate)]) -> Patches {
    let n = plates.len();
    let mut random = Random(8);
    let single = |v: V| v.map(|x| x as f32);
    let triangle = |p: V| [single(p), single(add(p, [0.1, 0.0, 0.0], 1.0)), single(add(p, [0.0, 0.1, 0.0], 1.0))];
    // Patch i has one or two pieces, on face i of as many faces.
    let start: Vec<u32> = (0..=n as u32).map(|i| i + i / 3).collect();
    let pieces = (0..n)
        .flat_map(|i| {
            vec![Piece { corners: triangle(plates[i].1.0), face: i as u32 }; (start[i + 1] - start[i]) as usize]
        })
        .collect();
    Patches {
        position: plates.iter().map(|(_, p)| single(p.0)).collect(),
        normal: plates.iter().map(|(_, p)| single(p.1)).collect(),
        area: plates.iter().map(|(_, p)| p.2 as f32).collect(),
        reflectance: (0..n).map(|_| std::array::from_fn(|_| 0.9 * random.next() as f32)).collect(),
        emission: (0..n).map(|_| std::array::from_fn(|_| random.next() as f32)).collect(),
        piece_start: start,
        pieces,
        locator: PatchLocator {
            cell_size: 1.0,
            face_start: (0..=n as u32).chain(if n % 2 == 1 { Some(n as u32) } else { None }).collect(),
            cell_key: vec![0; n],
            cell_patch: (0..n as u32).collect(),
            ..PatchLocator::default()
        },
    }
}

/// Numbers in 0 … 1 from a seed.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64
    }
}
