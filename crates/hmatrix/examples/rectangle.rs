//! Bytes, errors and times of the rows of the last gather, for a container that has mesh and patches, as CSV.
//!
//! `cargo run --release -p hmatrix --example rectangle -- BAKE.rad RAYS EDGE [error …]`
//!
//! Receivers are those of the mesh tessellated to EDGE metres. `sparse8` and `sparse4` are bytes a receiver of the same rows
//! as pairs of u32 and f32, or of u16 and u16, the sparse times those of a product with the former. `cpu1_ms` is the
//! median time of one product on one thread.

use std::time::Instant;

use hmatrix::{Params, Receivers, Rectangle, compress_rows, sparse};
use radfile::{Container, Elements, Mesh, Patches, PointRows, Quiet, Record, Rows};
use rayon::prelude::*;
use scene::{NO_TRIANGLE, Rays, SurfacePoint};
use transfer::GatherParams;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut argument = || arguments.next().ok_or("usage: rectangle BAKE.rad RAYS EDGE [error …]");
    let (path, rays, edge) = (argument()?, argument()?.parse()?, argument()?.parse()?);
    let mut targets = arguments.map(|a| a.parse()).collect::<Result<Vec<f64>, _>>()?;
    if targets.is_empty() {
        targets = vec![0.03, 0.01];
    }
    let container = Container::open(path.as_ref())?;
    let (mesh, patches) = (Mesh::read(&container)?, Patches::read(&container)?);
    let bvh = Rays::new(&mesh);
    let elements = Elements::whole(&patches);
    let from = transfer::Senders { patches: &patches, elements: &elements, rays: &bvh };
    let mode = transfer::Mode::Interpolate;
    let params = transfer::Params { mode, edge: Some(edge), ..transfer::Params::default() };
    let (fine, _) = transfer::transfer(&mesh, &from, &params, &Quiet)?;
    let receivers = Receivers { position: &fine.position, normal: &fine.normal };
    let point = |(p, n): (&[f32; 3], &[f32; 3])| SurfacePoint {
        position: glam::Vec3::from(*p),
        normal: glam::Vec3::from(*n),
        triangle: NO_TRIANGLE,
    };
    let points: Vec<SurfacePoint> = fine.position.iter().zip(&fine.normal).map(point).collect();
    let start = Instant::now();
    let gathered = transfer::gather_for_points(&from, &points, &GatherParams { rays, ..Default::default() }, &Quiet);
    let gather_s = start.elapsed().as_secs_f64();
    let PointRows::Gathered { rows, .. } = gathered else { return Err("points are gathered".into()) };
    let row = sparse(&rows, &receivers)?;
    let a_row = rows.sender.len() as f64 / rows.len() as f64;
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let sparse_ms = [one.install(|| sparse_ms(&rows, patches.len())), sparse_ms(&rows, patches.len())];
    println!(
        "receivers,dark,patches,rays,entries_a_row,error_target,bytes,bytes_per_receiver,bytes_per_entry,sparse8,sparse4,\
         structure_share,tile_share,mean_share,multiplications,l2,l2_max,p99,vis99,energy_bias,furnace,chunks,passes,\
         gather_s,pack_s,cpu1_ms,cpu_all_ms,sparse1_ms,sparse_all_ms"
    );
    for error in targets {
        let start = Instant::now();
        let (packed, r) = compress_rows(&receivers, &(&patches).into(), &row, &Params::error(error), &Quiet)?;
        let pack_s = start.elapsed().as_secs_f64();
        let share = |bytes: usize| bytes as f64 / r.bytes as f64;
        println!(
            "{},{},{},{rays},{a_row:.1},{error},{},{:.2},{:.5},{:.0},{:.0},{:.3},{:.3},{:.3},{:.4},{:.5},{:.5},{:.5},{:.5},\
             {:.6},{:.5},{},{},{gather_s:.1},{pack_s:.1},{:.3},{:.3},{:.3},{:.3}",
            r.receivers,
            r.dark,
            r.senders,
            r.bytes,
            r.bytes_per_receiver,
            r.bytes_per_entry,
            8.0 * a_row + 4.0,
            4.0 * a_row + 4.0,
            share(r.sizes.structure),
            share(r.sizes.tiles),
            share(r.sizes.mean_or_split),
            r.multiplications,
            r.l2_mean,
            r.l2_max,
            r.p99,
            r.vis99,
            r.energy_bias,
            r.furnace,
            r.chunks,
            r.passes,
            one.install(|| product_ms(&packed)),
            product_ms(&packed),
            sparse_ms[0],
            sparse_ms[1],
        );
    }
    Ok(())
}

/// Median of the milliseconds that `work` takes.
fn median(times: usize, mut work: impl FnMut()) -> f64 {
    let mut found: Vec<f64> = (0..times)
        .map(|_| {
            let start = Instant::now();
            work();
            1e3 * start.elapsed().as_secs_f64()
        })
        .collect();
    found.sort_by(f64::total_cmp);
    found[times / 2]
}

fn product_ms(packed: &Rectangle) -> f64 {
    let x = vec![[0.25, 0.5, 1.0]; packed.senders()];
    let (mut y, mut workspace) = (vec![[0.0; 3]; packed.receivers()], packed.workspace());
    median(31, || packed.multiply(std::hint::black_box(&x), &mut y, &mut workspace))
}

fn sparse_ms(rows: &Rows, patches: usize) -> f64 {
    let x = vec![[0.25f32, 0.5, 1.0]; patches];
    let mut y = vec![[0.0; 3]; rows.len()];
    let gather = |receiver: usize| {
        let add = |sum: [f32; 3], (patch, weight): (usize, f32)| std::array::from_fn(|c| sum[c] + weight * x[patch][c]);
        rows.row(receiver).fold([0.0; 3], add)
    };
    median(9, || y.par_iter_mut().enumerate().for_each(|(receiver, y)| *y = gather(receiver)))
}
