//! The light that every solver is held to, by a way that none of them takes.
//!
//! (I − F ρ) x = F ρ H⁰ is solved by plain elimination, then corrected by its own residual, which is summed with
//! twice the digits. What remains is not believed but bounded: rows of F sum to 1 at most, so
//! ‖(I − F ρ)⁻¹‖∞ ≤ 1 / (1 − ρ), and no patch is further from the truth than max |residual| / (1 − ρ).
//! Sources: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed. (2002), ch. 12 (refinement);
//! T. Ogita, S. M. Rump, S. Oishi, "Accurate sum and dot product", SIAM J. Sci. Comput. 26(6), 2005 (the sums).

/// A solution and its certificate.
pub struct Judged {
    /// Indirect irradiance after all bounces, W/m².
    pub light: Vec<f64>,
    /// No value is further from the truth than this share of the largest.
    pub bound: f64,
}

/// Indirect irradiance H of H = F ρ (H + H⁰) for one reflectance ρ < 1 and rows of `f` that sum to 1 at most.
pub fn all_bounces(f: &[f64], rho: f64, direct: &[f64]) -> Judged {
    let n = direct.len();
    let system = |at: usize| (if at / n == at % n { 1.0 } else { 0.0 }) - rho * f[at];
    let lu = Elimination::new((0..n * n).map(system).collect(), n);
    let residual = |x: &[f64]| -> Vec<f64> {
        let row = |i: usize| {
            let mut sum = Twofold::default();
            for j in 0..n {
                // ρ (x + H⁰) is rounded nowhere: each product of two numbers enters with its rounding error.
                sum.add_product(f[i * n + j], rho, x[j]);
                sum.add_product(f[i * n + j], rho, direct[j]);
            }
            sum.add(-x[i]);
            sum.value()
        };
        (0..n).map(row).collect()
    };
    let mut light = vec![0.0; n];
    for _ in 0..5 {
        let step = lu.solve(residual(&light));
        light.iter_mut().zip(step).for_each(|(x, s)| *x += s);
    }
    let largest = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let bound = largest(&residual(&light)) / (1.0 - rho) / largest(&light);
    Judged { light, bound }
}

/// L U of a matrix that needs no pivoting, as any with dominant rows.
pub struct Elimination {
    lu: Vec<f64>,
    n: usize,
}

impl Elimination {
    /// Of a row-major matrix.
    pub fn new(mut lu: Vec<f64>, n: usize) -> Elimination {
        for k in 0..n {
            let (above, below) = lu.split_at_mut((k + 1) * n);
            let pivot = &above[k * n..];
            for row in below.chunks_exact_mut(n) {
                row[k] /= pivot[k];
                let factor = row[k];
                row[k + 1..].iter_mut().zip(&pivot[k + 1..]).for_each(|(v, p)| *v -= factor * p);
            }
        }
        Elimination { lu, n }
    }

    /// x of L U x = b.
    pub fn solve(&self, mut x: Vec<f64>) -> Vec<f64> {
        let row = |i: usize| &self.lu[i * self.n..][..self.n];
        for i in 0..self.n {
            x[i] -= row(i)[..i].iter().zip(&x).map(|(l, x)| l * x).sum::<f64>();
        }
        for i in (0..self.n).rev() {
            let sum: f64 = row(i)[i + 1..].iter().zip(&x[i + 1..]).map(|(u, x)| u * x).sum();
            x[i] = (x[i] - sum) / row(i)[i];
        }
        x
    }
}

/// A sum with the rounding errors of its additions kept aside.
#[derive(Default)]
struct Twofold {
    sum: f64,
    errors: f64,
}

impl Twofold {
    fn add(&mut self, value: f64) {
        let sum = self.sum + value;
        let part = sum - self.sum;
        self.errors += (self.sum - (sum - part)) + (value - part);
        self.sum = sum;
    }

    /// Adds a b c with the rounding errors of both products.
    fn add_product(&mut self, a: f64, b: f64, c: f64) {
        let ab = a * b;
        let ab_error = a.mul_add(b, -ab);
        let abc = ab * c;
        self.errors += ab.mul_add(c, -abc) + ab_error * c;
        self.add(abc);
    }

    fn value(&self) -> f64 {
        self.sum + self.errors
    }
}
