//! The two kinds of numbers that matrices are made of.

use faer::traits::RealField;

/// f32 or f64.
pub trait Scalar: RealField + Copy + Into<f64> + Send + Sync + 'static {
    /// The nearest number of this kind.
    fn of(value: f64) -> Self;
}

impl Scalar for f32 {
    fn of(value: f64) -> f32 {
        value as f32
    }
}

impl Scalar for f64 {
    fn of(value: f64) -> f64 {
        value
    }
}

/// Σ a x in f64. Eight partial sums, so that the compiler may use vector registers; their order is fixed.
pub fn dot<A: Scalar, B: Scalar>(a: &[A], x: &[B]) -> f64 {
    let (a8, x8) = (a.chunks_exact(8), x.chunks_exact(8));
    let rest: f64 = a8.remainder().iter().zip(x8.remainder()).map(|(&a, &x)| a.into() * x.into()).sum();
    let mut part = [0.0; 8];
    for (a, x) in a8.zip(x8) {
        for at in 0..8 {
            part[at] += a[at].into() * x[at].into();
        }
    }
    part.iter().sum::<f64>() + rest
}

/// out ← out + factor a, in f64.
pub fn add_scaled<A: Scalar>(out: &mut [f64], factor: f64, a: &[A]) {
    out.iter_mut().zip(a).for_each(|(out, &a)| *out += factor * a.into());
}
