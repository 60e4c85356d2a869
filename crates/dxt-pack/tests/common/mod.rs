#![allow(dead_code)] // every test file uses a part of it

//! An empty room whose operator is computed here from first principles, to pack.

use radfile::{Operator, PatchLocator, Patches, Piece};

/// A room of 4 × 3 × 2.5 m with six coloured walls of `cells` × `cells` patches each, and its
/// all-bounce operator.
pub struct Room {
    pub patches: Patches,
    pub operator: Operator<'static>,
}

/// Walls: origin, the two edges, inward normal, reflectance.
type Wall = ([f32; 3], [f32; 3], [f32; 3], [f32; 3], [f32; 3]);
const WALLS: [Wall; 6] = [
    ([0., 0., 0.], [4., 0., 0.], [0., 3., 0.], [0., 0., 1.], [0.4, 0.3, 0.2]),
    ([0., 0., 2.5], [4., 0., 0.], [0., 3., 0.], [0., 0., -1.], [0.8, 0.8, 0.8]),
    ([0., 0., 0.], [4., 0., 0.], [0., 0., 2.5], [0., 1., 0.], [0.7, 0.7, 0.65]),
    ([0., 3., 0.], [4., 0., 0.], [0., 0., 2.5], [0., -1., 0.], [0.7, 0.7, 0.65]),
    ([0., 0., 0.], [0., 3., 0.], [0., 0., 2.5], [1., 0., 0.], [0.6, 0.1, 0.1]),
    ([4., 0., 0.], [0., 3., 0.], [0., 0., 2.5], [-1., 0., 0.], [0.1, 0.5, 0.1]),
];

pub fn room(cells: usize, channels: usize) -> Room {
    let patches = room_patches(cells, channels == 1);
    let form_factors = symmetric_form_factors(&patches);
    let n = patches.len();
    let mut values = Vec::with_capacity(channels * n * n);
    for channel in 0..channels {
        let reflectance: Vec<f32> = patches.reflectance.iter().map(|r| r[channel]).collect();
        values.extend(all_bounces(&form_factors, &reflectance));
    }
    Room { operator: Operator { n, channels, bounces: None, values: values.into() }, patches }
}

/// Patches without a mesh: the first `n` of a room, for operators that are made up.
pub fn some_patches(n: usize) -> Patches {
    let cells = (1..).find(|c| 6 * c * c >= n).unwrap();
    let mut patches = room_patches(cells, true);
    patches.position.truncate(n);
    patches.normal.truncate(n);
    patches.area.truncate(n);
    patches.reflectance.truncate(n);
    patches.emission.truncate(n);
    patches.piece_start.truncate(n + 1);
    patches.pieces.truncate(n);
    patches.locator.cell_key.clear();
    patches.locator.cell_patch.clear();
    patches
}

fn room_patches(cells: usize, grey: bool) -> Patches {
    let mut patches = Patches { piece_start: vec![0], ..Patches::default() };
    for (origin, u, v, normal, colour) in WALLS {
        for k in 0..cells * cells {
            let (s, t) = ((k % cells) as f32, (k / cells) as f32);
            let at = |s: f32, t: f32| -> [f32; 3] {
                std::array::from_fn(|a| origin[a] + (u[a] * s + v[a] * t) / cells as f32)
            };
            let length = |e: [f32; 3]| e.iter().map(|x| x * x).sum::<f32>().sqrt();
            patches.position.push(at(s + 0.5, t + 0.5));
            patches.normal.push(normal);
            patches.area.push(length(u) * length(v) / (cells * cells) as f32);
            patches.reflectance.push(if grey { [colour[0]; 3] } else { colour });
            patches.emission.push([0.0; 3]);
            patches.pieces.push(Piece { corners: [at(s, t), at(s + 1.0, t), at(s, t + 1.0)], face: 0 });
            patches.piece_start.push(patches.pieces.len() as u32);
        }
    }
    patches.locator = PatchLocator { cell_size: 1.0, face_start: vec![0, 0, 0], ..PatchLocator::default() };
    patches
}

/// W = A^{1/2} F A^{-1/2} from the point-to-point kernel, scaled symmetrically until rows of F sum to 1.
pub fn symmetric_form_factors(p: &Patches) -> Vec<f32> {
    let n = p.len();
    let mut w = vec![0f32; n * n];
    for i in 0..n {
        for j in 0..n {
            let d: [f32; 3] = std::array::from_fn(|a| p.position[j][a] - p.position[i][a]);
            let dot = |m: [f32; 3]| (0..3).map(|a| d[a] * m[a]).sum::<f32>();
            let cosines = dot(p.normal[i]).max(0.0) * (-dot(p.normal[j])).max(0.0);
            let r2 = dot(d) + 0.5 * (p.area[i] * p.area[j]).sqrt();
            w[i * n + j] = (p.area[i] * p.area[j]).sqrt() * cosines / (std::f32::consts::PI * r2 * r2);
        }
    }
    for _ in 0..30 {
        // Rows of F = A^{-1/2} W A^{1/2}.
        let row = |i: usize| (0..n).map(|j| w[i * n + j] * (p.area[j] / p.area[i]).sqrt()).sum::<f32>();
        let scale: Vec<f32> = (0..n).map(|i| row(i).sqrt().recip()).collect();
        for i in 0..n {
            for j in 0..n {
                w[i * n + j] *= scale[i] * scale[j];
            }
        }
    }
    w
}

/// K = W + W ρ W + … by doubling: 32 bounces leave less than 1e-4 at these reflectances.
fn all_bounces(w: &[f32], reflectance: &[f32]) -> Vec<f32> {
    let n = reflectance.len();
    let mut sum = w.to_vec(); // Σ of the first 2^k bounces
    let mut power = scale_columns(w, reflectance); // (Wρ)^(2^k)
    for _ in 0..5 {
        let later = product(n, &power, &sum);
        sum.iter_mut().zip(later).for_each(|(s, l)| *s += l);
        power = product(n, &power, &power);
    }
    sum
}

fn scale_columns(w: &[f32], factor: &[f32]) -> Vec<f32> {
    w.iter().enumerate().map(|(at, w)| w * factor[at % factor.len()]).collect()
}

fn product(n: usize, a: &[f32], b: &[f32]) -> Vec<f32> {
    let mut out = vec![0f32; n * n];
    for (out, a) in out.chunks_exact_mut(n).zip(a.chunks_exact(n)) {
        for (k, a) in a.iter().enumerate() {
            out.iter_mut().zip(&b[k * n..][..n]).for_each(|(o, b)| *o += a * b);
        }
    }
    out
}
