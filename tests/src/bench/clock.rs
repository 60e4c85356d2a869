//! How long products take, measured side by side.
//!
//! Machines slow down and speed up, and others work on them. So contestants take turns: in each turn every one
//! makes a product that does not count, which brings its operator to the caches that can hold it, and then a few that
//! do. Figures are medians over all turns.

use std::time::Instant;

use super::Product;

/// Turns that each contestant gets, and the milliseconds on as many threads after which it has had enough of them.
const TURNS: usize = 15;
const ENOUGH: f64 = 2500.0;
/// Milliseconds that a turn is to last, and most products in it.
const TURN: f64 = 15.0;
const MOST: usize = 40;
/// Threads that are tried.
const THREADS: [usize; 2] = [1, 2];

/// Median milliseconds of each product, on one thread and on two.
///
/// # Panics
///
/// If the machine gives no threads.
pub fn race<'a>(products: &mut [&mut (dyn Product + Send + 'a)], x: &[[f32; 3]]) -> Vec<[f64; 2]> {
    let pools = THREADS.map(|count| rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads"));
    let mut found = vec![[const { Vec::new() }; 2]; products.len()];
    let mut y = vec![[0.0; 3]; x.len()];
    for _ in 0..TURNS {
        for (product, found) in products.iter_mut().zip(&mut found) {
            for (pool, found) in pools.iter().zip(found).filter(|(_, found)| found.iter().sum::<f64>() < ENOUGH) {
                found.extend(pool.install(|| turn(*product, x, &mut y)));
            }
        }
    }
    found.into_iter().map(|counts| counts.map(median)).collect()
}

/// Milliseconds of the products of a turn.
fn turn(product: &mut (dyn Product + Send), x: &[[f32; 3]], y: &mut [[f32; 3]]) -> Vec<f64> {
    let first = milliseconds(product, x, y);
    let count = ((TURN / first) as usize).clamp(1, MOST);
    (0..count).map(|_| milliseconds(product, x, y)).collect()
}

fn milliseconds(product: &mut (dyn Product + Send), x: &[[f32; 3]], y: &mut [[f32; 3]]) -> f64 {
    let start = Instant::now();
    product.multiply(std::hint::black_box(x), y);
    std::hint::black_box(y);
    1e3 * start.elapsed().as_secs_f64()
}

fn median(mut found: Vec<f64>) -> f64 {
    found.sort_by(f64::total_cmp);
    found[found.len() / 2]
}
