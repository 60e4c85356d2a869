//! All bounces from one: the operator that keeps least, at the price of several products a frame.
//!
//! W = A^{1/2} F A^{-1/2} is one bounce. With R = ρ^{1/2}, K = W + W R (I − R W R)^{-1} R W (docs/theory.md (5.2)). So a frame is a
//! product with W, conjugate gradients in I − R W R, which is symmetric and positive definite, and a last product. There
//! is no colour and no reflectance in W: it is smaller than K, and surfaces may be repainted from frame to frame.
//!
//! Source: M. Hestenes, E. Stiefel, Methods of conjugate gradients for solving linear systems, J. Res. NBS 49, 1952.

/// Red, green and blue of every patch.
type Light = Vec<[f32; 3]>;

/// Most products of a frame.
const MOST_PRODUCTS: usize = 500;

/// Memory of a solve.
pub struct Solve {
    residual: Light,
    direction: Light,
    solution: Light,
    sent: Light,
    received: Light,
}

impl Solve {
    /// For `n` patches.
    pub fn new(n: usize) -> Solve {
        let zero = || vec![[0.0; 3]; n];
        Solve { residual: zero(), direction: zero(), solution: zero(), sent: zero(), received: zero() }
    }

    /// y = K x, where `one_bounce` writes W x to its second argument; the number of products that it took. Light is in
    /// the order of patches, `reflectance` is ρ. Takes no memory.
    ///
    /// Ends when what is missing is `tolerance` of the light after one bounce in every colour. It also ends where more light
    /// comes back than was sent, as may be with a W that was packed too coarsely and surfaces that reflect nearly
    /// all; the answer is what was found so far.
    ///
    /// # Panics
    ///
    /// If anything is of another length: a bug in the caller.
    pub fn all_bounces(
        &mut self,
        mut one_bounce: impl FnMut(&[[f32; 3]], &mut [[f32; 3]]),
        reflectance: &[[f32; 3]],
        tolerance: f64,
        x: &[[f32; 3]],
        y: &mut [[f32; 3]],
    ) -> usize {
        let Solve { residual, direction, solution, sent, received } = self;
        assert!([x.len(), y.len(), reflectance.len()] == [residual.len(); 3], "one value a patch");
        let root = |i: usize| reflectance[i].map(f32::sqrt);
        one_bounce(x, y);
        fill(residual, |i| times(root(i), y[i]));
        direction.clone_from_slice(residual);
        solution.fill([0.0; 3]);
        let mut square = dots(residual, residual);
        let enough = square.map(|s| s * tolerance * tolerance);
        let mut done = [0, 1, 2].map(|c| square[c] <= enough[c]);
        let mut products = 2;
        while products < MOST_PRODUCTS && done != [true; 3] {
            fill(sent, |i| times(root(i), direction[i]));
            one_bounce(sent, received);
            products += 1;
            fill(sent, |i| add(direction[i], [-1.0; 3], times(root(i), received[i])));
            let curvature = dots(direction, sent);
            (0..3).for_each(|c| done[c] |= curvature[c] <= 0.0);
            let step = [0, 1, 2].map(|c| if done[c] { 0.0 } else { (square[c] / curvature[c]) as f32 });
            fill_from(solution, |i, u| add(u, step, direction[i]));
            fill_from(residual, |i, r| add(r, step.map(|s| -s), sent[i]));
            let before = std::mem::replace(&mut square, dots(residual, residual));
            (0..3).for_each(|c| done[c] |= square[c] <= enough[c]);
            let turn = [0, 1, 2].map(|c| if done[c] { 0.0 } else { (square[c] / before[c]) as f32 });
            fill_from(direction, |i, p| add(residual[i], turn, p));
        }
        fill(sent, |i| times(root(i), solution[i]));
        one_bounce(sent, received);
        y.iter_mut().zip(received.iter()).for_each(|(y, more)| *y = add(*y, [1.0; 3], *more));
        products
    }
}

fn fill(out: &mut [[f32; 3]], value: impl Fn(usize) -> [f32; 3]) {
    out.iter_mut().enumerate().for_each(|(i, out)| *out = value(i));
}

fn fill_from(out: &mut [[f32; 3]], value: impl Fn(usize, [f32; 3]) -> [f32; 3]) {
    out.iter_mut().enumerate().for_each(|(i, out)| *out = value(i, *out));
}

fn times(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|c| a[c] * b[c])
}

/// a + factor · b.
fn add(a: [f32; 3], factor: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|c| a[c] + factor[c] * b[c])
}

