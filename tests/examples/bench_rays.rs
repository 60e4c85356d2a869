//! Rays per second on a scene: closest hits of incoherent gather rays, as form factors send them.
//!
//!     allbounce voxel-simplify sponza.glb -o sponza.rad
//!     cargo run --release -p allbounce-tests --example bench_rays -- sponza.rad [RAYS.f32]
//!
//! Rays start on triangles drawn by area, on either side, and leave with density cos θ / π, all in random order.
//! Every engine that is to be compared traces the same rays: RAYS.f32 receives origin and direction of each, six
//! little-endian f32. The answer is checked: on a sample of the rays every triangle of the mesh is tested in f64,
//! and the nearest must be the one that was found, but for ties.
//!
//! Prints CSV: scene, triangles, rays, threads, the median over runs of million rays per second and thread, and
//! the share of checked rays whose hit was right.

use std::{env, fs, hint::black_box, time::Instant};

use glam::{DVec3, Vec3};
use radfile::{Container, Mesh, Record};
use rayon::prelude::*;
use scene::{Rays, Sobol, cosine_direction, hash, square_to_triangle};

const COUNT: u32 = 1 << 20;
const RUNS: usize = 7;
const CHECKED: usize = 2000;

#[derive(Clone, Copy)]
struct Ray {
    origin: Vec3,
    direction: Vec3,
    own: u32,
}

fn main() {
    let args: Vec<String> = env::args().skip(1).collect();
    let [file, export @ ..] = &args[..] else { panic!("usage: bench_rays SCENE.rad [RAYS.f32]") };
    let container = Container::open(file.as_ref()).expect("a container with a mesh");
    let mesh = Mesh::read(&container).expect("a mesh");
    let rays = Rays::new(&mesh);
    let queries = incoherent(&mesh, &rays);
    if let Some(path) = export.first() {
        let numbers = queries.iter().flat_map(|q| q.origin.to_array().into_iter().chain(q.direction.to_array()));
        fs::write(path, numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>()).expect("a file");
    }
    let right = checked_share(&mesh, &rays, &queries[..CHECKED]);
    println!("scene,triangles,rays,threads,mrays_per_s_per_thread,checked,right");
    for threads in [1, rayon::current_num_threads()] {
        let rate = rate(&rays, &queries, threads);
        println!("{file},{},{COUNT},{threads},{rate:.3},{CHECKED},{right:.4}", mesh.triangles.len());
    }
}

/// Gather rays from the whole surface; neighbours in the list have nothing to do with each other.
fn incoherent(mesh: &Mesh, rays: &Rays) -> Vec<Ray> {
    let corners = |t: usize| mesh.corners(t).map(Vec3::from);
    let area = |t: usize| {
        let [a, b, c] = corners(t).map(|p| p.as_dvec3());
        (b - a).cross(c - a).length()
    };
    let up_to: Vec<f64> = (0..mesh.triangles.len())
        .scan(0.0, |sum, t| {
            *sum += area(t);
            Some(*sum)
        })
        .collect();
    let total = up_to.last().expect("triangles");
    let ray = |k: u32| {
        let number = |d: u32| f64::from(hash(hash(7, d), k)) / 2f64.powi(32);
        let own = up_to.partition_point(|s| *s <= number(0) * total).min(up_to.len() - 1);
        let [a, b, c] = corners(own);
        let (u, v) = square_to_triangle(number(1) as f32, number(2) as f32);
        let front = (b - a).cross(c - a).normalize_or(Vec3::Y);
        let normal = if number(3) < 0.5 { front } else { -front };
        let [x, y, ..] = Sobol::new(hash(9, k)).sample(0);
        let origin = rays.off_surface(a + u * (b - a) + v * (c - a), normal);
        Ray { origin, direction: cosine_direction(normal, x, y), own: own as u32 }
    };
    (0..COUNT).map(ray).collect()
}

/// Median over runs of million rays per second and thread.
fn rate(rays: &Rays, queries: &[Ray], threads: usize) -> f64 {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let trace = |q: &Ray| rays.closest(q.origin, q.direction, f32::INFINITY, q.own).map_or(0.0, |h| f64::from(h.t));
    let mut seconds: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            black_box(pool.install(|| queries.par_chunks(4096).map(|c| c.iter().map(trace).sum::<f64>()).sum::<f64>()));
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    queries.len() as f64 / seconds[RUNS / 2] / threads as f64 / 1e6
}

/// Share of rays whose hit is at the nearest place of all triangles, to a millionth of the scene.
fn checked_share(mesh: &Mesh, rays: &Rays, queries: &[Ray]) -> f64 {
    let extent = mesh.positions.iter().flatten().fold(0.0f32, |m, x| m.max(x.abs()));
    let right = |q: &&Ray| {
        let found = rays.closest(q.origin, q.direction, f32::INFINITY, q.own).map_or(f64::INFINITY, |h| f64::from(h.t));
        let truth = (0..mesh.triangles.len())
            .filter(|&t| t as u32 != q.own)
            .filter_map(|t| meet(mesh.corners(t).map(|p| Vec3::from(p).as_dvec3()), q))
            .fold(f64::INFINITY, f64::min);
        found == truth || (found - truth).abs() <= 1e-5 * f64::from(extent)
    };
    queries.par_iter().filter(right).count() as f64 / queries.len() as f64
}

/// Distance at which a ray meets a triangle (T. Möller, B. Trumbore, 1997), in f64.
fn meet([a, b, c]: [DVec3; 3], ray: &Ray) -> Option<f64> {
    let (e, f) = (b - a, c - a);
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let p = direction.cross(f);
    let scale = 1.0 / e.dot(p);
    let to = origin - a;
    let u = to.dot(p) * scale;
    let q = to.cross(e);
    let v = direction.dot(q) * scale;
    let t = f.dot(q) * scale;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}
