//! Bytes, errors and times of the packed operator of a container after the `series` stage, as CSV.
//!
//! `cargo run --release -p hmatrix --example rate_distortion -- BAKE.rad [error …]`
//!
//! `cpu1_ms` is the median time of one product on one thread, `dense8_ms` that of eight bounces with
//! the dense f32 form factors, all colours in one pass, on the same thread. `furnace` is the mean of
//! |Σ_j K_ij √A_j (1 − ρ_j) / √A_i − 1|, less what the dense operator has.

use std::time::Instant;

use hmatrix::{HMatrix, Params, compress};
use radfile::{Container, FormFactors, Operator, Patches, Quiet, Record};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: rate_distortion BAKE.rad [error …]")?;
    let mut targets = arguments.map(|a| a.parse()).collect::<Result<Vec<f64>, _>>()?;
    if targets.is_empty() {
        targets = vec![0.03, 0.01, 0.003];
    }
    let container = Container::open(path.as_ref())?;
    let patches = Patches::read(&container)?;
    let operator = Operator::read(&container)?;
    let factors = FormFactors::read(&container)?;
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let x: Vec<[f32; 3]> =
        patches.reflectance.iter().zip(&patches.area).map(|(r, a)| r.map(|r| r * a.sqrt())).collect();
    let dense = median(5, || std::hint::black_box(bounces(&factors, &patches, &x)).truncate(0));
    println!(
        "n,error_target,bytes,bytes_per_n2,luma_bytes_per_n2,colour_share,tile_share,multiplications,l2,\
         l2_max,vis99,energy_bias,furnace,pack_s,cpu1_ms,cpu_all_ms,dense8_ms"
    );
    for error in targets {
        let start = Instant::now();
        let (packed, report) = compress(&operator, &patches, &Params::error(error), &Quiet)?;
        let pack_s = start.elapsed().as_secs_f64();
        let (sizes, n2) = (&report.sizes, (operator.n as f64).powi(2));
        println!(
            "{},{error},{},{:.5},{:.5},{:.4},{:.4},{:.4},{:.5},{:.5},{:.5},{:.6},{:.6},{pack_s:.1},{:.4},{:.4},{dense:.3}",
            operator.n,
            report.bytes,
            report.bytes_per_entry,
            (report.bytes - sizes.colour) as f64 / n2,
            sizes.colour as f64 / (report.bytes - sizes.colour) as f64,
            sizes.tiles as f64 / report.bytes as f64,
            report.multiplications,
            report.l2_mean,
            report.l2_max,
            report.vis99,
            report.energy_bias,
            furnace(&packed, &operator, &patches),
            one.install(|| product_ms(&packed, &x)),
            product_ms(&packed, &x),
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

fn product_ms(packed: &HMatrix, x: &[[f32; 3]]) -> f64 {
    let (mut y, mut workspace) = (vec![[0.0; 3]; x.len()], packed.workspace());
    median(101, || packed.multiply(std::hint::black_box(x), &mut y, &mut workspace))
}

/// Eight bounces of classical radiosity: H ← F ρ H, all colours in one pass over F.
fn bounces(factors: &FormFactors, patches: &Patches, x: &[[f32; 3]]) -> Vec<[f32; 3]> {
    // The same vector instructions as the product has.
    let (arch, mut light) = (pulp::Arch::new(), x.to_vec());
    for _ in 0..8 {
        let sent = |c: usize| light.iter().zip(&patches.reflectance).map(|(l, r)| l[c] * r[c]).collect::<Vec<f32>>();
        let sent = [sent(0), sent(1), sent(2)];
        light = (0..x.len()).map(|i| arch.dispatch(Dots { row: factors.row(i), x: &sent })).collect();
    }
    light
}

/// A row of F times light.
struct Dots<'a> {
    row: &'a [f32],
    x: &'a [Vec<f32>; 3],
}

impl pulp::WithSimd for Dots<'_> {
    type Output = [f32; 3];

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> [f32; 3] {
        dots(self.row, self.x)
    }
}

#[inline(always)]
fn dots(row: &[f32], x: &[Vec<f32>; 3]) -> [f32; 3] {
    [dot(row, &x[0]), dot(row, &x[1]), dot(row, &x[2])]
}

#[inline(always)]
fn dot(row: &[f32], x: &[f32]) -> f32 {
    const LANES: usize = 32;
    let mut sum = [0.0f32; LANES];
    let ((row, row_rest), (x, x_rest)) = (row.as_chunks::<LANES>(), x.as_chunks::<LANES>());
    for (f, x) in row.iter().zip(x) {
        for lane in 0..LANES {
            sum[lane] += f[lane] * x[lane];
        }
    }
    across(&sum) + row_rest.iter().zip(x_rest).map(|(f, x)| f * x).sum::<f32>()
}

/// Apart, for the compiler else arranges the lanes of [`dot`] for this sum, which is slow.
#[inline(never)]
fn across(lanes: &[f32]) -> f32 {
    lanes.iter().sum()
}

/// What packing adds to the furnace's mean deviation: Σ_j X_ij (1 − ρ_j) = A_i in closed scenes.
fn furnace(packed: &HMatrix, operator: &Operator, patches: &Patches) -> f64 {
    let n = operator.n;
    let root: Vec<f32> = patches.area.iter().map(|a| a.sqrt()).collect();
    let x: Vec<[f32; 3]> =
        patches.reflectance.iter().zip(&root).map(|(r, a)| std::array::from_fn(|c| a * (1.0 - r[c]))).collect();
    let (mut y, mut workspace) = (vec![[0.0; 3]; n], packed.workspace());
    packed.multiply(&x, &mut y, &mut workspace);
    let mut sum = 0.0;
    for c in 0..operator.channels {
        for i in 0..n {
            let row = &operator.channel(c)[i * n..][..n];
            let exact: f64 = row.iter().zip(&x).map(|(k, x)| f64::from(*k) * f64::from(x[c])).sum();
            sum += (f64::from(y[i][c]) - exact).abs() / f64::from(root[i]);
        }
    }
    sum / (operator.channels * n) as f64
}
