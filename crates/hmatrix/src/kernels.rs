//! The inner loops of the product, three colours at a time.
//!
//! They are written so that the compiler makes vector instructions of them: a number for each of [`LANES`] triples
//! side by side, no sum across lanes in a loop. Sums are cut in the same places whatever the instructions, and no
//! multiplication is fused with an addition, so every processor gives the same bits. `tests/product.rs` holds
//! them against a decoded operator in f64.

/// Triples that are handled side by side.
pub const LANES: usize = 16;
/// A number for each of them, in three colours.
pub type Lanes = [[f32; LANES]; 3];
/// Rows of tiles that are handled side by side.
pub const ROWS: usize = 8;

/// Cᵀ x: codes of a row of triples at every patch, times light at the patch.
#[inline(always)]
pub fn gather(codes: &[[i8; LANES]], x: &[[f32; 3]]) -> Lanes {
    let mut sum = [[0.0; LANES]; 3];
    for (codes, x) in codes.iter().zip(x) {
        let codes = codes.map(f32::from);
        for (sum, &x) in sum.iter_mut().zip(x) {
            for lane in 0..LANES {
                sum[lane] += codes[lane] * x;
            }
        }
    }
    sum
}

/// Adds C t: codes of a patch, every `stride`th, times what their triples carry.
#[inline(always)]
pub fn scatter(sum: &mut Lanes, codes: &[[i8; LANES]], stride: usize, carried: &[Lanes]) {
    let mut local = *sum;
    for (codes, carried) in codes.iter().step_by(stride).zip(carried) {
        let codes = codes.map(f32::from);
        for (sum, carried) in local.iter_mut().zip(carried) {
            for lane in 0..LANES {
                sum[lane] += codes[lane] * carried[lane];
            }
        }
    }
    *sum = local;
}

/// The sum across lanes, by halves. Apart, for the compiler else arranges the lanes of [`scatter`] for this sum, which
/// takes twice as long.
#[inline(never)]
pub fn across(sum: &Lanes) -> [f32; 3] {
    sum.map(|lanes| {
        let eight: [f32; 8] = std::array::from_fn(|i| lanes[i] + lanes[i + 8]);
        let four: [f32; 4] = std::array::from_fn(|i| eight[i] + eight[i + 4]);
        (four[0] + four[2]) + (four[1] + four[3])
    })
}

/// Rows of tiles: squared codes times the scale of their tile and light.
#[inline(always)]
pub fn near(codes: &[[u8; ROWS]], senders: &[(u32, f32)], x: &[[f32; 3]]) -> [[f32; ROWS]; 3] {
    let mut sum = [[0.0; ROWS]; 3];
    for (codes, &(sender, scale)) in codes.iter().zip(senders) {
        let squares = codes.map(|c| f32::from(c) * f32::from(c));
        for (sum, &x) in sum.iter_mut().zip(&x[sender as usize]) {
            let x = scale * x;
            for row in 0..ROWS {
                sum[row] += squares[row] * x;
            }
        }
    }
    sum
}
