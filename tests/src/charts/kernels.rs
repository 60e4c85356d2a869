//! Form factors by one look from centre to centre, as they stand in many programs: cheap, and not normalised.
//!
//! F_ij ≈ cos θ cos θ' A_j / (π r²) is right for small patches far apart; it has no upper limit.
//! The point-to-disc formula, cos θ cos θ' A_j / (π r² + A_j), stays below 1 for each pair, but not for their sum.
//! Source of the second: M. F. Cohen, J. R. Wallace, Radiosity and Realistic Image Synthesis (1993), §4.8; it takes
//! the sender for a disc of the same area.

use super::{rectangles::Rectangle, room::Room};

/// Which formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// cos θ cos θ' A / (π r²).
    Centre,
    /// cos θ cos θ' A / (π r² + A).
    Disc,
}

/// Form factors of every pair, row = receiver, row-major.
pub fn form_factors(room: &Room, kernel: Kernel) -> Vec<f64> {
    let pairs = room.patches.iter().flat_map(|i| room.patches.iter().map(move |j| (i, j)));
    pairs.map(|(receiver, sender)| factor(receiver, sender, kernel)).collect()
}

fn factor(receiver: &Rectangle, sender: &Rectangle, kernel: Kernel) -> f64 {
    let (from, to) = (receiver.centre(), sender.centre());
    let way: [f64; 3] = std::array::from_fn(|a| to[a] - from[a]);
    let square: f64 = way.iter().map(|w| w * w).sum();
    let towards = |normal: [f64; 3], sign: f64| sign * way.iter().zip(normal).map(|(w, n)| w * n).sum::<f64>();
    let (here, there) = (towards(receiver.normal(), 1.0), towards(sender.normal(), -1.0));
    if here <= 0.0 || there <= 0.0 {
        return 0.0;
    }
    let added = if kernel == Kernel::Disc { sender.area() } else { 0.0 };
    here * there / square * sender.area() / (std::f64::consts::PI * square + added)
}

/// Largest row sum.
pub fn largest_row(f: &[f64], n: usize) -> f64 {
    f.chunks_exact(n).map(|row| row.iter().sum()).fold(0.0, f64::max)
}

/// Spectral radius of F by power iteration; F has no negative value, so it is the largest eigenvalue.
/// One is added to all of them, so that −λ cannot stand in the way.
pub fn radius(f: &[f64], n: usize) -> f64 {
    let mut x = vec![1.0; n];
    let mut radius = 0.0;
    for _ in 0..2000 {
        let y: Vec<f64> = f.chunks_exact(n).map(|row| row.iter().zip(&x).map(|(f, x)| f * x).sum()).collect();
        let largest = y.iter().zip(&x).map(|(y, x)| y + x).fold(0.0, f64::max);
        radius = largest - 1.0;
        x.iter_mut().zip(&y).for_each(|(x, y)| *x = (*x + y) / largest);
    }
    radius
}
