//! Small dense symmetric matrices, row-major, in f64.

/// Rotations of all pairs; each sweep squares what is left off the diagonal.
const SWEEPS: usize = 30;
/// Share of the largest pivot below which a column is a combination of the others.
const DEPENDENT: f64 = 1e-13;

/// Eigenvalues, largest first, and eigenvectors as the columns of a matrix.
///
/// Jacobi's method with cyclic sweeps (G. Golub, C. Van Loan, Matrix Computations, §8.5).
pub fn eigen(mut a: Vec<f64>, n: usize) -> (Vec<f64>, Vec<f64>) {
    // Rows of `v` are the vectors, so that rotations run along rows.
    let mut v: Vec<f64> = (0..n * n).map(|at| if at / n == at % n { 1.0 } else { 0.0 }).collect();
    let whole: f64 = a.iter().map(|x| x * x).sum();
    for _ in 0..SWEEPS {
        let off: f64 = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i * n + j].powi(2)).sum();
        if off <= 1e-30 * whole {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                if a[p * n + q] != 0.0 {
                    rotate(&mut a, &mut v, n, p, q);
                }
            }
        }
    }
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| a[j * n + j].total_cmp(&a[i * n + i]));
    let values = order.iter().map(|&i| a[i * n + i]).collect();
    let vectors = (0..n * n).map(|at| v[order[at % n] * n + at / n]).collect();
    (values, vectors)
}

/// Makes the entry (p, q) zero.
fn rotate(a: &mut [f64], v: &mut [f64], n: usize, p: usize, q: usize) {
    let theta = (a[q * n + q] - a[p * n + p]) / (2.0 * a[p * n + q]);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let c = (t * t + 1.0).sqrt().recip();
    let s = t * c;
    let turn = |m: &mut [f64], at: usize, to: usize| {
        let (x, y) = (m[at], m[to]);
        (m[at], m[to]) = (c * x - s * y, s * x + c * y);
    };
    (0..n).for_each(|k| turn(a, p * n + k, q * n + k));
    (0..n).for_each(|k| turn(a, k * n + p, k * n + q));
    (0..n).for_each(|k| turn(v, p * n + k, q * n + k));
}

/// L with L Lᵀ = a, lower; rows of dependent columns are zero.
pub fn cholesky(a: &[f64], n: usize) -> Vec<f64> {
    let largest = (0..n).map(|i| a[i * n + i]).fold(0.0, f64::max);
    let mut l = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
            let rest = a[i * n + j] - dot;
            if i == j {
                if rest > DEPENDENT * largest {
                    l[i * n + i] = rest.sqrt();
                } else {
                    l[i * n..][..=i].fill(0.0);
                }
            } else if l[j * n + j] > 0.0 {
                l[i * n + j] = rest / l[j * n + j];
            }
        }
    }
    l
}

/// Solves L x = b in place; 0 in dependent places.
pub fn forward(l: &[f64], x: &mut [f64]) {
    let n = x.len();
    for i in 0..n {
        let dot: f64 = (0..i).map(|k| l[i * n + k] * x[k]).sum();
        x[i] = if l[i * n + i] > 0.0 { (x[i] - dot) / l[i * n + i] } else { 0.0 };
    }
}

/// Solves Lᵀ x = b in place; 0 in dependent places.
pub fn backward(l: &[f64], x: &mut [f64]) {
    let n = x.len();
    for i in (0..n).rev() {
        let dot: f64 = (i + 1..n).map(|k| l[k * n + i] * x[k]).sum();
        x[i] = if l[i * n + i] > 0.0 { (x[i] - dot) / l[i * n + i] } else { 0.0 };
    }
}

/// The product of an m × k and a k × n matrix.
pub fn product(a: &[f64], b: &[f64], k: usize, n: usize) -> Vec<f64> {
    let mut out = vec![0.0; a.len() / k.max(1) * n];
    for (out, a) in out.chunks_exact_mut(n.max(1)).zip(a.chunks_exact(k.max(1))) {
        for (&a, b) in a.iter().zip(b.chunks_exact(n.max(1))) {
            out.iter_mut().zip(b).for_each(|(out, &b)| *out += a * b);
        }
    }
    out
}

/// The transpose of a matrix with `columns` columns.
pub fn transposed(a: &[f64], columns: usize) -> Vec<f64> {
    let rows = a.len() / columns.max(1);
    (0..a.len()).map(|at| a[at % rows * columns + at / rows]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some(n: usize) -> Vec<f64> {
        let b: Vec<f64> = (0..n * n).map(|k| ((k * k * 7 + k * 3) % 23) as f64 - 11.0).collect();
        product(&b, &transposed(&b, n), n, n)
    }

    #[test]
    fn eigenvectors_take_a_matrix_apart_and_put_it_together() {
        let (n, a) = (9, some(9));
        let (values, vectors) = eigen(a.clone(), n);
        assert!(values.windows(2).all(|w| w[0] >= w[1]));
        let scaled: Vec<f64> = vectors.iter().enumerate().map(|(at, v)| v * values[at % n]).collect();
        let again = product(&scaled, &transposed(&vectors, n), n, n);
        let off = again.iter().zip(&a).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12 * values[0], "{off}");
        let one = product(&transposed(&vectors, n), &vectors, n, n);
        assert!(one.iter().enumerate().all(|(at, x)| (x - f64::from(at / n == at % n)).abs() < 1e-13));
    }

    #[test]
    fn dependent_columns_are_left_out() {
        // The third column is the sum of the others.
        let a = [2.0, 1.0, 3.0, 1.0, 2.0, 3.0, 3.0, 3.0, 6.0];
        let l = cholesky(&a, 3);
        let mut x = [3.0, 3.0, 6.0];
        forward(&l, &mut x);
        backward(&l, &mut x);
        assert!((x[0] - 1.0).abs() < 1e-12 && (x[1] - 1.0).abs() < 1e-12 && x[2] == 0.0, "{x:?}");
    }
}
