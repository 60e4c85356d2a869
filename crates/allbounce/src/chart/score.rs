//! How far an answer is from the truth.

use serde::Serialize;

use super::truth::Truth;

/// The part of the truth's noise below which an RMS is not known: there the noise explains the error if its standard
/// errors are wrong by an eighth, since √(1 + ½²) is 1.12.
const UNSURE: f64 = 0.5;

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

/// The least RMS, over several lights, that these truths can tell from none.
pub fn least_rms(truths: &[Truth]) -> f64 {
    UNSURE * quadratic_mean(truths.iter().map(noise))
}

/// Root of the mean of the squares.
pub fn quadratic_mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
    if count == 0.0 { 0.0 } else { f64::sqrt(sum / count) }
}

#[cfg(test)]
mod tests {
    use super::{Truth, least_rms, noise, score};

    /// Light of 1 that is off by `error`, with `noise` as its standard error.
    fn truth(error: f64, noise: f64) -> Truth {
        let indirect = [1.0 - error, 1.0 + error].repeat(50).into_iter().map(|v| [v; 3]).collect();
        Truth { direct: vec![[0.0; 3]; 100], indirect, noise: vec![[noise; 3]; 100] }
    }

    /// A perfect answer differs from the truth by the truth's noise, even where that is a tenth larger than it is said to be.
    #[test]
    fn noise_of_the_truth_is_no_error_of_the_answer() {
        let perfect = vec![[1.0; 3]; 100];
        assert!(score(&perfect, &truth(0.1, 0.1)).rms < 1e-6);
        let understated = truth(0.11, 0.1);
        assert!((noise(&understated) - 0.1).abs() < 1e-12);
        let found = score(&perfect, &understated).rms;
        assert!(found > 0.04 && found < least_rms(&[understated]), "{found}");
        assert!((score(&perfect, &truth(0.5, 0.3)).rms - 0.4).abs() < 1e-9);
    }
}
