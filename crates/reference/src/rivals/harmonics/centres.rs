//! Where incident light is sampled: points in the air close to surfaces, spread by k-means as Sloan, Kautz and Snyder
//! (§5) spread theirs over an object by iterated closest points.

use glam::Vec3;
use scene::{Rays, Sobol, cosine_direction};

use crate::rivals::Setting;

/// Points to choose from, at most.
const CANDIDATES: usize = 4096;
/// From surfaces, as a part of the way to what is opposite: lamps are nearer to points half-way, and light falls off with
/// the square.
const NEAR: f32 = 0.1;
/// Rounds of k-means.
const ROUNDS: usize = 16;
/// Centres that are tried before a surface is taken to see none.
const TRIED: usize = 6;

/// Points in the air.
pub struct Centres(pub Vec<Vec3>);

impl Centres {
    /// `count` points, fewer if the scene has not as many places.
    pub fn new(setting: &Setting, count: usize, seed: u32) -> Centres {
        let candidates = in_the_air(setting, seed);
        let mut centres = far_apart(&candidates, count);
        for _ in 0..ROUNDS {
            centres = nearer_the_mean(&candidates, &centres);
        }
        Centres(centres)
    }

    /// The nearest centre that a point sees; the nearest of all if it sees none of the nearest few. There must be one.
    pub fn of(&self, rays: &Rays, point: Vec3, triangle: u32) -> usize {
        let mut order: Vec<(f32, usize)> =
            self.0.iter().enumerate().map(|(k, c)| (c.distance_squared(point), k)).collect();
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let seen = order.iter().take(TRIED).find(|(_, k)| rays.visible(point, self.0[*k], triangle));
        seen.unwrap_or(&order[0]).1
    }
}

/// A little along rays from receivers to what they meet.
fn in_the_air(setting: &Setting, seed: u32) -> Vec<Vec3> {
    let positions = setting.scene.mesh.positions.iter().map(|p| Vec3::from(*p));
    let low = positions.clone().fold(Vec3::MAX, Vec3::min);
    let farthest = 0.5 * positions.fold(Vec3::MIN, Vec3::max).distance(low);
    let step = setting.receivers.len().div_ceil(CANDIDATES).max(1);
    let sobol = Sobol::new(seed);
    let above = |(number, receiver): (usize, &scene::SurfacePoint)| {
        let [x, y, ..] = sobol.sample(number as u32);
        let direction = cosine_direction(receiver.normal, x, y);
        let origin = setting.rays.off_surface(receiver.position, receiver.normal);
        let hit = setting.rays.closest(origin, direction, farthest, receiver.triangle);
        origin + NEAR * hit.map_or(farthest, |h| h.t) * direction
    };
    setting.receivers.iter().step_by(step).enumerate().map(above).collect()
}

/// The first candidate, and again and again the one that is farthest from those chosen.
fn far_apart(candidates: &[Vec3], count: usize) -> Vec<Vec3> {
    let mut chosen: Vec<Vec3> = candidates.iter().take(1).copied().collect();
    let mut distance = vec![f32::INFINITY; candidates.len()];
    while let (true, Some(&last)) = (chosen.len() < count, chosen.last()) {
        distance.iter_mut().zip(candidates).for_each(|(d, c)| *d = d.min(c.distance_squared(last)));
        let farthest = (0..candidates.len()).fold(0, |best, i| if distance[i] > distance[best] { i } else { best });
        if distance[farthest] == 0.0 {
            break;
        }
        chosen.push(candidates[farthest]);
    }
    chosen
}

/// For each centre the candidate that is nearest to the mean of those nearest to it: in the air, which a mean need not be.
fn nearer_the_mean(candidates: &[Vec3], centres: &[Vec3]) -> Vec<Vec3> {
    let nearest = |points: &[Vec3], to: Vec3| {
        let square = |i: &usize| points[*i].distance_squared(to);
        (0..points.len()).min_by(|a, b| square(a).total_cmp(&square(b))).unwrap_or(0)
    };
    let mut sums = vec![(Vec3::ZERO, 0.0); centres.len()];
    for &candidate in candidates {
        let (sum, count) = &mut sums[nearest(centres, candidate)];
        (*sum, *count) = (*sum + candidate, *count + 1.0);
    }
    let moved = |((sum, count), old): (&(Vec3, f32), &Vec3)| match *count > 0.0 {
        true => candidates[nearest(candidates, *sum / *count)],
        false => *old,
    };
    sums.iter().zip(centres).map(moved).collect()
}
