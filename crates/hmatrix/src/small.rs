//! Small dense linear algebra in f64; a matrix is a list of its columns.

/// Makes columns orthonormal (Gram and Schmidt, three times); those that depend on others become zero.
pub fn orthonormalise(columns: &mut [Vec<f64>]) {
    for c in 0..columns.len() {
        let (done, rest) = columns.split_at_mut(c);
        let own = &mut rest[0];
        // Normalised in between: what is left of a dependent column is rounding, and has to be made orthogonal anew.
        for _ in 0..3 {
            scale(own, 1e-150);
            for other in done.iter() {
                let s = dot(other, own);
                own.iter_mut().zip(other).for_each(|(x, y)| *x -= s * y);
            }
        }
        scale(own, 0.5);
    }
}

/// Makes a column of unit length, or zero if it is no longer than `least`.
fn scale(column: &mut [f64], least: f64) {
    let norm = dot(column, column).sqrt();
    let factor = if norm > least { 1.0 / norm } else { 0.0 };
    column.iter_mut().for_each(|x| *x *= factor);
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Eigenvalues of a symmetric matrix, largest magnitude first, and their vectors (C. G. J. Jacobi's rotations).
pub fn eigen(mut a: Vec<Vec<f64>>) -> Vec<(f64, Vec<f64>)> {
    let n = a.len();
    let mut vectors: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    let size: f64 = a.iter().flatten().map(|x| x * x).sum();
    for _ in 0..30 {
        let off: f64 = (0..n).map(|i| a[i][..i].iter().map(|x| x * x).sum::<f64>()).sum();
        if off <= 1e-26 * size {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                rotate(&mut a, &mut vectors, p, q);
            }
        }
    }
    let mut pairs: Vec<(f64, Vec<f64>)> = (0..n).map(|i| a[i][i]).zip(vectors).collect();
    pairs.sort_by(|x, y| y.0.abs().total_cmp(&x.0.abs()));
    pairs
}

/// Makes a[p][q] zero.
fn rotate(a: &mut [Vec<f64>], vectors: &mut [Vec<f64>], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    for column in a.iter_mut() {
        (column[p], column[q]) = (c * column[p] - s * column[q], s * column[p] + c * column[q]);
    }
    for columns in [a, vectors] {
        let (first, second) = columns.split_at_mut(q);
        for (x, y) in first[p].iter_mut().zip(&mut second[0]) {
            (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
        }
    }
}
