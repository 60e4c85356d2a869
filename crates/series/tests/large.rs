//! Full size, run by hand: `cargo test --release -p series --test large -- --ignored --nocapture`.

mod common;

use std::time::Instant;

#[test]
#[ignore = "takes seconds at 3000 patches; ALLBOUNCE_PATCHES sets another number"]
fn a_whole_building_is_solved_to_the_last_digit() {
    let n = std::env::var("ALLBOUNCE_PATCHES").map_or(3000, |v| v.parse().unwrap());
    let (area, factors) = quick_room(n);
    let room = common::patches(area, common::colours(n, 42));
    let start = Instant::now();
    let (_, report) = common::solve(&room, &factors, None);
    println!("{n} patches: {:.2} s\n{report:#?}", start.elapsed().as_secs_f64());
    assert!(report.channel.iter().all(|c| c.residual < 1e-12 && c.furnace_max_error < 1e-10));
}

/// As `common::room` with rows that are normalised by the largest sum instead of balanced.
fn quick_room(n: usize) -> (Vec<f32>, radfile::FormFactors<'static>) {
    let mut random = common::Random(41);
    let mut values = vec![0.0_f32; n * n];
    for i in 0..n {
        for j in 0..i {
            let seen = if random.next() < 0.4 { random.next() as f32 } else { 0.0 };
            values[i * n + j] = seen;
            values[j * n + i] = seen;
        }
    }
    let sum = |row: &[f32]| row.iter().map(|&v| f64::from(v)).sum::<f64>();
    let largest = values.chunks_exact(n).map(sum).fold(0.0, f64::max);
    values.iter_mut().for_each(|v| *v = (f64::from(*v) / largest) as f32);
    let sky = values.chunks_exact(n).map(|row| (1.0 - sum(row)).clamp(0.0, 1.0) as f32).collect::<Vec<_>>();
    (vec![1.0; n], radfile::FormFactors { values: values.into(), sky: sky.into() })
}
