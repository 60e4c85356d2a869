//! Form factors by plain Monte Carlo, the yardstick of the gather: independent random points and directions.

use super::{rectangles::Rectangle, room};

/// Independent numbers in 0 … 1: SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, 2014).
pub struct Random(pub u64);

impl Random {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Exchange areas, m², row-major: `rays` from every rectangle, counted where they land, both ends of a pair pooled.
pub fn exchange_areas(rectangles: &[Rectangle], rays: u32, seed: u64) -> Vec<f64> {
    let n = rectangles.len();
    let mut counts = vec![0.0; n * n];
    for (i, rectangle) in rectangles.iter().enumerate() {
        let mut random = Random(seed << 32 | i as u64);
        for _ in 0..rays {
            let (start, way) = ray(rectangle, &mut random);
            if let Some(j) = closest(rectangles, start, way) {
                counts[i * n + j] += 1.0;
            }
        }
    }
    let area: Vec<f64> = rectangles.iter().map(Rectangle::area).collect();
    // A count of N rays has variance N E / A, and both ends measure the same E.
    let pooled = |i: usize, j: usize| {
        (counts[i * n + j] + counts[j * n + i]) / (f64::from(rays) * (1.0 / area[i] + 1.0 / area[j]))
    };
    (0..n * n).map(|at| pooled(at / n, at % n)).collect()
}

/// Form factors of a closed room from such exchange areas, scaled to rows of 1.
pub fn closed_form_factors(room: &room::Room, rays: u32, seed: u64) -> Vec<f64> {
    let mut exchange = exchange_areas(&room.patches, rays, seed);
    room::close(&mut exchange, &room.area);
    room::factors(exchange, &room.area)
}

/// A uniform point and a direction with density cos θ / π.
fn ray(rectangle: &Rectangle, random: &mut Random) -> ([f64; 3], [f64; 3]) {
    let [s, t] = rectangle.sides();
    let [low, high] = rectangle.corners;
    let mut start = low;
    for axis in [s, t] {
        start[axis] += random.uniform() * (high[axis] - low[axis]);
    }
    let (square, angle) = (random.uniform(), std::f64::consts::TAU * random.uniform());
    let mut way = [0.0; 3];
    way[rectangle.axis] = rectangle.facing * (1.0 - square).sqrt();
    way[s] = square.sqrt() * angle.cos();
    way[t] = square.sqrt() * angle.sin();
    (start, way)
}

/// The first rectangle whose front a ray meets.
fn closest(rectangles: &[Rectangle], start: [f64; 3], way: [f64; 3]) -> Option<usize> {
    let mut best = (f64::INFINITY, None);
    for (j, rectangle) in rectangles.iter().enumerate() {
        let axis = rectangle.axis;
        let distance = (rectangle.corners[0][axis] - start[axis]) / way[axis];
        if way[axis] * rectangle.facing >= 0.0 || distance <= 0.0 || distance >= best.0 {
            continue;
        }
        let inside = rectangle.sides().iter().all(|&s| {
            let place = start[s] + distance * way[s];
            rectangle.corners[0][s] <= place && place < rectangle.corners[1][s]
        });
        if inside {
            best = (distance, Some(j));
        }
    }
    best.1
}
