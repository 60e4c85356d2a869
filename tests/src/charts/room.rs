//! Empty boxes cut to unequal rectangles: rooms whose form factors are known exactly.

use radfile::{CellKey, Mesh, PatchLocator, Patches, Piece};

use super::rectangles::{Rectangle, exchange_area};

/// The inside of a box.
pub struct Room {
    pub patches: Vec<Rectangle>,
    /// m².
    pub area: Vec<f64>,
}

impl Room {
    /// A box from the origin whose walls are cut at the given places of each axis, which start with 0.
    pub fn new(cuts: [&[f64]; 3]) -> Room {
        let mut patches = Vec::new();
        for axis in 0..3 {
            for facing in [1.0, -1.0] {
                let plane = if facing > 0.0 { 0.0 } else { cuts[axis][cuts[axis].len() - 1] };
                let [s, t] = [(axis + 1) % 3, (axis + 2) % 3];
                for a in cuts[s].windows(2) {
                    for b in cuts[t].windows(2) {
                        let mut corners = [[plane; 3]; 2];
                        for end in 0..2 {
                            corners[end][s] = a[end];
                            corners[end][t] = b[end];
                        }
                        patches.push(Rectangle { corners, axis, facing });
                    }
                }
            }
        }
        Room { area: patches.iter().map(Rectangle::area).collect(), patches }
    }

    /// 5 m × 3 m × 2.5 m, 320 patches, narrower towards the edges; the largest has seven times the area of the smallest.
    pub fn hall() -> Room {
        let along = [0.0, 0.6, 1.2, 2.0, 3.0, 4.0, 5.0];
        Room::new([&along, &closer_at_the_ends(3.0, 8, 0.4), &closer_at_the_ends(2.5, 8, 0.4)])
    }

    /// How many patches.
    pub fn len(&self) -> usize {
        self.patches.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// Exact form factors, row = receiver, row-major: the closed forms, whose rows sum to 1 within 1e-12, scaled
    /// symmetrically until they do to the last digit. ρ = 0.9999 would make 1e-8 of 1e-12.
    pub fn form_factors(&self) -> Vec<f64> {
        let n = self.len();
        let mut exchange = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..i {
                let found = exchange_area(&self.patches[i], &self.patches[j]);
                (exchange[i * n + j], exchange[j * n + i]) = (found, found);
            }
        }
        close(&mut exchange, &self.area);
        factors(exchange, &self.area)
    }

    /// Direct irradiance at the middle of every patch, W/m², of a point light of 10 W/sr.
    pub fn lit_from(&self, lamp: [f64; 3]) -> Vec<f64> {
        let irradiance = |patch: &Rectangle| {
            let (centre, normal) = (patch.centre(), patch.normal());
            let way: [f64; 3] = std::array::from_fn(|a| lamp[a] - centre[a]);
            let square: f64 = way.iter().map(|w| w * w).sum();
            let cos = way.iter().zip(normal).map(|(w, n)| w * n).sum::<f64>() / square.sqrt();
            10.0 * cos.max(0.0) / square
        };
        self.patches.iter().map(irradiance).collect()
    }

    /// Mean over the area.
    pub fn mean(&self, light: &[f64]) -> f64 {
        let sum: f64 = self.area.iter().zip(light).map(|(a, h)| a * h).sum();
        sum / self.area.iter().sum::<f64>()
    }

    /// RMS over the area of `found` − `truth`, relative to that of `truth`.
    pub fn error(&self, found: &[f64], truth: &[f64]) -> f64 {
        let sum = |f: &dyn Fn(usize) -> f64| (0..self.len()).map(|i| self.area[i] * f(i).powi(2)).sum::<f64>();
        (sum(&|i| found[i] - truth[i]) / sum(&|i| truth[i])).sqrt()
    }
}

/// Places from 0 to `length` that cut it to `count` parts; `share` of their unevenness is that of a half circle's shadow.
pub fn closer_at_the_ends(length: f64, count: usize, share: f64) -> Vec<f64> {
    let place = |t: f64| length * ((1.0 - share) * t + share * 0.5 * (1.0 - (std::f64::consts::PI * t).cos()));
    (0..=count).map(|k| place(k as f64 / count as f64)).collect()
}

/// Scales exchange areas symmetrically until every row sums to its area, as in a closed room.
pub fn close(exchange: &mut [f64], area: &[f64]) {
    let n = area.len();
    for _ in 0..60 {
        let scale: Vec<f64> = (0..n).map(|i| (area[i] / exchange[i * n..][..n].iter().sum::<f64>()).sqrt()).collect();
        for (at, value) in exchange.iter_mut().enumerate() {
            *value *= scale[at / n] * scale[at % n];
        }
    }
}

/// Exchange areas to form factors.
pub fn factors(mut exchange: Vec<f64>, area: &[f64]) -> Vec<f64> {
    let n = area.len();
    exchange.iter_mut().enumerate().for_each(|(at, value)| *value /= area[at / n]);
    exchange
}

/// Rectangles as a mesh of two triangles each, and as patches, for a stage that works on scenes.
pub fn scene(rectangles: &[Rectangle]) -> (Mesh, Patches) {
    let (mut mesh, mut patches) = (Mesh::default(), Patches::default());
    // One cell for all: a face has one patch, so the cell has nothing to tell.
    let locator = PatchLocator { grid_origin: [-1e3; 3], cell_size: 1e6, ..PatchLocator::default() };
    let cell = CellKey::new(locator.cell_of([0.0; 3])).0;
    patches.locator = PatchLocator { face_start: vec![0], ..locator };
    patches.piece_start.push(0);
    for (number, rectangle) in rectangles.iter().enumerate() {
        let corners = ring(rectangle);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.triangle_material.extend([0, 0]);
        for (half, triangle) in [[0, 1, 2], [0, 2, 3]].into_iter().enumerate() {
            let face = 2 * (2 * number + half) as u32;
            patches.pieces.push(Piece { corners: triangle.map(|c| corners[c]), face });
            patches.locator.cell_key.push(cell);
            patches.locator.cell_patch.push(number as u32);
            // The front has this patch, the back none.
            patches.locator.face_start.extend([patches.locator.cell_key.len() as u32; 2]);
        }
        patches.piece_start.push(patches.pieces.len() as u32);
        patches.position.push(rectangle.centre().map(|x| x as f32));
        patches.normal.push(rectangle.normal().map(|x| x as f32));
        patches.area.push(rectangle.area() as f32);
        patches.reflectance.push([0.5; 3]);
        patches.emission.push([0.0; 3]);
    }
    (mesh, patches)
}

/// Corners, counter-clockwise seen from the front.
fn ring(rectangle: &Rectangle) -> [[f32; 3]; 4] {
    let [s, t] = rectangle.sides();
    let corner = |ends: [usize; 2]| {
        let mut corner = rectangle.corners[0];
        corner[s] = rectangle.corners[ends[0]][s];
        corner[t] = rectangle.corners[ends[1]][t];
        corner.map(|x| x as f32)
    };
    let ring = [[0, 0], [1, 0], [1, 1], [0, 1]].map(corner);
    if rectangle.facing > 0.0 { ring } else { [ring[0], ring[3], ring[2], ring[1]] }
}
