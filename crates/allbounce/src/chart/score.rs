//! How far an answer is from the truth.

use serde::Serialize;

use super::truth::Truth;

/// Errors of indirect irradiance over receivers and colours; 0.01 is 1 %.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Score {
    /// RMS of the error over the mean of the truth; the noise of the truth is taken off.
    pub rms: f64,
    /// Mean of the answer over that of the truth, minus 1.
    pub bias: f64,
    /// [`probes::vis99`]; the noise of the truth is in it.
    pub vis99: f64,
}

/// Holds an answer to the truth, whose mean is above 0.
pub fn score(answer: &[[f32; 3]], truth: &Truth) -> Score {
    let truths = truth.indirect.as_flattened();
    let answers = answer.as_flattened().iter().map(|&a| f64::from(a));
    let errors: Vec<f64> = answers.zip(truths).map(|(a, t)| a - t).collect();
    let (n, mean) = (errors.len() as f64, mean(truth));
    let own = (noise(truth) * mean).powi(2);
    let squares = errors.iter().map(|e| e * e).sum::<f64>() / n;
    let seen: Vec<f64> = truth.direct.as_flattened().iter().zip(truths).map(|(d, i)| d + i).collect();
    let mean_seen = seen.iter().sum::<f64>() / n;
    let pairs: Vec<[f64; 2]> = errors.iter().zip(seen).map(|(&e, s)| [e, s]).collect();
    Score {
        rms: (squares - own).max(0.0).sqrt() / mean,
        bias: errors.iter().sum::<f64>() / n / mean,
        vis99: probes::vis99(&pairs, mean_seen),
    }
}

/// One figure of several lights: quadratic mean, the bias that is furthest from 0, mean.
pub fn of_all(scores: &[Score]) -> Score {
    let largest = scores.iter().map(|s| s.bias).max_by(|a, b| a.abs().total_cmp(&b.abs()));
    Score {
        rms: quadratic_mean(scores.iter().map(|s| s.rms)),
        bias: largest.unwrap_or(0.0),
        vis99: scores.iter().map(|s| s.vis99).sum::<f64>() / scores.len() as f64,
    }
}

/// Mean indirect irradiance of the receivers, W/m².
pub fn mean(truth: &Truth) -> f64 {
    let all = truth.indirect.as_flattened();
    all.iter().sum::<f64>() / all.len().max(1) as f64
}

/// RMS of the truth's standard errors over its mean.
pub fn noise(truth: &Truth) -> f64 {
    quadratic_mean(truth.noise.as_flattened().iter().copied()) / mean(truth)
}

/// Root of the mean of the squares.
pub fn quadratic_mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
    if count == 0.0 { 0.0 } else { f64::sqrt(sum / count) }
}
