//! One identity, what was found of it, and the line that says so.

use serde::Serialize;

/// One identity: what was found, or why it was not asked.
#[derive(Serialize)]
pub struct Check {
    identity: String,
    /// Number of the equation in docs/theory.md.
    equation: &'static str,
    #[serde(flatten)]
    outcome: Outcome,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Outcome {
    Held { deviation: f64, tolerance: f64, holds: bool },
    Skipped { skipped: String },
}

/// A deviation that is no number does not hold.
pub fn check(equation: &'static str, identity: impl Into<String>, deviation: f64, tolerance: f64) -> Check {
    let holds = deviation.is_finite() && deviation <= tolerance;
    Check { identity: identity.into(), equation, outcome: Outcome::Held { deviation, tolerance, holds } }
}

/// An identity that the container cannot be held to.
pub fn skip(equation: &'static str, identity: impl Into<String>, reason: impl Into<String>) -> Check {
    Check { identity: identity.into(), equation, outcome: Outcome::Skipped { skipped: reason.into() } }
}

impl Check {
    /// Whether it was asked.
    pub fn asked(&self) -> bool {
        matches!(self.outcome, Outcome::Held { .. })
    }

    /// Whether it was asked and does not hold.
    pub fn fails(&self) -> bool {
        matches!(self.outcome, Outcome::Held { holds: false, .. })
    }

    /// For people.
    pub fn line(&self) -> String {
        let Check { identity, equation, outcome } = self;
        let equation = format!("({equation})");
        match outcome {
            Outcome::Held { deviation, tolerance, holds } => {
                let verdict = if *holds { "holds" } else { "FAILS" };
                format!("{verdict}    {equation:<7} {identity:<72} {deviation:.2e} (tolerance {tolerance:.0e})")
            }
            Outcome::Skipped { skipped } => format!("skipped  {equation:<7} {identity}: {skipped}"),
        }
    }
}