/// Scalar products of the colours, in double precision and always in the same order.
fn dots(a: &[[f32; 3]], b: &[[f32; 3]]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for (a, b) in a.iter().zip(b) {
        (0..3).for_each(|c| sums[c] += f64::from(a[c]) * f64::from(b[c]));
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two plates that send everything to each other.
    #[test]
    fn two_plates_have_the_light_of_their_geometric_series() {
        let swap = |x: &[[f32; 3]], y: &mut [[f32; 3]]| (y[0], y[1]) = (x[1], x[0]);
        let rho = [[0.5, 0.9, 0.99]; 2];
        let x = [[1.0; 3], [0.0; 3]];
        let mut y = [[0.0; 3]; 2];
        let products = Solve::new(2).all_bounces(swap, &rho, 1e-6, &x, &mut y);
        for c in 0..3 {
            let r = f64::from(rho[0][c]);
            // What leaves plate 1 reaches plate 2 after 1, 3, 5, … bounces and plate 1 after 2, 4, …
            let expected = [r / (1.0 - r * r), 1.0 / (1.0 - r * r)];
            for i in 0..2 {
                let error = f64::from(y[i][c]) / expected[i] - 1.0;
                assert!(error.abs() < 1e-4, "plate {i}, ρ = {r}: {} for {}", y[i][c], expected[i]);
            }
        }
        assert!(products <= 5, "two unknowns take two steps, not {products}");
    }

    #[test]
    fn black_surfaces_and_no_light_end_at_once_and_a_gaining_operator_ends() {
        let swap = |x: &[[f32; 3]], y: &mut [[f32; 3]]| (y[0], y[1]) = (x[1], x[0]);
        let mut y = [[0.0; 3]; 2];
        let mut solve = Solve::new(2);
        solve.all_bounces(swap, &[[0.0; 3]; 2], 1e-6, &[[1.0; 3], [0.0; 3]], &mut y);
        assert_eq!(y, [[0.0; 3], [1.0; 3]], "one bounce of black surfaces");
        solve.all_bounces(swap, &[[0.5; 3]; 2], 1e-6, &[[0.0; 3]; 2], &mut y);
        assert_eq!(y, [[0.0; 3]; 2]);
        let gains = |x: &[[f32; 3]], y: &mut [[f32; 3]]| (y[0], y[1]) = (x[1].map(|v| 2.0 * v), x[0].map(|v| 2.0 * v));
        let products = solve.all_bounces(gains, &[[0.9; 3]; 2], 1e-6, &[[1.0; 3]; 2], &mut y);
        assert!(products < 10 && y.as_flattened().iter().all(|v| v.is_finite()), "{products}: {y:?}");
    }

    /// A ring of plates, as a coarsely packed W may be: nearly 1.05 of what is sent comes back. Green surfaces make
    /// it gain, red and blue ones do not, and take more products than green.
    #[test]
    fn a_colour_that_gains_leaves_the_others_right() {
        const N: usize = 24;
        let gain = |i: usize| 0.5 + 0.025 * (i as f32 / N as f32);
        let ring = |x: &[[f32; 3]], y: &mut [[f32; 3]]| {
            fill(y, |i| {
                let (before, after) = ((i + N - 1) % N, (i + 1) % N);
                add([0, 1, 2].map(|c| gain(before) * x[before][c]), [gain(i); 3], x[after])
            });
        };
        let rho = [[0.6, 0.99, 0.9]; N];
        let x: Vec<[f32; 3]> = (0..N).map(|i| [(i % 5) as f32, 1.0, (i % 3) as f32]).collect();
        let mut y = vec![[0.0; 3]; N];
        Solve::new(N).all_bounces(ring, &rho, 1e-6, &x, &mut y);
        assert!(y.as_flattened().iter().all(|v| v.is_finite()), "{y:?}");
        for c in [0, 2] {
            let (mut bounce, mut expected) = (vec![0.0; N], vec![0.0; N]);
            let mut light: Vec<f64> = x.iter().map(|x| x[c].into()).collect();
            for _ in 0..1000 {
                for i in 0..N {
                    let (before, after) = ((i + N - 1) % N, (i + 1) % N);
                    bounce[i] = f64::from(gain(before)) * light[before] + f64::from(gain(i)) * light[after];
                    expected[i] += bounce[i];
                }
                (0..N).for_each(|i| light[i] = f64::from(rho[i][c]) * bounce[i]);
            }
            for i in 0..N {
                let error = f64::from(y[i][c]) / expected[i] - 1.0;
                assert!(error.abs() < 1e-5, "colour {c}, plate {i}: {} for {}", y[i][c], expected[i]);
            }
        }
    }
}
